"""The clock of a log: time, period, segments without gaps, uniform or not; here of rows that have no time stamps.

That of rows with stamps is made in `erclutch.logs.clock.time_stamps`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.errors import ShortLogError, TimingError
from erclutch.signals.array import Array, Mask

LATEST = 1e12  # s: no clock counts more, not even one that began in the year 1
MINIMUM_ROWS = 10
PAUSE = 11.0  # long steps between two stretches whose clock began anew
#: How the note of rows begins that are points of a table: none comes after another in time.
_IN_NO_TIME = "the rows are written"


@dataclass(frozen=True)
class LogClock:
    """When each kept row was sampled.

    Attributes:
        time: s, shape (kept rows,), strictly increasing inside each segment.
        period: sampling period in s.
        starts: first row of each segment.
        uniform: whether the steps inside segments are equal.
        keep: which rows of the log are kept, shape (rows,).
        notes: what was restored, cut or dropped.
    """

    time: Array
    period: float
    starts: tuple[int, ...]
    uniform: bool
    keep: Mask
    notes: tuple[str, ...]


def from_rate(rows: int, period: float, breaks: Sequence[int] = ()) -> LogClock:
    """A clock for rows that follow each other at one rate, without stamps.

    Args:
        rows: how many there are.
        period: in s.
        breaks: rows in which another stretch begins, some steps after the last.

    Raises:
        TimingError: too few rows, or a period that is not positive and finite.
    """
    if not (np.isfinite(period) and period > 0):
        problem = f"the sampling period is {period:g} s"
        raise TimingError(problem, remedy="Give a positive rate in Hz (--rate 1000)")
    require_rows(rows)
    places = np.arange(rows, dtype=np.float64)
    first_rows = np.asarray(breaks, dtype=np.int64)
    breaks_so_far = np.searchsorted(first_rows, np.arange(rows), side="right")
    places += PAUSE * breaks_so_far
    notes = [f"time counted from row number at {1 / period:g} Hz: gaps in the log would not show"]
    if breaks:
        notes.append(
            f"a blank line stands above data row {first_few(breaks)}: a new stretch each time"
        )
    return LogClock(
        time=places * period,
        period=period,
        starts=(0, *breaks),
        uniform=True,
        keep=np.ones(rows, dtype=np.bool_),
        notes=tuple(notes),
    )


def in_no_time(notes: Iterable[str]) -> bool:
    """Whether the notes of a log say that its rows are points of a table."""
    return any(note.startswith(_IN_NO_TIME) for note in notes)


def of_points(rows: int, period: float) -> LogClock:
    """A clock for rows that are points of a table, which do not follow each other in time.

    Args:
        rows: how many there are.
        period: in s, which the table does not say.

    Raises:
        TimingError: too few rows.
    """
    require_rows(rows)
    note = f"{_IN_NO_TIME} {period:g} s apart: a lag or a rate of change means nothing (--rate if they are a log)"
    return LogClock(
        time=np.arange(rows, dtype=np.float64) * period,
        period=period,
        starts=(0,),
        uniform=True,
        keep=np.ones(rows, dtype=np.bool_),
        notes=(note,),
    )


def require_rows(rows: int) -> None:
    """Raise a TimingError for fewer rows than anything can be said of."""
    if rows < MINIMUM_ROWS:
        problem = f"only {rows} row{'' if rows == 1 else 's'} of data, {MINIMUM_ROWS} are needed"
        raise ShortLogError(problem, remedy="Give a longer log")


def first_few(rows: Sequence[int]) -> str:
    """Numbers of data rows for a note, from 1; the first five of them."""
    numbers = ", ".join(f"{row + 1:,}" for row in rows[:5])
    return f"{numbers}, ..." if len(rows) > 5 else numbers
