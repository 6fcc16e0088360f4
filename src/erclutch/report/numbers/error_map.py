"""An error map says where in field and slip a model errs, and where the data have holes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import Array

Counts = NDArray[np.int64]

_FIELD_CELLS, _SLIP_CELLS = 32, 26
_FEWEST_SLIP_CELLS = 3
_FEW_LEVELS = 16  # fields of a log, each of which has a cell of its own


@dataclass(frozen=True)
class ErrorMap:
    """Cells of field and slip of one element.

    Attributes:
        element: its number, from 0.
        field_edges, slip_edges: shapes (nf + 1,), (ns + 1,).
        train, test: rows in each cell, shape (nf, ns).
        rmse: of the rows held out in each cell, nan where there are none, shape (nf, ns).
    """

    element: int
    field_edges: Array
    slip_edges: Array
    train: Counts
    test: Counts
    rmse: Array

    @property
    def blind(self) -> NDArray[np.bool_]:
        """Cells with rows held out and no training row."""
        return (self.test > 0) & (self.train == 0)

    @property
    def blind_share(self) -> float:
        """Share of the rows held out that lie in such cells."""
        held_out = max(int(self.test.sum()), 1)
        return float(self.test[self.blind].sum() / held_out)

    @property
    def empty_share(self) -> float:
        """Share of cells without any training row."""
        return 1.0 - np.count_nonzero(self.train) / self.train.size

    @property
    def empty_share_at_its_fields(self) -> float:
        """The same among the fields that the training rows have: a supply that is switched has none between levels."""
        has_rows = self.train.any(axis=1)
        at_its_fields = self.train[has_rows]
        return 1.0 - np.count_nonzero(at_its_fields) / max(at_its_fields.size, 1)

    def worst(self) -> tuple[int, int] | None:
        """The cell with the largest error among those that hold enough rows to say so."""
        fewest = max(20, int(self.test.sum()) // 2000)
        rmse = np.where(self.test >= fewest, self.rmse, np.nan)
        if not np.any(np.isfinite(rmse)):
            return None
        field, slip = np.unravel_index(int(np.nanargmax(rmse)), rmse.shape)
        return int(field), int(slip)


def error_maps(rows: RunRows, model: str) -> tuple[ErrorMap, ...]:
    """One map an element, of the residuals of a model."""
    squares = rows.residual(model)[rows.test] ** 2
    maps: list[ErrorMap] = []
    for number, element in enumerate(rows.data.elements):
        field_edges = _field_edges(element.field)
        slip_cells = _SLIP_CELLS
        if rows.data.in_no_time:  # a cell between two points of a table is no hole
            points_at_a_field = rows.data.rows // (field_edges.size - 1)
            slip_cells = int(np.clip(points_at_a_field // 2, _FEWEST_SLIP_CELLS, _SLIP_CELLS))
        slip_edges = even_edges(element.slip, slip_cells)
        size = (field_edges.size - 1, slip_edges.size - 1)
        count = size[0] * size[1]
        # One pass over the rows: np.histogram2d is several times slower.
        along_field = _cell(element.field, field_edges)
        along_slip = _cell(element.slip, slip_edges)
        cell = along_field * size[1] + along_slip
        train = np.bincount(cell[~rows.test], minlength=count)
        test = np.bincount(cell[rows.test], minlength=count)
        total = np.bincount(cell[rows.test], squares, minlength=count)
        mean_square = np.where(test > 0, total / np.maximum(test, 1), np.nan)
        rmse = np.sqrt(mean_square)
        maps.append(
            ErrorMap(
                element=number,
                field_edges=field_edges,
                slip_edges=slip_edges,
                train=train.reshape(size),
                test=test.reshape(size),
                rmse=rmse.reshape(size),
            )
        )
    return tuple(maps)


def _field_edges(field: Array) -> Array:
    """Evenly spaced cells; where only a few fields were logged, or one, a cell for each of them."""
    levels: Array = np.unique(field)
    if levels.size == 1:
        return even_edges(field, 1)
    if not 2 <= levels.size <= _FEW_LEVELS:
        return even_edges(field, _FIELD_CELLS)
    middles = 0.5 * (levels[1:] + levels[:-1])
    # The outermost cells reach as far out as in.
    first = 1.5 * levels[:1] - 0.5 * levels[1:2]
    last = 1.5 * levels[-1:] - 0.5 * levels[-2:-1]
    return np.concatenate([first, middles, last])


def even_edges(values: Array, cells: int) -> Array:
    """Edges of so many cells of the same width around all values."""
    low = float(values.min())
    high = float(values.max())
    if high == low:  # a single value lies in the middle of a range of 1
        low = low - 0.5
        high = high + 0.5
    return np.linspace(low, high, cells + 1)


def _cell(values: Array, edges: Array) -> NDArray[np.intp]:
    """Number of each value's cell; values beyond the edges lie in the outermost cells."""
    last = edges.size - 2
    even = np.allclose(np.diff(edges), edges[1] - edges[0], rtol=1e-9)
    if not even:
        return np.clip(np.searchsorted(edges, values, "right") - 1, 0, last)
    cells_per_unit = (last + 1) / (edges[-1] - edges[0])
    scaled = (values - edges[0]) * cells_per_unit
    return np.clip(scaled.astype(np.intp), 0, last)
