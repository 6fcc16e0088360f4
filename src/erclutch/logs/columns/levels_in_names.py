"""A name may hold a level that was set: ``F_0.5A`` is an effort at a field, ``Torque @ 100 rpm`` one at a speed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.levels_in_words import place_of, word_of_level
from erclutch.logs.columns.name_pattern import (
    FIELD_IN_A_NAME,
    FIELD_UNITS,
    NUMBER,
    may_lack_its_point,
    number_of,
)
from erclutch.logs.columns.names import spoken_name
from erclutch.signals import units

#: How a speed is written behind its number in a name, and the unit that it means.
_SPEED_UNITS = {
    **{word: "rpm" for word in ("rpm", "RPM", "r/min", "1/min", "U/min", "min-1", "tr/min")},
    **{unit: unit for unit in ("rad/s", "deg/s", "mm/s", "cm/s", "m/s", "in/s")},
    **{unit.replace("/", "_"): unit for unit in ("rad/s", "mm/s", "cm/s", "m/s", "in/s")},
}
_SPEED_IN_A_NAME = re.compile(
    rf"(?<![A-Za-z0-9.,])({NUMBER}) ?({'|'.join(sorted(_SPEED_UNITS, key=len, reverse=True))})(?![A-Za-z0-9/])"
)

#: A setting whose number has no unit behind it: ``current = 0.5``, ``I [A]: 0.5``, ``I<tab>0.5``.
_SETTING_WITHOUT_UNIT = re.compile(rf"([^\W\d_][^:=\t\d]{{0,40}}?)\s*[:=\t]\s*({NUMBER})")
_TOLD_TO_A_SUPPLY = re.compile(
    r"^(?:set|setting)[ _]|[ _](?:set|cmd|soll|setpoint)$", re.IGNORECASE
)
_A_FIELD_ALONE = frozenset({"field"})
_WHOLE_IN_FRONT = re.compile(r"\d_$")  # of 0_5A
_COUNT = re.compile(r"\d+")
#: What a position of a knob or a valve is counted in, by what the column of the positions is called.
_COUNTED_IN = {
    "clicks": "clicks? clics? klicks? klicke detents? notch(?:es)? rasten? clicchi scatti クリック 클릭",
    "turns": "turns? umdrehungen tours giri vueltas",
    "setting": "settings? stufen? einstellung reglages? ajustes? 段 档 档位",
}
_POSITIONS = "|".join("|".join(words.split()) for words in _COUNTED_IN.values())
#: In front of a level over the names of its columns: ``Current 0: force``. ``Current 1`` alone is a channel.
_HEADINGS = "current|voltage|strom|spannung|courant|tension|corrente|tensione|corriente|电流|電流"
_FROM_AN_END = r"(?: (?:out|in|open|(?:from )?(?:full(?:y)? )?(?:closed|open|soft|hard|in|out)))?"
#: A setting that is no number with a unit of a field: ``4 clicks``, ``Click 3``, ``PWM 50 %``, ``(50 %)``, ``I0``.
_SETTING = re.compile(
    rf"(?<![A-Za-z0-9.,])(?:(?P<counted>{NUMBER}) ?(?P<position>{_POSITIONS}){_FROM_AN_END}"
    rf"|(?P<position_before>{_POSITIONS})[ _#=-]*(?P<counted_behind>{NUMBER})"
    rf"|(?P<share>pwm|duty|dc)[ _=-]*(?P<percent_behind>{NUMBER}) ?%?"
    rf"|(?P<percent>{NUMBER}) ?(?:%|pct|percent)(?:[ _-]?(?P<share_behind>pwm|duty))?"
    rf"|(?:{_HEADINGS})[ =]*(?P<headed>{NUMBER})(?=: )"
    rf"|[IU][ _=-]?(?P<plain>{NUMBER}))(?![A-Za-z0-9%])",
    re.IGNORECASE,
)
#: What a quantity is called whose columns are called by their levels alone.
CALLED_BY_LEVEL = "value"
_LEVEL = "level"
_SETTING_IN_WORDS = "setting"


class StatedLevel(NamedTuple):
    """A number that may be the field or the speed of what bears the name.

    Attributes:
        name: what it is called.
        number: as written; of a word its place among its like.
        unit: as written; None where nobody says it.
        word: in place of a number; "" where a number stands there.
    """

    name: str
    number: float
    unit: str | None
    word: str = ""

    def __str__(self) -> str:
        number = f"{self.number:g} {self.unit}" if self.unit else f"{self.number:g}"
        return f"{self.name} = {number}"


def stated_in(name: str) -> StatedLevel | None:
    """The field that a name such as ``F_0.5A`` or ``1 A`` holds; None for no or several numbers with such a unit.

    None as well where the number may lack its point, as that of ``F_05A``: see `open_field_in`.
    """
    numbers = [*FIELD_IN_A_NAME.finditer(name)]
    if len(numbers) != 1 or may_lack_its_point(numbers[0]):
        return None
    return StatedLevel(name, number_of(numbers[0][1]), FIELD_UNITS[numbers[0][3]])


def open_field_in(name: str) -> str:
    """The only number with a unit of a field in a name, where it may lack its point: ``05A``, ``0_5A``; else ""."""
    numbers = [*FIELD_IN_A_NAME.finditer(name)]
    if len(numbers) != 1 or not may_lack_its_point(numbers[0]):
        return ""
    whole = _WHOLE_IN_FRONT.search(name[: numbers[0].start(1)])
    return f"{whole[0] if whole else ''}{numbers[0][1]}{numbers[0][3]}"


def field_set_in(name: str) -> StatedLevel | None:
    """The field that a setting such as ``current = 0.5`` gives, in the unit of its key if it has one; else None."""
    setting = _SETTING_WITHOUT_UNIT.fullmatch(name.strip())
    if setting is None:
        return None
    key, number = setting.groups()
    called, unit = split_label(key)
    if spoken_name(_TOLD_TO_A_SUPPLY.sub("", called)).may_be != _A_FIELD_ALONE:
        return None
    return StatedLevel(key.strip(), number_of(number), unit)


def without_field(name: str) -> str:
    """A name without the number that may be the field: of logs that differ in the field alone all are the same."""
    return FIELD_IN_A_NAME.sub("", name)


def speed_in(name: str) -> StatedLevel | None:
    """The speed that a name such as ``Torque @ 100 rpm`` holds; None for no or several numbers with such a unit."""
    numbers = _SPEED_IN_A_NAME.findall(name)
    if len(numbers) != 1:
        return None
    number, letters = numbers[0]
    return StatedLevel(name, number_of(number), _SPEED_UNITS[letters])


def without_speed(name: str) -> str:
    """A name without the number that may be the speed."""
    return _SPEED_IN_A_NAME.sub("", name)


def setting_in(name: str) -> StatedLevel | None:
    """The setting in a name that is no field by its unit, such as ``Force @ 4 clicks``; None for no or several.

    It is called by its word, ``clicks``, ``pwm`` or ``level``; a share has the unit %. A word such as ``Soft`` is a
    setting too, and its place among its like the number.
    """
    settings = [*_SETTING.finditer(name)]
    word = word_of_level(name)
    if not settings and word:
        _, place = place_of(word) or (0, 0)
        return StatedLevel(_SETTING_IN_WORDS, float(place), None, word.lower())
    if len(settings) != 1:
        return None
    said = settings[0].groupdict()
    position = said["position"] or said["position_before"]
    if position:
        number = number_of(said["counted"] or said["counted_behind"])
        counted_in = (
            called
            for called, words in _COUNTED_IN.items()
            if re.fullmatch("|".join(words.split()), position, re.IGNORECASE)
        )
        return StatedLevel(next(counted_in), number, None)
    share = said["share"] or said["share_behind"]
    if said["percent"] or share:
        number = number_of(said["percent"] or said["percent_behind"])
        unit = "%" if said["percent"] or "%" in settings[0][0] else None  # pwm 127 may be of 255
        return StatedLevel(share.lower() if share else _LEVEL, number, unit)
    return StatedLevel(_LEVEL, number_of(said["headed"] or said["plain"]), None)


def with_lost_points(names: Iterable[str]) -> dict[str, float]:
    """The settings of names whose numbers lack their points, by the names; none where they may be whole numbers.

    Of I0, I05, I1 and I15 the second is at 0.5: a count that is filled up with zeros is filled up in each name.
    """
    written: dict[str, str] = {}
    for name in names:
        settings = [*_SETTING.finditer(name)]
        digits = settings[0]["plain"] if len(settings) == 1 else None
        if digits and _COUNT.fullmatch(digits):
            written[name] = digits
    begins_with_zero = any(len(digits) > 1 and digits[0] == "0" for digits in written.values())
    is_filled_up = len({*map(len, written.values())}) == 1
    if not begins_with_zero or is_filled_up:
        return {}
    return {name: float(f"{digits[0]}.{digits[1:] or 0}") for name, digits in written.items()}


def without_setting(name: str) -> str:
    """A name without its setting."""
    without = _SETTING.sub("", name)
    return without if without != name else name.replace(word_of_level(name), "")


def differ_by_field(names: Sequence[str]) -> bool:
    """Whether names are the same but for the field that each of them holds."""
    fields = {each.number for each in map(stated_in, names) if each is not None}
    return 1 < len(fields) == len(names) and len({*map(without_field, names)}) == 1


def are_at_fields(names: Sequence[str]) -> bool:
    """Whether names are the same but for a field each, of which some may lack their point: ``F_0A`` and ``F_05A``."""
    fields = {name: stated_in(name) is not None or bool(open_field_in(name)) for name in names}
    bare = {without_field(name).rstrip("_0123456789") for name in names}
    return 1 < len(fields) == len(names) and all(fields.values()) and len(bare) == 1


def fields_told_by(names: Sequence[str]) -> dict[str, StatedLevel]:
    """The fields that names tell their logs apart by, and names without a field left out; none where they do not.

    ``0A`` and ``0.5A`` are such names, ``Test 1: current 0 A`` and ``Test 2: current 0.5 A``, ``I = 0`` and
    ``I = 0.5``, ``0A slow`` and ``0.5A fast``, ``0A 12V`` and ``0.5A 12V``.
    """
    stated = {name: stated_in(name) or field_set_in(name) for name in names}
    fields = {name: field for name, field in stated.items() if field is not None}
    fields = fields or _fields_that_differ(names)
    # Of one kind: 500 mA and 1 A, or settings of one key; 5 V beside 1 A is something else.
    kinds = {
        units.parse(each.unit).dimension if each.unit else each.name for each in fields.values()
    }
    if len(kinds) != 1:
        return {}
    numbers = {each.number for each in fields.values()}
    each_has_its_own = len(fields) == len(names) and len(numbers) > 1
    named = [*fields]
    is_told = each_has_its_own or differ_by_field(named) or _tell_fields_of_a_series(named)
    return fields if is_told else {}


def _fields_that_differ(names: Sequence[str]) -> dict[str, StatedLevel]:
    """Of names with several numbers that may be fields, in the same units, the one place whose numbers differ."""
    numbers_of_names = [FIELD_IN_A_NAME.findall(name) for name in names]
    units_of_names = {tuple(letters for _, _, letters in numbers) for numbers in numbers_of_names}
    if len(units_of_names) != 1 or len(numbers_of_names[0]) < 2:
        return {}
    places = [
        place
        for place, numbers in enumerate(zip(*numbers_of_names, strict=True))
        if len({*numbers}) > 1
    ]
    if len(places) != 1:
        return {}
    fields: dict[str, StatedLevel] = {}
    for name, numbers in zip(names, numbers_of_names, strict=True):
        number, _, letters = numbers[places[0]]
        fields[name] = StatedLevel(name, number_of(number), FIELD_UNITS[letters])
    return fields


def _tell_fields_of_a_series(names: Sequence[str]) -> bool:
    """Whether names are the same but for the field that each holds and a number that counts them from 0 or 1 on.

    ``Test 1: current 0 A`` and ``Test 2: current 0.5 A`` are such names; two tests may have the same field.
    """
    if not names or any(stated_in(name) is None for name in names):
        return False
    bare = [without_field(name) for name in names]
    counts = [_COUNT.findall(name) for name in bare]
    are_counted = all(len(numbers) == 1 for numbers in counts)
    if not are_counted or len({_COUNT.sub("#", name) for name in bare}) > 1:
        return False
    places = [int(numbers[0]) for numbers in counts]
    return len(names) > 1 and places in ([*range(len(names))], [*range(1, len(names) + 1)])
