"""A file's name can hold numbers: ``{amplitude}mm{frequency}Hz{field}A`` reads ``25mm0x5Hz0x25A.txt``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import PurePath

from erclutch.errors import MappingError
from erclutch.logs.columns.names import spoken_name
from erclutch.signals import units

#: A field of a pattern, with its name and its unit.
FIELD = re.compile(r"\{([A-Za-z_]\w*)(?:\s*(?::|\[)\s*([^{}\[\]]*?)\s*\]?)?\}")
#: A number in a name; x and p stand for the decimal point, which some systems allow in no name of a file.
NUMBER = r"[+-]?\d+(?:[.,xp]\d+)?"
_UNIT_AFTER = re.compile(r"[A-Za-zµ°%][A-Za-zµ°%/]*")
#: A hyphen behind a word is no sign: ``test-2A``.
_NUMBER_WITH_LETTERS = re.compile(r"(?:(?<![^\W_])(?<![)\]])[+-])?\d+(?:[.,xp]\d+)?([A-Za-z]*)")
_UNITS_OF_FIELD = ("A", "mA", "V", "kV", "T", "mT", "kA/m", "A/m", "kV/mm", "V/mm", "kV/m", "V/m")
#: What stands behind the number of a field in a name, and the unit that it means. A name of a column may hold a slash,
#: a name of a file none.
FIELD_UNITS: dict[str, str] = {
    **{unit: unit for unit in _UNITS_OF_FIELD},
    **{word: "A" for word in ("Amp", "Amps", "Ampere", "Amperes", "amp", "amps", "ampere")},
    **{word: "V" for word in ("Volt", "Volts", "volt", "volts")},
    **{word: "kV/mm" for word in ("kVmm", "kV_mm", "kV-mm", "kVpmm", "kVpermm", "kV_per_mm")},
    **{word: "V/mm" for word in ("Vmm", "V_mm", "V-mm", "Vpmm", "Vpermm")},
}
#: A number of a field with its unit; a dash behind a letter, a digit or a bracket parts words, and is no sign.
FIELD_IN_A_NAME = re.compile(
    r"(?<![\d.])(?<!\d[xp,])((?:(?<![^\W_])(?<![)\]])[+-])?\d+(?:[.,xp]\d+)?)( ?)"
    rf"({'|'.join(sorted(FIELD_UNITS, key=len, reverse=True))})(?![A-Za-z0-9])"
)
#: A number of a name with the letters in front of it and behind it.
_IN_WORDS = re.compile(
    r"([A-Za-z]*)([ _=-]?)((?:(?<![A-Za-z\d])[+-])?\d+(?:[.,xp]\d+)?)(?= ?([A-Za-zµ°%_]*))"
)
#: What numbers logs from 1 on, one after another.
_COUNTED = frozenset(
    (
        "run test trial rep repeat nr no sample specimen log file data exp part cycle v rev "
        "device unit versuch messung probe lauf essai ensayo"
    ).split()
)
#: In front of a number, these count logs: of ``run_1_5A`` the first is at 5 A, and ``F_1_5A`` may be at 1.5 A.
_COUNTS_LOGS = _COUNTED - {"data", "v", "part", "rev", "cycle"}
_WHOLE_BEHIND = re.compile(r"(?:([A-Za-z]*)[ _=-]|^)(\d)_$")
_ZERO_IN_FRONT = re.compile(r"0\d+")
_OF_MOTION_OR_HEAT = frozenset(
    (
        "mm cm m um µm in Hz hz HZ kHz rpm RPM rps mps mms cms rads s ms min h C degC °C K F "
        "deg ° N kN Nm g kg bar MPa"
    ).split()
)
_DIGITS_OF_A_DATE = 6  # or more
_NO_COUNT = 10  # steps from one number to the next that are no count of logs
_QUANTITIES = {
    "mm": "amplitude",
    "Hz": "frequency",
    "rpm": "speed",
    "s": "time",
    "C": "temperature",
    "Nm": "torque",
}


def may_lack_its_point(number: re.Match[str]) -> bool:
    """Whether a number of `FIELD_IN_A_NAME` may be written without its decimal point: ``05A``, ``0_5A`` and ``1_5A``.

    Names of variables and of many files hold no point, and ``05`` may be padded as well.
    """
    digits = number[1]
    if _ZERO_IN_FRONT.fullmatch(digits):
        return True
    whole = _WHOLE_BEHIND.search(number.string[: number.start(1)])
    if whole is None or not digits.isdigit():
        return False
    word, digit = whole.groups("")
    return digit == "0" or word.lower() not in _COUNTS_LOGS


def names_a_folder(pattern: str) -> bool:
    """Whether a pattern is of the folder too; a unit such as kV/mm has a slash of its own."""
    return "/" in FIELD.sub("", pattern)


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


def pattern_among(names: Sequence[str], *, called_so: bool = False) -> str:
    """A pattern for names that differ in one number that may be the field, such as ``PWM25``, ``PWM50``; "" for others.

    Numbers that count logs, and such of a motion or a temperature, are none. Of several, one that is called like a
    field or has its unit is taken.

    Args:
        names: of logs.
        called_so: whether only a number will do that is called like a field or has its unit.
    """
    found = [list(_IN_WORDS.finditer(name)) for name in names]
    words = {
        tuple((each[1], each[2], each[4].rstrip("_")) for each in numbers) for numbers in found
    }
    between = {_IN_WORDS.sub("", name) for name in names}
    if len(words) != 1 or len(between) != 1:
        return ""
    called: list[int] = []
    others: list[int] = []
    decimals: set[int] = set()  # places of numbers behind a whole one
    in_words = words.pop()
    for place, (before, _, after) in enumerate(in_words):
        texts = {numbers[place][3] for numbers in found}
        behind = in_words[place + 1 : place + 2]
        if behind and behind[0][:2] == ("", "_") and max(map(len, texts)) == 1 < len(texts):
            decimals.add(place + 1)
        if {place, place + 1} & decimals:
            continue  # 0_4 and 1_2 may be 0.4 and 1.2
        has_field_unit = after in FIELD_UNITS or before in ("i", "I")
        is_padded = any(map(_ZERO_IN_FRONT.fullmatch, texts))
        if is_padded and (has_field_unit or len({*map(len, texts)}) > 1):
            continue  # 05 A may be 0.5 A
        digits = max(sum(map(str.isdigit, text)) for text in texts)
        if len(texts) == 1 or after in _OF_MOTION_OR_HEAT or digits >= _DIGITS_OF_A_DATE:
            continue
        is_called = bool(spoken_name(before).forms["field"]) or before in ("i", "I")
        in_order = sorted(number_of(text) for text in texts)
        steps = [after - before for before, after in pairwise(in_order)]
        # b may be a brake, and a lone letter but that of a current says nothing.
        says_so = is_called and (len(before) > 1 or before in ("i", "I"))
        if (says_so if called_so else is_called) or after in FIELD_UNITS:
            called.append(place)
        elif before.lower() in _COUNTED:
            # No run is the 1.2th, and of test1000 and test1200 none counts the tests.
            if not all(number.is_integer() for number in in_order) or min(steps) >= _NO_COUNT:
                others.append(place)
        elif any(step != 1.0 for step in steps):
            # Of one thing after another the numbers are 1, 2, 3, or 3, 4.
            others.append(place)
    chosen = called or ([] if called_so else others)
    if len(chosen) != 1:
        return ""
    name = names[0]
    pattern = ""
    end = 0  # of the number before
    for place, number in enumerate(found[0]):
        letters = number[4].rstrip("_")
        unit = FIELD_UNITS.get(letters, letters)
        label = "field" if place == chosen[0] else f"n{place + 1}"
        if place == chosen[0] and unit != letters:
            label = f"field:{unit}"
        pattern += f"{name[end : number.start(3)]}{{{label}}}"
        end = number.end(3)
    return pattern + name[end:]


def constants_of(pattern: str, name: str) -> dict[str, tuple[float, str | None]]:
    """Numbers and units that a file's name gives under a pattern.

    A field is ``{name}``, ``{name:unit}`` or ``{name [unit]}``; without a unit, the letters that follow it are taken as
    its unit if they read as one. A point, a comma, ``x`` or ``p`` is the decimal mark. The suffix may be left out.
    A pattern with a slash, such as ``I{field}/run{n}``, is of the folder too: the name is a path then.

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
    folders = "".join(literals).count("/")
    if folders:
        name = "/".join(PurePath(name).parts[-1 - folders :])
    stems = [name, *(name[:at] for at, letter in enumerate(name) if letter == ".")]
    matches = (re.fullmatch(expression, stem) for stem in stems)
    first_match = next((match for match in matches if match is not None), None)
    if first_match is None:
        example = ' = "0.5 A"' if keys[0] == "field" else ""
        raise MappingError(
            f"the file's name does not match the pattern '{pattern}'",
            remedy=(
                "Rename the file or correct the name pattern ({...} stands for a number, x or p for its decimal "
                f"point), or give the number of this log: --constant, or constants.{keys[0]}{example} in a mapping "
                "file beside it"
            ),
        )

    numbers: dict[str, tuple[float, str | None]] = {}
    for field, number, after in zip(fields, first_match.groups(), literals[1:], strict=True):
        unit = field.group(2)
        letters = _UNIT_AFTER.match(after)
        if not unit and letters:
            # A slash is of the unit (kV/mm), or parts the name of the folder from that of the file.
            whole = letters.group()
            known = (text for text in (whole, whole.partition("/")[0]) if units.is_unit(text))
            unit = next(known, None)
        numbers[field.group(1)] = (number_of(number), unit)
    return numbers


def fits_name(pattern: str, path: str) -> bool:
    """Whether the name of a file has the numbers of a pattern, or its path where the pattern is of its folder too."""
    name = path if names_a_folder(pattern) else PurePath(path).name
    try:
        constants_of(pattern, name)
    except MappingError:
        return False
    return True
