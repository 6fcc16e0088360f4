"""Channels may stand side by side, each behind a time of its own: they are joined by time.

Scopes of controllers write so. Times that repeat the first are left out.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.readers.found_recordings import Found, joined_by_time
from erclutch.logs.table import Table

_TIME = "time"
_COPY = re.compile(r" \(\d+\)")  # behind a name that an earlier column has


def with_times_joined(table: Table) -> Table:
    """The table with all channels at the times of one, where each stands behind a time of its own.

    Times that repeat the first are left out; else the channels are joined by time.
    """
    if not table.columns or table.clock is not None:
        return table
    first, *_ = table.columns
    called = _COPY.sub("", first)
    channels: dict[str, list[str]] = {}  # by the column of their time
    for name in table.columns:
        if _COPY.sub("", name) == called and table.units.get(name) == table.units.get(first):
            channels[name] = []
        else:
            channels[[*channels][-1]].append(name)
    if len(channels) < 2 or not all(channels.values()) or not spoken_name(called).is_time:
        return table
    values = [_COPY.sub("", name) for names in channels.values() for name in names]
    if len({*values}) < len(values):  # tables of the same columns
        return table
    for time in channels:
        stamps = table.columns[time]
        if np.any(np.diff(stamps[np.isfinite(stamps)]) <= 0.0):
            return table

    _, *others = channels
    if all(np.array_equal(table.columns[other], table.columns[first], equal_nan=True) for other in others):
        columns = {name: each for name, each in table.columns.items() if name not in others}
        return replace(table, columns=columns, notes=(*table.notes, f"column {', '.join(others)} repeats {first}"))

    found: dict[str, Found] = {}
    efforts = [time for time, names in channels.items() if any("effort" in spoken_name(name).may_be for name in names)]
    for time in dict.fromkeys([*efforts, *channels]):
        known = np.isfinite(table.columns[time])
        columns = {_TIME: table.columns[time][known]}
        for name in channels[time]:
            columns[name] = table.columns[name][known]
        found[channels[time][0]] = Found(columns, {name: table.units.get(name) for name in channels[time]})
    try:
        joined = joined_by_time(found, "channel")
    except LogError:  # no time that all have
        return table
    unit = table.units.get(first)
    columns = {first: joined.columns.pop(_TIME), **joined.columns}
    note = f"{len(channels)} channels stand behind times of their own"
    return replace(
        table,
        columns=columns,
        units={**joined.units, first: unit},
        breaks=(),
        notes=(*table.notes, note, *joined.notes),
    )
