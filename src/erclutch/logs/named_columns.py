"""A column that a user named is found in a table, with its unit; the error for any other name lists what is there."""

from __future__ import annotations

from erclutch.errors import LogError, MappingError, UnitError, shell_word
from erclutch.logs.labels import own_unit, split_end, split_label
from erclutch.logs.mapping import ColumnChoice
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS


def locate(table: Table, choice: ColumnChoice, signal: str) -> tuple[str, str | None, float]:
    """Column name, unit and factor that a choice means; an exact column name wins over its reading as a label.

    Raises:
        MappingError: no such column; the message lists the columns and a close match.
        LogError: its cells are no numbers.
    """
    text = str(choice.column).strip()
    _refuse_unreadable(table, text)
    for candidate, factor in ((text, 1.0), (text[1:].strip(), -1.0))[: 1 + text.startswith("-")]:
        name, unit = candidate, choice.unit
        if name not in table.columns:
            name, own = split_label(candidate)
            unit = choice.unit or own
        if name not in table.columns and name.isdecimal() and len(name) < 10:
            name = table.numbered(int(name)) or name
        if name in table.columns:
            _refuse_another_kind(name, unit, signal)
            si_units = SIGNALS[signal].si_units if signal in SIGNALS else ("s",) if signal == "time" else ()
            return name, choice.unit or own_unit(name, unit or table.units.get(name), si_units), factor * choice.scale
    raise _no_column(table, text, signal)


def _refuse_unreadable(table: Table, text: str) -> None:
    """Raise a LogError where the column that is named holds no numbers."""
    plain = text.removeprefix("-").strip()
    for name in (text, plain, split_label(text)[0], split_label(plain)[0]):
        if name not in table.columns and name in table.unreadable:
            raise LogError(table.unreadable[name], remedy="Correct its cells, or name another column")


def _refuse_another_kind(name: str, unit: str | None, signal: str) -> None:
    """Refuse a unit that is given for a column whose name ends in a unit of another kind: no volt is an ampere."""
    _, end = split_end(name)
    if not end or not unit or not (units.is_unit(end) and units.is_unit(unit)):
        return
    if units.parse(end).dimension != units.parse(unit).dimension:
        problem = f"column '{name}' ends in a unit, {end}, and {unit} is of another kind"
        scale = shell_word(f"{signal}=1 {unit}/{end}")
        remedy = f"Give it as it is, --{signal} {shell_word(name)}"
        remedy += f", or what one {end} of it means, such as --scale {scale}" if signal in SIGNALS else ""
        raise UnitError(problem, remedy=remedy)


def _no_column(table: Table, text: str, signal: str) -> MappingError:
    import difflib

    lower = {name.lower(): name for name in table.columns if name not in table.truths}
    near = difflib.get_close_matches(split_label(text)[0].lower(), lower, n=1, cutoff=0.5)
    close = lower[near[0]] if near else ""
    hint = f"Did you mean {close}? Give it as" if close else "Give one of them as"
    problem = f"there is no column '{text}' for {signal}; the file has: {table.listed}"
    each = "; for a log of each column of such a name add --variable all" if "*" in text and signal != "time" else ""
    return MappingError(problem, remedy=f"{hint} --{signal} {shell_word(close or 'NAME [unit]')}{each}")
