"""Compression: the rows of a static model as weighted centroids of a grid over its few inputs.

Within a cell a smooth model hardly changes, so the cost of the full data is that of the centroids, plus the scatter
inside cells, which no parameter moves. Coarse grids give starts, finer ones the fit, all rows the figures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Cells along each input by number of inputs, coarse to fine.
_LEVELS = {
    1: ((64,), (256,), (1024,)),
    2: ((48, 40), (96, 80), (192, 160)),
    3: ((24, 16, 16), (40, 24, 24), (64, 32, 32)),
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
    cell = np.zeros(y.size, np.int64)
    for values, cells in zip(x if by is None else by, grid_of(x.shape[0], level), strict=True):
        low, high = float(values.min()), float(values.max())
        scale = cells / (high - low) if high > low else 0.0
        place = ((values - low) * scale).astype(np.int64)
        cell *= cells
        cell += np.minimum(place, cells - 1, out=place)
    size = int(np.prod([float(c) for c in grid_of(x.shape[0], level)]))
    if size > 4 * y.size + 1_000_000:
        cell = np.unique(cell, return_inverse=True)[1]
        size = int(cell.max()) + 1
    counts = np.bincount(cell, minlength=size)
    used = np.flatnonzero(counts)
    count = counts[used].astype(np.float64)
    centre = np.array([np.bincount(cell, values, size)[used] / count for values in x])
    mean = np.bincount(cell, y, size)[used] / count
    return Centroids(centre, mean, count, max(float(y @ y) - float(count @ (mean * mean)), 0.0))
