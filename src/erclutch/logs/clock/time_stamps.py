"""Time stamps become a clock: a regular grid through them where they allow it, cut where rows are missing.

A stamp is only as fine as it was printed. So the resolution of the stamps (their decimals, or float32) is measured
first, and only what differs by more than that resolution counts as a gap, a repeat or jitter.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import TimingError
from erclutch.logs.clock.timing import PAUSE, LogClock, first_few, require_rows
from erclutch.signals.array import Array, Mask
from erclutch.signals.percent import percent

#: In a note, between the time and the rows in which it does so.
BEGINS_ANEW = " begins anew in data row "
_GAP = 1.5  # periods
_JITTER = 1e-3  # share of the period that stamps may wander and still be called uniform
_JITTER_IN_WORDS = percent(_JITTER, 1)
_AROUND = 40  # rows on either side of a long step
_FAR_APART = 10  # rows over which the period is told
_LATE = 0.5  # periods by which a clock stays late behind a lost row
_BUSY = 60  # rows over which late stamps average out
_WHOLE = 0.1  # of a period, by which a whole number of periods is off at most
_EQUAL = 0.01  # of a step, by which equal steps differ
_BESIDE = 0.3  # periods that a stamp is off a grid which is not its own
_MOSTLY = 0.95  # of the steps
_WANDERS = 0.5  # periods that such an average may move
DISORDER = 0.05  # share of the steps from which on backward ones are no slips of a clock
_POINTS = "--time none"  # the option that takes rows as points
_AS_POINTS = f"take the rows as points ({_POINTS})"  # of a remedy
_SHORTEST = 1e-12  # s: no logger samples at a THz
_COARSE = 0.2  # share of repeated stamps above which they are coarser than the sampling


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
    stamps, restarts = begun_anew(stamps, column)
    _refuse_no_clock(stamps, column)
    notes: list[str] = []
    keep = np.ones(stamps.size, dtype=np.bool_)
    regular = _regular_grid(stamps, grain, column, hint)

    # Rows with the stamp of the row before: written twice, or by a busy logger, or stamped more coarsely than sampled.
    repeats = np.concatenate(([False], np.diff(stamps) == 0))
    if repeats.any():
        written_twice = repeats & same
        other_values = repeats & ~same
        wanders = regular.wander > 1.0
        busy = wanders and other_values.sum() > written_twice.sum() and _is_steady(stamps, regular)
        too_few_for_coarse_stamps = wanders and np.mean(other_values) <= _COARSE
        all_written_twice = not other_values.any()
        if not busy and (all_written_twice or are_stray(repeats) or too_few_for_coarse_stamps):
            keep = ~repeats
            dropped: list[str] = []
            if written_twice.any():
                rows = int(written_twice.sum())
                dropped.append(f"{rows} rows that repeat the row before were dropped")
            if other_values.any():
                rows = int(other_values.sum())
                which = f"{rows} rows with the {column} of the row before but other values"
                dropped.append(f"{which} were dropped, the first kept")
            notes.append("; ".join(dropped))
            stamps = stamps[keep]
            require_rows(stamps.size)
            regular = _regular_grid(stamps, regular.grain[keep], column, hint)

    period = regular.period
    uniform = regular.wander <= 1.0
    if period == 0.0:  # whole seconds, say, over unlike numbers of rows: no row has a time then
        rate = f"{stamps.size / (stamps[-1] - stamps[0]):.3g}"  # Hz
        problem = f"column {column} has {np.unique(stamps).size} stamps for {stamps.size} rows, not evenly"
        in_the_mean = f"Give a rate ({rate} Hz in the mean: --rate {rate})"
        raise TimingError(problem, remedy=f"{in_the_mean}, or {_AS_POINTS}", answers=[_POINTS])
    _refuse_short(period, column)
    gaps = [start - 1 for start in regular.starts[1:]]
    steps = np.delete(np.diff(stamps), gaps)
    away = np.abs(stamps - regular.grid)  # s, shape (n,)
    if not uniform and _is_steady(stamps, regular):
        late = float(np.percentile(away, 99))
        where = " between the gaps" if gaps else ""
        notes.append(
            f"stamps of {column} come up to {late:.2g} s early or late about a steady {period:.6g} s, and no row is "
            f"missing{where}: put on the regular grid"
        )
        stamps = regular.grid
        uniform = True
    elif uniform:
        even = steps.size == 0 or np.abs(steps - period).max() <= 1e-6 * period
        moves = float(away.max()) > 1e-9 * period
        if moves and not even:
            coarsest = float(regular.grain.max())
            how = f"wanders by less than {_JITTER_IN_WORDS} of a period"
            if np.any(np.diff(stamps) == 0):
                how = "is coarser than the sampling (stamps repeat)"
            elif coarsest > 0.75 * _JITTER * period:
                how = f"is rounded to {coarsest:.2g} s"
            notes.append(f"{column} {how}: put on the regular grid of {period:.10g} s")
            stamps = regular.grid
    elif not np.all(steps > 0):
        raise TimingError(
            f"column {column} repeats its stamps without a pattern",
            remedy=f"Give the sampling rate instead (--rate 1000), log finer stamps, or {_AS_POINTS}",
            answers=[_POINTS],
        )
    else:
        shortest, longest = np.percentile(steps, (1, 99)).tolist()
        usual = float(np.median(steps))
        others = int(np.count_nonzero(np.abs(steps - usual) > 1e-6 * usual))
        if longest - shortest > 1e-6 * usual:
            about = f"steps of {column} spread by {longest - shortest:.3g} s about {period:.4g} s"
        else:
            about = f"{others} of {steps.size} steps of {column} are not {usual:.4g} s"
        notes.append(f"the sampling is not uniform ({about}): the stamps are kept")
    return LogClock(
        time=stamps,
        period=period,
        starts=regular.starts,
        uniform=uniform,
        keep=keep,
        notes=(*restarts, *notes, *regular.gaps),
    )


def begun_anew(stamps: Array, column: str) -> tuple[Array, tuple[str, ...]]:
    """Stamps that go on where the clock began anew: long after the last one, which cuts the log there."""
    steps = np.diff(stamps)
    back = np.flatnonzero(steps < 0) + 1
    if not back.size or back.size > 0.01 * stamps.size or not np.any(steps > 0):
        return stamps, ()
    pause = PAUSE * float(np.percentile(steps[steps > 0], 90))
    near_the_start = stamps[back] <= stamps[0] + pause
    far_back = stamps[back - 1] - stamps[back] >= pause
    if not np.all(near_the_start & far_back):
        return stamps, ()
    if back[-1] == stamps.size - 1 or np.any(steps[back] > pause):
        return stamps, ()  # one damaged stamp: the clock goes on as before it

    shift = np.zeros(stamps.size)
    shift[back] = pause - steps[back - 1]
    joined = stamps + np.cumsum(shift)
    pauses = joined[back] - joined[back - 1]
    if not np.all(pauses > 0.9 * pause):
        return stamps, ()  # stamps so large that a pause is lost in their rounding
    rows = first_few(back.tolist())
    note = f"{column}{BEGINS_ANEW}{rows}: a new stretch each time, {pause:.3g} s after the last"
    return joined, (note,)


def _refuse_no_clock(stamps: Array, column: str) -> None:
    """Refuse stamps that never change, that run backwards, or whose steps are below all that a logger has."""
    remedy = "choose the time column (--time) or give a sampling rate (--rate)"
    steps = np.diff(stamps)
    if not np.any(steps):
        remedy += f", or {_AS_POINTS}"
        problem = f"column {column} is {stamps[0]:g} in all {stamps.size} rows"
        raise TimingError(problem, remedy=remedy.capitalize(), answers=[_POINTS])
    usual = float(np.median(steps[steps != 0]))
    _refuse_short(usual, column)
    back = np.flatnonzero(steps < 0)
    if not back.size:
        return
    row = int(back[0]) + 1
    order = f"{stamps[row]:.10g} s after {stamps[row - 1]:.10g} s"
    if back.size > 1:
        order += f" ({back.size} times in all)"
    others = "choose another time column (--time) or a rate (--rate)"
    problem = f"column {column} runs backwards at data row {row + 1}: {order}"
    if back.size == steps.size:
        remedy = f"The newest row stands first: sort the rows by {column}"
        raise TimingError(problem, remedy=remedy)
    remedy = f"Split the log there, sort it, {others}, or {_AS_POINTS}"
    if back.size > DISORDER * stamps.size:
        as_points = f"take them as points ({_POINTS}), or give a rate (--rate)"
        remedy = f"The rows follow no time: {as_points}"
    raise TimingError(problem, remedy=remedy, answers=[_POINTS])


def _refuse_short(step: float, column: str) -> None:
    """Refuse a step in s that no logger takes."""
    if abs(step) < _SHORTEST:
        below = f"below the shortest of {_SHORTEST:g} s"
        problem = f"steps of column {column} are {step:.3g} s, {below}"
        remedy = "Check its unit, choose the time column (--time) or give a sampling rate (--rate)"
        raise TimingError(problem, remedy=remedy)


def resolution_of(stamps: Array) -> Array:
    """How fine each stamp is in s: its last decimal (the finest in its decade), float32, or float64.

    "24.6492" among "0.0003328" is the mark of six significant digits, so decimals are counted decade by decade.
    """
    magnitude = np.abs(stamps)
    noise = 4 * np.spacing(magnitude.max())
    decimals = np.zeros(stamps.size)
    for places in range(12):
        scaled = stamps * 10.0**places
        left_over = np.abs(scaled - np.rint(scaled))
        decimals[left_over > noise * 10.0**places] = places + 1

    decade = np.floor(np.log10(np.maximum(magnitude, 1e-12))).astype(np.int64)
    grain = np.empty(stamps.size)
    finest = 0.0
    # Smaller numbers are never printed coarser than larger ones.
    for number in np.unique(decade)[::-1]:
        of_decade = decade == number
        finest = max(finest, float(decimals[of_decade].max()))
        grain[of_decade] = 10.0**-finest
    grain = np.where(grain <= 1e-11, noise, grain)

    as_float32 = stamps.astype(np.float32).astype(np.float64)
    if np.array_equal(as_float32, stamps) and decimals.max() > 6:
        of_float32 = np.spacing(magnitude.astype(np.float32))
        grain = np.maximum(grain, of_float32.astype(np.float64))
    steps = np.diff(stamps)
    # A tick may be no power of ten, such as the 15.6 ms of an operating system.
    if np.mean(steps == 0) > _COARSE:
        grain = np.maximum(grain, float(np.median(steps[steps > 0])))
    return grain


class _Regular(NamedTuple):
    """A regular grid through n stamps.

    Attributes:
        grid: s, shape (n,).
        period: s.
        wander: largest distance of a stamp to the grid, as a share of what rounding allows.
        grain: how fine each stamp is, in s, shape (n,).
        starts: first row of each segment.
        gaps: a note on the gaps between the segments, if there are any.
    """

    grid: Array
    period: float
    wander: float
    grain: Array
    starts: tuple[int, ...]
    gaps: tuple[str, ...]


def _regular_grid(stamps: Array, grain: Array, column: str, hint: float | None) -> _Regular:
    """The grid through stamps, cut at gaps; see `from_stamps`."""
    about = mean_step(stamps, grain)
    steps = np.diff(stamps)
    rounding = np.maximum(grain[1:], grain[:-1])
    shortest = min(about, float(np.median(steps[steps > 0])))
    # The longest step that rounding makes of one period.
    printed = np.ceil(shortest / rounding - 0.02) * rounding
    longest_step = np.maximum(_GAP * about, printed)
    gaps = np.flatnonzero(steps > longest_step * (1 + 1e-9) + 1e-9 * about)

    # A period just above the resolution rounds up to two of it, at equal distances.
    doubtful = gaps[steps[gaps] <= _GAP * about + rounding[gaps]]
    if doubtful.size > 2 and np.ptp(np.diff(doubtful)) <= 2:
        gaps = np.setdiff1d(gaps, doubtful)
    gaps = _lasting(stamps, about, gaps)
    # Where there is no clock at all, cutting at every long step would leave nothing.
    if gaps.size > 0.1 * steps.size:
        gaps = np.flatnonzero(steps > 10 * float(np.percentile(steps, 90)))

    notes: tuple[str, ...] = ()
    if gaps.size:
        longest = int(gaps[np.argmax(steps[gaps])])  # row
        where = f"longest {steps[longest]:.4g} s after {stamps[longest]:.6g} s"
        count = "1 gap" if gaps.size == 1 else f"{gaps.size} gaps"
        notes = (f"{count} in {column} ({where}): cut into {gaps.size + 1} segments",)
    starts = (0, *(gaps + 1).tolist())
    grid, period, wander = grid_through(stamps, grain, starts, about, hint)
    return _Regular(grid, period, wander, grain, starts, notes)


def mean_step(stamps: Array, grain: Array) -> float:
    """Mean step of all that is no gap, in s."""
    steps = np.diff(stamps)
    usual = float(np.median(steps[steps > 0]))
    rounding = np.maximum(grain[1:], grain[:-1])
    inside = steps <= _GAP * usual + rounding
    count = max(int(inside.sum()), 1)
    return float(steps[inside].sum() / count)


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
    steady = period
    if reach:
        far_steps = stamps[reach:] - stamps[:-reach]
        steady = float(np.median(far_steps)) / reach
    late = stamps - steady * np.arange(stamps.size)
    lasting: list[int] = []

    def moved(gap: int) -> float:
        """By how much the clock is later behind a long step than before it; no window reaches over another gap."""
        middle = gap + 1
        begin = max(0, middle - _AROUND)
        end = min(late.size, middle + _AROUND)
        for other in lasting:
            if other < gap:
                begin = max(begin, other + 1)
            elif other > gap:
                end = min(end, other + 1)
        return float(np.median(late[middle:end]) - np.median(late[begin:middle]))

    # The clearest first: beside a row that is lost, a late stamp looks like another.
    for gap in sorted(gaps.tolist(), key=moved, reverse=True):
        if moved(gap) > _LATE * period:
            lasting.append(gap)
    return np.array(sorted(lasting), dtype=np.intp)


def _segments(starts: Sequence[int], rows: int) -> list[slice]:
    """Rows of each segment, by the first rows of all."""
    return [slice(start, stop) for start, stop in pairwise((*starts, rows))]


def grid_through(
    stamps: Array,
    grain: Array,
    starts: tuple[int, ...],
    period: float,
    hint: float | None,
) -> tuple[Array, float, float]:
    """Regular grid through the stamps, one period for all segments, each with its own start.

    Returns:
        grid in s, shape (n,); period in s; the largest distance to the stamps as a share of what rounding allows.
    """
    segments = _segments(starts, stamps.size)
    # Stamps may be rounded up or down, not only to the nearest.
    allowed = 1.05 * grain + _JITTER * period

    # A straight line through the stamps of each segment by least squares: its slope is the period.
    product = 0.0
    square = 0.0
    for rows in segments:
        weight = allowed[rows] ** -2.0 * allowed.min() ** 2
        index = np.arange(weight.size, dtype=np.float64)
        index -= float(weight @ index) / float(weight.sum())
        elapsed = stamps[rows] - stamps[rows.start]
        weighted = weight * index
        product += float(weighted @ elapsed)
        square += float(weighted @ index)
    fitted = product / square if square > 0 else period  # [s]
    grid, wander = _line(stamps, allowed, segments, fitted)
    if wander > 1.0:
        return grid, fitted, wander

    # Among the periods that the stamps cannot tell apart, the header's is taken, else the shortest number.
    longest = max(rows.stop - rows.start for rows in segments)
    told_by_stamps = float(grain.max()) / max(longest - 1, 1)
    slack = max(told_by_stamps, 1e-12 * fitted)  # [s]
    shorter = [float(f"{fitted:.{digits}g}") for digits in range(1, 13)]
    for other in [hint, *shorter] if hint else shorter:
        if abs(other - fitted) > slack:
            continue
        trial, distance = _line(stamps, allowed, segments, other)
        if distance <= max(1.05 * wander, 0.7):
            return trial, other, distance
    return grid, fitted, wander


def _line(
    stamps: Array,
    allowed: Array,
    segments: Sequence[slice],
    period: float,
) -> tuple[Array, float]:
    """The grid of one period that stays closest to the stamps, and its largest distance as a share of the allowed."""
    grid = np.empty_like(stamps)
    wander = 0.0
    for rows in segments:
        line: Array = period * np.arange(rows.stop - rows.start, dtype=np.float64)
        begins = stamps[rows] - line  # where the line would begin that meets each stamp
        # Between low and high, all stamps are as near as allowed.
        low = float((begins - allowed[rows]).max())
        high = float((begins + allowed[rows]).min())
        begin = float(begins[0])
        if not low <= begin <= high:
            begin = 0.5 * (low + high)
        grid[rows] = begin + line
        distance = np.abs(begins - begin) / allowed[rows]
        wander = max(wander, float(distance.max()))
    return grid, wander


def _is_steady(stamps: Array, regular: _Regular) -> bool:
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

    # Nearly all steps are one length, and yet most stamps stand beside the grid: a single odd step has moved it.
    usual = float(np.median(steps[steps > 0]))
    are_equal = float(np.mean(np.abs(steps - usual) < _EQUAL * usual)) >= _MOSTLY
    if are_equal and float(np.median(np.abs(away))) > _BESIDE:
        return False
    for rows in _segments(regular.starts, stamps.size):
        part = away[rows]
        width = min(_BUSY, part.size)
        averages = np.convolve(part, np.full(width, 1.0 / width), "valid")
        if float(np.ptp(averages)) > _WANDERS:
            return False
    return True


def are_stray(repeats: Mask) -> bool:
    """Whether repeated stamps are stray rows: few, and not at the equal distances that a coarse stamp makes."""
    if np.mean(repeats) > _COARSE:
        return False
    distances = np.diff(np.flatnonzero(repeats))
    return distances.size < 2 or bool(np.ptp(distances) > 2)
