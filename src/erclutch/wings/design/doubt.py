"""A law may be wrong: each cell of field, slip and their directions has an offset of its own, with one deviation.

A criterion that believes the law goes where the law is steep, and stays there. With offsets a second row in a cell
tells little, and a cell without rows is not known, however well the numbers are. The offsets are integrated out: theirs
is a diagonal block of the information matrix. Sources: Kennedy and O'Hagan 2001, doi:10.1111/1467-9868.00294 (a model
and its discrepancy); Chaloner and Verdinelli 1995, doi:10.1214/ss/1177009939 (a prior in the design).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array, largest_size
from erclutch.signals.device import speeds_of
from erclutch.wings.design.fill import Cells

_LEVELS = 8  # along the field, on either side of zero, and along the speed
_DIRECTIONS = 9  # field and speed each fall, are steady or rise
_AGO = 0.01  # s, over which a direction is told
_STEADY = 0.02  # share of the largest value below which nothing moved


@dataclass(frozen=True)
class CellGrid:
    """Cells over what a rig does.

    Attributes:
        field, speed: largest, by size.
    """

    field: float
    speed: float

    @classmethod
    def of(cls, *logs: Dataset) -> CellGrid:
        """Cells over all that some logs have."""
        signals = [_signed(rows) for rows in logs]
        field = max(largest_size(fields) for fields, _ in signals)
        speed = max(largest_size(speeds) for _, speeds in signals)
        return cls(field or 1.0, speed or 1.0)

    @property
    def size(self) -> int:
        """Number of cells."""
        return (2 * _LEVELS + 1) * _LEVELS * _DIRECTIONS

    def cells(self, data: Dataset) -> Cells:
        """The cell of each row, shape (n,)."""
        fields, speeds = _signed(data)
        share = np.clip(np.abs(fields) / self.field, 0.0, 1.0)
        level = np.ceil(share * _LEVELS) * np.sign(fields) + _LEVELS
        along = (speeds / self.speed + 1.0) * 0.5  # from 0 to 1
        place = np.clip(np.floor(along * _LEVELS), 0, _LEVELS - 1)
        turn_of_field = self._directions(data, fields, self.field)
        turn_of_speed = self._directions(data, speeds, self.speed)
        turns = 3 * turn_of_field + turn_of_speed
        return ((level * _LEVELS + place) * _DIRECTIONS + turns).astype(np.intp)

    def _directions(self, data: Dataset, values: Array, largest: float) -> Array:
        """0 where a value falls, 1 where it is steady, 2 where it rises."""
        ago = max(1, round(_AGO / data.period))
        change = np.zeros_like(values)
        for span in data.clock.spans:
            of_span = values[span.start : span.stop]
            change[span.start + ago : span.stop] = of_span[ago:] - of_span[:-ago]
        steady = np.abs(change) <= _STEADY * largest
        rises_or_falls = np.where(change > 0.0, 2.0, 0.0)
        return np.where(steady, 1.0, rises_or_falls)


def _signed(data: Dataset) -> tuple[Array, Array]:
    """Field, of a pair positive for the first clutch, and the speed of the drive."""
    first, *others = data.elements
    field = first.field
    for other in others:
        field = field - other.field
    slips = [element.slip for element in data.elements]
    return field, speeds_of(data.device, slips)[0]


@dataclass(frozen=True)
class RowsOfUse:
    """Rows where a device is used, summed over each cell: a criterion that asks for them has so few sums to look at.

    Attributes:
        rows: how many.
        squares: of their derivatives by the law's numbers, shape (k + p, k + p).
        counts: rows in each cell, shape (cells,).
        sums: of their derivatives in each cell, shape (cells, k + p).
    """

    rows: int
    squares: Array
    counts: Array
    sums: Array

    @classmethod
    def of(cls, derivatives: Array, cells: Cells, grid: CellGrid) -> RowsOfUse:
        """Sum rows by their derivatives, shape (n, k + p), and cells, shape (n,)."""
        sums = np.zeros((grid.size, derivatives.shape[1]))
        np.add.at(sums, cells, derivatives)
        counts = np.bincount(cells, minlength=grid.size).astype(np.float64)
        return cls(cells.size, derivatives.T @ derivatives, counts, sums)


@dataclass(frozen=True)
class Doubt:
    """What rows say of the offsets.

    Attributes:
        grid: their cells.
        deviation: standard deviation of an offset before any row.
        counts: precision that the rows of a cell bring, shape (cells,).
        sums: of the rows' derivatives by the law's numbers, as precisely, shape (cells, k + p).
    """

    grid: CellGrid
    deviation: float
    counts: Array
    sums: Array

    @classmethod
    def of(
        cls,
        cells_of: CellGrid,
        known: Dataset,
        deviation: float,
        derivatives: Array,
        weight: float,
    ) -> Doubt:
        """Of the rows that a law was fitted to.

        Args:
            cells_of: the grid.
            known: the rows.
            deviation: of an offset before any row.
            derivatives: by the law's numbers, shape (n, k + p).
            weight: precision that a row brings.
        """
        _, numbers = derivatives.shape
        no_counts = np.zeros(cells_of.size)
        no_sums = np.zeros((cells_of.size, numbers))
        nothing = cls(cells_of, deviation, no_counts, no_sums)
        return nothing.plus(cells_of.cells(known), derivatives, weight)

    def plus(self, cells: Cells, derivatives: Array, weight: float) -> Doubt:
        """With more rows."""
        counts = self.counts + weight * np.bincount(cells, minlength=self.grid.size)
        sums = self.sums.copy()
        np.add.at(sums, cells, weight * derivatives)
        return replace(self, counts=counts, sums=sums)

    @property
    def precision(self) -> Array:
        """Of each offset, were the law's numbers known, shape (cells,)."""
        return self.counts + self.deviation**-2.0

    def left_to_numbers(self, information: Array) -> Array:
        """The information on the law's numbers once the offsets are allowed for, shape (k + p, k + p)."""
        allowed = self.sums / self.precision[:, None]
        return information - allowed.T @ self.sums

    def squares(self, used: RowsOfUse) -> Array:
        """Squares of the derivatives in rows of use once each row's offset is allowed for, shape (k + p, k + p)."""
        # Taken from the derivatives of each row of the cell.
        allowed = self.sums / self.precision[:, None]
        mixed = used.sums.T @ allowed
        weighed = allowed * used.counts[:, None]
        return used.squares - mixed - mixed.T + weighed.T @ allowed

    def own_variance(self, used: RowsOfUse) -> float:
        """Variance of the offsets themselves, a mean over the rows of use."""
        return float(used.counts @ (1.0 / self.precision)) / used.rows
