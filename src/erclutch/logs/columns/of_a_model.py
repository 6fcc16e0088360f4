"""What a model says of an effort may stand beside what was measured: the parts that it adds up, and its estimates."""

from __future__ import annotations

from collections.abc import Iterable

from erclutch.logs.columns.names import NOT_MEASURED, PARTS_OF_A_MODEL, TOLD
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns


def parts_of_a_model(efforts: Iterable[SeenColumn]) -> list[str]:
    """Columns that a model adds up to an effort, where two and more kinds of parts stand beside another effort.

    Args:
        efforts: columns that may be the effort by their units.
    """
    kinds: set[str] = set()
    parts: list[str] = []
    others = 0
    for column in efforts:
        if "effort" not in column.spoken.may_be:
            continue
        words = PARTS_OF_A_MODEL.intersection(column.spoken.stem_words)
        if words:
            parts.append(column.name)
            kinds |= words
        elif TOLD.isdisjoint(column.spoken.stem_words):
            others += 1
    return parts if len(kinds) > 1 and others else []


def with_estimates(seen: SeenColumns, names: list[str]) -> list[str]:
    """A column that was calculated or calibrated and the estimates beside it: ``tau_cal`` and ``tau_est``."""
    if len(names) != 1:
        return names
    words = {*seen.columns[names[0]].spoken.stem_words}
    if "cal" not in words:
        return names
    words_besides = words - {"cal"}
    estimates: list[str] = []
    for column in seen.without(names):
        own_words = {*column.spoken.stem_words}
        own_besides = own_words - NOT_MEASURED
        if own_besides == words_besides and own_besides != own_words:
            estimates.append(column.name)
    return [*names, *estimates]
