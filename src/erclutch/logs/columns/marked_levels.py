"""A table for training may mark the level of each row by a 1 in one of several columns: ``I_0A``, ``I_05A``, ``I_1A``.

The columns become one column: of the numbers, where the names tell a field by one word and a number, else of the names
as words, which part the rows.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from erclutch.errors import listed
from erclutch.logs.columns.levels_in_names import open_field_in, stated_in
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.table import Table, WordColumn
from erclutch.signals.array import Array

#: What the words of the marked columns are called together.
CALLED = "level"
_MARK = re.compile(
    r"(?P<front>[^\W\d_](?:.*[^\W\d_])?)(?P<sign>[ _=-]+|(?<=[IiUuVE]))(?P<number>\d+(?:[._]\d+)?)"
)
#: ``05`` and ``0_5`` may be 0.5 or 5.
_LACKS_ITS_POINT = re.compile(r"0\d+|\d+_\d+")
_UNMARKED = "none of them"
_FIELD = "a field in its unit"


def with_levels_of_marks(table: Table) -> Table:
    """The table with one column in place of those that mark levels by 0 and 1; else as it is."""
    by_kind: dict[str, list[str]] = {}
    for name, values in table.columns.items():
        if set(np.unique(values).tolist()) != {0.0, 1.0}:
            continue
        # A mark tells a field with its unit, or the number of a word for a field.
        match = _MARK.fullmatch(name)
        if stated_in(name) is not None or open_field_in(name):
            by_kind.setdefault(_FIELD, []).append(name)
        elif match is not None and "field" in spoken_name(match["front"]).may_be:
            by_kind.setdefault(match["front"], []).append(name)
    for kind, names in by_kind.items():
        marked = np.column_stack([table.columns[name] for name in names])
        marks_of_row = marked.sum(axis=1)
        numbers_in = [match["number"] for match in map(_MARK.fullmatch, names) if match]
        are_counted = kind != _FIELD and {*numbers_in} == {*map(str, range(1, len(names) + 1))}
        # pandas may drop the first level: its rows have no mark.
        fewest = 0.0 if kind == _FIELD else 1.0
        one_in_each_row = bool(np.all((marks_of_row <= 1.0) & (marks_of_row >= fewest)))
        is_taken = CALLED in (*table.columns, *table.words)
        if len(names) < 2 or not one_in_each_row or is_taken or are_counted:
            continue
        without_mark = marks_of_row == 0.0
        of_row = np.where(without_mark, len(names), marked.argmax(axis=1)).astype(np.int32)
        others = {name: values for name, values in table.columns.items() if name not in names}
        note = f"columns {listed(names)} mark the level of each row by a 1"
        numbers = {name: place for name, place in table.numbers.items() if name in others}
        units_of = {name: unit for name, unit in table.units.items() if name not in names}
        bare = replace(table, columns=others, units=units_of, numbers=numbers)
        if kind == _FIELD or any(map(_LACKS_ITS_POINT.fullmatch, numbers_in)):
            words = WordColumn((*names, *[_UNMARKED] * bool(without_mark.any())), of_row)
            words_of = {**table.words, CALLED: words}
            return replace(bare, words=words_of, notes=(*table.notes, f"{note}: read as words"))
        column: Array = np.array([float(number) for number in numbers_in])[of_row]
        said = f"{note}: column {kind} has their numbers"
        return replace(bare, columns={**others, kind: column}, notes=(*table.notes, said))
    return table
