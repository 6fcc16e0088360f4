"""Columns of the phases of an alternating current: what a power analyser shows of a motor, none of which is a field."""

from __future__ import annotations

import numpy as np

from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import known_rows, takes_both_signs
from erclutch.logs.columns.vocabulary import CURRENTS, VOLTAGES

_THREE = frozenset({"1", "2", "3"})
#: What an analyser makes of a voltage and a current in a phase: powers, their factor, an angle, frequencies.
_POWERS = frozenset(
    {"p", "s", "q", "lambda", "phi", "pf", "fu", "fi", "cosphi", "thd", "uthd", "ithd"}
)
#: Of these a direct current has none.
_OF_ALTERNATING = frozenset({"q", "lambda", "phi", "pf", "fu", "cosphi"})
_LETTERS = ("abc", "uvw", "rst", "123")
_NOTHING = 0.1  # of what three phases add up to without their signs: noise and offsets of sensors
_SUMS = frozenset({"sigma", "sum", "total", "σ"})


def is_of_phases(seen: SeenColumns, column: SeenColumn) -> bool:
    """Whether a column is one of a voltage, a current or a power in three phases, or a sum over these.

    Of three voltages and three currents alone each may be that of a coil: a power factor, say, must stand beside them,
    or AC in their names.
    """
    if column.name in _adding_up_to_nothing(seen, column):
        return True
    stem = column.spoken.bare_stem
    words = {*column.spoken.stem_words}
    if "ac" in words:
        alternating = [each for each in seen.columns.values() if _is_alternating(each)]
        return _is_alternating(column) and len(alternating) >= len(_THREE)
    is_a_sum = not words.isdisjoint(_SUMS)
    if is_a_sum:
        stem = "".join(word for word in column.spoken.stem_words if word not in _SUMS)
    elif column.spoken.plain_stem.removeprefix(stem) not in _THREE:
        return False
    if stem not in CURRENTS | VOLTAGES | _POWERS:
        return False

    families: dict[str, set[str]] = {}  # stem -> numbers behind it
    for each in seen.columns.values():
        bare = each.spoken.bare_stem
        families.setdefault(bare, set()).add(each.spoken.plain_stem.removeprefix(bare))
    whole = {bare for bare, numbers in families.items() if numbers >= _THREE}
    return bool(whole & CURRENTS) and bool(whole & VOLTAGES) and bool(whole & _OF_ALTERNATING)


def _adding_up_to_nothing(seen: SeenColumns, column: SeenColumn) -> list[str]:
    """Three currents or voltages of one name but for a letter or a number (a, b, c), as the phases of a motor have.

    Their sum is about zero in each row. A column of no such three gives none.
    """
    stem = column.spoken.plain_stem
    letters = next((letters for letters in _LETTERS if stem[-1:] in letters), "")
    front = stem.rstrip("0123456789")[: len(stem) - 1]
    if not letters or not {front, front.removesuffix("phase")} & (CURRENTS | VOLTAGES):
        return []
    stems = {front + letter for letter in letters}
    three = [each for each in seen.columns.values() if each.spoken.plain_stem in stems]
    alternate = all(takes_both_signs(each.values) for each in three)
    if len(three) != len(letters) or not alternate:
        return []
    known = known_rows(*(each.values for each in three))
    total = np.zeros(known[0].size)
    size = np.zeros(known[0].size)
    for values in known:
        total += values
        size += np.abs(values)
    adds_up = bool(np.abs(total).sum() < _NOTHING * size.sum())
    return [each.name for each in three] if adds_up else []


def _is_alternating(column: SeenColumn) -> bool:
    """Whether a name says AC, and that it is a voltage or a current."""
    words = {*column.spoken.stem_words}
    return "ac" in words and not words.isdisjoint(CURRENTS | VOLTAGES)
