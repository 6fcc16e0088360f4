"""Compression: the rows of a static model as weighted centroids of a grid over its few inputs.

Within a cell a smooth model hardly changes, so the cost of the full data is that of the centroids, plus the scatter
inside cells, which no parameter moves. Coarse grids give starts, finer ones the fit, all rows the figures.

Rows may come at once (`compress`) or block by block (`Grid`, `Totals`): the centroids are the same to the last bit,
because each cell adds its rows in their order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.int64]

#: Cells along each input by number of inputs, coarse to fine.
_LEVELS = {
    1: ((64,), (256,), (1024,)),
    2: ((24, 32), (48, 40), (192, 160)),
    3: ((8, 16, 16), (16, 20, 20), (32, 64, 64)),
    4: ((16, 12, 12, 10), (24, 16, 16, 12), (32, 20, 20, 16)),
}
_MANY = ((8,), (10,), (14,))  # cells along each of more inputs: only those with rows count
LEVELS = 3


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
        for row, low, high, cells in zip(values, self.low.tolist(), self.high.tolist(), self.cells, strict=True):
            scale = cells / (high - low) if high > low else 0.0
            place = ((row - low) * scale).astype(np.int64)
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
        mean = means[-1]
        return Centroids(means[:-1], mean, count, max(self._power - float(count @ (mean * mean)), 0.0))


def grid_of(inputs: int, level: int) -> tuple[int, ...]:
    """Cells along each input at a level, 0 (coarse) to 2 (fine)."""
    return (_LEVELS.get(inputs) and _LEVELS[inputs][level]) or _MANY[level] * inputs


def compress(x: Array, y: Array, level: int, by: Array | None = None) -> Centroids:
    """Centroids of the rows on a grid between the smallest and the largest value of each input.

    Args:
        x: inputs, shape (inputs, n).
        y: effort, shape (n,).
        level: 0 (coarse) to 2 (fine).
        by: what the grid is over in place of the inputs, such as the logarithm of one, shape (inputs, n).
    """
    values = x if by is None else by
    grid = Grid(values.min(axis=1), values.max(axis=1), grid_of(x.shape[0], level))
    place, size = grid.place(values), grid.size
    if size > 4 * y.size + 1_000_000:
        place = np.unique(place, return_inverse=True)[1]
        size = int(place.max()) + 1
    totals = Totals(size, x.shape[0])
    totals.add(place, x, y)
    return totals.centroids()
