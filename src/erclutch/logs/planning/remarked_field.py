"""A line above the rows may state the field in words that are no sure name of it: it is quoted and asked about.

``Command: 0.5 A``, ``PWM duty: 50 %`` and ``coil driven with 0.5 A`` are such lines. What supplies the bench, bounds it
or feeds a sensor is none.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.name_pattern import FIELD_IN_A_NAME, FIELD_UNITS, number_of
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.vocabulary import AGAINST, NOT_MEASURED, OTHER, TOLD, set_of
from erclutch.logs.planning.draft import Draft
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

_FIRST_NUMBER = re.compile(r"([+-]?\d+(?:[.,]\d+)?)\s*(%?)$")
#: What a line is of that is no field, whatever its unit: what can be, what feeds another part, who made or counted it.
_OTHER_WORDS = (
    AGAINST["field"]
    | NOT_MEASURED
    | (OTHER - {"density"})
    | set_of(
        "maximum minimum range rated rating full scale fuse probe clamp gain sensitivity calibration amplifier source "
        "motor servo engine trigger threshold model serial version firmware operator company date time file name "
        "channel id type standard order part batch specimen netz versorgung nenn zero resistance temp rate"
    )
)
#: What a voltage or a number without a unit must be called to be asked about.
_OF_A_FIELD = set_of("field coil magnet solenoid electromagnet electrode gap duty pwm spule feld")
_FEEDS_A_SENSOR = "excitation"
_DIGITS = re.compile(r"\d+")


class _Line(NamedTuple):
    """A line that may state the field: its words as they stand in the file, and the number with its unit."""

    words: str
    quantity: str


def ask_about_remarked_field(draft: Draft) -> bool:
    """Ask whether a line above the rows states the field, where no column and no sure name does.

    Returns:
        Whether a line was found.
    """
    lines: list[_Line] = []
    for key, text in draft.table.metadata.items():
        quantity = _field_of(key, text)
        if quantity:
            lines.append(_Line(f"'{key}: {text}'", quantity))
    if not lines:
        return False
    # Lines that number their tests tell one field after another, such as 0, 0.5, 1 A; others are about several things.
    about = {_DIGITS.sub("", line.words.partition(":")[0]) for line in lines}
    parts = [line.quantity.partition(" ") for line in lines]
    units_of_lines = {unit for _, _, unit in parts}
    if len(lines) > 1 and len(about) == 1 and len(units_of_lines) == 1:
        numbers = ", ".join(number for number, _, _ in parts)
        of_stretches = f"{numbers} {units_of_lines.pop()}".strip()
        option = f"--constant {shell_word(f'field={of_stretches}')}"
        problem = f"no column for field, and lines above the rows say {_quoted(lines)}"
        remedy = f"If these are the fields of one stretch after another, give {option}; else --field none"
        draft.ask("field", MappingError(problem, remedy=remedy, option=option), option)
        return True
    quoted = _quoted(lines)
    verb = "says" if len(lines) == 1 else "say"
    subject = "a line above the rows" if len(lines) == 1 else "lines above the rows"
    option = f"--constant {shell_word(f'field={lines[0].quantity}')}"
    which = "that is" if len(lines) == 1 else "the first is"
    problem = f"no column for field, and {subject} {verb} {quoted}"
    remedy = f"If {which} the field, give {option}; else --field none"
    draft.ask("field", MappingError(problem, remedy=remedy), option)
    return True


def _quoted(lines: Sequence[_Line]) -> str:
    return ", ".join(line.words for line in lines)


def _field_of(key: str, text: str) -> str:
    """The quantity that a line may state the field by, such as ``0.5 A``; "" for another line."""
    label, unit_of_key = split_label(key)
    name = spoken_name(label)
    words = {*name.words}
    said = {word.lower() for word in re.findall(r"[^\W\d_]+", text)}
    if not _OTHER_WORDS.isdisjoint(words | said) or "field" in name.turned:
        return ""
    is_called_so = "field" in name.may_be and len(name.plain_stem) > 1
    is_called_so = is_called_so or not _OF_A_FIELD.isdisjoint(words)
    is_told = not TOLD.isdisjoint(words)

    alone = _FIRST_NUMBER.match(text.strip())
    unit = unit_of_key or name.end
    if alone is not None and unit and not alone[2]:
        number, letters = alone[1], unit
    elif alone is not None:  # nobody says of what
        feeds_a_sensor = _FEEDS_A_SENSOR in words
        is_enough = is_called_so and not is_told and not feeds_a_sensor
        number_and_unit = f"{number_of(alone[1]):g} {alone[2]}".strip()
        return number_and_unit if is_enough else ""
    else:
        numbers = FIELD_IN_A_NAME.findall(text)
        if len(numbers) != 1:
            return ""
        number, gap, sign = numbers[0]
        letters = FIELD_UNITS[sign]
        starts_so = text.lstrip().startswith(number)
        # 2A among other words may be a specimen.
        if not starts_so and not gap and not re.search("[.,]", number):
            return ""
    if not units.is_unit(letters) or units.fits(letters, SIGNALS["field"].si_units[1:]) is None:
        return ""
    is_voltage = units.fits(letters, ("V",)) is not None
    says_field = is_called_so or "field" in name.within or not _OF_A_FIELD.isdisjoint(said)
    if is_voltage and (_FEEDS_A_SENSOR in words or not says_field):
        return ""  # amplifiers, ranges and supplies have volts too
    return f"{number_of(number):g} {letters}"
