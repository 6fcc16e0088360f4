"""The clock of a log is chosen: a rate, a column of stamps, a column of dates, or the period in the file's header."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from erclutch.errors import MappingError, MissingClockError, UnitError, shell_word
from erclutch.logs.clock.mixed_rows import are_mixed_up
from erclutch.logs.columns.labels import COUNTS, split_label
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.names import plain
from erclutch.logs.columns.seen_columns import EVEN, SeenColumns, is_of_steps
from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.mapping import NONE, ColumnChoice, ColumnMap
from erclutch.logs.plan import THOUGH, ClockPlan
from erclutch.logs.planning.clock_by_motion import rate_by_motion, unit_by_motion
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.named_columns import locate
from erclutch.logs.planning.unit_of_stamps import (
    FEW_STEPS,
    as_seconds,
    doubt_of_seconds,
    doubt_of_unit,
    is_since_1970,
    likely_unit,
)
from erclutch.logs.readers.header_pairs import LONGEST_PERIOD
from erclutch.logs.table import Table
from erclutch.signals import units

_APART = 1.0  # s between points: the steps of a clock that nothing may be read from
#: us between rows: a counter that grows by more counts the cycles of a processor.
_LONGEST_TICK = 1e5
_OTHER_RATE = 0.01  # share by which a given rate differs from that of the file at least
_STEADY_STEPS = 0.2  # of their mean, between the shortest and the longest: a rate stands for them
_COUNTED = frozenset({"tick", "ticks", "frame", "frames", "sample", "samples", "scan", "scans"})
#: A time that is counted in steps of so long, or in a part of a second that no reader knows: time_10ms, t_cs.
_IN_STEPS = re.compile(r"[_ ](?:\d+ ?[munµ]?s|[cd]s)$")
_NUMBERED_TIME = re.compile(r"[tT]_?\d")
_RATES = {
    "fs",
    "rate",
    "samplerate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "samplefreq",
    "samplingfreq",
}
_PERIODS = {
    "ts",
    "dt",
    "sampletime",
    "samplingtime",
    "sampleperiod",
    "samplingperiod",
    "sampleinterval",
    "tinterval",
}


def choose_clock(draft: Draft) -> None:
    """Choose the clock of a log; where it has none, what is wrong is a question."""
    signals = [each.column for each in draft.signals.values()]
    try:
        draft.clock = clock_plan(draft.seen, draft.told, signals)
    except MappingError as error:
        draft.ask("time", error)


def clock_plan(seen: SeenColumns, told: ColumnMap, taken: Sequence[str]) -> ClockPlan:
    """The best clock that a table has: a rate, a column of stamps, a column of dates, the period in its header.

    Args:
        seen: the columns of the log.
        told: what the user said of time or rate; the rest is guessed.
        taken: columns that are signals.

    Raises:
        MappingError: no clock of any kind, or no such column. UnitError: its unit is none of time.
    """
    table = seen.table
    counters = seen.counters
    dates = [table.clock_name] if table.clock_name else []
    if told.rate is not None:
        said = f"time from the sampling rate of {told.rate:g} Hz ({told.source})"
        own = _rate_of_file(seen, taken)
        if own is not None and abs(told.rate - own) > _OTHER_RATE * own:
            said += f", {THOUGH} {own:.5g} Hz"
        not_signals = (*counters, *dates)
        return ClockPlan(
            "rate",
            period=1.0 / told.rate,
            not_signals=not_signals,
            reason=told.source,
            sentence=said,
        )

    header = table.sample_period or _header_period(table)
    choice = told.time
    if choice is not None and choice.is_none and NONE not in table.columns:
        return points(
            counters,
            f"no time ({choice.source}): the rows are points, none after another",
            choice.source,
        )
    # A recording of ours begins at its log time; the loop's own clock began at any number.
    has_log_time = table.device is not None and table.clock is not None
    if choice is None and not has_log_time:
        guessed = seen.time_column(taken)
        guessed_from = "its name or unit"
        if guessed is None and table.clock is None and header is None:
            guessed = _time_since_1970(seen, taken)
            guessed_from = "its numbers, as a time since 1970 has them"
        if guessed is not None:
            choice = ColumnChoice(guessed, source=f"guessed from {guessed_from}")
    if choice is not None:
        return _clock_of_stamps(seen, choice, header, is_given=told.time is not None)

    if table.clock is not None:
        said = f"time <- date and time in column {table.clock_name}"
        not_signals = (*counters, *dates)
        return ClockPlan(
            "dates",
            table.clock_name,
            period=header,
            not_signals=not_signals,
            sentence=said,
        )
    if header is None:
        problem = f"no time column and no sampling rate; the file has: {table.listed}"
        remedy = 'Give --time "NAME [s]" or --rate HZ, or --time none for a table of points (no lag is fitted)'
        why, answer = _steady_column(seen, taken) or _column_of_steps(seen, taken) or ("", "")
        if answer:
            remedy = f"{why}, give {answer}"
        elif (rate := rate_by_motion(seen)) is not None:
            answer = f"--rate {shell_word(f'{rate:g} Hz')}"
            remedy = f"The speed is the rate of the position at {rate:g} Hz, if both are in units of one kind: {answer}"
        raise MissingClockError(problem, remedy=remedy, answers=[answer] if answer else [])

    said = f"time from the sampling period in the header: {header:g} s"
    if not counters:
        counters = _counters_with_gaps(seen, taken)
        said += f", counted by column {counters[0]}" if counters else ""
    if not counters or not np.isfinite(table.columns[counters[0]]).all():
        return ClockPlan("header", period=header, not_signals=counters, sentence=said)
    counter = counters[0]
    first = float(table.columns[counter][0])
    return ClockPlan(
        "counter",
        counter,
        factor=header,
        zero=first,
        period=header,
        not_signals=counters,
        sentence=said,
    )


def _clock_of_stamps(
    seen: SeenColumns, choice: ColumnChoice, header: float | None, *, is_given: bool
) -> ClockPlan:
    """The clock of a column of stamps, whose unit the header or a motion may tell where nobody wrote it.

    Args:
        seen: the columns of the log.
        choice: the column.
        header: sampling period in s that the file states; None where it states none.
        is_given: whether the user named the column.

    Raises:
        MappingError: no such column. UnitError: its unit is none of time.
    """
    name, written, scale = locate(seen.table, choice, "time")
    unit = written or None
    all_stamps = seen.table.columns[name]
    stamps = all_stamps[np.isfinite(all_stamps)]
    if are_mixed_up(stamps):
        stamps = np.sort(stamps)
    factor, zero, how = as_seconds(name, unit, stamps)
    is_open = not unit and not is_given
    if is_open and header and stamps.size > 1:
        # Stamps that grow by the period of the header in ms or us are no seconds.
        step = float(np.median(np.diff(stamps)))
        sizes = (("ms", 1e-3), ("us", 1e-6))
        told = [short for short, size in sizes if abs(step * size - header) <= _OTHER_RATE * header]
        if told:
            unit = told[0]
            factor, zero, how = as_seconds(name, unit, stamps)
            how += ", in which it grows by the period of the header"
    if is_open and not unit and factor == 1.0 and doubt_of_seconds(name, stamps):
        unit = unit_by_motion(seen, all_stamps)
        if unit:
            factor, zero, _ = as_seconds(name, unit, stamps)
            how = f", no unit: taken as {unit}, in which the speed is the rate of the position"

    doubt = ""
    likely = likely_unit(stamps)
    if not is_given and unit:
        doubt = doubt_of_unit(name, unit, stamps, factor)
        likely = "s" if doubt else likely
    elif not is_given and factor == 1.0:  # nothing tells the unit: the steps must look like seconds
        doubt = doubt_of_seconds(name, stamps)
    return ClockPlan(
        "column",
        name,
        unit,
        scale,
        scale * factor,
        zero,
        header,
        not_signals=(*seen.counters, name),
        reason=choice.source,
        sentence=f"time <- column {name}{how} ({choice.source})",
        doubt=doubt,
        likely=likely,
    )


def points(counters: Sequence[str], sentence: str, reason: str) -> ClockPlan:
    """The clock of rows in no time: no row of a table of points tells what comes before it.

    Args:
        counters: columns that count samples.
        sentence: why there is no time.
        reason: who said so, or what it was guessed from.
    """
    return ClockPlan(
        "points",
        period=_APART,
        not_signals=tuple(counters),
        reason=reason,
        sentence=sentence,
    )


def _rate_of_file(seen: SeenColumns, taken: Sequence[str]) -> float | None:
    """The sampling rate in Hz that the file states, or that its time tells; None where it says nothing."""
    table = seen.table
    header = table.sample_period or _header_period(table)
    if header:
        return 1.0 / header
    if table.clock is not None and table.clock.size > FEW_STEPS:  # dates
        step = float(np.median(np.diff(table.clock)))
        return 1.0 / step if step > 0.0 else None
    name = seen.time_column(taken)
    if name is None:
        return None
    stamps = table.columns[name]
    stamps = stamps[np.isfinite(stamps)]
    unit = seen.columns[name].written_unit
    if stamps.size <= FEW_STEPS:
        return None
    is_no_time = not units.fits(unit, ("s",)) if unit else doubt_of_seconds(name, stamps)
    if is_no_time:
        return None
    factor, _, _ = as_seconds(name, unit, stamps)
    step = float(np.median(np.diff(stamps))) * factor
    return 1.0 / step if step > 0.0 else None


def _counters_with_gaps(seen: SeenColumns, taken: Sequence[str]) -> tuple[str, ...]:
    """The first column that counts ticks, frames or samples of which the file lacks some: 0, 4, 8, or 1, 2, 4."""
    for column in seen.without(taken):
        values = column.values
        if column.written_unit not in (None, *COUNTS) or not column.spoken.says(_COUNTED):
            continue
        if not np.isfinite(values).all() or not are_whole(values):
            continue
        steps = np.diff(values)
        if steps.size and steps.min() >= 1.0 and steps.max() > 1.0:
            return (column.name,)
    return ()


def _header_period(table: Table) -> float | None:
    """The period in s of a header constant such as ``fs``, ``sample_rate_kHz`` or ``Ts``."""
    for name, value in table.constants.items():
        label, unit = split_label(name)
        stem, end = split_end(label)
        unit = unit or end
        called = plain(stem)
        if not 0 < value < float("inf"):
            continue
        try:
            if called in _RATES:
                return 1.0 / units.in_unit(f"{value!r} {unit or 'Hz'}", "Hz")
            if called in _PERIODS and unit:
                return units.in_unit(f"{value!r} {unit}", "s")
        except UnitError:
            continue  # a unit of something else
        if called in _PERIODS and value < LONGEST_PERIOD:
            return value
    return None


def _time_since_1970(seen: SeenColumns, taken: Sequence[str]) -> str | None:
    """The only column without a unit whose numbers rise in each row and are a time since 1970; else None."""
    times: list[str] = []
    for column in seen.without(taken):
        if column.unit or column.spoken.may_be or not np.isfinite(column.values).all():
            continue
        if np.all(column.steps > 0.0) and is_since_1970(column.values):
            times.append(column.name)
    return times[0] if len(times) == 1 else None


def _column_of_steps(seen: SeenColumns, taken: Sequence[str]) -> tuple[str, str] | None:
    """Why a column called like a step of the time, which hardly changes, may tell the rate, and that option."""
    for column in seen.without(taken):
        unit = column.unit or column.spoken.end or "s"
        known = column.values[np.isfinite(column.values)]
        fitting = units.fits(unit, ("s",)) if units.is_unit(unit) else None
        if not is_of_steps(column) or fitting is None or not known.size or known.min() <= 0.0:
            continue
        mean = float(known.mean())
        period = mean * fitting[0]  # [s]
        if np.ptp(known) > _STEADY_STEPS * mean or period > LONGEST_PERIOD:
            continue
        said = f"column {column.name} is the step of each row, {mean:.4g} {unit} on average"
        return f"If {said}", f"--rate {shell_word(f'{1.0 / period:.4g} Hz')}"
    return None


def _steady_column(seen: SeenColumns, taken: Sequence[str]) -> tuple[str, str] | None:
    """Why the first column may be the time, and that option: it has no unit, and equal steps other than 1.

    A torque may be called t1 too, but none rises by equal steps. Rows are counted by 1; by 5 and by 5000 a controller
    counts ms and us.
    """
    first = next(iter(seen.columns.values()), None)
    if first is None or first.name in taken or first.unit:
        return None
    if first.spoken.may_be and not _NUMBERED_TIME.fullmatch(first.name):
        return None
    name = first.name
    steps = np.diff(first.values)
    if steps.size < 2 or not np.isfinite(steps).all():
        return None
    step = float(np.median(steps))
    even = step > 0 and bool(np.all(np.abs(steps - step) <= EVEN * step))
    is_a_count = step.is_integer() and not 1.0 < step <= _LONGEST_TICK
    unit = likely_unit(first.values)
    if even and _IN_STEPS.search(name):
        return f"{name} grows by {step:.4g} from row to row: if it is the time", _option(
            name, "UNIT"
        )
    if not even or is_a_count or (step.is_integer() and unit == "s"):
        return None
    why = f"{name} grows by {step:.4g} from row to row: if that is {unit}"
    return why, _option(name, unit)


def _option(name: str, unit: str) -> str:
    return f"--time {shell_word(f'{name} [{unit}]')}"
