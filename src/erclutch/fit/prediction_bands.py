"""Prediction bands are calibrated on training rows and judged on rows held out (conformal, bin by bin: Mondrian).

The rows of a cell of `models.band` give its half widths: quantiles of measured less estimated effort (Vovk, Gammerman
and Shafer 2005, doi 10.1007/b106715, chapter 4.5). Neighbouring rows are alike: large errors come in clumps, which
count as one row each, and a cell needs enough of them, else it borrows from the cells around it. The model was fitted
to the same rows, so errors are widened as Akaike's final prediction error says for that many parameters (1970,
doi 10.1007/BF02506337). Errors of several logs are those without the logs of the same motion (`left_out_logs`); each
log then counts the same, however long (Dunn, Wasserman and Ramdas 2023, doi 10.1080/01621459.2022.2060112), and a cell
needs several. `studies/bands.py` tries all this on fresh logs of a known source.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.intervals import correlated_rows
from erclutch.logs.dataset import Dataset
from erclutch.models.adaptive_band import adapted
from erclutch.models.band import MOST_EDGES, Band, centres, leading
from erclutch.signals.array import Array, Mask

LEVEL = 0.95
#: Share of the field's span from its lag at which the field is switching, and the grid on which its edges lie.
_SWITCHING, _GRID = 0.05, 8
#: Independent rows that a cell needs for quantiles of its own, and logs where each log is to be new.
_ENOUGH, _ENOUGH_LOGS = 100, 4
#: Settling times: the longest of those whose bands are as narrow as the narrowest, but for this share; each part of
#: the rows, switching or not, has at least such a share of all.
_AS_NARROW, _LEAST = 0.02, 0.1
_LONGEST_S = 1.0
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
) -> list[tuple[Band, float] | None]:
    """The band of each model and the width of its plain band; None where an error is not finite.

    Args:
        data: all rows.
        train: the rows to calibrate on, to which the models were fitted, shape (n,).
        errors: measured less estimated effort of each model, each (n,).
        parameters: number of parameters of each model.
        unseen: of each model the errors on the training rows as new logs, shape (m,); None: they are not known.
    """
    field, slip = leading([e.field for e in data.elements], [e.slip for e in data.elements])
    field = np.abs(field)
    every = -(-int(train.sum()) // _MOST_ROWS)
    known = np.flatnonzero(train)[::every]
    cells = [
        (band, band.cells(data.elements, data.clock)[known])
        for band in _empty_bands(data, train, field[known], np.abs(slip[known]))
    ]
    usable = [each for each in cells if _LEAST <= _switching(each) <= 1.0 - _LEAST] or cells[:1]
    found: list[tuple[Band, float] | None] = []
    logs = np.searchsorted([stop for _, stop in data.source_rows], known, side="right")
    for error, count, new in zip(errors, parameters, unseen or (None,) * len(errors), strict=True):
        if not np.all(np.isfinite(error)):
            found.append(None)
            continue
        seen = error[train]
        if new is None or new.shape != seen.shape:
            rows, wider, log = seen, _widened(seen.size / correlated_rows(seen), count), None
        else:
            rows, wider, log = new, 1.0, logs
        directed = wider * np.where(slip[known] < 0.0, -rows[::every], rows[::every])
        own = _Errors.of(directed, log, max(_alike(rows) / every, 1.0))
        plain = _Errors.of(np.abs(directed), log, own.per_row)
        found.append((_narrowest(usable, own), 2.0 * plain.ends(np.arange(known.size), LEVEL)[1]))
    return found


def coverage(data: Dataset, ends: tuple[Array, Array], rows: Mask) -> Coverage:
    """What a band, low and high end each (n,), holds on some rows."""
    inside = (ends[0] <= data.effort) & (data.effort <= ends[1])
    shares = {name: float(np.mean(inside[piece])) for name, piece in pieces(data, rows)}
    where = min(shares, key=lambda name: shares[name])
    width = float(np.mean((ends[1] - ends[0])[rows]))
    return Coverage(int(rows.sum()), float(np.mean(inside[rows])), shares[where], where, width)


def pieces(data: Dataset, rows: Mask) -> list[tuple[str, NDArray[np.intp]]]:
    """Logs, or seconds where the rows are of one log, with the places of their rows.

    Seconds with less than half as many rows as usual are left out: they begin or end a stretch.
    """
    at = np.flatnonzero(rows)
    log = np.searchsorted([stop for _, stop in data.source_rows], at, side="right")
    second = (np.arange(at.size) * data.period).astype(np.intp)
    number = log if np.ptp(log) else second
    found: list[tuple[str, NDArray[np.intp]]] = []
    for k in np.unique(number):
        piece = at[number == k]
        when = f"the second from {data.clock.time[piece[0]]:.4g} s on"
        found.append((str(data.sources[int(k)]) if np.ptp(log) else when, piece))
    few = 0.0 if np.ptp(log) else 0.5 * float(np.median([piece.size for _, piece in found]))
    return [(name, piece) for name, piece in found if piece.size >= few]


def judged(data: Dataset, test: Mask, predicted: Array, band: Band, plain: float, *, sensor: bool = False) -> HeldBand:
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
    taught = adapted(band, ends, predicted, data.effort, data.clock) if sensor else None
    return HeldBand(coverage(data, ends, test), plain, None if taught is None else coverage(data, taught, test))


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
    def of(cls, directed: Array, log: NDArray[np.intp] | None, per_row: float) -> _Errors:
        """In the order of the calibration rows."""
        place = np.argsort(directed, kind="stable")
        if log is None:
            return cls(directed[place], place, None, None, per_row)
        _, number, rows = np.unique(log[place], return_inverse=True, return_counts=True)
        return cls(directed[place], place, number, 1.0 / rows[number], per_row)

    def enough(self, some: NDArray[np.intp]) -> bool:
        """Whether a cell with these errors needs no others."""
        rows = some.size >= _ENOUGH * self.per_row
        if self.log is None or not rows:
            return rows
        return np.unique(self.log[some]).size >= min(_ENOUGH_LOGS, int(self.log.max()) + 1)

    def ends(self, some: NDArray[np.intp], share: float) -> tuple[float, float]:
        """The errors below and above which a further one lies as rarely as the share allows, if so many are as one."""
        some, n = np.sort(some), some.size
        rank = share * (n + self.per_row)
        if self.weight is None:
            above = min(int(np.ceil(rank)), n)
            return float(self.directed[some[n - above]]), float(self.directed[some[above - 1]])
        counted = np.cumsum(self.weight[some])
        counted *= n / counted[-1]
        low, high = counted.searchsorted(n - rank, "right"), min(int(counted.searchsorted(rank)), n - 1)
        return float(self.directed[some[low]]), float(self.directed[some[high]])


#: A band without widths, and the cell of each calibration row, shape (n,).
_Cells = tuple[Band, NDArray[np.intp]]


def _switching(cells: _Cells) -> float:
    """Share of the rows in which the field is switching."""
    _, fields, slips = cells[0].shape
    return float(np.mean(cells[1] >= fields * slips))


def _narrowest(cells: Sequence[_Cells], errors: _Errors) -> Band:
    """The band with the longest settling time among those that are as narrow as the narrowest."""
    found = [(band, at, *_half_widths(errors, at, band.shape)) for band, at in cells]
    widths = [float(np.mean((behind + ahead)[at])) for _, at, behind, ahead in found]
    last = max(k for k, width in enumerate(widths) if width <= (1.0 + _AS_NARROW) * min(widths))
    band, _, behind, ahead = found[last]
    return replace(band, behind=tuple(behind.tolist()), ahead=tuple(ahead.tolist()))


def _alike(error: Array) -> float:
    """How many rows carry the information of one independent row on how often the error is large."""
    size = np.abs(error)
    return correlated_rows((size > np.quantile(size, LEVEL)).astype(np.float64))


def _widened(independent: float, parameters: int) -> float:
    """How much larger errors are on new rows than on those that so many parameters were fitted to; at most sqrt(3)."""
    rows = max(independent, 2.0 * parameters, 1.0)
    return float(np.sqrt((rows + parameters) / (rows - parameters)))


def _empty_bands(data: Dataset, train: Mask, field: Array, slip: Array) -> Iterator[Band]:
    """Bands without widths, from the shortest settling time to the longest.

    Args:
        data: all rows.
        train: rows to calibrate on, shape (n,); the grid lies over their range.
        field: magnitudes, of the rows that are used of these.
        slip: the same of the slip.
    """
    parts = np.arange(1, MOST_EDGES + 1) / (MOST_EDGES + 1)
    low, span = float(field.min()), float(np.ptp(field))
    # On a grid that begins half a step above zero: a command of few levels and some noise is not cut through a level.
    steps = np.minimum(np.floor((np.quantile(field, parts) - low) / (span or 1.0) * _GRID), _GRID - 1)
    over_fields, over_slips = (_covered(data, name, train) for name in ("field", "slip"))
    wanted = low + (steps + 0.5) / _GRID * span, np.quantile(slip, parts)
    fields, slips = (_between_cells(at, covered) for at, covered in zip(wanted, (over_fields, over_slips), strict=True))
    threshold = _SWITCHING * (span or float(field.max()) or 1.0)
    settling = 2.0 * data.period
    while settling <= _LONGEST_S or settling == 2.0 * data.period:
        yield Band(LEVEL, settling, threshold, over_fields, over_slips, fields, slips, (), ())
        settling *= 2.0


def _covered(data: Dataset, name: str, rows: Mask) -> tuple[float, float]:
    """Smallest and largest field or slip of all elements over some rows."""
    signals = [getattr(element, name)[rows] for element in data.elements]
    return min(float(x.min()) for x in signals), max(float(x.max()) for x in signals)


def _between_cells(edges: Array, covered: tuple[float, float]) -> tuple[float, ...]:
    """Edges moved to where they part cells of the grid, each one once; none where the grid has no cells apart."""
    at = centres(covered)
    sizes = np.unique(np.abs(at))
    sizes = sizes[np.diff(sizes, prepend=-np.inf) > 0.25 * (at[1] - at[0])]  # both sides of zero may be alike
    if sizes.size < 2:
        return ()
    parting = 0.5 * (sizes[1:] + sizes[:-1])
    return tuple(np.unique(parting[np.abs(parting - edges[:, None]).argmin(axis=1)]).tolist())


def _half_widths(errors: _Errors, at: NDArray[np.intp], shape: tuple[int, int, int]) -> tuple[Array, Array]:
    """Half widths against and in the direction of the slip, one a cell."""
    cells = int(np.prod(shape))
    place = np.array(np.unravel_index(np.arange(cells), shape)).T
    at = at[errors.place]
    order = np.argsort(at.astype(np.uint8), kind="stable")
    rows = np.split(order, np.searchsorted(at[order], np.arange(1, cells)))
    widths = np.empty((2, cells))
    for cell in range(cells):
        own = order
        for near in _neighbours(place, cell):
            own = np.concatenate([rows[i] for i in np.flatnonzero(near)])
            if errors.enough(own):
                break
        low, high = errors.ends(own, 0.5 * (1.0 + LEVEL))
        widths[:, cell] = max(-low, 0.0), max(high, 0.0)
    return widths[0], widths[1]


def _neighbours(place: NDArray[np.intp], cell: int) -> Iterator[NDArray[np.bool_]]:
    """The cell alone; with those of neighbouring slips; all slips; all fields too; all cells."""
    away = np.abs(place - place[cell])
    yield (away == 0).all(axis=1)
    yield (away[:, :2] == 0).all(axis=1) & (away[:, 2] <= 1)
    yield (away[:, :2] == 0).all(axis=1)
    yield away[:, 0] == 0
    yield np.ones(len(place), np.bool_)
