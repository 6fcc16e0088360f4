"""Lines above the rows may say which field each test had, and a column says which test each row is of.

``Test 1: 0 A`` and ``Test 2: 0.5 A`` stand above a column ``Test`` of 1 and 2; ``soft: 0.2 A`` above a column of words.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from erclutch.errors import listed
from erclutch.logs.columns.levels_in_names import StatedLevel, stated_in
from erclutch.logs.columns.vocabulary import set_of
from erclutch.logs.columns.word_columns import with_words_used_up
from erclutch.logs.rows.fields_in_words import has_a_field
from erclutch.logs.table import Table
from erclutch.signals.array import Array

#: What a line begins with: ``Test 1``, ``run #2``, ``No. 3``.
_NUMBERED = re.compile(r"([^\d#]*)#?(\d{1,3})")
_MOST_LINES = 400
_CALLED = "field"  # no column is called so, or there would be one that may be the field
#: What is numbered beside a current or a voltage and is no test: ``Channel 1: 10 V`` is a range.
_NO_TESTS = set_of("channel ch ai ao input output sensor range limit port adc dac")


def with_levels_of_a_legend(table: Table) -> Table:
    """The table with a column of the field by its legend, where no other column may be the field; else as it is."""
    # Field of each test or word that a line above the rows gives one.
    legend: dict[str, StatedLevel] = {}
    for key, text in [*table.metadata.items()][:_MOST_LINES]:
        stated = stated_in(text)
        if stated is not None:
            legend[" ".join(key.casefold().split())] = stated._replace(name=key)
    if len(legend) < 2 or has_a_field(table):
        return table
    for name, words in table.words.items():
        levels = [legend.get(word.casefold().strip()) for word in words.words]
        if (words.of_row >= 0).all() and (of_words := _of_one_unit(levels)) is not None:
            table = with_words_used_up(table, name)
            return _with_field(table, name, of_words[words.of_row], levels)
    for name, values in table.columns.items():
        numbers, of_row = np.unique(values, return_inverse=True)
        if numbers.size > len(legend):
            continue
        levels = [_of_test(legend, name, number) for number in numbers.tolist()]
        if (of_numbers := _of_one_unit(levels)) is not None:
            return _with_field(table, name, of_numbers[of_row], levels)
    return table


def _of_test(legend: Mapping[str, StatedLevel], column: str, number: float) -> StatedLevel | None:
    """The level of the test of this number, where the lines and the column call tests alike."""
    for key, level in legend.items():
        numbered = _NUMBERED.fullmatch(key)
        if numbered is None or float(numbered[2]) != number:
            continue
        word = numbered[1].strip(" .:_-")
        if word and word not in _NO_TESTS and word in column.casefold():
            return level
    return None


def _of_one_unit(levels: list[StatedLevel | None]) -> Array | None:
    """The numbers of levels, two of which differ, in one unit; None for others."""
    known = [level for level in levels if level is not None]
    numbers = [level.number for level in known]
    if len(known) < len(levels) or len({level.unit for level in known}) != 1:
        return None
    return np.array(numbers) if len({*numbers}) > 1 else None


def _with_field(table: Table, column: str, field: Array, levels: list[StatedLevel | None]) -> Table:
    known = [level for level in levels if level is not None]
    said = listed([f"{level.name} ({level.number:g} {level.unit})" for level in known])
    note = f"lines above the rows tell the field of each {column}: {said}"
    return replace(
        table,
        columns={**table.columns, _CALLED: field},
        units={**table.units, _CALLED: known[0].unit},
        notes=(*table.notes, note),
    )
