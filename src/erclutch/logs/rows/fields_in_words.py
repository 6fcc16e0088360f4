"""A column of texts may tell the field of its rows: names of files or tests such as ``damper_0.5A_2Hz.csv``.

Several logs were put one under another then, and this column says which log each row is of.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.errors import listed
from erclutch.logs.columns.levels_in_names import fields_told_by
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.word_columns import with_words_used_up
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

_CALLED = "field of "  # before the name of the column of texts


def with_fields_of_words(table: Table) -> Table:
    """The table with a column of the field that texts tell, where no other column may be the field; else as it is."""
    if has_a_field(table):
        return table
    for name, words in table.words.items():
        fields = fields_told_by(words.words)
        has_a_field_in_each = (words.of_row >= 0).all() and len(fields) == len(words.words)
        units_of_fields = {field.unit for field in fields.values()}
        if not has_a_field_in_each or len(units_of_fields) != 1:
            continue
        of_word = np.array([fields[word].number for word in words.words])
        if np.unique(of_word).size < 2:
            continue
        called = f"{_CALLED}{name}"
        said = [f"{word} ({field.number:g} {field.unit or '?'})" for word, field in fields.items()]
        # Rows that differ in the field alone are of one device: the texts part them no more.
        table = with_words_used_up(table, name)
        return replace(
            table,
            columns={**table.columns, called: of_word[words.of_row]},
            units={**table.units, called: units_of_fields.pop()},
            notes=(*table.notes, f"column {name} tells the field: {listed(said)}"),
        )
    return table


def has_a_field(table: Table) -> bool:
    """Whether a column may be the field, by its name or its unit."""
    for name in table.columns:
        unit = table.units.get(name) or ""
        is_in_a_unit = unit != "" and units.is_unit(unit)
        has_the_unit = is_in_a_unit and units.fits(unit, SIGNALS["field"].si_units) is not None
        if has_the_unit or "field" in spoken_name(name).may_be:
            return True
    return False
