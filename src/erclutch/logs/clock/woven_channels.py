"""Channels of several rates that are woven into one table are joined by time: each row has the cells of one channel.

Exports of plotting tools for robots are such: the current stands in other rows than the torque, and each row has a
time. Such cells are not missing; the channels are joined by time, as groups of a measurement file are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.readers.found_recordings import Found, joined_by_time
from erclutch.logs.table import Table
from erclutch.signals.array import Array, Mask

_TIME = "time"
_FEWEST = 20  # samples of a channel
_MOST = 0.75  # share of the rows in which a channel beside whole columns has cells: with more, values are missing
_STEADY = 4.0  # times its usual distance that the samples of such a channel are apart at most
_ONE_A_ROW = (0.9, 1.1)  # channels a row where each stands in rows of its own


@dataclass(frozen=True)
class _Channel:
    """Columns that have cells in the same rows.

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
    channels = _channels(sparse, woven_alone=not whole)
    if whole:
        each_row = np.ones(table.rows, np.bool_)
        channels = [_Channel(each_row, whole), *channels] if channels else []
    if len(channels) < 2:
        return table

    # The effort is never made up between two samples: its channel goes first, then those with the most samples.
    efforts = {name for name, column in seen.columns.items() if "effort" in column.spoken.may_be}
    channels.sort(key=lambda channel: (efforts.isdisjoint(channel.columns), -np.count_nonzero(channel.rows)))
    recordings: dict[str, Found] = {}
    for channel in channels:
        columns = {_TIME: stamps[channel.rows]}
        for name in channel.columns:
            columns[name] = table.columns[name][channel.rows]
        units = {name: table.units.get(name) for name in channel.columns}
        recordings[channel.columns[0]] = Found(columns, units)
    try:
        joined = joined_by_time(recordings, "column")
    except LogError:  # no time that grows, or none that all have
        return table

    at = joined.columns.pop(_TIME)
    columns = {name: joined.columns[name] for name in table.columns if name in joined.columns}
    if time:
        columns = {time: at, **columns}
    note = f"the table holds {len(channels)} channels that were sampled at times of their own"
    return replace(
        table,
        columns=columns,
        clock=None if table.clock is None else at,
        breaks=(),
        words={},
        notes=(*table.notes, note, *joined.notes),
    )


def _channels(sparse: Mapping[str, Array], *, woven_alone: bool) -> list[_Channel]:
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
    is_one_a_row = woven_alone and fewest <= cells_a_row <= most  # in each row the cells of one channel alone
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
