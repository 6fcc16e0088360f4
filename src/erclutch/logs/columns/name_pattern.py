"""A file's name can hold numbers: ``{amplitude}mm{frequency}Hz{field}A`` reads ``25mm0x5Hz0x25A.txt``."""

from __future__ import annotations

import re

from erclutch.errors import MappingError
from erclutch.signals import units

#: A field of a pattern, with its name and its unit.
FIELD = re.compile(r"\{([A-Za-z_]\w*)(?:\s*(?::|\[)\s*([^{}\[\]]*?)\s*\]?)?\}")
#: A number in a name; x and p stand for the decimal point, which some systems allow in no name of a file.
NUMBER = r"[+-]?\d+(?:[.,xp]\d+)?"
_UNIT_AFTER = re.compile(r"[A-Za-zµ°%][A-Za-zµ°%/]*")
_NUMBER_WITH_LETTERS = re.compile(rf"{NUMBER}([A-Za-z]*)")
_UNITS_OF_FIELD = ("A", "mA", "V", "kV", "T", "mT")
_QUANTITIES = {"mm": "amplitude", "Hz": "frequency", "rpm": "speed", "s": "time", "C": "temperature", "Nm": "torque"}


def number_of(text: str) -> float:
    """A number as a name has it."""
    return float(re.sub("[xp,]", ".", text))


def proposed(name: str) -> str:
    """A pattern for a name that holds one number with a field's unit, such as ``5mm3Hz0x25A.txt``; "" for others."""
    stem = name.rpartition(".")[0] or name
    numbers = list(_NUMBER_WITH_LETTERS.finditer(stem))
    of_fields = [number for number in numbers if number.group(1) in _UNITS_OF_FIELD]
    if len(of_fields) != 1:
        return ""
    pattern = ""
    end = 0  # of the number before
    for place, number in enumerate(numbers, start=1):
        unit = number.group(1)
        quantity = "field" if unit in _UNITS_OF_FIELD else _QUANTITIES.get(unit, "")
        if not quantity or f"{{{quantity}}}" in pattern:
            quantity = f"number{place}"
        pattern += f"{stem[end : number.start()]}{{{quantity}}}{unit}"
        end = number.end()
    return pattern + stem[end:]


def constants_of(pattern: str, name: str) -> dict[str, tuple[float, str | None]]:
    """Numbers and units that a file's name gives under a pattern.

    A field is ``{name}``, ``{name:unit}`` or ``{name [unit]}``; without a unit, the letters that follow it are taken as
    its unit if they read as one. A point, a comma, ``x`` or ``p`` is the decimal mark. The suffix may be left out.

    Raises:
        MappingError: the pattern has no field or one twice, or the name does not match.
    """
    fields = list(FIELD.finditer(pattern))
    keys = [match.group(1) for match in fields]
    odd_bracket = re.search(r"[{}]", FIELD.sub("", pattern))
    if not keys or len(set(keys)) < len(keys) or odd_bracket:
        problem = f"the name pattern '{pattern}' is not a template with different fields"
        raise MappingError(problem, remedy="Write it like {amplitude}mm{frequency}Hz{field}A")
    literals = FIELD.split(pattern)[::3]  # what stands between the fields
    expression = f"({NUMBER})".join(re.escape(literal) for literal in literals)
    stems = [name, *(name[:at] for at, letter in enumerate(name) if letter == ".")]
    matches = (re.fullmatch(expression, stem) for stem in stems)
    first_match = next((match for match in matches if match is not None), None)
    if first_match is None:
        raise MappingError(
            f"the file's name does not match the pattern '{pattern}'",
            remedy="Rename the file or correct name_pattern ({...} stands for a number, x or p for its decimal point)",
        )

    numbers: dict[str, tuple[float, str | None]] = {}
    for field, number, after in zip(fields, first_match.groups(), literals[1:], strict=True):
        unit = field.group(2)
        letters = _UNIT_AFTER.match(after)
        if not unit:
            unit = letters.group() if letters and units.is_unit(letters.group()) else None
        numbers[field.group(1)] = (number_of(number), unit)
    return numbers
