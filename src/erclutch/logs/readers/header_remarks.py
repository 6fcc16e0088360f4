"""A line above the rows may state a number among words, without a mark: ``gear ratio 1:10``, ``1024 ppr encoder``.

What an arm, an encoder or a gear is called tells such a line from other remarks.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from erclutch.signals import units

_LONGEST = 200  # letters of a remark
_NUMBER = r"\d+(?:[.,]\d+)?"
_KEY = r"\W*([^\d\W][^\d:=;\t]{0,40}?)"
_GEARS = (
    r"gear|getriebe|reduction|reducer|reduktor|[uü]bersetzung|r[ée]ducteur|rapport|减速|ギア|감속"
)
_RATIO = re.compile(rf"{_KEY}\s+({_NUMBER})\s*[:/]\s*({_NUMBER})\s*", re.IGNORECASE)
_RATIO_ALONE = re.compile(rf"{_KEY}(?<=ratio|ction|tzung|pport)\s+({_NUMBER})\s*", re.IGNORECASE)
_OF_A_TURN = (
    r"(?:ppr|cpr|(?:counts?|pulses?|ticks?|lines?|steps?|impulse|inkremente)\s*(?:/|per|pro)\s*"
    r"(?:rev(?:olution)?|turn|umdrehung|u)|striche?)"
)
_COUNTS = re.compile(
    rf"(?:{_KEY}\s+)?\W*(\d+)\s*({_OF_A_TURN})(?![^\W\d_])([^:=;\t]*)", re.IGNORECASE
)
_ARMS = (
    r"(?:(?:lever|moment|torque) ?arm|lever|arm|hebelarm|hebel|bras de levier|brazo(?: de palanca)?|braccio"
    r"|力臂|杠杆臂|アーム)"
)
_LENGTH = rf"({_NUMBER})\s?(mm|cm|m|in|inch)"
_IN_FRONT_OF_ARM = re.compile(
    rf"(?:[^:=;\t]*\D|\W*)(?<![\w.,]){_LENGTH}\s+({_ARMS})(?![^\W\d_])[^\d:=;\t]*", re.IGNORECASE
)
# Three digits behind a comma may be thousands, but for those behind a 0.
_DECIMAL_COMMA = re.compile(rf"{_KEY}\s+(\d+,\d{{1,2}}|0,\d+)\s?([^\W\d_][\w/*^·]*)\s*")
_UNIT_OF_KEY = re.compile(rf"{_KEY}\s*[\[(]([^\[\]()]+)[\])]\s+({_NUMBER})\s*")


class Remark(NamedTuple):
    """What a line states: the key and the value of a pair."""

    key: str
    value: str


def stated_across_a_mark(line: str) -> Remark | None:
    """The ratio of a gear, or a number with a decimal comma: the mark in there parts no key from its value."""
    if len(line) > _LONGEST:
        return None
    ratio = _RATIO.fullmatch(line)
    if ratio and re.search(_GEARS, ratio[1], re.IGNORECASE):
        return Remark(ratio[1], f"{_point(ratio[2])}:{_point(ratio[3])}")
    alone = _RATIO_ALONE.fullmatch(line)
    if alone and re.search(_GEARS, alone[1], re.IGNORECASE):
        return Remark(alone[1], _point(alone[2]))
    decimal = _DECIMAL_COMMA.fullmatch(line)
    if decimal and units.is_unit(decimal[3]):
        return Remark(decimal[1], f"{_point(decimal[2])} {decimal[3]}")
    return None


def stated_among_words(line: str) -> Remark | None:
    """The counts of an encoder's turn, the length of an arm behind its number, or a number with the key's own unit."""
    if len(line) > _LONGEST:
        return None
    counts = _COUNTS.fullmatch(line)
    if counts:
        key, number, unit, behind = counts.groups()
        return Remark(key or "encoder", f"{number} {unit}{behind}".strip())
    arm = _IN_FRONT_OF_ARM.fullmatch(line)
    if arm:
        return Remark(arm[3], f"{_point(arm[1])} {arm[2]}")
    of_key = _UNIT_OF_KEY.fullmatch(line)
    if of_key and units.is_unit(of_key[2]):
        return Remark(of_key[1], f"{_point(of_key[3])} {of_key[2]}")
    return None


def _point(number: str) -> str:
    return number.replace(",", ".")
