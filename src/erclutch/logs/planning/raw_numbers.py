"""Whole numbers of a converter under the name of a signal are doubted: nobody says what a count is.

They are called so (``adc_force``), or an effort in them stays about the zero of a converter, such as 2048.
"""

from __future__ import annotations

import numpy as np

from erclutch.errors import shell_word
from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.missing_columns import usual_unit
from erclutch.signals.array import Array

_OF_A_CONVERTER = frozenset({"adc", "lsb"})
_SIGNALS = ("slip", "position", "effort")
_FEWEST = 16  # different numbers; a few are levels
#: A converter of ten bits or more has its zero at half of its range, 512 or more.
_LEAST_ZERO = 400
_SWING = 0.5  # of the zero


def doubt_numbers_of_a_converter(draft: Draft) -> None:
    """Doubt guessed motions and efforts without a unit that are called after a converter and are whole numbers."""
    for signal in _SIGNALS:
        guessed = draft.guessed(signal)
        if guessed is None or guessed.unit or signal in draft.told.scales:
            continue
        column = draft.seen.columns[guessed.column]
        known = column.values[np.isfinite(column.values)]
        if not are_whole(known) or np.unique(known).size < _FEWEST:
            continue
        is_called_so = column.spoken.says(_OF_A_CONVERTER)
        if not is_called_so and not (signal == "effort" and _stay_about_a_zero(known)):
            continue
        turns = signal == "effort" and column.kind == "N*m"
        unit = "N*m" if turns else usual_unit(signal)
        scale = shell_word(f"{signal}=NUMBER {unit}/count")
        doubt = f"in whole numbers of a converter, whose zero and unit nobody says: add --scale {scale} if you know it"
        draft.doubt(signal, doubt, shell_word(draft.table.label(column.name)))


def _stay_about_a_zero(known: Array) -> bool:
    """Whether large numbers swing little about one of them: 2048 is no torque, but no load to a converter."""
    low = float(np.min(np.abs(known)))
    swing = float(np.ptp(known))
    return low >= _LEAST_ZERO and swing < _SWING * low
