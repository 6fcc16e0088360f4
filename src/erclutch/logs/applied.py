"""A plan is carried out: signals converted, rows put on one clock, the log cut at gaps, what is not finite refused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError, MappingError, TimingError, placed, shell_word
from erclutch.logs.clock import timing
from erclutch.logs.clock.time_stamps import from_stamps
from erclutch.logs.plan import ClockPlan, Invalid, Plan, SignalPlan
from erclutch.logs.planning.unit_of_stamps import SLOW
from erclutch.logs.rows.unmeasured_rows import unmeasured_rows
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array, Mask
from erclutch.signals.recording import CUT_THERE, POSITION, TEMPERATURE, Recording

_LARGEST = 1e30  # of a signal in SI units; squares of sums of such are still numbers
#: Between which a signal lies where it is measured; all others are between -_LARGEST and _LARGEST.
_LIMITS = {"temperature": (units.LEAST_KELVIN, units.MOST_KELVIN)}


def apply(plan: Plan, table: Table) -> Recording:
    """Make a Recording of a table; see `apply_rows`."""
    return apply_rows(plan, table)[0]


def apply_rows(plan: Plan, table: Table) -> tuple[Recording, NDArray[np.int64]]:
    """Make a Recording of a table, and tell which row of the table each of its rows was, shape (n,).

    Args:
        plan: without open questions. A plan that was made of one block of a log serves for all of its blocks.
        table: the columns that the plan names.

    Raises:
        MappingError: an open question, or a column that is not there.
        LogError: values that are not finite; TimingError: time that cannot be put right.
    """
    with placed(table.name), np.errstate(over="ignore", invalid="ignore"):  # as in `plan_of`
        plan.require_answers()
        clock_plan = plan.clock
        assert clock_plan is not None, "a plan without a clock has a question about it"
        notes = list(plan.notes)

        # Values in the unit of the recording, each of shape (rows of the table,).
        signals = {each.signal: _values(each, table) for each in plan.signals}
        inputs = {each.column: _values(each, table) for each in plan.inputs}
        units_of_inputs = {each.column: each.si for each in plan.inputs}
        units_of = {each.signal: each.si for each in plan.signals}
        spare: dict[str, Array] = {}
        for name in plan.spare:
            values = table.planned(name)
            if np.isfinite(values).all():
                spare[name] = values
                units_of_inputs[name] = table.units.get(name) or units.UNKNOWN

        rows = np.arange(table.rows)
        if clock_plan.kind == "column":
            unstamped = ~np.isfinite(table.planned(clock_plan.column))
            if unstamped.any():
                _refuse_or_note(table, {clock_plan.column: unstamped}, plan.invalid, notes)
                rows = rows[~unstamped]
        if _newest_first(clock_plan, table, rows):
            rows = rows[::-1]
            notes.append(
                f"the newest row stands first in column {clock_plan.column}: the rows are turned round"
            )
        if clock_plan.is_mixed_up:
            rows = rows[np.argsort(table.planned(clock_plan.column)[rows])]
        clock = clock_of(clock_plan, table, rows, notes)
        unmeasured = unmeasured_rows(plan, table, notes)
        bad = _unusable_rows(plan, table, {**signals, **inputs}, unmeasured, notes)

        # Which row of the table each row of the clock is, and which of them are left.
        kept = rows[clock.keep]
        usable = ~bad[kept]
        timing.require_rows(int(usable.sum()))
        starts, stops = _segments(clock, usable)
        taken = kept[usable]
        for each in plan.signals:
            if len(each.numbers) > 1:
                signals[each.signal] = _stepped(each, starts, stops)
            else:
                signals[each.signal] = signals[each.signal][taken]

        extras = {name: values[taken] for name, values in inputs.items()}
        if "temperature" in signals:
            extras = {TEMPERATURE: signals.pop("temperature"), **extras}
            units_of_inputs[TEMPERATURE] = units_of.pop("temperature")
        if "position" in plan.told.columns and {"position", "slip"} <= signals.keys():
            # Named beside the slip, it is not there to be differentiated: the effort may depend on it.
            extras = {POSITION: signals["position"], **extras}
            units_of_inputs[POSITION] = units_of["position"]
        if "alpha_raw" in signals:
            signals["alpha"] = signals.pop("alpha_raw")
            del units_of["alpha_raw"]
            units_of["alpha"] = "rad"
        recording = Recording(
            name=table.name,
            signals=_read_only(signals),
            units=MappingProxyType(units_of),
            time=_frozen(clock.time[usable]),
            period=clock.period,
            segments=tuple(zip(starts.tolist(), stops.tolist(), strict=True)),
            uniform=clock.uniform,
            digest=table.digest,
            constants=MappingProxyType({**table.constants, **plan.constants}),
            origin=table.origin,
            extras=_read_only(extras),
            extra_units=MappingProxyType(units_of_inputs),
            spare=_read_only({name: values[taken] for name, values in spare.items()}),
            notes=(*notes, *clock.notes),
            mapping=plan.told.file,
        )
        return recording, taken


def _values(choice: SignalPlan, table: Table) -> Array:
    """A signal in all rows of the table, in the unit of the recording, shape (rows,)."""
    if choice.numbers:
        return np.full(table.rows, choice.numbers[0])
    values = table.planned(choice.column)
    if choice.factor != 1.0:
        values = values * choice.factor
    if choice.offset:
        values = values + choice.offset
    if choice.lead is not None:
        return values * (2 * pi / choice.lead)
    return values


def _newest_first(plan: ClockPlan, table: Table, rows: NDArray[np.int64]) -> bool:
    """Whether the stamps of a log fall from row to row, all through it."""
    if plan.kind == "dates":
        assert table.clock is not None
        stamps = table.clock[rows]
    elif plan.kind == "column":
        stamps = table.planned(plan.column)[rows]
    else:
        return False
    steps = np.diff(stamps)
    return bool(steps.size and np.all(steps <= 0.0) and np.any(steps < 0.0))


def clock_of(
    plan: ClockPlan,
    table: Table,
    rows: NDArray[np.int64],
    notes: list[str],
) -> timing.LogClock:
    """The clock of some rows of a table; ``notes`` gets a sentence on it.

    Raises:
        TimingError: time that cannot be put right.
    """
    notes.append(plan.sentence)
    period = plan.period
    if plan.kind in ("rate", "header"):
        assert period is not None
        breaks = np.unique(np.searchsorted(rows, table.breaks))
        inside = (breaks > 0) & (breaks < rows.size)
        return timing.from_rate(rows.size, period, breaks[inside].tolist())
    if plan.kind == "points":
        assert period is not None
        return timing.of_points(rows.size, period)
    if plan.kind == "dates":
        assert table.clock is not None
        stamps = table.clock[rows]
    else:
        column = table.planned(plan.column)[rows]
        since_zero = column if plan.zero == 0.0 else column - plan.zero
        stamps = since_zero * plan.factor
    latest = float(np.abs(stamps).max(initial=0.0))
    if latest > timing.LATEST:
        remedy = f"Check its unit: --time {shell_word(f'{plan.column} [ms]')}, or give --rate"
        raise TimingError(f"column {plan.column} goes up to {latest:.3g} s", remedy=remedy)

    # A row that repeats the row before in all but the time and the count of samples was written twice.
    same = np.ones(rows.size, dtype=np.bool_)
    same[:1] = False
    for name, values in table.columns.items():
        if name not in plan.not_signals:
            taken = values[rows]
            now = taken[1:]
            before = taken[:-1]
            both_empty = np.isnan(now) & np.isnan(before)
            same[1:] &= (now == before) | both_empty
    clock = from_stamps(stamps, same, column=plan.column, hint=period)
    if plan.kind == "column" and not plan.unit and clock.period >= SLOW:
        remedy = f"if it counts milliseconds, give --time {shell_word(f'{plan.column} [ms]')}"
        notes.append(
            f"{plan.column} has no unit, and in s its rows are {clock.period:.4g} s apart: {remedy}"
        )
    return clock


class RunsOfClock(NamedTuple):
    """A log whose clock may restart.

    Attributes:
        runs: of each run the rows of the table that its clock keeps, and the clock.
        columns: names of those that tell the time or count rows.
        notes: a sentence on each choice.
    """

    runs: list[tuple[NDArray[np.int64], timing.LogClock]]
    columns: set[str]
    notes: list[str]


def clocked_runs(plan: ClockPlan, table: Table) -> RunsOfClock:
    """The clock of each run of a log, which a restart of its time column ends.

    Raises:
        TimingError: time that cannot be put right.
    """
    stamps: Array | None = None
    if plan.kind == "column":
        stamps = table.columns.get(plan.column)
    elif plan.kind == "dates":
        stamps = table.clock
    stamped = np.arange(table.rows)
    # Of the stamped rows, those whose stamp is before that of the row before.
    restarts: list[int] = []
    if stamps is not None:
        stamped = np.flatnonzero(np.isfinite(stamps))
        goes_back = np.diff(stamps[stamped]) < 0
        restarts = (1 + np.flatnonzero(goes_back)).tolist()
    runs: list[tuple[NDArray[np.int64], timing.LogClock]] = []
    notes: list[str] = []
    with placed(table.name):
        for part in np.split(stamped, restarts):
            if restarts and part.size < timing.MINIMUM_ROWS:
                notes.append(f"{part.size} rows between two restarts of the clock left out")
                continue
            cut = {name: values[part] for name, values in table.columns.items()}
            dates = None if table.clock is None else table.clock[part]
            run = replace(table, columns=cut, clock=dates, breaks=())
            clock = clock_of(plan, run, np.arange(part.size), notes)
            notes.extend(clock.notes)
            runs.append((part[clock.keep], clock))
        timing.require_rows(sum(kept.size for kept, _ in runs))
    return RunsOfClock(runs, {*plan.not_signals, table.clock_name} - {""}, notes)


def _unusable_rows(
    plan: Plan,
    table: Table,
    values_of: Mapping[str, Array],
    unmeasured: Mask,
    notes: list[str],
) -> Mask:
    """Rows that are not measured or where a signal is not finite, shape (rows of the table,).

    What is not finite is an error unless it is to be dropped.

    Args:
        plan: says which.
        table: the rows.
        values_of: signals and inputs by name, each of shape (rows of the table,).
        unmeasured: see `unmeasured_rows`.
        notes: get a sentence on what is dropped.

    Raises:
        LogError: a value that is not finite, or one that nothing measures.
    """
    columns = {each.signal: each.column for each in plan.signals if each.column}
    units_of = {each.signal: each.si for each in plan.signals}
    unsampled = table.unsampled
    if unsampled is None:
        unsampled = np.zeros(table.rows, dtype=np.bool_)
    holes: dict[str, Mask] = {}
    for signal, values in values_of.items():
        missing = ~np.isfinite(values) & ~unsampled
        if missing.any():
            holes[columns.get(signal, signal)] = missing
    if holes:
        _refuse_or_note(table, holes, plan.invalid, notes)

    for signal, values in values_of.items():
        least, most = _LIMITS.get(signal, (-_LARGEST, _LARGEST))
        beyond = ((values < least) | (values > most)) & np.isfinite(values) & ~unmeasured
        if beyond.any():
            row = int(np.where(beyond, np.abs(values), 0.0).argmax())
            unit = units_of.get(signal, "")  # a further input has none
            value = f"{values[row]:.3g} {unit}".rstrip()
            where = f"data row {table.first_row + row + 1}"
            name = columns.get(signal, signal)
            limit = f"{most:.0e}" if signal not in _LIMITS else f"{least:g} to {most:g} {unit}"
            problem = f"column {name} is {value} in {where}, beyond {limit}, which nothing measures"
            raise LogError(problem, remedy="Correct the row, or leave it out with --skip")
    if unsampled.any():
        notes.append(
            f"{int(unsampled.sum())} steps of the loop had no good sample: left out, {CUT_THERE}"
        )
    return np.logical_or.reduce([*holes.values(), unsampled, unmeasured])


def _refuse_or_note(
    table: Table,
    holes: Mapping[str, Mask],
    invalid: Invalid,
    notes: list[str],
) -> None:
    """What to say of values that are not finite, by column; the first column goes first."""
    name, bad = next(iter(holes.items()))
    row = int(np.argmax(bad))
    count = int(bad.sum())
    values = table.columns.get(name)
    shown = "nan"
    if values is not None and not np.isnan(values[row]):
        shown = "infinity" if values[row] > 0 else "-infinity"
    many = f"{count} value{'s' if count > 1 else ''} missing or infinite"
    text = f"column {name} has {many}, the first ({shown}) in data row {table.first_row + row + 1}"
    if invalid == "error":
        answer = "--invalid drop"
        remedy = f"Correct them, or cut the log there with {answer}"
        raise LogError(text, remedy=remedy, answers=[answer])
    _, *others = holes.items()
    for other, rows in others:
        text += f", column {other} {int(rows.sum())}"
    dropped = np.logical_or.reduce(list(holes.values()))
    total = int(dropped.sum())
    notes.append(f"{text}: {total} row{'s' if total > 1 else ''} dropped, {CUT_THERE}")


def _segments(clock: timing.LogClock, usable: Mask) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First row of each segment and the row behind its last, in rows that are usable.

    A segment ends where the clock has a gap, and where rows are left out.
    """
    first = np.zeros(usable.size, dtype=np.bool_)
    first[list(clock.starts)] = True
    part = np.cumsum(first)  # which segment of the clock a row is in
    place = np.flatnonzero(usable)
    rows_left_out = np.diff(place) > 1
    gap_of_clock = np.diff(part[usable]) > 0
    after_a_gap = rows_left_out | gap_of_clock
    begins = np.concatenate(([True], after_a_gap))
    starts = np.flatnonzero(begins).astype(np.int64)
    return starts, np.append(starts[1:], place.size)


def _stepped(
    choice: SignalPlan,
    starts: NDArray[np.int64],
    stops: NDArray[np.int64],
) -> Array:
    """A signal that is one number in each segment, shape (rows,)."""
    if len(choice.numbers) != starts.size:
        rows = [f"{count:,}" for count in stops - starts]
        many = f"{', '.join(rows[:8])}{', ...' if len(rows) > 8 else ''}"
        segments = f"{starts.size} segments between gaps, of {many} rows"
        problem = f"{len(choice.numbers)} numbers for {choice.signal} and {segments}"
        raise MappingError(problem, remedy="Give one number for each")
    return np.repeat(np.array(choice.numbers), stops - starts)


def _read_only(signals: Mapping[str, Array]) -> Mapping[str, Array]:
    return MappingProxyType({name: _frozen(values) for name, values in signals.items()})


def _frozen(values: Array) -> Array:
    values = np.ascontiguousarray(values, dtype=np.float64).copy()
    values.setflags(write=False)
    return values
