"""Channels may stand side by side, each behind a time of its own: they are joined by time.

Scopes of controllers and spreadsheets with channels of two rates are such. Times that repeat the first are left out.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
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
    if not _is_called_time(called):
        return table
    of_one_name = [name for name in table.columns if _COPY.sub("", name) == called]
    is_of_one_name = len(of_one_name) > 1 and spoken_name(called).is_time
    times = of_one_name if is_of_one_name else [name for name in table.columns if _is_called_time(name)]
    channels: dict[str, list[str]] = {}  # by the column of their time
    for name in table.columns:
        if name in times and table.units.get(name) == table.units.get(first):
            channels[name] = []
        else:
            channels[[*channels][-1]].append(name)
    if len(channels) < 2 or not all(channels.values()):
        return table
    if not is_of_one_name and not _end_with_their_times(table, channels):
        return table  # a second stamp of the same rows
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
    at = joined.columns.pop(_TIME)
    first = first if spoken_name(first).is_time or spoken_name(first).ends_in_time else _TIME
    columns = {first: at, **joined.columns}
    note = f"{len(channels)} channels stand behind times of their own"
    return replace(
        table,
        columns=columns,
        units={**joined.units, first: unit},
        breaks=(),
        notes=(*table.notes, note, *joined.notes),
    )


def _is_called_time(name: str) -> bool:
    """Whether a name is that of a time, or of one of several: ``Time2``, ``Current Time``, ``t_fast``."""
    spoken = spoken_name(name)
    if spoken.is_time or spoken.ends_in_time:
        return True
    words = [word for word in (re.sub(r"\d+$", "", word) for word in spoken.stem_words) if word]
    is_temperature = re.match(r"T(?![a-z])", spoken.stem) is not None  # T1, T_oil
    return 0 < len(words) < 3 and spoken_name(words[0]).is_time and not is_temperature


def _end_with_their_times(table: Table, channels: Mapping[str, list[str]]) -> bool:
    """Whether each channel has cells down to where its time ends, and the times end in different rows."""
    ends: set[int] = set()
    for time, names in channels.items():
        rows = int(np.count_nonzero(np.isfinite(table.columns[time])))
        for name in (time, *names):
            known = np.isfinite(table.columns[name])
            if not known[:rows].all() or np.count_nonzero(known) != rows:
                return False
        ends.add(rows)
    return len(ends) > 1
