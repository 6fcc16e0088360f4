"""The clock of a log is chosen: a rate, a column of stamps, a column of dates, or the period in the file's header."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs import columns
from erclutch.logs.mapping import ColumnChoice, ColumnMap
from erclutch.logs.named_columns import locate
from erclutch.logs.plan import ClockPlan
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array

_COUNTER = "samplenumber"
#: s between rows from which on stamps without a unit may be ms or counts.
SLOW = 0.5
_FEW_STEPS = 9  # in fewer nothing of the rate is seen


def clock_plan(table: Table, told: ColumnMap, taken: Sequence[str]) -> ClockPlan:
    """The best clock that a table has: a rate, a column of stamps, a column of dates, the period in its header.

    Args:
        table: columns as in the file.
        told: what the user said of time or rate; the rest is guessed.
        taken: columns that are signals.

    Raises:
        MappingError: no clock of any kind, or no such column. UnitError: its unit is none of time.
    """
    counted = counters(table)
    dates = [table.clock_name] if table.clock_name else []
    if told.rate is not None:
        said = f"time from the sampling rate of {told.rate:g} Hz ({told.source})"
        not_signals = (*counted, *dates)
        return ClockPlan("rate", period=1.0 / told.rate, not_signals=not_signals, reason=told.source, sentence=said)

    header = table.sample_period or _header_period(table)
    choice = told.time
    if choice is None:
        name = columns.time_column(table, taken)
        choice = None if name is None else ColumnChoice(name, source="guessed from its name or unit")
    if choice is not None:
        name, unit, scale = locate(table, choice, "time")
        stamps = table.columns[name]
        factor, zero, how = _as_seconds(name, unit, stamps[np.isfinite(stamps)])
        said = f"time <- column {name}{how} ({choice.source})"
        not_signals = (*counted, name)
        guessed = told.time is None and not unit and factor == 1.0
        doubt = _doubt(name, stamps[np.isfinite(stamps)]) if guessed else ""
        scales = (scale, scale * factor, zero, header)
        return ClockPlan("column", name, unit, *scales, not_signals, choice.source, said, doubt)

    if table.clock is not None:
        said = f"time <- date and time in column {table.clock_name}"
        not_signals = (*counted, *dates)
        return ClockPlan("dates", table.clock_name, period=header, not_signals=not_signals, sentence=said)
    if header is None:
        problem = f"no time column and no sampling rate; the file has: {table.listed}"
        steady = _steady_column(table, taken)
        if steady is not None:
            name, step = steady
            remedy = (
                f"{name} grows by {step:.4g} from row to row: if that is s, give --time {shell_word(f'{name} [s]')}"
            )
            raise MappingError(problem, remedy=remedy)
        raise MappingError(problem, remedy='Give --time "NAME [s]" or --rate HZ')
    said = f"time from the sampling period in the header: {header:g} s"
    if not counted or not np.isfinite(table.columns[counted[0]]).all():
        return ClockPlan("header", period=header, not_signals=tuple(counted), sentence=said)
    first = float(table.columns[counted[0]][0])
    return ClockPlan(
        "counter", counted[0], factor=header, zero=first, period=header, not_signals=tuple(counted), sentence=said
    )


def _steady_column(table: Table, taken: Sequence[str]) -> tuple[str, float] | None:
    """The first column, and its step, where that looks like a time: no unit, equal steps that are no whole number."""
    name = next(iter(table.columns), "")
    if not name or name in taken or table.units.get(name):
        return None
    steps = np.diff(table.columns[name])
    if steps.size < 2 or not np.isfinite(steps).all():
        return None
    step = float(np.median(steps))
    even = step > 0 and bool(np.all(np.abs(steps - step) <= 1e-3 * step))
    return (name, step) if even and not step.is_integer() else None


def _header_period(table: Table) -> float | None:
    """The period in s of a header constant such as ``fs``."""
    for name, value in table.constants.items():
        plain = name.lower().replace("_", "")
        if plain in {"fs", "rate", "samplerate", "samplingrate"} and 0 < value < float("inf"):
            return 1.0 / value
    return None


def _as_seconds(name: str, unit: str | None, stamps: Array) -> tuple[float, float, str]:
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
            raise UnitError(problem, remedy=f"Give its unit, such as --time {shell_word(f'{name} [ms]')}")
        if unit:
            return seconds[0], 0.0, f", converted from {unit}" if seconds[0] != 1.0 else ""
    steps = np.abs(np.diff(stamps))
    if stamps.size > 1 and np.all((stamps > 20_000) & (stamps < 80_000)) and np.median(steps) < 1.2e-5:
        how = ", no unit: dates as spreadsheets number them, taken as days"
        return 86_400.0, float(np.floor(stamps[0])), how
    for short, factor in (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if stamps.size and np.all((stamps * factor > 1e9) & (stamps * factor < 4.1e9)):
            return factor, float(stamps[0]), f", no unit: a time since 1970, taken as {short}"
    return 1.0, 0.0, ", no unit: taken as s"


def _doubt(name: str, stamps: Array) -> str:
    """Why stamps without a unit may be no seconds; "" where they look like seconds."""
    steps = np.abs(np.diff(stamps))
    if steps.size < _FEW_STEPS or bool(np.all((stamps > 1e9) & (stamps < 4.1e9))):  # seconds since 1970
        return ""
    step = float(np.median(steps))
    if step < SLOW:
        return ""
    return f"time is column {name} in s, though it has no unit and grows by {step:.4g} a row, as ms do"


def counters(table: Table) -> list[str]:
    """Columns that count samples."""
    return [name for name in table.columns if name.replace(" ", "").lower() == _COUNTER]
