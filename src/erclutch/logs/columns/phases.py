"""Columns of the phases of an alternating current: what a power analyser shows of a motor, none of which is a field."""

from __future__ import annotations

from erclutch.logs.columns.names import CURRENTS, VOLTAGES
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns

_THREE = frozenset({"1", "2", "3"})
#: What an analyser makes of a voltage and a current in a phase: powers, their factor, an angle, frequencies.
_POWERS = frozenset({"p", "s", "q", "lambda", "phi", "pf", "fu", "fi", "cosphi", "thd", "uthd", "ithd"})
#: Of these a direct current has none.
_OF_ALTERNATING = frozenset({"q", "lambda", "phi", "pf", "fu", "cosphi"})
_SUMS = frozenset({"sigma", "sum", "total", "σ"})


def is_of_phases(seen: SeenColumns, column: SeenColumn) -> bool:
    """Whether a column is one of a voltage, a current or a power in three phases, or a sum over these.

    Of three voltages and three currents alone each may be that of a coil: a power factor, say, must stand beside them,
    or AC in their names.
    """
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


def _is_alternating(column: SeenColumn) -> bool:
    """Whether a name says AC, and that it is a voltage or a current."""
    words = {*column.spoken.stem_words}
    return "ac" in words and not words.isdisjoint(CURRENTS | VOLTAGES)
