"""Boxes in the space of a network's inputs say where training rows lie, and a weight fades to zero beyond them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any

import numpy as np

from erclutch.arithmetic.elementary import less_select
from erclutch.signals.array import Array

#: Cells of the grid over field and slip along each of the two.
CELLS = 16


def within(x: Any, low: float, high: float) -> Any:
    """A value held within two limits, elementwise on any operand; the low one where it is not a number."""
    above = less_select(low, x, x, low)
    return less_select(above, high, above, high)


def smooth(share: Any) -> Any:
    """A share from 0 to 1 that leaves and reaches both ends without a kink, elementwise on any operand."""
    return share * share * (3.0 - 2.0 * share)


def grid_cell(x: Any, covered: tuple[float, float]) -> Any:
    """Number of the cell of a value along a range, less than 16, with a fraction; elementwise on any operand."""
    low, high = covered
    scale = min(CELLS / (high - low), 1e18) if high > low else 0.0
    return within((x - low) * scale, 0.0, CELLS - 0.5)


@dataclass(frozen=True, eq=False)
class CoveredCells:
    """Boxes that hold all training rows, some inputs at a time.

    The weight is one in each box and falls smoothly to zero over the reach around it. Beyond the reach of all boxes
    the weight is zero: outside the range of an input, and in a gap that no row of the training data fills.

    Attributes:
        low, high: corners of each box in the units of the inputs, shape (boxes, inputs).
        reach: distance over which the weight falls to zero, for each input, shape (inputs,).
    """

    low: Array
    high: Array
    reach: Array

    @cached_property
    def _corners(self) -> list[list[tuple[float, float]]]:
        """Corners in units of the reach."""
        scaled = zip(self.low / self.reach, self.high / self.reach, strict=True)
        return [list(zip(low.tolist(), high.tolist(), strict=True)) for low, high in scaled]

    def weight(self, inputs: Sequence[Any]) -> Any:
        """The weight from 0 to 1 for all inputs, elementwise on any operand."""
        x = [value * (1.0 / float(reach)) for value, reach in zip(inputs, self.reach, strict=True)]
        nearest = reduce(_smaller, (_beyond(x, box) for box in self._corners))
        return smooth(within(1.0 - nearest, 0.0, 1.0))


def _beyond(x: Sequence[Any], box: Sequence[tuple[float, float]]) -> Any:
    """How far a point lies outside a box: the largest distance along an input; below zero inside."""
    distances = (d for value, (low, high) in zip(x, box, strict=True) for d in (low - value, value - high))
    return reduce(_larger, distances)


def _smaller(a: Any, b: Any) -> Any:
    return less_select(a, b, a, b)


def _larger(a: Any, b: Any) -> Any:
    return less_select(a, b, b, a)


#: Share of an input's whole range over which the weight falls to zero.
_REACH = 0.05
#: Rows by which cuts are chosen; the boxes hold all rows.
_FEW = 4000
_PLACES = np.linspace(0.0, 1.0, 9)[1:-1]


def cells_of(inputs: Array, boxes: int = 8) -> CoveredCells:
    """The boxes of some rows, shape (inputs, n): cut in two again and again, where most empty space is left out."""
    whole = np.ptp(inputs, axis=1)
    reach = _REACH * np.where(whole > 0, whole, np.maximum(1.0, np.abs(inputs[:, 0])))
    cells: list[Array] = [inputs]
    while len(cells) < boxes:
        cuts = [_best_cut(cell, reach) for cell in cells]
        gain, i, at = max(cuts)
        if gain == -np.inf:  # all rows of each box are the same
            break
        k = cuts.index((gain, i, at))
        cell = cells.pop(k)
        cells += [cell[:, cell[i] <= at], cell[:, cell[i] > at]]
    low, high = (np.array([end(cell) for cell in cells]) for end in (_low, _high))
    return CoveredCells(low, high, reach)


def _low(cell: Array) -> Array:
    return np.asarray(np.min(cell, axis=1), np.float64)


def _high(cell: Array) -> Array:
    return np.asarray(np.max(cell, axis=1), np.float64)


def _best_cut(cell: Array, reach: Array) -> tuple[float, int, float]:
    """The volume that the best cut leaves out, the input that it cuts, and where."""
    rows = cell[:, :: max(1, cell.shape[1] // _FEW)]
    low, wide = rows.min(axis=1), np.ptp(rows, axis=1)
    whole = _volume(rows, reach)
    best = (-np.inf, 0, 0.0)
    for i in range(len(rows)):
        places: list[float] = (low[i] + _PLACES * wide[i]).tolist() if wide[i] > 0 else []
        for at in (at for at in places if at < rows[i].max()):  # a few last digits wide, the last place is the end
            left = rows[i] <= at
            gain = whole - _volume(rows[:, left], reach) - _volume(rows[:, ~left], reach)
            best = max(best, (gain, i, at))
    return best


def _volume(rows: Array, reach: Array) -> float:
    """Volume of a box in units of the reach, an edge of which belongs to the box."""
    wide: Array = np.asarray(_high(rows) - _low(rows)) if rows.size else -reach
    return float(np.prod(wide / reach + 1.0))
