"""A stamp in two columns, whole seconds and the nanoseconds beyond them as ROS writes it, is one time."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from erclutch.logs.table import Table

_SECONDS = re.compile(r"(.*?)[._/ ]?(?:secs?|seconds)", re.IGNORECASE)
_BEYOND = {
    **dict.fromkeys(("nsec", "nsecs", "nanosec", "nanosecs", "nanoseconds"), 1e-9),
    **dict.fromkeys(("usec", "usecs", "microseconds"), 1e-6),
}


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
    return replace(table, columns=columns, notes=(*table.notes, *notes)) if notes else table


def _beyond(table: Table, stem: str) -> tuple[str, float] | None:
    """The column with the rest of a stamp, by the name in front of ``sec``, and the factor to s."""
    for name, values in table.columns.items():
        front, word = name[: len(stem)], name[len(stem) :].lstrip("._/ ").lower()
        if front != stem or word not in _BEYOND:
            continue
        factor = _BEYOND[word]
        known = values[np.isfinite(values)]
        within_a_second = known.size and known.min() >= 0.0 and known.max() * factor < 1.0
        if within_a_second and np.all(known == np.round(known)):
            return name, factor
    return None
