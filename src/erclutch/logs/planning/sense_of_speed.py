"""A guessed slip that has no sign may be half of a motion: its sense stands in another column, or in none."""

from __future__ import annotations

import numpy as np

from erclutch.errors import shell_word
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.senses import DIRECTIONS
from erclutch.logs.columns.shapes import FEW, LOOKED_AT, known_rows, takes_both_signs
from erclutch.logs.columns.vocabulary import SENSES
from erclutch.logs.planning.draft import Draft

_FAST = 0.3  # of the largest speed, above which a device moves
_RESTS = 0.02  # of the largest speed, below which it comes near rest
_LARGE = 0.2  # of the largest effort
_OFTEN = 0.2  # of the rows that move


def doubt_a_speed_without_its_sense(draft: Draft) -> None:
    """Doubt a guessed slip that never turns, where a column of words says in which sense the device moves."""
    slip = draft.guessed("slip")
    effort = draft.signals.get("effort")
    if slip is None or effort is None:
        return
    speed = draft.table.columns.get(slip.column)
    measured = draft.table.columns.get(effort.column)
    if speed is None or measured is None:
        return
    if takes_both_signs(speed) or not takes_both_signs(measured):
        return
    for name, values in draft.table.columns.items():
        if DIRECTIONS.isdisjoint(words_of(name)):
            continue
        if np.unique(values[:LOOKED_AT]).size not in (2, 3):
            continue
        draft.doubt(
            "slip",
            f"which has no sign, while {name} tells the direction: give a column whose sign turns",
        )
        return
    for name, column in draft.table.words.items():
        senses = [word for word in column.words if not SENSES.isdisjoint(words_of(word))]
        if len(senses) < 2:
            continue
        first, second, *_ = senses
        of_one_sense = shell_word(f"{name}={first}")
        says = f"which has no sign, while {name} says {first} and {second}"
        remedy = f"give a column whose sign turns, or --variable {of_one_sense} for the rows of one sense"
        draft.doubt("slip", f"{says}: {remedy}")
        return
    # The user chose rows of one sense by a word.
    if any(note.startswith("rows where ") for note in draft.table.notes):
        return
    # In a motion to and fro the effort is large both ways, and the speed comes near rest.
    v, f = known_rows(speed, measured)
    v = np.abs(v)
    if f.size < FEW or not np.any(v):
        return
    fast = v > _FAST * v.max()
    large = _LARGE * np.abs(f).max()
    forth = np.count_nonzero(fast & (f > large))
    back = np.count_nonzero(fast & (f < -large))
    is_often = min(forth, back) >= _OFTEN * np.count_nonzero(fast)
    comes_to_rest = v.min() <= _RESTS * v.max()
    if comes_to_rest and is_often:
        doubt = f"which has no sign and comes to rest, while {effort.column} takes both signs"
        draft.doubt("slip", f"{doubt}: give a column whose sign turns, or the position")
