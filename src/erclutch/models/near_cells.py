"""Where training rows were: cells of a grid over field and slip, and how much a network alone counts beside them.

A network knows nothing where no training row was. There a law takes its place. Between the two the network's share
falls from one to zero over a cell of the grid, which is a sixteenth of the training range::

    effort = network + (1 - share) * (law - network)

The share is exactly one at all training rows, so a law beside a network changes no bit of what the network says there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import mul
from typing import Any

import numpy as np

from erclutch.arithmetic.elementary import (
    is_less,
    less_select,
    one_where,
    table_entry,
    whole_number_near,
)
from erclutch.models.covered_cells import CELLS, smooth, within

Pair = tuple[float, float]
Table = tuple[tuple[bool, ...], ...]


def faded(network: Any, law: Any, share: Any) -> Any:
    """Effort of a network with a share, one to zero, the rest of which is a law's; elementwise on any operand."""
    return network + (1.0 - share) * (law - network)


@dataclass(frozen=True)
class NearCells:
    """The cells near training rows of one element: those that hold a row, and those beside.

    Beyond the range lies a ring of cells, as near as the last cells of the range. Beyond the ring no cell is near.

    Attributes:
        field, slip: training ranges that the grid lies over.
        masks: 16 numbers, one for each cell of the field from the lowest; bit k of a number is the cell k of the slip.
    """

    field: Pair
    slip: Pair
    masks: tuple[int, ...]

    def far(self, field: Any, slip: Any) -> Any:
        """Whether the cell of a row is not near; elementwise on any operand."""
        row, column = self._cell(field, slip)
        return table_entry(self._far, row, column)

    def amid(self, field: Any, slip: Any) -> Any:
        """Whether the cell of a row and all cells around are near: the share is one; elementwise on any operand."""
        row, column = self._cell(field, slip)
        return table_entry(self._amid, row, column)

    def share(self, field: Any, slip: Any) -> Any:
        """One where training rows were near, zero where none was, elementwise on any operand.

        Bilinear between the centres of the cells, each of which counts one or zero.
        """
        row, down = _between_centres(field, self.field)
        column, along = _between_centres(slip, self.slip)
        next_row = row + 1.0
        next_column = column + 1.0
        # How much is missed at the four centres around the point, one or zero; then between two columns of each row.
        above_left = one_where(table_entry(self._far_or_beyond, row, column))
        above_right = one_where(table_entry(self._far_or_beyond, row, next_column))
        below_left = one_where(table_entry(self._far_or_beyond, next_row, column))
        below_right = one_where(table_entry(self._far_or_beyond, next_row, next_column))
        above = (1.0 - along) * above_left + along * above_right
        below = (1.0 - along) * below_left + along * below_right
        return 1.0 - ((1.0 - down) * above + down * below)

    def _cell(self, field: Any, slip: Any) -> tuple[Any, Any]:
        """Numbers of the cells, the ring's own as the first and the last, with a fraction."""
        row = within(_cells_along(field, self.field) + 1.0, 0.0, CELLS + 1.5)
        column = within(_cells_along(slip, self.slip) + 1.0, 0.0, CELLS + 1.5)
        return row, column

    @cached_property
    def _near(self) -> Any:
        """The cells and the ring, shape (18, 18)."""
        own: list[list[bool]] = []
        for mask in self.masks:
            own.append([bool(mask >> k & 1) for k in range(CELLS)])
        return np.pad(np.array(own), 1, mode="edge")

    @cached_property
    def _far(self) -> Table:
        """Which of the cells and the ring are not near, (18, 18)."""
        return _table(~self._near)

    @cached_property
    def _amid(self) -> Table:
        """Which of the cells and the ring are near together with all eight around, (18, 18)."""
        size = CELLS + 2
        around = np.pad(self._near, 1, constant_values=False)
        every: Any = np.ones((size, size), np.bool_)
        for i in range(3):
            for k in range(3):
                every &= around[i : i + size, k : k + size]
        return _table(every)

    @cached_property
    def _far_or_beyond(self) -> Table:
        """The cells, the ring and what lies beyond, shape (20, 20)."""
        return _table(np.pad(~self._near, 1, constant_values=True))


@dataclass(frozen=True)
class Nearness:
    """What is near over all elements and further inputs.

    Attributes:
        elements: of each element.
        extras: training range of each further input.
    """

    elements: Sequence[NearCells]
    extras: Sequence[Pair] = ()

    def amid(
        self,
        fields: Sequence[Any],
        slips: Sequence[Any],
        extras: Sequence[Any],
    ) -> Any:
        """Whether the share is one because the cells of all elements lie amid near ones; on any operand."""
        amid: list[Any] = []
        for cells, field, slip in zip(self.elements, fields, slips, strict=True):
            amid.append(cells.amid(field, slip))
        for value, covered in zip(extras, self.extras, strict=True):
            amid.append(is_less(_beyond(value, covered), 0.5))
        every = amid[0]
        for each in amid[1:]:
            every = every & each
        return every

    def share(
        self,
        fields: Sequence[Any],
        slips: Sequence[Any],
        extras: Sequence[Any],
    ) -> Any:
        """How much a network counts, one to zero, elementwise on any operand."""
        shares: list[Any] = []
        for cells, field, slip in zip(self.elements, fields, slips, strict=True):
            shares.append(cells.share(field, slip))
        for value, covered in zip(extras, self.extras, strict=True):
            # One within half a cell beyond the range, zero from one and a half cells on.
            shares.append(within(1.5 - _beyond(value, covered), 0.0, 1.0))
        return smooth(reduce(mul, shares))


def _cells_along(x: Any, covered: Pair) -> Any:
    """Where a value lies along a range, in cells; zero along a range of one value."""
    low, high = covered
    cells_per_unit = min(CELLS / (high - low), 1e18) if high > low else 0.0
    return (x - low) * cells_per_unit


def _between_centres(x: Any, covered: Pair) -> tuple[Any, Any]:
    """The cell whose centre lies below a value, counted from two cells below the range, and how far on the value is."""
    at = within(_cells_along(x, covered) + 1.5, 0.0, CELLS + 3.0)
    # The number lies within these limits; said so, a proof of the C sees that, too.
    cell = within(whole_number_near(at - 0.5), 0.0, CELLS + 2.0)
    return cell, at - cell


def _beyond(x: Any, covered: Pair) -> Any:
    """How far a value lies beyond a range, in cells; below zero within."""
    low, high = covered
    width = (high - low) or abs(high) or 1.0
    cells_per_unit = min(CELLS / width, 1e18)
    below = low - x
    above = x - high
    return less_select(below, above, above, below) * cells_per_unit


def _table(cells: Any) -> Table:
    """An array of truths as tuples, which a record can look up."""
    return tuple(map(tuple, cells.tolist()))
