"""Boxes in the space of a network's inputs say where training rows lie, and a weight fades to zero beyond them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
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
        boxes: list[list[tuple[float, float]]] = []
        lows = (self.low / self.reach).tolist()
        highs = (self.high / self.reach).tolist()
        for low, high in zip(lows, highs, strict=True):
            boxes.append(list(zip(low, high, strict=True)))
        return boxes

    def weight(self, inputs: Sequence[Any]) -> Any:
        """The weight from 0 to 1 for all inputs, elementwise on any operand."""
        per_unit = [1.0 / reach for reach in self.reach.tolist()]
        in_reaches = [value * reaches for value, reaches in zip(inputs, per_unit, strict=True)]
        nearest: Any = None
        for box in self._corners:
            # The distance to a box is the largest one along an input; below zero inside.
            distance: Any = None
            for value, (low, high) in zip(in_reaches, box, strict=True):
                for along in (low - value, value - high):
                    distance = (
                        along if distance is None else less_select(distance, along, along, distance)
                    )
            nearest = (
                distance if nearest is None else less_select(nearest, distance, nearest, distance)
            )
        return smooth(within(1.0 - nearest, 0.0, 1.0))


#: Share of an input's whole range over which the weight falls to zero.
_REACH = 0.05
#: Rows by which cuts are chosen; the boxes hold all rows.
_FEW = 4000
_PLACES = np.linspace(0.0, 1.0, 9)[1:-1]


def cells_of(inputs: Array, boxes: int = 8) -> CoveredCells:
    """The boxes of some rows, shape (inputs, n): cut in two again and again, where most empty space is left out."""
    whole = np.ptp(inputs, axis=1)
    # In place of a range, for an input that does not vary.
    of_one_value = np.maximum(1.0, np.abs(inputs[:, 0]))
    reach = _REACH * np.where(whole > 0, whole, of_one_value)
    cells: list[Array] = [inputs]
    while len(cells) < boxes:
        cuts = [_best_cut(cell, reach) for cell in cells]
        best = max(cuts)
        gain, i, at = best
        if gain == -np.inf:  # all rows of each box are the same
            break
        cell = cells.pop(cuts.index(best))
        before = cell[i] <= at
        cells += [cell[:, before], cell[:, ~before]]
    lows = [cell.min(axis=1) for cell in cells]
    low = np.array(lows, np.float64)
    highs = [cell.max(axis=1) for cell in cells]
    high = np.array(highs, np.float64)
    return CoveredCells(low, high, reach)


def _best_cut(cell: Array, reach: Array) -> tuple[float, int, float]:
    """The volume that the best cut leaves out, the input that it cuts, and where."""
    every = max(1, cell.shape[1] // _FEW)
    rows = cell[:, ::every]
    low = rows.min(axis=1)
    high = rows.max(axis=1)
    whole = _volume(low, high, reach)
    best = (-np.inf, 0, 0.0)
    for i, row in enumerate(rows):
        wide = high[i] - low[i]
        if not wide > 0:
            continue
        places: Array = low[i] + _PLACES * wide
        # Rows in the order of the stretches between the places, of which some may be empty.
        stretch = np.asarray(np.searchsorted(places, row), np.intp)
        count = np.bincount(stretch, minlength=_PLACES.size + 1)
        in_order = rows[:, np.argsort(stretch, kind="stable")]
        filled = np.flatnonzero(count)
        begin = np.cumsum(count)[filled] - count[filled]
        lows = np.minimum.reduceat(in_order, begin, axis=1)  # (inputs, filled stretches)
        highs = np.maximum.reduceat(in_order, begin, axis=1)
        low_before = np.minimum.accumulate(lows, axis=1)
        high_before = np.maximum.accumulate(highs, axis=1)
        from_the_end = slice(None, None, -1)
        low_behind = np.minimum.accumulate(lows[:, from_the_end], axis=1)[:, from_the_end]
        high_behind = np.maximum.accumulate(highs[:, from_the_end], axis=1)[:, from_the_end]
        for place, at in enumerate(places.tolist()):
            # Stretches with rows up to the place.
            parts = int(np.searchsorted(filled, place, side="right"))
            # Of an input a few last digits wide, the last place is the end.
            if parts == filled.size:
                continue
            before = _volume(low_before[:, parts - 1], high_before[:, parts - 1], reach)
            behind = _volume(low_behind[:, parts], high_behind[:, parts], reach)
            best = max(best, (whole - before - behind, i, at))
    return best


def _volume(low: Array, high: Array, reach: Array) -> float:
    """Volume of a box in units of the reach, an edge of which belongs to the box."""
    return float(np.prod((high - low) / reach + 1.0))
