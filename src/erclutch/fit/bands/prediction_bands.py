"""Prediction bands are calibrated on training rows and judged on rows held out (conformal, bin by bin: Mondrian).

The rows of a cell of `models.band` give its half widths: quantiles of measured less estimated effort (Vovk, Gammerman
and Shafer 2005, doi 10.1007/b106715, chapter 4.5). Neighbouring rows are alike: large errors come in clumps, which
count as one row each, and a cell needs enough of them, else it borrows from the cells around it. The model was fitted
to the same rows, so errors are widened as Akaike's final prediction error says for that many parameters (1970,
doi 10.1007/BF02506337), or as refits without parts of the rows have shown. Errors of several logs are those without the
logs of the same motion (`left_out_logs`); each log then counts the same, however long (Dunn, Wasserman and Ramdas 2023,
doi 10.1080/01621459.2022.2060112), and a cell needs several. `studies/bands.py` tries all this on fresh logs of a known
source.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.bands.band_pieces import log_of, pieces
from erclutch.fit.solver.intervals import correlated_rows
from erclutch.fit.training_range import span_of
from erclutch.logs.dataset import Dataset
from erclutch.models.adaptive_band import adapted
from erclutch.models.alarms import LONG, block_rows, in_half_widths, part_of
from erclutch.models.band import MOST_EDGES, Band, centres, leading
from erclutch.signals.array import Array, Mask

LEVEL = 0.95
#: The field is switching where it is so far from its lag, as a share of its span.
_SWITCHING = 0.05
#: The same of points of a table, none after another: nothing lies so far apart, so none is switching.
_NEVER = 2.0
#: Steps of the grid on which edges between fields lie.
_GRID = 8
#: Independent rows that a cell needs for quantiles of its own.
_ENOUGH_ROWS = 100
#: Logs that it needs where each log is to be new.
_ENOUGH_LOGS = 4
#: The longest settling time is taken whose band is as narrow as the narrowest, but for this share.
_AS_NARROW = 0.02
#: Each part of the rows, switching or not, has at least such a share of all.
_LEAST_PART = 0.1
_LONGEST_SETTLING_S = 1.0
#: Rows that are enough to calibrate on; of more, every so many one is used.
_MOST_ROWS = 20_000


@dataclass(frozen=True)
class Coverage:
    """What a band holds.

    Attributes:
        rows: on which it is judged.
        share: of these rows that lie inside.
        worst: the smallest share over the pieces; `pieces`.
        where: the piece with the smallest share.
        width: mean of high less low end, in the effort's unit.
    """

    rows: int
    share: float
    worst: float
    where: str
    width: float


@dataclass(frozen=True)
class HeldBand:
    """How the band of a model does on the rows held out.

    Attributes:
        held: without a sensor.
        plain: mean width of the plain band of the same calibration rows: one half width for all rows.
        with_sensor: what the band holds if it learns from the measured effort of past rows; None: not tried.
    """

    held: Coverage
    plain: float
    with_sensor: Coverage | None = None


def calibrated(
    data: Dataset,
    train: Mask,
    errors: Sequence[Array],
    parameters: Sequence[int],
    unseen: Sequence[Array | None] | None = None,
    growth: Sequence[float] | None = None,
) -> list[tuple[Band, float] | None]:
    """The band of each model and the width of its plain band; None where an error is not finite.

    Args:
        data: all rows.
        train: the rows to calibrate on, to which the models were fitted, shape (n,).
        errors: measured less estimated effort of each model, each (n,).
        parameters: number of parameters of each model.
        unseen: of each model the errors on the training rows as new logs, shape (m,); None: they are not known.
        growth: how many times larger each model's errors were on training rows new to a fit; None: not tried.
    """
    fields = [element.field for element in data.elements]
    slips = [element.slip for element in data.elements]
    field, slip = leading(fields, slips)
    field = np.abs(field)
    every = -(-int(train.sum()) // _MOST_ROWS)  # rounded up
    known = np.flatnonzero(train)[::every]
    log = log_of(data, known)

    # Bands that differ in their settling time. One that hardly ever, or nearly always, calls the field switching
    # has too few rows for the widths of one of its parts.
    bands: list[_Cells] = []
    for band in _empty_bands(data, train, field[known], np.abs(slip[known])):
        cell_of_row = band.cells(data.elements, data.clock)
        bands.append((band, cell_of_row[known]))
    usable: list[_Cells] = []
    for band, cell in bands:
        _, fields_of_band, slips_of_band = band.shape
        switching = float(np.mean(cell >= fields_of_band * slips_of_band))  # share of the rows
        if _LEAST_PART <= switching <= 1.0 - _LEAST_PART:
            usable.append((band, cell))
    usable = usable or bands[:1]

    results: list[tuple[Band, float] | None] = []
    unseen = unseen or [None] * len(errors)
    growth = growth or [1.0] * len(errors)
    block = LONG * block_rows(data.period * every)  # rows of a block
    for error, count, new, larger in zip(errors, parameters, unseen, growth, strict=True):
        if not np.all(np.isfinite(error)):
            results.append(None)
            continue
        seen = error[train]
        if new is None or new.shape != seen.shape:
            rows = seen
            # Errors are larger on new rows than on those that so many parameters were fitted to; by sqrt(3) at most.
            independent = max(seen.size / correlated_rows(seen), 2.0 * count, 1.0)
            wider = float(np.sqrt((independent + count) / (independent - count)))
            # Of a model that was fitted anew without parts of the rows it is known how much larger.
            wider = max(wider, larger)
            log_of_row = None
        else:  # errors on new logs need no widening, and logs count in place of rows
            rows = new
            wider = 1.0
            log_of_row = log
        along_slip = np.where(slip[known] < 0.0, -rows[::every], rows[::every])
        # So many rows carry the information of one independent row on how often the error is large.
        size = np.abs(rows)
        large = size > np.quantile(size, LEVEL)
        alike = correlated_rows(large.astype(np.float64))
        as_one = max(alike / every, 1.0)
        directed = _Errors.of(wider * along_slip, log_of_row, as_one)
        plain = _Errors.of(np.abs(wider * along_slip), log_of_row, as_one)
        _, half_width = plain.ends(np.arange(known.size), LEVEL)

        # The band with the longest settling time among those that are as narrow as the narrowest.
        with_widths: list[_Cells] = []
        widths: list[float] = []
        for empty, cell in usable:
            behind, ahead = _half_widths(directed, cell, empty.shape)
            band = replace(empty, behind=tuple(behind.tolist()), ahead=tuple(ahead.tolist()))
            with_widths.append((band, cell))
            whole_width = behind + ahead
            widths.append(float(np.mean(whole_width[cell])))
        narrow = (1.0 + _AS_NARROW) * min(widths)
        place = max(place for place, width in enumerate(widths) if width <= narrow)
        band, cell = with_widths[place]

        estimate = data.effort[known] - error[known]
        part = _followed(band, cell, rows[::every], estimate, log, block)
        results.append((replace(band, part=part), 2.0 * half_width))
    return results


def coverage(data: Dataset, ends: tuple[Array, Array], rows: Mask) -> Coverage:
    """What a band, low and high end each (n,), holds on some rows."""
    low, high = ends
    inside = (low <= data.effort) & (data.effort <= high)
    shares: dict[str, float] = {}
    for name, piece in pieces(data, rows):
        shares[name] = float(np.mean(inside[piece]))
    where = min(shares, key=lambda name: shares[name])
    return Coverage(
        rows=int(rows.sum()),
        share=float(np.mean(inside[rows])),
        worst=shares[where],
        where=where,
        width=float(np.mean((high - low)[rows])),
    )


def judged(
    data: Dataset,
    test: Mask,
    predicted: Array,
    band: Band,
    plain: float,
    *,
    sensor: bool = False,
) -> HeldBand:
    """How a band does on the rows held out, around the effort of all rows, shape (n,).

    Args:
        data: all rows.
        test: the rows held out, shape (n,).
        predicted: estimated effort, shape (n,).
        band: of the model.
        plain: width of its plain band.
        sensor: also try it with a sensor.
    """
    ends = band.around(predicted, data.elements, data.clock)
    held = coverage(data, ends, test)
    if not sensor:
        return HeldBand(held, plain)
    taught = adapted(band, ends, predicted, data.effort, data.clock)
    return HeldBand(held, plain, coverage(data, taught, test))


@dataclass(frozen=True)
class _Errors:
    """Errors of a model on the calibration rows, from the smallest to the largest.

    Attributes:
        directed: in the direction of the slip, shape (n,).
        place: of each among the calibration rows, shape (n,).
        log: number of its log, shape (n,); None where rows count and not logs.
        weight: so that each log counts the same, shape (n,); None: each row does.
        per_row: how many count as one.
    """

    directed: Array
    place: NDArray[np.intp]
    log: NDArray[np.intp] | None
    weight: Array | None
    per_row: float

    @classmethod
    def of(
        cls,
        directed: Array,
        log: NDArray[np.intp] | None,
        per_row: float,
    ) -> _Errors:
        """In the order of the calibration rows."""
        place = np.argsort(directed, kind="stable")
        if log is None:
            return cls(directed[place], place, None, None, per_row)
        _, number, rows = np.unique(log[place], return_inverse=True, return_counts=True)
        return cls(directed[place], place, number, 1.0 / rows[number], per_row)

    def enough(self, some: NDArray[np.intp]) -> bool:
        """Whether a cell with these errors needs no others."""
        if some.size < _ENOUGH_ROWS * self.per_row:
            return False
        if self.log is None:
            return True
        logs = int(self.log.max()) + 1
        return np.unique(self.log[some]).size >= min(_ENOUGH_LOGS, logs)

    def ends(self, some: NDArray[np.intp], share: float) -> tuple[float, float]:
        """The errors below and above which a further one lies as rarely as the share allows, if so many are as one."""
        count = some.size
        rank = share * (count + self.per_row)
        if self.weight is None:
            above = min(int(np.ceil(rank)), count)
            low = count - above
            high = above - 1
            ordered = np.partition(some, (low, high))  # these two stand as in a sorted array
        else:
            ordered = np.sort(some, kind="stable")  # cells that ascend are merged
            # Up to each error, the whole being their count.
            weight = np.cumsum(self.weight[ordered])
            weight *= count / weight[-1]
            low = int(weight.searchsorted(count - rank, "right"))
            high = min(int(weight.searchsorted(rank)), count - 1)
        least = float(self.directed[ordered[low]])
        most = float(self.directed[ordered[high]])
        return least, most


#: A band without widths, and the cell of each calibration row, shape (n,).
_Cells = tuple[Band, NDArray[np.intp]]


def _followed(
    band: Band,
    cell: NDArray[np.intp],
    error: Array,
    estimate: Array,
    log: NDArray[np.intp],
    block: int,
) -> float | None:
    """The part of the estimate that errors of a block follow as seldom as the level of the band allows.

    Args:
        band: with widths.
        cell: of each row, shape (n,).
        error: measured less estimated effort, shape (n,).
        estimate: shape (n,).
        log: number of the log of each row, shape (n,).
        block: rows of a block.
    """
    half_width = 0.5 * (np.asarray(band.behind) + np.asarray(band.ahead))[cell]
    off, size = np.zeros((2, error.size))  # a band without a width asks nothing
    usable = half_width > 0.0
    off[usable], size[usable] = in_half_widths(error[usable], estimate[usable], half_width[usable])

    parts: list[float] = []  # of each whole block
    starts_of_logs = np.flatnonzero(np.diff(log)) + 1
    for rows in np.split(np.arange(error.size), starts_of_logs):
        for first in range(0, rows.size - block + 1, block):
            some = rows[first : first + block]
            along = off[some] @ size[some]
            whole = size[some] @ size[some]
            parts.append(abs(part_of(along, whole, block)))
    rank = int(np.ceil(band.level * (len(parts) + 1)))
    if not parts or rank > len(parts):
        return None
    part = np.sort(parts)[rank - 1]
    return float(max(part, np.finfo(float).tiny))


def _half_widths(
    errors: _Errors,
    cell_of_row: NDArray[np.intp],
    shape: tuple[int, int, int],
) -> tuple[Array, Array]:
    """Half widths against and in the direction of the slip, each (cells,).

    Args:
        errors: of the calibration rows.
        cell_of_row: number of the cell of each calibration row, shape (n,).
        shape: cells by switching, field and slip.
    """
    cells = int(np.prod(shape))
    places_of_cells = np.unravel_index(np.arange(cells), shape)
    indices = np.array(places_of_cells).T  # of each cell, shape (cells, 3)
    cell = cell_of_row[errors.place]  # of each error, from the smallest error to the largest
    every = np.argsort(cell.astype(np.uint8), kind="stable")
    first_of_cells = np.searchsorted(cell[every], np.arange(1, cells))
    own = np.split(every, first_of_cells)  # errors of each cell

    behind = np.empty(cells)
    ahead = np.empty(cells)
    for number in range(cells):
        switching, field, slip = np.abs(indices - indices[number]).T
        same_field = (switching == 0) & (field == 0)
        larger_and_larger = (
            same_field & (slip == 0),  # the cell alone
            same_field & (slip <= 1),
            same_field,
            switching == 0,
            np.ones(cells, np.bool_),
        )
        some = every
        for near in larger_and_larger:
            some = np.concatenate([own[i] for i in np.flatnonzero(near)])
            if errors.enough(some):
                break
        low, high = errors.ends(some, 0.5 * (1.0 + LEVEL))
        behind[number] = max(-low, 0.0)
        ahead[number] = max(high, 0.0)
    return behind, ahead


def _empty_bands(data: Dataset, train: Mask, field: Array, slip: Array) -> Iterator[Band]:
    """Bands without widths, from the shortest settling time to the longest.

    Args:
        data: all rows.
        train: rows to calibrate on, shape (n,); the grid lies over their range.
        field: magnitudes, of the rows that are used of these.
        slip: the same of the slip.
    """
    low = float(field.min())
    span = float(np.ptp(field))
    parts = np.arange(1, MOST_EDGES + 1) / (MOST_EDGES + 1)

    # Edges between fields lie on a grid that begins half a step above the lowest field: a command of few levels and
    # some noise is not cut through a level.
    share = (np.quantile(field, parts) - low) / (span or 1.0)
    steps = np.minimum(np.floor(share * _GRID), _GRID - 1)
    wanted_fields = low + (steps + 0.5) / _GRID * span
    covered_fields = span_of([element.field[train] for element in data.elements])
    field_edges = _between_cells(wanted_fields, covered_fields)

    covered_slips = span_of([element.slip[train] for element in data.elements])
    slip_edges = _between_cells(np.quantile(slip, parts), covered_slips)

    switching = _NEVER if data.in_no_time else _SWITCHING
    threshold = switching * (span or float(field.max()) or 1.0)
    shortest_s = 2.0 * data.period
    settling_s = shortest_s
    while settling_s <= _LONGEST_SETTLING_S or settling_s == shortest_s:
        yield Band(
            level=LEVEL,
            settling_s=settling_s,
            threshold=threshold,
            field=covered_fields,
            slip=covered_slips,
            field_edges=field_edges,
            slip_edges=slip_edges,
            behind=(),
            ahead=(),
        )
        settling_s *= 2.0


def _between_cells(edges: Array, covered: tuple[float, float]) -> tuple[float, ...]:
    """Edges moved to where they part cells of the grid, each one once; none where the grid has no cells apart."""
    centre = centres(covered)
    step = centre[1] - centre[0]
    sizes = np.unique(np.abs(centre))
    # Where the range holds zero, cells on both sides of it may be alike in size.
    sizes = sizes[np.diff(sizes, prepend=-np.inf) > 0.25 * step]
    if sizes.size < 2:
        return ()
    parting = 0.5 * (sizes[1:] + sizes[:-1])
    nearest = np.abs(parting - edges[:, None]).argmin(axis=1)
    return tuple(np.unique(parting[nearest]).tolist())
