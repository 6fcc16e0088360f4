"""``ros2 topic echo --csv`` of joint states writes no names: the columns are told by what the message holds.

A row of ``sensor_msgs/JointState`` has the seconds and the nanoseconds of its stamp, the name of a frame, then the name
of each joint, and then a position, a velocity and an effort of each. Only such a table has as many words in all rows,
and three times as many numbers behind them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.table import Table

_NAMELESS = re.compile(r"c(\d{1,4})")
_NANOSECONDS = 1e9
_FRAME = 3  # place of the frame's name; the joints' names begin behind it
_QUANTITIES = ("position", "velocity", "effort")


def with_joint_states_named(table: Table) -> Table:
    """The table with names for the stamp, and for the quantities of each joint; as it is where it is no such echo."""
    words = _places(table.unreadable)
    numbers = _places(table.columns)
    joints = [place for place in words if place > _FRAME]
    first = _FRAME + 1 + len(joints)  # place of the first joint's position
    of_joints = [*range(first, first + len(_QUANTITIES) * len(joints))]
    is_echo = (
        bool(joints)
        and joints == [*range(_FRAME + 1, first)]
        and len(numbers) == len(table.columns)
        and numbers == [1, 2, *of_joints]
    )
    if not is_echo:
        return table
    seconds = table.columns["c1"]
    nanoseconds = table.columns["c2"]  # beyond the seconds
    for part in (seconds, nanoseconds):
        if not np.isfinite(part).all() or not are_whole(part):
            return table
    never_fall = bool(np.all(np.diff(seconds) >= 0.0))
    if not never_fall or not 0.0 <= nanoseconds.min() <= nanoseconds.max() < _NANOSECONDS:
        return table

    new_names = {"c1": "sec", "c2": "nanosec"}
    named = [
        f"{quantity}_{joint}" for quantity in _QUANTITIES for joint in range(1, len(joints) + 1)
    ]
    if len(joints) == 1:
        named = [*_QUANTITIES]
    new_names |= {f"c{place}": name for place, name in zip(of_joints, named, strict=True)}
    note = (
        f"an echo of joint states without names: columns are called {named[0]} .. {named[-1]} by their places in the "
        f"message, for {len(joints)} {'joint' if len(joints) == 1 else 'joints'}"
    )
    return replace(
        table,
        columns={new_names[name]: values for name, values in table.columns.items()},
        units={new_names[name]: unit for name, unit in table.units.items() if name in new_names},
        numbers={new_names[name]: at for name, at in table.numbers.items() if name in new_names},
        notes=(*table.notes, note),
    )


def _places(names: Iterable[str]) -> list[int]:
    """Places of the columns that are called by them alone, in the order of the file."""
    matches = [_NAMELESS.fullmatch(name) for name in names]
    return sorted(int(match[1]) for match in matches if match)
