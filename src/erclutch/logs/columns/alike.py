"""Columns that say what another one says are told apart: degrees beside radians, counts beside volts, a second zero."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.columns.two_courses import go_straight
from erclutch.signals import units
from erclutch.signals.array import Array

_DIGITS = 2e-3  # share of the largest number by which numbers written with some digits may differ


def distinct(seen: SeenColumns, names: Iterable[str]) -> list[str]:
    """Columns without those that never change beside some that do, and without the same numbers in another unit."""
    columns = [seen.columns[name] for name in names]
    moving = [column for column in columns if not column.shape.constant]
    kept: list[SeenColumn] = []
    for column in moving or columns:
        if not any(_are_one_quantity(column, other) for other in kept):
            kept.append(column)
    return [column.name for column in kept]


def _are_one_quantity(column: SeenColumn, other: SeenColumn) -> bool:
    """Whether two columns with units hold one quantity: degrees beside radians."""
    unit = column.written_unit
    other_unit = other.written_unit
    if not unit or not other_unit:
        return False
    if not units.is_unit(unit) or not units.is_unit(other_unit):
        return False
    meaning = units.parse(unit)
    other_meaning = units.parse(other_unit)
    if meaning.dimension != other_meaning.dimension or meaning.factor == other_meaning.factor:
        return False

    in_si = column.values * meaning.factor
    other_in_si = other.values * other_meaning.factor
    known = np.isfinite(in_si) & np.isfinite(other_in_si)
    largest = float(np.abs(in_si[known]).max(initial=0.0))
    if not largest > 0.0:
        return False
    off = np.abs(in_si - other_in_si)[known]
    return bool(off.max() <= _DIGITS * largest)


def without_raw(seen: SeenColumns, names: Sequence[str]) -> list[str]:
    """Columns without each that has no unit and goes straight with one that has: the counts of its converter."""
    columns = [seen.columns[name] for name in names]
    with_unit = [column for column in columns if column.written_unit]
    kept: list[str] = []
    for column in columns:
        is_raw = not column.written_unit and any(go_straight(column.values, other.values) for other in with_unit)
        if not is_raw:
            kept.append(column.name)
    return kept


def without_other_zeros(seen: SeenColumns, positions: Iterable[str]) -> list[str]:
    """Positions without those that say the same from another zero: a travel beside an absolute one."""
    kept: list[SeenColumn] = []
    for name in positions:
        position = seen.columns[name]
        in_that_unit = [other for other in kept if other.unit == position.unit]
        if not any(_move_alike(position.values, other.values) for other in in_that_unit):
            kept.append(position)
    return [position.name for position in kept]


def _move_alike(position: Array, other: Array) -> bool:
    """Whether two positions in one unit differ in where they count from, and in nothing else."""
    known = np.isfinite(position) & np.isfinite(other)
    if not known.any():
        return False
    moved = float(np.ptp(position[known]))
    apart = (position - other)[known]
    return bool(moved > 0.0 and np.ptp(apart) <= _DIGITS * moved)
