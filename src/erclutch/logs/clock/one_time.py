"""A table gets one time for all of its columns: split stamps are put together, channels of several rates are joined.

A stamp in two columns, whole seconds and the nanoseconds beyond them as ROS writes it, is one time. So is a time of day
in columns of hours, minutes and seconds.

Channels of several rates may be woven into one table: each row has the cells of the channel that was sampled then.
Exports of plotting tools for robots are such: the current stands in other rows than the torque, and each row has a
time. Such cells are not missing; the channels are joined by time, as groups of a measurement file are.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.readers.found_recordings import Found, joined_by_time
from erclutch.logs.table import Table
from erclutch.signals.array import Array, Mask
from erclutch.signals.units import is_unit, parse

_SECONDS = re.compile(r"(.*?)[._/ ]?(?:secs?|seconds)", re.IGNORECASE)
_BEYOND = {
    **dict.fromkeys(("nsec", "nsecs", "nanosec", "nanosecs", "nanoseconds"), 1e-9),
    **dict.fromkeys(("usec", "usecs", "microseconds"), 1e-6),
}
_TIME = "time"
#: What the columns of a time of day are called, their unit in s, and how many of them make the next larger one.
_OF_A_DAY = (
    ("hour hours hr hrs hh stunde heure hora ora 时 時", 3600.0, 24),
    ("minute minutes min mins mm minuto minuti 分", 60.0, 60),
    ("second seconds sec secs ss sekunde seconde segundo secondo 秒", 1.0, 60),
    ("millisecond milliseconds millisec msec ms", 1e-3, 1000),
    ("microsecond microseconds microsec usec us", 1e-6, 1_000_000),
)
_DATES = frozenset({"year", "month", "day", "yyyy", "dd", "jahr", "monat", "tag", "annee", "mois", "jour"})
_DAY = 86_400.0  # s
_FEWEST = 20  # samples of a channel
_MOST = 0.75  # share of the rows in which a channel beside whole columns has cells: with more, values are missing
_STEADY = 4.0  # times its usual distance that the samples of such a channel are apart at most
_ONE_A_ROW = (0.9, 1.1)  # channels a row where each stands in rows of its own


def with_whole_stamps(table: Table) -> Table:
    """The table with one column in s in place of seconds and nanoseconds; as it is where there is no such pair."""
    columns = dict(table.columns)
    notes: list[str] = []
    for name in table.columns:
        match = _SECONDS.fullmatch(name)
        beyond = None if match is None else _beyond(table, match.group(1))
        if beyond is not None:
            other, factor = beyond
            columns[name] = columns[name] + factor * columns.pop(other)
            notes.append(f"columns {name} and {other} are one time, in s")
    if notes:
        return replace(table, columns=columns, notes=(*table.notes, *notes))
    return _with_time_of_day(table)


def _with_time_of_day(table: Table) -> Table:
    """The table with one column in s in place of hours, minutes and seconds; as it is where these are no time of day.

    The seconds of a time of day begin anew with each minute, so that its parts alone are no time.
    """
    parts: dict[float, str] = {}  # unit in s -> name
    begins_anew = False
    for words, unit, most in _OF_A_DAY:
        known = words.split()
        name = next((name for name in table.columns if name.strip().lower() in known), None)
        if name is None:
            continue
        values = table.columns[name]
        whole = unit == 1.0 or bool(np.all(values == np.round(values)))
        own = table.units.get(name)
        other_unit = own is not None and not (is_unit(own) and parse(own).factor == unit)
        if other_unit or not np.isfinite(values).all() or not whole or values.min() < 0.0 or values.max() >= most:
            return table
        begins_anew = begins_anew or (unit <= 1.0 and bool(np.any(np.diff(values) < 0.0)))
        parts[unit] = name
    if not {60.0, 1.0} <= parts.keys() or not (begins_anew or 3600.0 in parts):
        return table

    since_midnight = np.sum([unit * table.columns[name] for unit, name in parts.items()], axis=0)
    days = np.cumsum(np.diff(since_midnight, prepend=since_midnight[0]) < -_DAY / 2)
    time = since_midnight + _DAY * days
    if np.any(np.diff(time) < 0.0) or time[0] == time[-1]:
        return table
    dates = [name for name in table.columns if name.strip().lower() in _DATES]
    name = _TIME if _TIME not in table.columns else "time of day"
    merged = {*parts.values(), *dates}
    left = {each: values for each, values in table.columns.items() if each not in merged}
    note = f"columns {', '.join(parts.values())} are one time of day, in s: column {name}"
    return replace(
        table,
        columns={name: time, **left},
        units={**table.units, name: "s"},
        notes=(*table.notes, note),
    )


def _beyond(table: Table, stem: str) -> tuple[str, float] | None:
    """The column with the rest of a stamp, by the name in front of ``sec``, and the factor to s."""
    for name, values in table.columns.items():
        front = name[: len(stem)]
        word = name[len(stem) :].lstrip("._/ ").lower()
        if front != stem or word not in _BEYOND:
            continue
        factor = _BEYOND[word]
        known = values[np.isfinite(values)]
        within_a_second = known.size and known.min() >= 0.0 and known.max() * factor < 1.0
        if within_a_second and np.all(known == np.round(known)):
            return name, factor
    return None


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
    if channels is None or len(channels) + bool(whole) < 2:
        return table
    if whole:
        each_row = np.ones(table.rows, np.bool_)
        channels = [(each_row, whole), *channels]

    # The effort is never made up between two samples: its channel goes first.
    efforts = {name for name, column in seen.columns.items() if "effort" in column.spoken.may_be}

    def place(channel: tuple[Mask, list[str]]) -> tuple[bool, int]:
        """The effort's channel, then those with the most samples."""
        rows, names = channel
        return efforts.isdisjoint(names), -int(np.count_nonzero(rows))

    channels.sort(key=place)
    found: dict[str, Found] = {}
    for rows, names in channels:
        columns = {_TIME: stamps[rows]}
        for name in names:
            columns[name] = table.columns[name][rows]
        units = {name: table.units.get(name) for name in names}
        found[names[0]] = Found(columns, units)
    try:
        joined = joined_by_time(found, "column")
    except LogError:  # no time that grows, or none that all have
        return table
    at = joined.columns.pop(_TIME)
    columns = {name: joined.columns[name] for name in table.columns if name in joined.columns}
    clock = at if table.clock is not None else None
    if time:
        columns = {time: at, **columns}
    note = f"the table holds {len(channels)} channels that were sampled at times of their own"
    return replace(
        table,
        columns=columns,
        clock=clock,
        breaks=(),
        words={},
        notes=(*table.notes, note, *joined.notes),
    )


def _channels(sparse: Mapping[str, Array], *, woven_alone: bool) -> list[tuple[Mask, list[str]]] | None:
    """The rows and the columns of each channel; None where a column has values missing as a sensor that fails has.

    Args:
        sparse: columns with values missing, each (n,).
        woven_alone: whether all columns but the time are such.
    """
    channels: dict[bytes, tuple[Mask, list[str]]] = {}
    for name, values in sparse.items():
        rows = np.isfinite(values)
        _, names = channels.setdefault(rows.tobytes(), (rows, []))
        names.append(name)
    filled = sum(np.count_nonzero(rows) for rows, _ in channels.values())
    cells = filled / next(iter(sparse.values())).size  # a row
    for rows, _ in channels.values():
        places = np.flatnonzero(rows)
        if places.size < _FEWEST:
            return None
        if woven_alone and _ONE_A_ROW[0] <= cells <= _ONE_A_ROW[1]:
            continue  # in each row the cells of one channel alone
        steps = np.diff(np.concatenate([[-1], places, [rows.size]]))
        if places.size > _MOST * rows.size or steps.max() > _STEADY * np.median(steps):
            return None
    return list(channels.values())
