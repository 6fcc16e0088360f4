"""Channels that were sampled at times of their own, in one table, are joined by time.

Scopes of controllers, and spreadsheets with channels of two rates, have each channel behind a time of its own. Exports
of plotting tools for robots weave channels: the current stands in other rows than the torque, and each row has a time.
Cells without a number are not missing there. The effort is never made up between two samples, so the others are brought
to its times.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.labels import without_copy_number
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.readers.found_recordings import Found, joined_by_time
from erclutch.logs.table import Table
from erclutch.signals.array import Array, Mask

_TIME = "time"  # of a channel, while the channels are joined
_FEWEST = 20  # samples of a channel
_MOST = 0.75  # share of the rows in which a channel beside whole columns has cells: with more, values are missing
_STEADY = 4.0  # times its usual distance that the samples of such a channel are apart at most
_ONE_A_ROW = (0.9, 1.1)  # channels a row where each stands in rows of its own


def with_times_joined(table: Table) -> Table:
    """The table with all channels at the times of one, where each stands behind a time of its own.

    Times that repeat the first are left out; else the channels are joined by time.
    """
    if not table.columns or table.clock is not None:
        return table
    first, *_ = table.columns
    called = without_copy_number(first)
    if not _is_called_time(called):
        return table
    times = [name for name in table.columns if without_copy_number(name) == called]
    have_one_name = len(times) > 1 and spoken_name(called).is_time
    if not have_one_name:
        times = [name for name in table.columns if _is_called_time(name)]
    channels: dict[str, list[str]] = {}  # by the column of their time
    last = first
    for name in table.columns:
        if name in times and table.units.get(name) == table.units.get(first):
            last = name
            channels[name] = []
        else:
            channels[last].append(name)
    if len(channels) < 2 or not all(channels.values()):
        return table
    signals = [without_copy_number(name) for names in channels.values() for name in names]
    if len({*signals}) < len(signals):  # tables of the same columns
        return table
    for time in channels:
        stamps = table.columns[time]
        if np.any(np.diff(stamps[np.isfinite(stamps)]) <= 0.0):
            return table

    _, *other_times = channels
    stamps_of_first = table.columns[first]
    times_of_others = [table.columns[time] for time in other_times]
    if all(np.array_equal(stamps, stamps_of_first, equal_nan=True) for stamps in times_of_others):
        columns = dict(table.columns)
        for time in other_times:
            del columns[time]
        note = f"column {', '.join(other_times)} repeats {first}"
        return replace(table, columns=columns, notes=(*table.notes, note))
    if not have_one_name and not _end_with_their_times(table, channels):
        return table  # a second stamp of the same rows

    efforts = {name for name in table.columns if "effort" in spoken_name(name).may_be}
    with_effort = [time for time, names in channels.items() if not efforts.isdisjoint(names)]
    recordings: dict[str, Found] = {}
    for time in dict.fromkeys([*with_effort, *channels]):
        stamps = table.columns[time]
        names = channels[time]
        recordings[names[0]] = _recording(table, names, stamps, np.isfinite(stamps))
    joined = _joined(recordings, "channel")
    if joined is None:
        return table
    unit = table.units.get(first)
    says_time = spoken_name(first).is_time or spoken_name(first).ends_in_time
    time = first if says_time else _TIME
    at = joined.columns.pop(_TIME)
    note = f"{len(channels)} channels stand behind times of their own"
    return replace(
        table,
        columns={time: at, **joined.columns},
        units={**joined.units, time: unit},
        breaks=(),
        notes=(*table.notes, note, *joined.notes),
    )


def _is_called_time(name: str) -> bool:
    """Whether a name is that of a time, or of one of several: ``Time2``, ``Current Time``, ``t_fast``."""
    spoken = spoken_name(name)
    if spoken.is_time or spoken.ends_in_time:
        return True
    unnumbered = [re.sub(r"\d+$", "", word) for word in spoken.stem_words]
    words = [word for word in unnumbered if word]
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


@dataclass(frozen=True)
class _Channel:
    """Columns of a weave that have cells in the same rows.

    Attributes:
        rows: in which they have cells, shape (rows of the table,).
        columns: their names.
    """

    rows: Mask
    columns: list[str] = field(default_factory=list[str])


def unwoven(table: Table) -> Table:
    """The table with all channels at the times of one, that of the effort; as it is where it is no such weave."""
    has_holes = any(np.isnan(values).any() for values in table.columns.values())
    if table.unsampled is not None or not has_holes:
        return table
    seen = seen_columns(table)
    stamps = seen.stamps
    time = "" if table.clock is not None else seen.time_column()
    if stamps is None or time is None or not np.isfinite(stamps).all():
        return table

    whole: list[str] = []  # columns with a cell in each row
    sparse: dict[str, Array] = {}
    for name, values in table.columns.items():
        if name == time:
            continue
        if np.isnan(values).any():
            sparse[name] = values
        else:
            whole.append(name)
    channels = _woven_channels(sparse, woven_alone=not whole)
    if whole and channels:
        each_row = np.ones(table.rows, np.bool_)
        channels = [_Channel(each_row, whole), *channels]
    if len(channels) < 2:
        return table

    # The channel of the effort goes first, then those with the most samples.
    efforts = {name for name, column in seen.columns.items() if "effort" in column.spoken.may_be}
    channels.sort(
        key=lambda channel: (efforts.isdisjoint(channel.columns), -np.count_nonzero(channel.rows))
    )
    recordings: dict[str, Found] = {}
    for channel in channels:
        recordings[channel.columns[0]] = _recording(table, channel.columns, stamps, channel.rows)
    joined = _joined(recordings, "column")
    if joined is None:
        return table
    at = joined.columns.pop(_TIME)
    columns = {name: joined.columns[name] for name in table.columns if name in joined.columns}
    note = f"the table holds {len(channels)} channels that were sampled at times of their own"
    return replace(
        table,
        columns={time: at, **columns} if time else columns,
        clock=None if table.clock is None else at,
        breaks=(),
        words={},
        notes=(*table.notes, note, *joined.notes),
    )


def _woven_channels(sparse: Mapping[str, Array], *, woven_alone: bool) -> list[_Channel]:
    """The channels of a weave; none where a column has values missing as a sensor that fails has.

    Args:
        sparse: columns with values missing, each (n,).
        woven_alone: whether all columns but the time are such.
    """
    channels: dict[bytes, _Channel] = {}
    for name, values in sparse.items():
        rows = np.isfinite(values)
        channel = channels.setdefault(rows.tobytes(), _Channel(rows))
        channel.columns.append(name)
    filled = sum(np.count_nonzero(channel.rows) for channel in channels.values())
    cells_a_row = filled / next(iter(sparse.values())).size
    fewest, most = _ONE_A_ROW
    # In each row stand the cells of one channel alone.
    is_one_a_row = woven_alone and fewest <= cells_a_row <= most
    for channel in channels.values():
        rows = channel.rows
        places = np.flatnonzero(rows)
        if places.size < _FEWEST:
            return []
        if is_one_a_row:
            continue
        steps = np.diff(np.concatenate([[-1], places, [rows.size]]))
        if places.size > _MOST * rows.size or steps.max() > _STEADY * np.median(steps):
            return []
    return list(channels.values())


def _recording(table: Table, names: Iterable[str], stamps: Array, rows: Mask) -> Found:
    """Some columns in some rows as a recording of their own, on the times of these rows."""
    columns = {_TIME: stamps[rows]}
    units: dict[str, str | None] = {}
    for name in names:
        columns[name] = table.columns[name][rows]
        units[name] = table.units.get(name)
    return Found(columns, units)


def _joined(recordings: Mapping[str, Found], what: str) -> Found | None:
    """Recordings at the times of the first; None where times do not grow, or where no time is one of all."""
    try:
        return joined_by_time(recordings, what)
    except LogError:
        return None
