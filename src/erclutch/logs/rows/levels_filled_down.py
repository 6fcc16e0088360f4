"""A sheet may give a level once, in the first row of the rows it is for: it holds down to the next level.

So merged cells of a workbook are read, and what people leave blank below a current. Where blanks mean that, another
column shows it: it runs through its course once for each level, and begins anew where the next level stands. An effort
is measured and no level: where it stands once a course, nobody knows the rest of it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from erclutch.logs.columns.names import spoken_name
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_FEWEST_LEVELS = 2
_FEWEST_ROWS = 3  # of a level: two rows make no course


def with_levels_filled_down(table: Table) -> Table:
    """The table with such levels in all of their rows; else as it is."""
    filled: dict[str, Array] = {}
    for name, column in table.columns.items():
        starts = np.flatnonzero(np.isfinite(column))
        ends = np.append(starts[1:], table.rows)
        spoken = spoken_name(name)
        may_be_set = "effort" not in spoken.may_be | spoken.within
        is_a_level = may_be_set and starts.size >= _FEWEST_LEVELS and starts[0] == 0
        if not is_a_level or np.any(ends - starts < _FEWEST_ROWS):
            continue
        others = [other for other in table.columns.values() if np.all(np.isfinite(other))]
        if any(_begins_anew(other, starts) for other in others):
            filled[name] = np.repeat(column[starts], ends - starts)
    if not filled:
        return table
    note = (
        f"{', '.join(filled)}: a number stands in the first row of each level alone, and holds down "
        "to the next"
    )
    return replace(table, columns={**table.columns, **filled}, notes=(*table.notes, note))


def _begins_anew(course: Array, starts: NDArray[np.intp]) -> bool:
    """Whether a column runs one way between the starts, and back at each of them."""
    steps = np.diff(course)
    at_a_start = np.zeros(steps.size, bool)
    at_a_start[starts[1:] - 1] = True
    within, back = steps[~at_a_start], steps[at_a_start]
    if not within.any():
        return False  # it has no course
    rises = bool(np.all(within >= 0.0) and np.all(back < 0.0))
    falls = bool(np.all(within <= 0.0) and np.all(back > 0.0))
    return rises or falls
