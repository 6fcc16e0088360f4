"""A device may move at both ends: ``x1_dot`` and ``x2_dot``. Its slip is what they differ by, or one of them.

Where one end stands on the ground, or the other motion is of another floor of a building, the effort keeps to the sign
of one of them; the user is asked in any case.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from erclutch.logs.columns.seen_columns import SeenColumns
from erclutch.logs.columns.turn_apart import along
from erclutch.logs.table import MINUS

_ENDS = (("1", "2"), ("0", "1"))
_NUMBER = re.compile(r"\d+")
_ALONG_A_LINE = re.compile(r"d?[xyzv]", re.IGNORECASE)
_BETTER = 0.02  # share of the rows, by which one end's motion keeps the sign in more of them


def motion_between(seen: SeenColumns, names: Sequence[str], efforts: Sequence[str]) -> str:
    """What may be the motion of a device between two ends, as the label of a column or of a difference; "" for others.

    Args:
        seen: the columns of the log.
        names: the columns that may be the motion, the speed or the position of an end each.
        efforts: the columns that may be the effort; several are of several devices.
    """
    if len(names) != 2 or len(efforts) > 1:
        return ""
    first, second = (seen.columns[name] for name in names)
    numbers = tuple(_NUMBER.findall(first.name) + _NUMBER.findall(second.name))
    are_alike = _NUMBER.sub("#", first.name) == _NUMBER.sub("#", second.name)
    if numbers not in _ENDS or not are_alike or first.unit != second.unit:
        return ""
    may_be = first.spoken.may_be & {"slip", "position"}
    if not may_be or (not efforts and not _ALONG_A_LINE.match(first.name)):
        return ""  # joints of a robot turn each on its own
    effort = seen.columns[efforts[0]].values if efforts else np.zeros(seen.table.rows)
    is_speed = "slip" in may_be
    moves = [first.values, second.values, first.values - second.values]
    speeds = moves if is_speed else [np.gradient(each) for each in moves]
    of_first, of_second, of_both = (along(effort, speed) for speed in speeds)
    if max(of_first, of_second) > of_both + _BETTER:
        return seen.table.label(first.name if of_first >= of_second else second.name)
    difference = f"{first.name}{MINUS}{second.name}"
    return f"{difference} [{first.unit}]" if first.unit else difference
