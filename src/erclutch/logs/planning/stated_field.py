"""A field that no column holds may be stated: in the header, beside the columns, in a name of an effort or a file.

A log at 0.5 A is another log than one at 1 A: read as logs without a field, both would be mixed in a fit.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import isclose
from pathlib import Path

from erclutch.errors import MappingError, UnitError, listed, shell_word
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.levels_in_names import (
    StatedLevel,
    differ_by_field,
    open_field_in,
    stated_in,
    without_field,
)
from erclutch.logs.columns.name_pattern import (
    FIELD_IN_A_NAME,
    FIELD_UNITS,
    NUMBER,
    may_lack_its_point,
    number_of,
)
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.vocabulary import CURRENTS, OTHER, TOLD, set_of
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import SignalPlan
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.field_of_words import ask_about_the_only_word, ask_about_words
from erclutch.logs.planning.remarked_field import ask_about_remarked_field
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

#: Words of a header that may be those of an amplifier or a load cell, whatever their unit.
_OF_INSTRUMENTS = frozenset({"excitation", "command", "cmd", "duty", "pwm", "field"})
_CURRENTS = ("A",)
#: What a field is measured in that no amplifier has.
_OF_FIELDS_ALONE = ("A", "T", "A/m", "V/m")
#: What a current is called by that magnetizes the fluid, in front of a word for a current.
_OF_A_MAGNET = set_of("magnet electromagnet solenoid excitation exciting magnetizing")
#: Whose current turns a shaft.
_MACHINES = set_of("motor engine servo actuator")
_OF_A_DEVICE = set_of(
    "brake clutch damper coil magnet electromagnet fluid bremse kupplung frein freno"
)
#: What a single number is called; a column that is called so may be a phase.
_LETTER_AND_UNIT = re.compile(r"I_(m?A)|U_(k?V)")
_FOLDERS_ABOVE = 2  # of a log, whose names may tell its field: ``0.5A/2Hz/log.csv``
_NUMBER = re.compile(NUMBER.removeprefix("[+-]?"))
_COUNTED = re.compile(r"([1-9]\d?)([AVT])")  # 1A: the first specimen of batch A, or a log at 1 A


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
        draft.ask(
            "field",
            MappingError(problem, remedy=remedy),
            f"--constant {shell_word(f'field={first}')}",
        )
        return True
    if stated:
        (only,) = stated
        _take(draft, only, "beside its columns")
        return True
    effort = draft.signals.get("effort")
    of_effort = None if effort is None else stated_in(effort.column)
    if effort is not None and of_effort is not None:
        # The effort stands beside others whose names differ in that number alone, and each has its point.
        bare = without_field(effort.column)
        alike = [name for name in draft.table.columns if without_field(name) == bare]
        if differ_by_field(alike) and not any(map(open_field_in, draft.table.columns)):
            _take(draft, of_effort, "by the name of the effort")
            return True
    of_effort_or_recording = "" if effort is None else open_field_in(effort.column)
    of_effort_or_recording = of_effort_or_recording or open_field_in(draft.told.variable or "")
    if of_effort_or_recording:
        _ask_about_an_open_number(draft, of_effort_or_recording, "the name of the log")
        return True
    of_recording = stated_in(draft.told.variable or "")
    if of_recording is not None:  # 1A may be the first specimen of batch A
        text = f"{of_recording.number:g} {of_recording.unit}"
        option = f"--constant {shell_word(f'field={text}')}"
        problem = f"no column for field, and the name of the recording says {text}"
        remedy = f"If that is the field, give {option}; else --field none"
        draft.ask("field", MappingError(problem, remedy=remedy), option)
        return True
    asked = ask_about_remarked_field(draft) or ask_about_the_only_word(draft)
    return asked or ask_about_words(draft) or _ask_about_the_name(draft)


def states_a_field(draft: Draft) -> bool:
    """Whether the header or a number beside the columns states a field."""
    return bool(_beside_the_columns(draft))


def ask_about_specimens(names: Sequence[str], told: ColumnMap) -> None:
    """Ask whether names such as ``1A``, ``2A``, ``3A`` number specimens or tell fields; nothing else is in them.

    Raises:
        MappingError: nobody said it.
    """
    matches = [_COUNTED.fullmatch(name) for name in names]
    counted = [(int(match[1]), match[2]) for match in matches if match is not None]
    letters = {letter for _, letter in counted}
    numbers = sorted(number for number, _ in counted)
    if len(names) < 2 or len(letters) != 1 or numbers != [*range(1, len(names) + 1)]:
        return
    is_said = told.name_pattern is not None or "field" in told.columns or "field" in told.constants
    if is_said or told.declines("field"):
        return
    letter = letters.pop()
    problem = f"the names {listed(names)} may number specimens, or tell the field in {letter}"
    option = "--variable all --field none"
    pattern = shell_word(f"{{field}}{letter}")
    remedy = f"Say which: {option}, or --variable all --name-pattern {pattern}"
    raise MappingError(problem, remedy=remedy, option=option)


def _take(draft: Draft, stated: StatedLevel, where: str) -> None:
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
    draft.notes.append(f"field <- {stated}, {reason} {where}{how}")


def _beside_the_columns(draft: Draft) -> list[StatedLevel]:
    """Numbers of the header, and numbers beside vectors, whose name is that of a current or a voltage."""
    stated: list[StatedLevel] = []
    for name, number in draft.table.constants.items():
        label, in_brackets = split_label(name)
        letter = _LETTER_AND_UNIT.fullmatch(label)
        if letter is not None or _is_called_so(label):
            own = in_brackets or draft.table.units.get(name) or spoken_name(label).end
            stated.append(StatedLevel(name, number, own or (letter and (letter[1] or letter[2]))))
    for key, text in draft.table.metadata.items():
        label, unit = split_label(key)
        try:
            number, own = units.quantity(text)
        except UnitError:
            continue
        unit = own or unit
        if not unit:
            continue
        words = spoken_name(label).words
        is_of_a_magnet = len(words) == 2 and words[0] in _OF_A_MAGNET and words[1] in CURRENTS
        # No amplifier has a field or a magnet in such a unit.
        is_in_its_unit = units.is_unit(unit) and units.fits(unit, _OF_FIELDS_ALONE) is not None
        is_a_field = is_in_its_unit and (is_of_a_magnet or words == ("field",))
        if is_a_field or _is_called_so(label):
            stated.append(StatedLevel(label, number, unit))
    units_of_field = SIGNALS["field"].si_units[1:]  # of a current, a voltage or a magnetic field
    fitting: list[StatedLevel] = []
    for each in stated:
        unit = each.unit
        if not unit or (units.is_unit(unit) and units.fits(unit, units_of_field) is not None):
            fitting.append(each)
    return fitting


def _is_called_so(name: str) -> bool:
    """Whether a whole name is that of a current or a voltage, not of a limit, a set point or a supply."""
    spoken = spoken_name(name)
    form = spoken.forms["field"]
    is_another = "field" in spoken.turned or bool({*spoken.words} & (TOLD | OTHER | _MACHINES))
    if not form or form in _OF_INSTRUMENTS or is_another:
        return False
    return len(form) > 2 or name == "I"


def _ask_about_the_name(draft: Draft) -> bool:
    """Ask whether the number in front of an A or a V in the name of the file, or of a folder of it, is the field."""
    if draft.told.name_pattern is not None:
        return False
    name = draft.table.name
    stem, _, _ = name.rpartition(".")
    number = _number_of_a_field(name)
    if number is not None:
        where = "file"
        said = stem if number.end() <= len(stem) else name
        beside = ""
    else:
        where = "folder"
        said = ""
        beside = f"/{stem or name}"
        folders = [*Path(draft.table.path).resolve().parents] if draft.table.path else []
        for folder in folders[:_FOLDERS_ABOVE]:
            said = folder.name
            number = _number_of_a_field(said)
            if number is not None:
                break
            beside = f"/{said}{beside}"
    if number is None:
        return False
    unit = FIELD_UNITS[number[3]]
    volts = draft.supply if unit == "V" else None  # of a motor under test, as its powers tell
    is_the_supply = volts is not None and isclose(number_of(number[1]), volts, rel_tol=0.01)
    if is_the_supply or _feeds_a_motor(draft, number, said):
        return False
    if may_lack_its_point(number):
        written = open_field_in(said) or f"{number[1]}{number[3]}"  # a supply may stand beside it
        _ask_about_an_open_number(draft, written, f"the name of the {where}")
        return True

    # The other numbers differ from file to file too.
    counted = (f"{{n{place}}}" for place in range(1, len(said + beside)))
    before = _NUMBER.sub(lambda _: next(counted), said[: number.start(1)])
    after = _NUMBER.sub(lambda _: next(counted), said[number.end(1) :] + beside)
    label = "{field}" if unit == number[3] else f"{{field:{unit}}}"
    option = f"--name-pattern {shell_word(f'{before}{label}{after}')}"
    problem = (
        f"no column for field, and the name of the {where} says {number_of(number[1]):g} {unit}"
    )
    # Of a motor under test, whose powers tell another voltage, it is rather what feeds it.
    is_rather_none = volts is not None
    remedy = f"If that is the field, give {option}; else --field none"
    likely = "--field none" if is_rather_none else option
    draft.ask("field", MappingError(problem, remedy=remedy, option=option), likely)
    return True


def _feeds_a_motor(draft: Draft, number: re.Match[str], said: str) -> bool:
    """Whether a number of volts stands behind the word motor in a name, of a motor under test and of no device.

    Its powers may tell another voltage, as where they were computed for the rated one: that is said.
    """
    if FIELD_UNITS[number[3]] != "V" or draft.supply is None:
        return False
    spoken = spoken_name(said[: number.start()])
    if not spoken.says(_MACHINES) or spoken.says(_OF_A_DEVICE):
        return False
    draft.notes.append(
        f"the name {said} says {number_of(number[1]):g} V, and the powers of the motor under test tell "
        f"{draft.supply:.4g} V: taken for what feeds the motor, and for no field"
    )
    return True


def _ask_about_an_open_number(draft: Draft, written: str, where: str) -> None:
    """Ask for the field that a name such as ``F_05A`` tells: 5 A or 0.5 A."""
    unit = FIELD_UNITS[written.lstrip("+-0123456789_")]
    option = f"--constant {shell_word(f'field=NUMBER {unit}')}"
    problem = f"no column for field, and {where} says {written}, which may lack its decimal point"
    remedy = f"If that is the field, give {option}; else --field none"
    draft.ask("field", MappingError(problem, remedy=remedy, option=option), option)


def _number_of_a_field(name: str) -> re.Match[str] | None:
    """The only number in front of a unit of a field in a name, or the only current where a supply stands beside it."""
    numbers = list(FIELD_IN_A_NAME.finditer(name))
    if len(numbers) > 1:
        numbers = [each for each in numbers if units.fits(FIELD_UNITS[each[3]], _CURRENTS)]
    return numbers[0] if len(numbers) == 1 else None
