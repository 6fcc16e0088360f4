"""Whole numbers of a converter under the name of a signal (``adc_force``) are doubted: nobody says what a count is."""

from __future__ import annotations

import numpy as np

from erclutch.errors import shell_word
from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.missing_columns import usual_unit

_OF_A_CONVERTER = frozenset({"adc", "lsb"})
_SIGNALS = ("slip", "position", "effort")
_FEWEST = 16  # different numbers; a few are levels


def doubt_numbers_of_a_converter(draft: Draft) -> None:
    """Doubt guessed motions and efforts without a unit that are called after a converter and are whole numbers."""
    for signal in _SIGNALS:
        guessed = draft.guessed(signal)
        if guessed is None or guessed.unit or signal in draft.told.scales:
            continue
        column = draft.seen.columns[guessed.column]
        known = column.values[np.isfinite(column.values)]
        is_of_a_converter = column.spoken.says(_OF_A_CONVERTER) and are_whole(known)
        if not is_of_a_converter or np.unique(known).size < _FEWEST:
            continue
        scale = shell_word(f"{signal}=NUMBER {usual_unit(signal)}/count")
        doubt = f"in whole numbers of a converter, whose zero and unit nobody says: add --scale {scale} if you know it"
        draft.doubt(signal, doubt, shell_word(draft.table.label(column.name)))
