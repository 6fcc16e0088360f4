"""The clock of a log is chosen: a rate, a column of stamps, a column of dates, or the period in the file's header."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.columns.labels import COUNTS, split_end, split_label
from erclutch.logs.columns.names import plain
from erclutch.logs.columns.seen_columns import EVEN, SeenColumns
from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.mapping import NONE, ColumnChoice, ColumnMap
from erclutch.logs.plan import THOUGH, ClockPlan
from erclutch.logs.planning.clock_by_motion import rate_by_motion, unit_by_motion
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.named_columns import locate
from erclutch.logs.readers.header_pairs import LONGEST_PERIOD
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array

_APART = 1.0  # s between points: the steps of a clock that nothing may be read from
#: s between rows from which on stamps without a unit may be ms or counts.
SLOW = 0.5
_OTHER_RATE = 0.01  # share by which a given rate differs from that of the file at least
_FEW_STEPS = 9  # in fewer nothing of the rate is seen
_SINCE_1970 = (1e9, 4.1e9)  # s: 2001 to 2100
_SHEET_DAYS = (20_000, 80_000)  # days as spreadsheets number them: 1954 to 2119
_SHEET_STEP = 1.2e-5  # days: 1 Hz or faster
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
        choice = (
            None
            if guessed is None
            else ColumnChoice(guessed, source="guessed from its name or unit")
        )
    if choice is not None:
        name, unit, scale = locate(table, choice, "time")
        stamps = table.columns[name]
        stamps = stamps[np.isfinite(stamps)]
        by_header = (
            _unit_of_header(stamps, header) if told.time is None and not unit and header else None
        )
        unit = unit or by_header
        by_motion = _told_by_motion(seen, name, unit, stamps) if told.time is None else None
        unit = unit or by_motion
        factor, zero, how = _as_seconds(name, unit, stamps)
        how += ", in which it grows by the period of the header" if by_header else ""
        how = (
            f", no unit: taken as {unit}, in which the speed is the rate of the position"
            if by_motion
            else how
        )
        # A unit that nobody wrote and that nothing tells: the steps must look like seconds.
        taken_for_seconds = told.time is None and not unit and factor == 1.0
        too_fast = (
            _in_another_unit(name, unit, stamps, factor) if told.time is None and unit else ""
        )
        return ClockPlan(
            "column",
            name,
            unit,
            scale,
            scale * factor,
            zero,
            header,
            not_signals=(*counters, name),
            reason=choice.source,
            sentence=f"time <- column {name}{how} ({choice.source})",
            doubt=_doubt(name, stamps) if taken_for_seconds else too_fast,
            likely="s" if too_fast else _likely_unit(stamps),
        )

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
        any_clock = 'Give --time "NAME [s]" or --rate HZ, or --time none for a table of points (no lag is fitted)'
        remedy = _steady_column(seen, taken) or _rate_told(seen) or any_clock
        raise MappingError(problem, remedy=remedy)

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


_COUNTED = frozenset({"tick", "ticks", "frame", "frames", "sample", "samples", "scan", "scans"})
_NUMBERED_TIME = re.compile(r"[tT]_?\d")
_FEWEST_COUNTED = 200  # stamps
_SLOWEST_IN_MS = 1000.0  # ms a row: above it whole stamps are microseconds
_FASTEST = 1e-8  # s a row: 100 MHz
_SLOWEST_IN_US = 1e6  # us a row: from it on they are nanoseconds


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


def _unit_of_header(stamps: Array, header: float) -> str | None:
    """The unit in which stamps of no unit grow by the period that the header gives, where they are no seconds."""
    step = float(np.median(np.diff(stamps))) if stamps.size > 1 else 0.0
    for unit, size in (("ms", 1e-3), ("us", 1e-6)):
        if abs(step * size - header) <= _OTHER_RATE * header:
            return unit
    return None


def _rate_of_file(seen: SeenColumns, taken: Sequence[str]) -> float | None:
    """The sampling rate in Hz that the file states, or that its time tells; None where it says nothing."""
    table = seen.table
    header = table.sample_period or _header_period(table)
    if header:
        return 1.0 / header
    if table.clock is not None and table.clock.size > _FEW_STEPS:  # dates
        step = float(np.median(np.diff(table.clock)))
        return 1.0 / step if step > 0.0 else None
    name = seen.time_column(taken)
    if name is None:
        return None
    stamps = table.columns[name]
    stamps = stamps[np.isfinite(stamps)]
    unit = seen.columns[name].written_unit
    if stamps.size <= _FEW_STEPS:
        return None
    is_no_time = not units.fits(unit, ("s",)) if unit else _doubt(name, stamps)
    if is_no_time:
        return None
    factor, _, _ = _as_seconds(name, unit, stamps)
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


def _as_seconds(
    name: str,
    unit: str | None,
    stamps: Array,
) -> tuple[float, float, str]:
    """Factor from stamps to s, the stamp that is 0 s, and as what the stamps are taken.

    Stamps without a unit may be dates as spreadsheets number them (1954 to 2119, at 1 Hz or faster) or a time since
    1970 (2001 to 2100).

    Raises:
        UnitError: a unit that is none of time.
    """
    if unit is not None:
        seconds = units.fits(unit, ("s",)) if units.is_unit(unit) else None
        if seconds is None:
            problem = f"column '{name}' has the unit '{unit}', which is no unit of time"
            raise UnitError(
                problem, remedy=f"Give its unit, such as --time {shell_word(f'{name} [ms]')}"
            )
        if unit:
            factor, _ = seconds
            return factor, 0.0, "" if factor == 1.0 else f", converted from {unit}"

    steps = np.abs(np.diff(stamps))
    if stamps.size > 1 and _lie_within(stamps, _SHEET_DAYS) and np.median(steps) < _SHEET_STEP:
        how = ", no unit: dates as spreadsheets number them, taken as days"
        return 86_400.0, float(np.floor(stamps[0])), how
    for short, factor in (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if stamps.size and _lie_within(stamps * factor, _SINCE_1970):
            return factor, float(stamps[0]), f", no unit: a time since 1970, taken as {short}"
    return 1.0, 0.0, ", no unit: taken as s"


def _lie_within(stamps: Array, ends: tuple[float, float]) -> bool:
    low, high = ends
    return bool(np.all((stamps > low) & (stamps < high)))


def _doubt(name: str, stamps: Array) -> str:
    """Why stamps without a unit may be no seconds; "" where they look like seconds."""
    steps = np.abs(np.diff(stamps))
    if steps.size < _FEW_STEPS or _lie_within(stamps, _SINCE_1970):
        return ""
    step = float(np.median(steps))
    if step < SLOW:
        return ""
    counted = _likely_unit(stamps)
    small = counted if counted in ("us", "ns") else "ms"
    return f"time is column {name} in s, though it has no unit and grows by {step:.4g} a row, as {small} do"


def _told_by_motion(seen: SeenColumns, name: str, unit: str | None, stamps: Array) -> str | None:
    """The unit that a motion tells of stamps that may be no seconds; None where nothing does, or is open."""
    factor, _, _ = _as_seconds(name, unit, stamps)
    if unit or factor != 1.0 or not _doubt(name, stamps):
        return None
    return unit_by_motion(seen, seen.table.columns[name])


def _in_another_unit(name: str, unit: str, stamps: Array, factor: float) -> str:
    """Why stamps may not be in the unit that stands there; "" where they may."""
    return _too_fast(name, unit, stamps, factor) or _in_seconds_after_all(
        name, unit, stamps, factor
    )


def _too_fast(name: str, unit: str, stamps: Array, factor: float) -> str:
    """Why stamps may not be in the unit that stands there: no logger takes rows that fast; "" where one may."""
    steps = np.abs(np.diff(stamps))
    if steps.size < _FEW_STEPS:
        return ""
    step = float(np.median(steps)) * factor  # s
    if not 0.0 < step < _FASTEST:
        return ""
    return f"time is column {name} in {unit}, though it grows by {step:.2g} s a row then, as no logger is fast"


def _in_seconds_after_all(name: str, unit: str, stamps: Array, factor: float) -> str:
    """Why stamps may be s in spite of the smaller unit that stands there: so many s lie behind 1970, with a fraction.

    A controller's counter of ms may have such numbers after 12 days, but whole ones.
    """
    if (
        factor >= 1.0
        or not stamps.size
        or not _lie_within(stamps, _SINCE_1970)
        or np.all(stamps == np.round(stamps))
    ):
        return ""
    year = 1970 + int(stamps[0] // 31_556_952)
    return f"time is column {name} in {unit}, though its numbers are a date in {year} if they are s since 1970"


def _likely_unit(stamps: Array) -> str:
    """The unit that stamps without one have, by their steps: many whole numbers above 1 are counted by a controller.

    A few of them are the points of an instrument that waits for s. Many that count the rows tell no unit: "".
    """
    steps = np.abs(np.diff(stamps))
    step = float(np.median(steps)) if steps.size else 0.0
    whole = are_whole(stamps)
    if not whole or step < 1.0 or stamps.size < _FEWEST_COUNTED:
        return "s"
    if step == 1.0:
        return "" if steps.max() == 1.0 else "s"
    if step <= _SLOWEST_IN_MS:
        return "ms"
    return "us" if step < _SLOWEST_IN_US else "ns"


def _rate_told(seen: SeenColumns) -> str:
    """A remedy that proposes the rate at which speeds are the rates of their positions; "" where nothing tells it."""
    rate = rate_by_motion(seen)
    if rate is None:
        return ""
    option = f"--rate {shell_word(f'{rate:g} Hz')}"
    return f"The speed is the rate of the position at {rate:g} Hz, if both are in units of one kind: {option}"


def _steady_column(seen: SeenColumns, taken: Sequence[str]) -> str:
    """A remedy that proposes the first column as the time: no unit, equal steps that are no whole number; else "".

    A torque may be called t1 too, but none rises by equal steps.
    """
    first = next(iter(seen.columns.values()), None)
    if first is None or first.name in taken or first.unit:
        return ""
    if first.spoken.may_be and not _NUMBERED_TIME.fullmatch(first.name):
        return ""
    name = first.name
    steps = np.diff(first.values)
    if steps.size < 2 or not np.isfinite(steps).all():
        return ""
    step = float(np.median(steps))
    even = step > 0 and bool(np.all(np.abs(steps - step) <= EVEN * step))
    if not even or step.is_integer():
        return ""
    return f"{name} grows by {step:.4g} from row to row: if that is s, give --time {shell_word(f'{name} [s]')}"
