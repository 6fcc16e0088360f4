"""Whole numbers of a converter under the name of a signal are doubted: nobody says what a count is, or where zero is.

They are called so (``adc_force``), or an effort in them stays about the zero of a converter, such as 2048.
"""

from __future__ import annotations

import numpy as np

from erclutch.errors import UnitError, shell_word
from erclutch.logs.columns.labels import COUNTS
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.shapes import are_whole, reads_about_a_zero
from erclutch.logs.columns.vocabulary import ZEROS
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.missing_columns import usual_unit
from erclutch.signals import units
from erclutch.signals.array import Array

_OF_A_CONVERTER = frozenset({"adc", "lsb"})
_SIGNALS = ("slip", "position", "effort")
_FEWEST = 16  # different numbers; a few are levels


def doubt_numbers_of_a_converter(draft: Draft) -> None:
    """Doubt guessed motions and efforts without a unit that are called after a converter and are whole numbers."""
    for signal in _SIGNALS:
        chosen = draft.signals.get(signal)
        if chosen is None or not chosen.column or signal in draft.told.zeros:
            continue
        if chosen.unit and chosen.unit not in COUNTS:
            continue
        column = draft.seen.columns[chosen.column]
        known = column.values[np.isfinite(column.values)]
        if not are_whole(known) or np.unique(known).size < _FEWEST:
            continue
        is_called_so = column.spoken.says(_OF_A_CONVERTER)
        about_a_zero = reads_about_a_zero(known, is_of_a_converter=is_called_so)
        stays_about_a_zero = signal == "effort" and about_a_zero
        if not is_called_so and not stays_about_a_zero:
            continue

        stated = _stated_zero(draft, known) or "NUMBER"
        zero = f"--zero {shell_word(f'{signal}={stated}')}"
        if draft.guessed(signal) is None:
            if stays_about_a_zero:
                level = f"{chosen.column} stays between {known.min():.0f} and {known.max():.0f}"
                draft.notes.append(f"{level}, as about the zero of a converter: {zero} if it is")
            continue
        label = shell_word(draft.table.label(column.name))
        answer = f"{label} {zero}" if stays_about_a_zero else label
        if signal in draft.told.scales:
            if stays_about_a_zero:
                draft.doubt(signal, "in whole numbers of a converter about its zero", answer)
            continue
        turns = signal == "effort" and column.kind == "N*m"
        unit = "N*m" if turns else usual_unit(signal)
        scale = shell_word(f"{signal}=NUMBER {unit}/count")
        doubt = f"in whole numbers of a converter, whose unit nobody says: add --scale {scale} if you know it"
        if stays_about_a_zero:
            doubt += ", and give what it reads without a load as the zero"
        draft.doubt(signal, doubt, answer)


def say_what_has_no_column(draft: Draft) -> None:
    """Say which scales and zeros were given for what is read from no column: they do nothing."""
    given = [("scale", *each) for each in draft.told.scales.items()]
    given += [("zero", *each) for each in draft.told.zeros.items()]
    for kind, signal, text in given:
        chosen = draft.signals.get(signal)
        has_a_column = chosen is not None and bool(chosen.column)
        if signal not in draft.questions and not has_a_column:
            why = f"no column is the {signal}"
            draft.notes.append(f"the {kind} of {signal}, {text}, is not used: {why}")


def _stated_zero(draft: Draft, known: Array) -> str:
    """The only number above the rows that is called a zero and lies among the known ones, as text; "" for none."""
    stated: set[str] = set()
    for key, text in draft.table.metadata.items():
        if ZEROS.isdisjoint(words_of(key)):
            continue
        try:
            number, unit = units.quantity(text.strip())
        except UnitError:
            continue
        is_in_counts = unit is None or unit in COUNTS
        if is_in_counts and known.min() <= number <= known.max():
            stated.add(f"{number:g}")
    return stated.pop() if len(stated) == 1 else ""
