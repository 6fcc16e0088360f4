"""Columns that a user named are taken first; the error for a name that is not there lists what is there.

A column that nobody named, that is called like a signal and that holds no numbers ends the plan: the log would be read
without the signal.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from erclutch.errors import LogError, MappingError, UnitError, shell_word
from erclutch.logs.columns.labels import own_unit, split_label
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.vocabulary import NEED_UNIT, OTHER, TOLD
from erclutch.logs.mapping import NONE, ColumnChoice
from erclutch.logs.plan import SignalPlan
from erclutch.logs.planning.draft import Draft
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

_TEMPERATURE = "temperature"
_LONGEST_NUMBER = 9  # digits of a column's place in the file


def refuse_unreadable_signals(draft: Draft) -> None:
    """Refuse a log in which a column is called like a signal, or like the time, and holds no numbers.

    Only where nothing else was chosen for that signal, and no other column is called so: the log would be read without
    the signal.

    Raises:
        LogError: there is such a column.
    """
    for name, meant in unreadable_signals(draft).items():
        remedy = (
            f"Correct its cells, or say what the {meant} is: --{meant} {shell_word('NAME [unit]')}"
        )
        remedy += ", or --field none if it was not logged" if meant == "field" else ""
        problem = f"{draft.table.unreadable[name]}, and it is called like the {meant}"
        raise LogError(problem, remedy=remedy)


def unreadable_signals(draft: Draft) -> dict[str, str]:
    """Columns without numbers that are called like a signal, or like the time, which no other column may be."""
    table = draft.table
    told = draft.told
    meant_by: dict[str, str] = {}
    settled = {*told.columns, *told.constants}
    if settled & {"slip", "position"}:
        settled |= {"slip", "position"}
    wanted = draft.needed - settled
    if told.name_pattern:
        wanted = {signal for signal in wanted if f"{{{signal}}}" not in told.name_pattern}
    timed = told.time is not None or told.rate is not None or table.clock is not None

    for name in table.unreadable:
        bare, _ = split_label(name)  # some readers know such a column by its label alone
        meant = _meant_by(bare, wanted, time=not timed)
        if not meant or any(
            _meant_by(other, {meant}, time=meant == "time") for other in table.columns
        ):
            continue
        meant_by[name] = meant
    return meant_by


def _meant_by(name: str, signals: Iterable[str], *, time: bool) -> str:
    """The signal that a name alone speaks for, ``time`` among them where that is looked for; "" for none.

    Short names that mean several things speak for none.
    """
    said = spoken_name(name)
    if time and said.is_time:
        return "time"
    of_something_else = said.says(TOLD | OTHER)
    for signal in sorted(signals):
        form = said.forms.get(signal)
        if form and form not in NEED_UNIT and (signal == "field" or not of_something_else):
            return signal
    return ""


def take_named(draft: Draft) -> None:
    """Take the columns that the user named; what is wrong with one of them is a question.

    Raises:
        MappingError: a signal that the device does not have. LogError: a column without numbers.
    """
    allowed = {*draft.known_signals, _TEMPERATURE}
    # A run names the columns of the log that it was fitted to; a recording of the live loop names its channels itself.
    named_by_itself = draft.known_signals if draft.table.device is not None else ()
    for signal, choice in draft.told.columns.items():
        declined = draft.told.declines(signal) and NONE not in draft.table.columns
        if signal not in allowed and not (signal == "field" and declined):
            own = ", ".join(sorted(draft.known_signals))
            problem = f"'{signal}' is no signal of a {draft.device} device (it has: {own})"
            raise MappingError(problem, remedy="Use one of these, or set --device")
        if not declined:
            try:
                name, unit, factor = locate(draft.table, choice, signal)
                if name in draft.seen.empty:
                    raise _without_numbers(draft.table, name, signal)
                if signal == _TEMPERATURE:
                    logged = draft.table.columns[name] * factor
                    in_kelvin, offset = units.to_kelvin(logged, unit, name)
                    draft.signals[signal] = SignalPlan(
                        signal,
                        name,
                        unit,
                        factor,
                        factor * in_kelvin,
                        "K",
                        offset=offset,
                        reason=choice.source,
                    )
                    draft.notes.append(
                        f"temperature <- column {name} [{unit}], in K ({choice.source})"
                    )
                else:
                    draft.take(signal, name, unit, factor, choice.source)
            except MappingError as error:
                if signal in named_by_itself:
                    draft.notes.append(
                        f"{signal}: the recording's own channel; it has no column '{choice.column}'"
                    )
                else:
                    draft.ask(signal, error)
        elif signal == "field":
            draft.take_no_field(said=True)
        else:
            draft.declined.append(signal)
            draft.notes.append(f"{signal}: no column is taken for it ({choice.source})")


def _without_numbers(table: Table, name: str, signal: str) -> MappingError:
    """The error for a column that was named and has no number."""
    problem = f"column '{name}' holds no number in any row, so it cannot be the {signal}; the file has: {table.listed}"
    none = ", or --field none" if signal == "field" else ""
    return MappingError(problem, remedy=f"Name another column with --{signal}{none}")


def locate(
    table: Table,
    choice: ColumnChoice,
    signal: str,
) -> tuple[str, str | None, float]:
    """Column name, unit and factor that a choice means; an exact column name wins over its reading as a label.

    Raises:
        MappingError: no such column; the message lists the columns and a close match. UnitError: a unit of another
            kind than the unit that ends the column's name.
        LogError: its cells are no numbers.
    """
    text = str(choice.column).strip()
    positive = text.removeprefix("-").strip()
    hollow = split_label(positive)[0]
    if hollow in table.hollow:
        raise _without_numbers(table, hollow, signal)
    for name in (text, positive, split_label(text)[0], split_label(positive)[0]):
        if name not in table.columns and name in table.unreadable:
            raise LogError(
                table.unreadable[name], remedy="Correct its cells, or name another column"
            )

    readings = [(text, 1.0)]
    if text.startswith("-"):
        readings.append((positive, -1.0))
    for label, sign in readings:
        name = label
        unit = choice.unit
        if name not in table.columns:
            name, own = split_label(label)
            unit = choice.unit or own
        # The label may be the whole head of a column with its unit once more behind it.
        head = split_label(name)[0]
        if name not in table.columns and head in table.columns:
            name = head
        if name not in table.columns and name.isdecimal() and len(name) <= _LONGEST_NUMBER:
            name = table.numbered(int(name)) or name
        if name in table.columns:
            _, end = split_end(name)
            both = end and unit and units.is_unit(end) and units.is_unit(unit)
            # No volt is an ampere.
            if both and units.parse(end or "").dimension != units.parse(unit or "").dimension:
                problem = f"column '{name}' ends in a unit, {end}, and {unit} is of another kind"
                as_it_is = f"--{signal} {shell_word(name)}"
                remedy = f"Give it as it is, {as_it_is}"
                answers = [as_it_is]
                if signal in SIGNALS:
                    scaled = f"--scale {shell_word(f'{signal}=1 {unit}/{end}')}"
                    remedy += f", or what one {end} of it means, such as {scaled}"
                    answers.append(f"{as_it_is} {scaled}")
                raise UnitError(problem, remedy=remedy, answers=answers)
            si_units = ("s",) if signal == "time" else ()
            if signal in SIGNALS:
                si_units = SIGNALS[signal].si_units
            unit = choice.unit or own_unit(name, unit or table.units.get(name), si_units)
            return name, unit, sign * choice.scale
    raise _no_such_column(table, text, signal)


def _no_such_column(table: Table, text: str, signal: str) -> MappingError:
    """The error for a column that was named and is not there, with the column that is called nearly so."""
    readable = {name.lower(): name for name in table.columns if name not in table.truths}
    near = get_close_matches(split_label(text)[0].lower(), readable, n=1, cutoff=0.5)
    remedy = f"Give one of them as --{signal} {shell_word('NAME [unit]')}"
    answers: list[str] = []
    if near:
        close = readable[near[0]]
        named = f"--{signal} {shell_word(close)}"
        remedy = f"Did you mean {close}? Give it as {named}"
        # A signal's unit may not fit that column; what is called like a time is a time.
        answers = [named] if signal == "time" else []
    option = ""
    if "*" in text and signal != "time":
        option = "--variable all"
        remedy += f"; for a log of each column of such a name add {option}"
    problem = f"there is no column '{text}' for {signal}; the file has: {table.listed}"
    return MappingError(problem, remedy=remedy, answers=answers, option=option)
