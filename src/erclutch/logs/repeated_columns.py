"""Columns that say what another column says are left out: degrees beside radians, a travel beside a position."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from erclutch.logs.seen_columns import SeenColumn, SeenColumns
from erclutch.signals import units
from erclutch.signals.array import Array

_DIGITS = 2e-3  # share of the largest number by which numbers written with some digits may differ


def distinct(seen: SeenColumns, names: Iterable[str]) -> list[str]:
    """Columns without those that never change beside some that do, and without the same numbers in another unit."""
    found = [seen.columns[name] for name in names]
    moving = [column for column in found if not column.shape.constant]
    kept: list[SeenColumn] = []
    for column in moving or found:
        if not any(_one_quantity(column, other) for other in kept):
            kept.append(column)
    return [column.name for column in kept]


def one_motion(seen: SeenColumns, names: Iterable[str]) -> list[str]:
    """Positions without those that say the same from another zero: a travel beside an absolute one."""
    kept: list[SeenColumn] = []
    for column in (seen.columns[name] for name in names):
        if not any(column.unit == other.unit and _move_alike(column.values, other.values) for other in kept):
            kept.append(column)
    return [column.name for column in kept]


def _one_quantity(column: SeenColumn, other: SeenColumn) -> bool:
    """Whether two columns with units hold one quantity: degrees beside radians."""
    unit, other_unit = column.written_unit, other.written_unit
    if not unit or not other_unit or not units.is_unit(unit) or not units.is_unit(other_unit):
        return False
    first, second = units.parse(unit), units.parse(other_unit)
    if first.dimension != second.dimension or first.factor == second.factor:
        return False

    one = column.values * first.factor
    two = other.values * second.factor
    known = np.isfinite(one) & np.isfinite(two)
    largest = float(np.abs(one[known]).max(initial=0.0))
    if not largest > 0.0:
        return False
    return bool(np.abs(one - two)[known].max() <= _DIGITS * largest)


def _move_alike(first: Array, second: Array) -> bool:
    """Whether two positions in one unit differ in where they count from, and in nothing else."""
    known = np.isfinite(first) & np.isfinite(second)
    moved = float(np.ptp(first[known])) if known.any() else 0.0
    return bool(moved > 0.0 and np.ptp((first - second)[known]) <= _DIGITS * moved)
