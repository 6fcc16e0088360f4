"""A stamp that stands in several columns becomes one time: seconds and the nanoseconds beyond them, as ROS writes it.

So does a time of day in columns of hours, minutes and seconds, and a date with milliseconds in a column of their own.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.table import Table
from erclutch.signals.array import Array
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
_DATES = frozenset(
    {"year", "month", "day", "yyyy", "dd", "jahr", "monat", "tag", "annee", "mois", "jour"}
)
_DAY = 86_400.0  # s


def with_whole_stamps(table: Table) -> Table:
    """The table with one column in s in place of seconds and nanoseconds; as it is where there is no such pair."""
    columns = dict(table.columns)
    notes: list[str] = []
    for name in table.columns:
        match = _SECONDS.fullmatch(name)
        if match is None:
            continue
        # The rest of a stamp has the same name in front of its unit.
        stem = match.group(1)
        for other, values in table.columns.items():
            word = other[len(stem) :].lstrip("._/ ").lower()
            if other[: len(stem)] != stem or word not in _BEYOND:
                continue
            factor = _BEYOND[word]  # to s
            known = values[np.isfinite(values)]
            within_a_second = known.size and known.min() >= 0.0 and known.max() * factor < 1.0
            if within_a_second and are_whole(known):
                columns[name] = columns[name] + factor * columns.pop(other)
                notes.append(f"columns {name} and {other} are one time, in s")
                break
    if notes:
        return replace(table, columns=columns, notes=(*table.notes, *notes))
    if table.clock is not None:
        return _with_milliseconds(table, table.clock)
    return _with_time_of_day(table)


def _with_milliseconds(table: Table, clock: Array) -> Table:
    """The table with its dates in ms, where a column beside whole seconds has the milliseconds beyond them.

    Args:
        table: with dates.
        clock: its dates in s, shape (n,).
    """
    *_, (words, unit, most), _ = _OF_A_DAY
    name = next((name for name in table.columns if name.strip().lower() in words.split()), None)
    if name is None or not are_whole(clock):
        return table
    beyond = table.columns[name]
    if not np.isfinite(beyond).all() or not are_whole(beyond):
        return table
    if not 0 <= beyond.min() <= beyond.max() < most:
        return table
    time = clock + unit * beyond
    if np.any(np.diff(time) <= 0.0):
        return table
    called = table.clock_name.split(" and ")
    return replace(
        table,
        clock=time - time[0],
        columns={each: values for each, values in table.columns.items() if each != name},
        words={each: words for each, words in table.words.items() if each not in called},
        notes=(*table.notes, f"column {name} has the milliseconds of {table.clock_name}"),
    )


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
        written = table.units.get(name)
        if written is not None and not (is_unit(written) and parse(written).factor == unit):
            return table
        if not np.isfinite(values).all() or values.min() < 0.0 or values.max() >= most:
            return table
        if unit != 1.0 and not are_whole(values):
            return table
        if unit <= 1.0 and np.any(np.diff(values) < 0.0):
            begins_anew = True
        parts[unit] = name
    if not {60.0, 1.0} <= parts.keys() or not (begins_anew or 3600.0 in parts):
        return table

    in_seconds = [unit * table.columns[name] for unit, name in parts.items()]
    since_midnight = np.sum(in_seconds, axis=0)  # s, shape (n,)
    steps = np.diff(since_midnight, prepend=since_midnight[0])
    days = np.cumsum(steps < -_DAY / 2)
    time = since_midnight + _DAY * days
    if np.any(np.diff(time) < 0.0) or time[0] == time[-1]:
        return table
    merged = {*parts.values()}
    other_columns: dict[str, Array] = {}
    for name, values in table.columns.items():
        if name not in merged and name.strip().lower() not in _DATES:
            other_columns[name] = values
    called = _TIME if _TIME not in table.columns else "time of day"
    note = f"columns {', '.join(parts.values())} are one time of day, in s: column {called}"
    return replace(
        table,
        columns={called: time, **other_columns},
        units={**table.units, called: "s"},
        notes=(*table.notes, note),
    )
