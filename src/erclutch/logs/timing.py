"""Time stamps, or a sampling rate, become a clock: time, period, segments without gaps, uniform or not.

A stamp is only as fine as it was printed. So the resolution of the stamps (their decimals, or float32) is measured
first, and only what differs by more than that resolution counts as a gap, a repeat or jitter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ShortLogError, TimingError
from erclutch.signals.array import Array, Mask
from erclutch.signals.percent import percent

MINIMUM_ROWS = 10
#: How the note of rows begins that are points of a table: none comes after another in time.
IN_NO_TIME = "the rows are written"
_GAP = 1.5  # periods
_SHORTEST = 1e-12  # s: no logger samples at a THz
_JITTER = 1e-3  # share of the period that stamps may wander and still be called uniform
_PAUSE = 11.0  # long steps between two stretches whose clock began anew
_AROUND = 40  # rows on either side of a long step
DISORDER = 0.05  # share of the steps from which on backward ones are no slips of a clock
_FAR_APART = 10  # rows over which the period is told
_LATE = 0.5  # periods by which a clock stays late behind a lost row
_BUSY = 60  # rows over which late stamps average out
_WHOLE, _MOSTLY = 0.1, 0.95  # of a period; of the steps
_WANDERS = 0.5  # periods that such an average may move
_COARSE = 0.2  # share of repeated stamps above which they are coarser than the sampling


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
    places += _PAUSE * np.searchsorted(np.asarray(breaks, dtype=np.int64), np.arange(rows), side="right")
    notes = [f"time counted from row number at {1 / period:g} Hz: gaps in the log would not show"]
    if breaks:
        shown = ", ".join(f"{row + 1:,}" for row in breaks[:5]) + (", ..." if len(breaks) > 5 else "")
        notes.append(f"a blank line stands above data row {shown}: a new stretch each time")
    return LogClock(places * period, period, (0, *breaks), True, np.ones(rows, dtype=np.bool_), tuple(notes))


def of_points(rows: int, period: float) -> LogClock:
    """A clock for rows that are points of a table, which do not follow each other in time.

    Args:
        rows: how many there are.
        period: in s, which the table does not say.

    Raises:
        TimingError: too few rows.
    """
    require_rows(rows)
    stamps = np.arange(rows, dtype=np.float64) * period
    note = f"{IN_NO_TIME} {period:g} s apart: a lag or a rate of change means nothing (--rate if they are a log)"
    return LogClock(stamps, period, (0,), True, np.ones(rows, dtype=np.bool_), (note,))


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
    grain = _resolution(stamps) if np.any(np.diff(stamps)) else np.zeros(stamps.size)
    stamps, restarts = _restarted(stamps, column)
    _refuse_no_clock(stamps, column)
    notes: list[str] = []
    keep = np.ones(stamps.size, dtype=np.bool_)
    regular = _regular(stamps, grain, column, hint)

    # Rows with the stamp of the row before: written twice, or by a busy logger, or stamped more coarsely than sampled.
    repeats = np.concatenate(([False], np.diff(stamps) == 0))
    if repeats.any():
        written_twice = repeats & same
        other_values = repeats & ~same
        wanders = regular.wander > 1.0
        busy = wanders and other_values.sum() > written_twice.sum() and _steady(stamps, regular)
        if not busy and (_stray(repeats) or (wanders and np.mean(other_values) <= _COARSE)):
            keep = ~repeats
            notes.append(_dropped(repeats, same, column))
            stamps = stamps[keep]
            require_rows(stamps.size)
            regular = _regular(stamps, regular.grain[keep], column, hint)

    period = regular.period
    uniform = regular.wander <= 1.0
    _refuse_short(period, column)
    steps = np.delete(np.diff(stamps), [start - 1 for start in regular.starts[1:]])  # without the gaps
    if not uniform and _steady(stamps, regular):
        late = float(np.percentile(np.abs(stamps - regular.grid), 99))
        notes.append(
            f"stamps of {column} come up to {late:.2g} s early or late about a steady {period:.6g} s, and no row is "
            "missing: put on the regular grid"
        )
        stamps, uniform = regular.grid, True
    elif uniform:
        even = steps.size == 0 or np.abs(steps - period).max() <= 1e-6 * period
        moved = float(np.abs(regular.grid - stamps).max())
        if moved > 1e-9 * period and not even:
            notes.append(_restored(stamps, regular.grain, period, column))
            stamps = regular.grid
    elif not np.all(steps > 0):
        raise TimingError(
            f"column {column} repeats its stamps without a pattern",
            remedy="Give the sampling rate instead (--rate 1000), or log finer stamps",
        )
    else:
        spread = float(np.percentile(steps, 99) - np.percentile(steps, 1))
        about = f"steps of {column} spread by {spread:.3g} s about {period:.4g} s"
        notes.append(f"the sampling is not uniform ({about}): the stamps are kept")
    return LogClock(stamps, period, regular.starts, uniform, keep, (*restarts, *notes, *regular.gaps))


def require_rows(rows: int) -> None:
    """Raise a TimingError for fewer rows than anything can be said of."""
    if rows < MINIMUM_ROWS:
        problem = f"only {rows} row{'' if rows == 1 else 's'} of data, {MINIMUM_ROWS} are needed"
        raise ShortLogError(problem, remedy="Give a longer log")


class _Regular(NamedTuple):
    """A regular grid through stamps of a grain, with the largest distance as a share of what rounding allows."""

    grid: Array
    period: float
    wander: float
    grain: Array
    starts: tuple[int, ...]
    gaps: tuple[str, ...]


def _regular(stamps: Array, grain: Array, column: str, hint: float | None) -> _Regular:
    period = _period(stamps, grain)
    starts, gaps = _cut(stamps, grain, period, column)
    return _Regular(*_grid(stamps, grain, starts, period, hint), grain, starts, gaps)


def _refuse_no_clock(stamps: Array, column: str) -> None:
    remedy = "choose the time column (--time) or give a sampling rate (--rate)"
    steps = np.diff(stamps)
    if not np.any(steps):
        raise TimingError(f"column {column} is {stamps[0]:g} in all {stamps.size} rows", remedy=remedy.capitalize())
    usual = float(np.median(steps[steps != 0]))
    _refuse_short(usual, column)
    back = np.flatnonzero(steps < 0)
    if back.size:
        row = int(back[0]) + 1
        more = f" ({back.size} times in all)" if back.size > 1 else ""
        order = f"{stamps[row]:.10g} s after {stamps[row - 1]:.10g} s"
        mend = "Split the log there, sort it, or choose another time column (--time) or a rate (--rate)"
        if back.size == steps.size:
            mend = f"The newest row stands first: sort the rows by {column}"
        elif back.size > DISORDER * stamps.size:
            mend = "The rows follow no time: take them as points (--time none), or give a rate (--rate)"
        raise TimingError(f"column {column} runs backwards at data row {row + 1}: {order}{more}", remedy=mend)


def _refuse_short(step: float, column: str) -> None:
    if abs(step) < _SHORTEST:
        problem = f"steps of column {column} are {step:.3g} s, below the shortest of {_SHORTEST:g} s"
        raise TimingError(
            problem, remedy="Check its unit, choose the time column (--time) or give a sampling rate (--rate)"
        )


def _restarted(stamps: Array, column: str) -> tuple[Array, tuple[str, ...]]:
    """Stamps that go on where the clock began anew: long after the last one, which cuts the log there."""
    steps = np.diff(stamps)
    back = np.flatnonzero(steps < 0) + 1
    if not back.size or back.size > 0.01 * stamps.size or not np.any(steps > 0):
        return stamps, ()
    pause = _PAUSE * float(np.percentile(steps[steps > 0], 90))
    near_the_start = stamps[back] <= stamps[0] + pause
    far_back = stamps[back - 1] - stamps[back] >= pause
    if not np.all(near_the_start & far_back):
        return stamps, ()
    if back[-1] == stamps.size - 1 or np.any(steps[back] > pause):
        return stamps, ()  # one damaged stamp: the clock goes on as before it

    shift = np.zeros(stamps.size)
    shift[back] = pause - steps[back - 1]
    rows = ", ".join(f"{row + 1:,}" for row in back[:5]) + (", ..." if back.size > 5 else "")
    note = f"{column} begins anew in data row {rows}: a new stretch each time, {pause:.3g} s after the last"
    joined = stamps + np.cumsum(shift)
    if not np.all(joined[back] - joined[back - 1] > 0.9 * pause):
        return stamps, ()  # stamps so large that a pause is lost in their rounding
    return joined, (note,)


def _resolution(stamps: Array) -> Array:
    """How fine each stamp is in s: its last decimal (the finest in its decade), float32, or float64.

    "24.6492" among "0.0003328" is the mark of six significant digits, so decimals are counted decade by decade.
    """
    magnitude = np.abs(stamps)
    noise = 4 * np.spacing(magnitude.max())
    decimals = np.zeros(stamps.size)
    for places in range(12):
        scaled = stamps * 10.0**places
        decimals[np.abs(scaled - np.rint(scaled)) > noise * 10.0**places] = places + 1

    decade = np.floor(np.log10(np.maximum(magnitude, 1e-12))).astype(np.int64)
    grain = np.empty(stamps.size)
    finest = 0.0
    for value in np.unique(decade)[::-1]:  # smaller numbers are never printed coarser than larger ones
        finest = max(finest, float(decimals[decade == value].max()))
        grain[decade == value] = 10.0**-finest
    grain = np.where(grain <= 1e-11, noise, grain)

    is_float32 = np.array_equal(stamps.astype(np.float32).astype(np.float64), stamps)
    if is_float32 and decimals.max() > 6:
        grain = np.maximum(grain, np.spacing(magnitude.astype(np.float32)).astype(np.float64))
    steps = np.diff(stamps)
    if np.mean(steps == 0) > _COARSE:  # a tick that is no power of ten, such as the 15.6 ms of an operating system
        grain = np.maximum(grain, float(np.median(steps[steps > 0])))
    return grain


def _period(stamps: Array, grain: Array) -> float:
    """Mean step of all that is no gap, in s."""
    steps = np.diff(stamps)
    usual = float(np.median(steps[steps > 0]))
    inside = steps <= _GAP * usual + np.maximum(grain[1:], grain[:-1])
    return float(steps[inside].sum() / max(int(inside.sum()), 1))


def _stray(repeats: Mask) -> bool:
    """Whether repeated stamps are stray rows: few, and not at the equal distances that a coarse stamp makes."""
    distances = np.diff(np.flatnonzero(repeats))
    return bool(np.mean(repeats) <= _COARSE and (distances.size < 2 or np.ptp(distances) > 2))


def _dropped(repeats: Mask, same: Mask, column: str) -> str:
    alike = int((repeats & same).sum())
    different = int((repeats & ~same).sum())
    parts = [f"{alike} rows that repeat the row before were dropped"] * (alike > 0)
    if different:
        which = f"{different} rows with the {column} of the row before but other values"
        parts.append(f"{which} were dropped, the first kept")
    return "; ".join(parts)


def _cut(stamps: Array, grain: Array, period: float, column: str) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """First row of each segment, and a note on the gaps."""
    steps = np.diff(stamps)
    rounding = np.maximum(grain[1:], grain[:-1])
    shortest = min(period, float(np.median(steps[steps > 0])))
    printed = np.ceil(shortest / rounding - 0.02) * rounding  # the longest step that rounding makes of one period
    longest_step = np.maximum(_GAP * period, printed)
    gaps = np.flatnonzero(steps > longest_step * (1 + 1e-9) + 1e-9 * period)

    doubtful = gaps[steps[gaps] <= _GAP * period + rounding[gaps]]
    if doubtful.size > 2 and np.ptp(np.diff(doubtful)) <= 2:  # a period just above the resolution: equal distances
        gaps = np.setdiff1d(gaps, doubtful)
    gaps = _lasting(stamps, period, gaps)
    if gaps.size > 0.1 * steps.size:  # no clock at all: cutting at every long step would leave nothing
        gaps = np.flatnonzero(steps > 10 * float(np.percentile(steps, 90)))
    if not gaps.size:
        return (0,), ()

    longest = int(gaps[np.argmax(steps[gaps])])
    where = f"longest {steps[longest]:.4g} s after {stamps[longest]:.6g} s"
    count = f"{gaps.size} gap{'s' if gaps.size > 1 else ''}"
    note = f"{count} in {column} ({where}): cut into {gaps.size + 1} segments"
    starts = (0, *(gaps + 1).tolist())
    return starts, (note,)


def _lasting(stamps: Array, period: float, gaps: NDArray[np.intp]) -> NDArray[np.intp]:
    """Of long steps, those behind which the clock stays late: rows are missing there.

    A busy logger writes a stamp late and the next ones in time again; then no row is missing. So the stamps around each
    long step, less a period a row, are compared as medians of up to 40 rows on either side: a lost row moves all that
    follow by a period, a late stamp moves itself.
    """
    if not gaps.size:
        return gaps
    # Over many rows lateness averages out, and few gaps do not move a median.
    reach = min(_FAR_APART, stamps.size // 4)
    steady = float(np.median(stamps[reach:] - stamps[:-reach])) / reach if reach else period
    late = stamps - steady * np.arange(stamps.size)
    lasting: list[int] = []

    def moved(gap: int) -> float:
        """By how much the clock is later behind a long step than before it; no window reaches over another gap."""
        begin = max([0, gap + 1 - _AROUND, *(other + 1 for other in lasting if other < gap)])
        end = min([late.size, gap + 1 + _AROUND, *(other + 1 for other in lasting if other > gap)])
        return float(np.median(late[gap + 1 : end]) - np.median(late[begin : gap + 1]))

    # The clearest first: beside a row that is lost, a late stamp looks like another.
    for gap in sorted(gaps.tolist(), key=moved, reverse=True):
        if moved(gap) > _LATE * period:
            lasting.append(gap)
    return np.array(sorted(lasting), dtype=np.intp)


def _steady(stamps: Array, regular: _Regular) -> bool:
    """Whether stamps that wander belong to a steady sampler whose logger was busy.

    Their distances to the grid then have no memory: over 60 rows they average out. A clock that drifts, or rows that
    are taken when something happens, stay away from any grid.
    """
    away = (stamps - regular.grid) / regular.period
    if float(np.std(away)) > 1.0:
        return False

    # Steps of one, two, three periods: rows are missing everywhere, and no stamp is late.
    steps = np.diff(stamps)
    periods = steps / float(np.percentile(steps[steps > 0], 30))
    whole = np.abs(periods - np.rint(periods)) < _WHOLE
    several = whole & (periods > 1.5)
    if np.mean(whole) > _MOSTLY and np.mean(several) > 1.0 - _MOSTLY:
        return False

    for start, stop in zip(regular.starts, (*regular.starts[1:], stamps.size), strict=True):
        part = away[start:stop]
        width = min(_BUSY, part.size)
        averages = np.convolve(part, np.full(width, 1.0 / width), "valid")
        if float(np.ptp(averages)) > _WANDERS:
            return False
    return True


def _grid(
    stamps: Array, grain: Array, starts: tuple[int, ...], period: float, hint: float | None
) -> tuple[Array, float, float]:
    """Regular grid through the stamps, one period for all segments, each with its own start.

    Returns:
        grid in s, shape (n,); period in s; the largest distance to the stamps as a share of what rounding allows.
    """
    spans = [slice(start, stop) for start, stop in zip(starts, (*starts[1:], stamps.size), strict=True)]
    allowed = 1.05 * grain + _JITTER * period  # stamps may be rounded up or down, not only to the nearest
    product = square = 0.0
    for span in spans:
        weight = allowed[span] ** -2.0 * allowed.min() ** 2
        index = np.arange(weight.size, dtype=np.float64)
        index -= float(weight @ index) / float(weight.sum())
        product += float((weight * index) @ (stamps[span] - stamps[span.start]))
        square += float((weight * index) @ index)
    fitted = product / square if square > 0 else period  # [s]
    grid, wander = _line(stamps, allowed, spans, fitted)
    if wander > 1.0:
        return grid, fitted, wander

    # Among the periods that the stamps cannot tell apart, the header's is taken, else the shortest number.
    longest = max(span.stop - span.start for span in spans)
    slack = max(float(grain.max()) / max(longest - 1, 1), 1e-12 * fitted)  # [s]
    shorter = [float(f"{fitted:.{digits}g}") for digits in range(1, 13)]
    for other in [hint, *shorter] if hint else shorter:
        if abs(other - fitted) > slack:
            continue
        trial, distance = _line(stamps, allowed, spans, other)
        if distance <= max(1.05 * wander, 0.7):
            return trial, other, distance
    return grid, fitted, wander


def _line(stamps: Array, allowed: Array, spans: Sequence[slice], period: float) -> tuple[Array, float]:
    """The grid of one period that stays closest to the stamps, and its largest distance as a share of the allowed."""
    grid = np.empty_like(stamps)
    wander = 0.0
    for span in spans:
        line: Array = period * np.arange(span.stop - span.start, dtype=np.float64)
        rest = stamps[span] - line
        low = float((rest - allowed[span]).max())  # between low and high, all stamps are as near as allowed
        high = float((rest + allowed[span]).min())
        begin = float(rest[0]) if low <= rest[0] <= high else 0.5 * (low + high)
        grid[span] = begin + line
        wander = max(wander, float((np.abs(rest - begin) / allowed[span]).max()))
    return grid, wander


def _restored(stamps: Array, grain: Array, period: float, column: str) -> str:
    if np.any(np.diff(stamps) == 0):
        how = "is coarser than the sampling (stamps repeat)"
    elif float(grain.max()) > 0.75 * _JITTER * period:
        how = f"is rounded to {grain.max():.2g} s"
    else:
        how = f"wanders by less than {percent(_JITTER, 1)} of a period"
    return f"{column} {how}: put on the regular grid of {period:.10g} s"
