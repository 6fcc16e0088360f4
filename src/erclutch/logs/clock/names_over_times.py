"""Drives record pairs of columns, a count or a time and a value, and write the channel's name over the first of them.

Where a line below the names calls the pairs x and y, names that speak are put right by
`erclutch.logs.readers.header_lines`. Names that say nothing (``0x2201/31``) are put right here, by the numbers.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from erclutch.logs.columns.seen_columns import EVEN
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_FEWEST_ROWS = 200  # a curve that was read off a picture has fewer
_TIME = "time"


def with_names_at_values(table: Table) -> Table:
    """The table with the names at the values, where they stand over one and the same time that rises by equal steps."""
    names = [*table.columns]
    over_times = names[::2]
    values = names[1::2]
    if len(values) < 2 or len(over_times) != len(values) or table.rows < _FEWEST_ROWS:
        return table
    for time, value in zip(over_times, values, strict=True):
        place = table.numbers.get(value, 0)
        # A column without a name is called by its place, which follows that of the column with one.
        if value != f"c{place}" or table.numbers.get(time) != place - 1 or time == f"c{place - 1}":
            return table
    times = [table.columns[name] for name in over_times]
    is_one_time = all(np.array_equal(one, other) for one, other in pairwise(times))
    stamps = times[0]
    steps = np.diff(stamps)
    begins_at_zero = is_one_time and stamps[0] == 0.0 and np.all(steps > 0.0)
    if not begins_at_zero or np.ptp(steps) > EVEN * np.median(steps):
        return table

    columns: dict[str, Array] = {_TIME: stamps}
    units: dict[str, str | None] = {_TIME: None}
    numbers = {_TIME: table.numbers[over_times[0]]}
    for name, value in zip(over_times, values, strict=True):
        columns[name] = table.columns[value]
        units[name] = table.units.get(name)
        numbers[name] = table.numbers[value]
    note = f"each name stands over a time that all {len(values)} channels share: the names are those of the values"
    return replace(table, columns=columns, units=units, numbers=numbers, notes=(*table.notes, note))
