"""Drives tell a torque as a share of the rated torque: in percent, in thousandths (CiA 402), or per unit.

Such numbers are no N m, whatever their column is called: what the rated torque is only the user can say.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from erclutch.errors import shell_word
from erclutch.logs.columns.seen_columns import SeenColumn

#: The torque actual value of CiA 402, in thousandths of the rated torque.
_OF_CIA_402 = re.compile(
    r"(?:0x)?6077(?:h|[ :_./-]|sub|$)|\btorque[ _]?actual[ _]?value", re.IGNORECASE
)
_IS_TORQUE = re.compile(
    r"torque|moment|couple|coppia|trq|力矩|转矩|扭矩|トルク|\bM\b", re.IGNORECASE
)
_THOUSANDTHS = re.compile(r"‰|per[ _-]?mill?e?\b|promille|0\.1 ?%", re.IGNORECASE)
_RATED = r"(?:of[ _])?(?:the[ _])?(?:rated|nominal|nom|rtd|nenn|M_?[nN])\w*"
_PERCENT = re.compile(
    rf"(?:%|percent|pct|prozent)[ _]*(?:{_RATED}|(?:of[ _])?(?:f\.?s\b|full[ _]?scale))|{_RATED}[ _]*(?:%|percent|pct)",
    re.IGNORECASE,
)
_FULL_SCALE = re.compile(r"full[ _-]?scale|messbereich|endwert", re.IGNORECASE)
_PER_UNIT = re.compile(r"(?<![^\W_])(?:p\.?u\.?|per[ _]unit)(?![^\W_])", re.IGNORECASE)
_RATED_WORD = re.compile(r"rated|nominal|\bnom\b|nenn|nomin|额定|額定|定格|정격", re.IGNORECASE)
_RATED_KEY = re.compile(
    r"[MT]_?(?:n|N|nom|rated)|(?:par|couple|coppia) nomin\w{0,6}", re.IGNORECASE
)
_OVER_RATED = re.compile(r"\b[MT]\w*\s*/\s*[MT]_?(?:n|N|nom|rated)\b")


class RatedShare(NamedTuple):
    """How a column tells its torque.

    Attributes:
        words: what a number of it is.
        option: what answers it once the rated torque is put in.
        sensor: what the scale calls the unit of the column.
        size: of a 1 in the column, in rated torques.
    """

    words: str
    option: str
    sensor: str
    size: float


def share_of_rated_torque(column: SeenColumn) -> RatedShare | None:
    """How a column tells a share of a rated torque; None for a column that tells none."""
    written = column.written_unit or ""
    said = f"{column.name} [{written}]" if written else column.name
    is_of_cia = not written and _OF_CIA_402.search(column.name) is not None
    is_over_rated = _OVER_RATED.search(column.name) is not None
    is_torque = _IS_TORQUE.search(column.name.replace("_", " ")) is not None
    is_torque = is_torque or "effort" in column.spoken.may_be
    if not (is_of_cia or is_over_rated or is_torque):
        return None
    if is_of_cia or _THOUSANDTHS.search(said):
        return _share(column, "a thousandth of the rated torque", "count", 1e-3)
    if _PERCENT.search(said) or (is_over_rated and written == "%"):
        return _share(column, "a percent of the rated torque", "%", 1e-2)
    if _PER_UNIT.search(said) or (is_over_rated and not written):
        return _share(column, "the rated torque", "count", 1.0)
    return None


def is_rated_torque(key: str) -> bool:
    """Whether a key above the rows is that of a rated torque: ``Rated torque``, ``Nennmoment``, ``T_n``."""
    words = key.replace("_", " ")
    if _FULL_SCALE.search(words):
        return True  # the unit behind it tells of what
    return _RATED_KEY.fullmatch(key.strip()) is not None or (
        _RATED_WORD.search(words) is not None and _IS_TORQUE.search(words) is not None
    )


def is_rating(column: SeenColumn) -> bool:
    """Whether a column repeats the rated torque of a drive in each row: no measurement."""
    return column.shape.constant and is_rated_torque(column.name)


def _share(column: SeenColumn, words: str, sensor: str, size: float) -> RatedShare:
    # A unit that is no unit to us is replaced by the name that the scale has for it.
    label = (
        f"{column.name} [{sensor}]"
        if column.written_unit not in (None, "", sensor)
        else column.name
    )
    scale = shell_word(f"effort=NUMBER N*m/{sensor}")
    return RatedShare(words, f"--effort {shell_word(label)} --scale {scale}", sensor, size)
