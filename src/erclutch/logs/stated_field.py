"""A field that no column holds may be stated: in the header of the file, by a number beside its columns, in its name.

A log at 0.5 A is another log than one at 1 A: read as logs without a field, both would be mixed in a fit.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.draft import Draft
from erclutch.logs.labels import split_label
from erclutch.logs.names import OTHER, TOLD, spoken_name
from erclutch.logs.plan import SignalPlan
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

#: Words of a header that may be those of an amplifier or a load cell, whatever their unit.
_OF_INSTRUMENTS = frozenset({"excitation", "command", "cmd", "duty", "pwm", "field"})
_CURRENTS = ("A",)
_IN_A_NAME = re.compile(r"(?<![\d.x])([+-]?\d+(?:[.x]\d+)?)(mA|A|kV|V|mT|T)(?![A-Za-z0-9])")
_NUMBER = re.compile(r"\d+(?:[.x]\d+)?")


class StatedField(NamedTuple):
    """A number that may be the field.

    Attributes:
        name: what it is called.
        number: as written.
        unit: as written; None where nobody says it.
    """

    name: str
    number: float
    unit: str | None

    def __str__(self) -> str:
        number = f"{self.number:g} {self.unit}" if self.unit else f"{self.number:g}"
        return f"{self.name} = {number}"


def take_stated_field(draft: Draft) -> bool:
    """Take the field from what the file states beside its columns; ask where it states two, or its name one.

    Returns:
        Whether the field was taken or is asked about.
    """
    stated = _beside_the_columns(draft)
    currents = [each for each in stated if each.unit and units.fits(each.unit, _CURRENTS)]
    if len(currents) == 1:  # a voltage beside it drives it
        stated = currents
    if len(stated) > 1:
        words = ", ".join(map(str, stated))
        first = f"{stated[0].number:g} {stated[0].unit or ''}".strip()
        remedy = f"Say which, such as --constant {shell_word(f'field={first}')}, or --field none"
        problem = f"field may be any of the numbers that the file states: {words}"
        draft.ask("field", MappingError(problem, remedy=remedy), f"--constant {shell_word(f'field={first}')}")
        return True
    if stated:
        _take(draft, stated[0])
        return True
    return _ask_about_the_name(draft)


def _take(draft: Draft, stated: StatedField) -> None:
    if stated.unit:
        factor, si = units.conversion(stated.unit, SIGNALS["field"], stated.name)
        how = ""
    else:
        factor = 1.0
        si = units.UNKNOWN
        how = ", no unit: taken as written"
    number = stated.number * factor
    reason = "stated in the file"
    draft.signals["field"] = SignalPlan(
        "field",
        unit=stated.unit,
        si=si,
        numbers=(number,),
        reason=reason,
        sureness="likely",
    )
    draft.constants["field"] = number
    draft.notes.append(f"field <- {stated}, {reason} beside its columns{how}")


def _beside_the_columns(draft: Draft) -> list[StatedField]:
    """Numbers of the header, and numbers beside vectors, whose name is that of a current or a voltage."""
    found: list[StatedField] = []
    for name, number in draft.table.constants.items():
        if _is_called_so(name):
            found.append(StatedField(name, number, draft.table.units.get(name) or spoken_name(name).end))
    for key, text in draft.table.metadata.items():
        label, unit = split_label(key)
        if not _is_called_so(label):
            continue
        try:
            number, own = units.quantity(text)
        except UnitError:
            continue
        if own or unit:
            found.append(StatedField(label, number, own or unit))
    return [each for each in found if not each.unit or _fits(each.unit)]


def _fits(unit: str) -> bool:
    """Whether a unit is one of a current, a voltage or a magnetic field."""
    return units.is_unit(unit) and units.fits(unit, SIGNALS["field"].si_units[1:]) is not None


def _is_called_so(name: str) -> bool:
    """Whether a whole name is that of a current or a voltage, not of a limit, a set point or a supply."""
    spoken = spoken_name(name)
    form = spoken.forms["field"]
    if not form or form in _OF_INSTRUMENTS or "field" in spoken.turned or {*spoken.words} & (TOLD | OTHER):
        return False
    return len(form) > 2 or name == "I"


def _ask_about_the_name(draft: Draft) -> bool:
    """Ask whether the number in front of an A or a V in the file's name is the field."""
    name = draft.table.name
    numbers = list(_IN_A_NAME.finditer(name))
    if len(numbers) != 1 or draft.told.name_pattern is not None:
        return False
    number = numbers[0]
    stem, _, _ = name.rpartition(".")
    if number.end() > len(stem):
        stem = name

    # The other numbers differ from file to file too.
    counted = (f"{{n{place}}}" for place in range(1, len(stem)))
    before = _NUMBER.sub(lambda _: next(counted), stem[: number.start(1)])
    after = _NUMBER.sub(lambda _: next(counted), stem[number.end(1) :])
    option = f"--name-pattern {shell_word(f'{before}{{field}}{after}')}"
    problem = f"no column for field, and the name of the file says {number.group(1)} {number.group(2)}"
    draft.ask("field", MappingError(problem, remedy=f"If that is the field, give {option}; else --field none"), option)
    return True
