"""The rows of a static model are compressed to weighted centroids of a grid over its few inputs.

Within a cell a smooth model hardly changes, so the cost of the full data is that of the centroids, plus the scatter
inside cells, which no parameter moves. Coarse grids give starts, finer ones the fit, all rows the figures.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array

Places = NDArray[np.int64]

#: Cells along each input by number of inputs, coarse to fine.
_LEVELS = {
    1: ((64,), (256,), (1024,)),
    2: ((24, 32), (48, 40), (192, 160)),
    3: ((8, 16, 16), (16, 20, 20), (32, 64, 64)),
    4: ((16, 12, 12, 10), (24, 16, 16, 12), (32, 20, 20, 16)),
}
_MANY = ((8,), (10,), (14,))  # cells along each of more inputs: only those with rows count


@dataclass(frozen=True)
class Centroids:
    """Rows after compression.

    Attributes:
        x: mean inputs of each cell, shape (inputs, m).
        y: mean effort, shape (m,).
        count: rows in each cell, shape (m,).
        scatter: sum of squares of the effort round its cells' means: the part of the cost that is the same for all
            models.
    """

    x: Array
    y: Array
    count: Array
    scatter: float


@dataclass(frozen=True)
class Grid:
    """Equal cells between the ends of each input.

    Attributes:
        low, high: smallest and largest value of each input, shape (inputs,).
        cells: how many cells lie between them.
    """

    low: Array
    high: Array
    cells: tuple[int, ...]

    @property
    def size(self) -> int:
        """Number of cells in all."""
        return int(np.prod([float(c) for c in self.cells]))

    def place(self, values: Array) -> Places:
        """The cell of each row, shape (n,), for inputs (inputs, n) between the ends."""
        cell = np.zeros(values.shape[1], np.int64)
        lows = self.low.tolist()
        highs = self.high.tolist()
        for row, low, high, cells in zip(values, lows, highs, self.cells, strict=True):
            cells_per_unit = cells / (high - low) if high > low else 0.0
            place = ((row - low) * cells_per_unit).astype(np.int64)
            cell *= cells
            cell += np.minimum(place, cells - 1, out=place)
        return cell


class Totals:
    """Sums over the rows of each cell, to which blocks of rows are added.

    Args:
        size: number of cells.
        inputs: number of inputs.
    """

    def __init__(self, size: int, inputs: int) -> None:
        self._counts = np.zeros(size, np.int64)
        self._sums = np.zeros((inputs + 1, size))
        self._power = 0.0

    def add(self, place: Places, x: Array, y: Array) -> None:
        """Add rows: their cells (n,), inputs (inputs, n) and effort (n,)."""
        size = self._counts.size
        first = not self._power and not self._counts.any()
        self._counts += np.bincount(place, minlength=size)
        for sums, values in zip(self._sums, (*x, y), strict=True):
            if first:  # the same sum, faster
                sums[:] = np.bincount(place, values, size)
            else:
                np.add.at(sums, place, values)
        self._power += float(y @ y)

    def centroids(self) -> Centroids:
        """Centroids of the cells that have rows."""
        used = np.flatnonzero(self._counts)
        count = self._counts[used].astype(np.float64)
        means = np.array([sums[used] / count for sums in self._sums])
        x = means[:-1]
        y = means[-1]
        scatter = self._power - float(count @ (y * y))
        return Centroids(x, y, count, max(scatter, 0.0))


def grid_of(inputs: int, level: int) -> tuple[int, ...]:
    """Cells along each input at a level, 0 (coarse) to 2 (fine)."""
    if inputs in _LEVELS:
        return _LEVELS[inputs][level]
    return _MANY[level] * inputs


#: Inputs (inputs, n) and effort (n,) of some rows, and what the grid is over in place of the inputs, (inputs, n).
Gridded = tuple[Array, Array, Array]


def centroids_of(rows: Gridded, levels: Collection[int]) -> dict[int, Centroids]:
    """Centroids of rows by level, on grids between the smallest and the largest value of what the grids are over.

    Args:
        rows: inputs, effort, and what the grids are over.
        levels: 0 (coarse) to 2 (fine).
    """
    x, y, by = rows
    low = by.min(axis=1)
    high = by.max(axis=1)
    centroids: dict[int, Centroids] = {}
    for level in levels:
        grid = Grid(low, high, grid_of(low.size, level))
        place = grid.place(by)
        size = grid.size
        # Far more cells than rows: only those with rows are counted.
        if size > 4 * y.size + 1_000_000:
            cells, place = np.unique(place, return_inverse=True)
            size = cells.size
        totals = Totals(size, low.size)
        totals.add(place, x, y)
        centroids[level] = totals.centroids()
    return centroids


def compress(
    x: Array,
    y: Array,
    level: int,
    by: Array | None = None,
) -> Centroids:
    """`centroids_of` rows at one level; the grid is over the inputs where nothing else is given."""
    return centroids_of((x, y, x if by is None else by), [level])[level]
