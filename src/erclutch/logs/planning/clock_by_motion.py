"""The unit of stamps that have none is told by a motion: a speed is the rate of its position in that unit alone."""

from __future__ import annotations

import re
from collections import Counter

from erclutch.logs.columns.names import TOLD
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.columns.two_courses import over_rate
from erclutch.signals.array import Array

#: How many times the rate by the stamps a speed is, where these are no seconds.
_RATIOS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
_CLOSE = 0.05
_NONE = ""  # what a pair in other units tells
_MANY = 12  # pairs of a speed and a position: more are not looked at
_JOINT = re.compile(r"\D*(\d+)\D*")


def unit_by_motion(seen: SeenColumns, stamps: Array) -> str | None:
    """The unit in which speeds are the rates of their positions; None where no pair tells one, or pairs tell several.

    A pair in units of its own, such as a gripper's, tells none: most of the pairs have to tell the one.

    Args:
        seen: the columns of the log.
        stamps: as logged, shape (n,).
    """
    told: Counter[str] = Counter()
    for speed, position in _pairs(seen):
        ratio = over_rate(speed.values, position.values, stamps)
        if ratio is None:
            continue
        fitting = [unit for unit, times in _RATIOS.items() if abs(ratio / times - 1.0) < _CLOSE]
        told[fitting[0] if fitting else _NONE] += 1
    units = {*told} - {_NONE}
    if len(units) != 1:
        return None
    unit = units.pop()
    return unit if told[unit] > told[_NONE] else None


def _pairs(seen: SeenColumns) -> list[tuple[SeenColumn, SeenColumn]]:
    """Speeds beside positions of the same joint, by their names; both without a unit, or both with one."""
    measured = [column for column in seen.columns.values() if TOLD.isdisjoint(column.spoken.stem_words)]
    speeds = [column for column in measured if "slip" in column.spoken.may_be]
    positions = [column for column in measured if "position" in column.spoken.may_be]
    pairs: list[tuple[SeenColumn, SeenColumn]] = []
    for speed in speeds:
        for position in positions:
            have_units = bool(speed.written_unit) == bool(position.written_unit)
            if have_units and speed is not position and _joint(speed) == _joint(position):
                pairs.append((speed, position))
    return pairs[:_MANY]


def _joint(column: SeenColumn) -> str:
    """The one number in a name; "" for none and several."""
    number = _JOINT.fullmatch(column.spoken.stem)
    return number.group(1) if number else ""
