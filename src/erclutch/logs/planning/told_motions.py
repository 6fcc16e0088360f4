"""Whether a drive was told a motion: columns such as a target position stand in the table."""

from __future__ import annotations

from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.seen_columns import SeenColumns
from erclutch.logs.columns.vocabulary import TOLD


def has_a_told_motion(seen: SeenColumns) -> bool:
    """Whether a drive was told a motion, such as a target position, and no column holds a told field."""
    told: set[str] = set()  # signals that a word of a told column's name speaks for
    for column in seen.columns.values():
        words = column.spoken.stem_words
        if TOLD.isdisjoint(words):
            continue
        for word in words:
            if len(word) > 1:
                told |= {signal for signal, form in spoken_name(word).forms.items() if form}
    return not told.isdisjoint(("slip", "position")) and "field" not in told


def has_a_controller(seen: SeenColumns) -> bool:
    """Whether a motion or an effort was told, such as ``cmd_tau``."""
    for column in seen.columns.values():
        words = column.spoken.stem_words
        others = [word for word in words if word not in TOLD and len(word) > 1]
        if len(others) == len(words):
            continue
        for word in others:
            forms = spoken_name(word).forms
            if forms["slip"] or forms["position"] or forms["effort"]:
                return True
    return False
