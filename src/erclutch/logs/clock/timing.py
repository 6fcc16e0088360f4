"""Time stamps, or a sampling rate, become a clock: time, period, segments without gaps, uniform or not.

A stamp is only as fine as it was printed. So the resolution of the stamps (their decimals, or float32) is measured
first, and only what differs by more than that resolution counts as a gap, a repeat or jitter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.errors import ShortLogError, TimingError
from erclutch.logs.clock.regular_grid import (
    COARSE,
    JITTER,
    PAUSE,
    first_few,
    is_steady,
    refuse_no_clock,
    refuse_short,
    regular_grid,
    resolution_of,
    restarted,
)
from erclutch.signals.array import Array, Mask
from erclutch.signals.percent import percent

MINIMUM_ROWS = 10
#: How the note of rows begins that are points of a table: none comes after another in time.
IN_NO_TIME = "the rows are written"


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
        notes.append(f"a blank line stands above data row {first_few(breaks)}: a new stretch each time")
    return LogClock(
        time=places * period,
        period=period,
        starts=(0, *breaks),
        uniform=True,
        keep=np.ones(rows, dtype=np.bool_),
        notes=tuple(notes),
    )


def of_points(rows: int, period: float) -> LogClock:
    """A clock for rows that are points of a table, which do not follow each other in time.

    Args:
        rows: how many there are.
        period: in s, which the table does not say.

    Raises:
        TimingError: too few rows.
    """
    require_rows(rows)
    note = f"{IN_NO_TIME} {period:g} s apart: a lag or a rate of change means nothing (--rate if they are a log)"
    return LogClock(
        time=np.arange(rows, dtype=np.float64) * period,
        period=period,
        starts=(0,),
        uniform=True,
        keep=np.ones(rows, dtype=np.bool_),
        notes=(note,),
    )


def from_stamps(stamps: Array, same: Mask, *, column: str, hint: float | None = None) -> LogClock:
    """A clock from time stamps.

    Args:
        stamps: s, shape (n,), finite.
        same: whether a row equals the row before in all columns but the time, shape (n,).
        column: name of the time column, for messages.
        hint: period in s from a header; taken where the stamps agree with it within their resolution.

    Raises:
        TimingError: fewer than 10 rows, constant time, time that runs backwards, stamps that repeat without a pattern.
    """
    require_rows(stamps.size)
    grain = resolution_of(stamps) if np.any(np.diff(stamps)) else np.zeros(stamps.size)
    stamps, restarts = restarted(stamps, column)
    refuse_no_clock(stamps, column)
    notes: list[str] = []
    keep = np.ones(stamps.size, dtype=np.bool_)
    regular = regular_grid(stamps, grain, column, hint)

    # Rows with the stamp of the row before: written twice, or by a busy logger, or stamped more coarsely than sampled.
    repeats = np.concatenate(([False], np.diff(stamps) == 0))
    if repeats.any():
        written_twice = repeats & same
        other_values = repeats & ~same
        wanders = regular.wander > 1.0
        busy = wanders and other_values.sum() > written_twice.sum() and is_steady(stamps, regular)
        too_few_for_coarse_stamps = wanders and np.mean(other_values) <= COARSE
        if not busy and (_stray(repeats) or too_few_for_coarse_stamps):
            keep = ~repeats
            notes.append(_dropped(repeats, same, column))
            stamps = stamps[keep]
            require_rows(stamps.size)
            regular = regular_grid(stamps, regular.grain[keep], column, hint)

    period = regular.period
    uniform = regular.wander <= 1.0
    refuse_short(period, column)
    gaps = [start - 1 for start in regular.starts[1:]]
    steps = np.delete(np.diff(stamps), gaps)
    away = np.abs(stamps - regular.grid)  # s, shape (n,)
    if not uniform and is_steady(stamps, regular):
        late = float(np.percentile(away, 99))
        notes.append(
            f"stamps of {column} come up to {late:.2g} s early or late about a steady {period:.6g} s, and no row is "
            "missing: put on the regular grid"
        )
        stamps = regular.grid
        uniform = True
    elif uniform:
        even = steps.size == 0 or np.abs(steps - period).max() <= 1e-6 * period
        moves = float(away.max()) > 1e-9 * period
        if moves and not even:
            notes.append(_restored(stamps, regular.grain, period, column))
            stamps = regular.grid
    elif not np.all(steps > 0):
        raise TimingError(
            f"column {column} repeats its stamps without a pattern",
            remedy="Give the sampling rate instead (--rate 1000), or log finer stamps",
        )
    else:
        shortest, longest = np.percentile(steps, (1, 99)).tolist()
        about = f"steps of {column} spread by {longest - shortest:.3g} s about {period:.4g} s"
        notes.append(f"the sampling is not uniform ({about}): the stamps are kept")
    return LogClock(
        time=stamps,
        period=period,
        starts=regular.starts,
        uniform=uniform,
        keep=keep,
        notes=(*restarts, *notes, *regular.gaps),
    )


def require_rows(rows: int) -> None:
    """Raise a TimingError for fewer rows than anything can be said of."""
    if rows < MINIMUM_ROWS:
        problem = f"only {rows} row{'' if rows == 1 else 's'} of data, {MINIMUM_ROWS} are needed"
        raise ShortLogError(problem, remedy="Give a longer log")


def _stray(repeats: Mask) -> bool:
    """Whether repeated stamps are stray rows: few, and not at the equal distances that a coarse stamp makes."""
    if np.mean(repeats) > COARSE:
        return False
    distances = np.diff(np.flatnonzero(repeats))
    return distances.size < 2 or bool(np.ptp(distances) > 2)


def _dropped(repeats: Mask, same: Mask, column: str) -> str:
    alike = int((repeats & same).sum())
    different = int((repeats & ~same).sum())
    parts: list[str] = []
    if alike:
        parts.append(f"{alike} rows that repeat the row before were dropped")
    if different:
        which = f"{different} rows with the {column} of the row before but other values"
        parts.append(f"{which} were dropped, the first kept")
    return "; ".join(parts)


def _restored(stamps: Array, grain: Array, period: float, column: str) -> str:
    if np.any(np.diff(stamps) == 0):
        how = "is coarser than the sampling (stamps repeat)"
    elif float(grain.max()) > 0.75 * JITTER * period:
        how = f"is rounded to {grain.max():.2g} s"
    else:
        how = f"wanders by less than {percent(JITTER, 1)} of a period"
    return f"{column} {how}: put on the regular grid of {period:.10g} s"
