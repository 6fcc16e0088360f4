"""A column may part the rows of a file: by material, by test, by direction. The rows of one word are a recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.errors import LogError, listed, shell_word
from erclutch.logs.columns.word_columns import MOST_WORDS
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_BEFORE_A_UNIT = "[({</（［"


def groups_in(table: Table, column: str) -> list[str]:
    """The rows that a column parts, named ``COLUMN=WORD``, in the order of the file.

    Raises:
        LogError: no such column, or numbers that part nothing.
    """
    return [f"{_name_in(table, column)}={word}" for word in _words(table, column)]


def rows_of(table: Table, label: str, word: str) -> Table:
    """The rows of one word of a column.

    Raises:
        LogError: no such column or word.
    """
    words = _words(table, label)
    if word not in words:
        problem = f"no row has {label} {word!r} (there are: {listed(words)})"
        option = f"--variable {shell_word(f'{label}={words[0]}')}"
        raise LogError(problem, remedy=f"Choose one, such as {option}", option=option)
    name = _name_in(table, label)
    if name in table.words:
        column = table.words[name]
        kept = column.of_row == column.words.index(word)
    else:
        kept = table.columns[name] == float(word)
    columns: dict[str, Array] = {}
    hollow: list[str] = []  # columns without a number in these rows
    for name, values in table.columns.items():
        if np.isnan(values[kept]).all():
            hollow.append(name)
        else:
            columns[name] = values[kept]
    clock = None if table.clock is None else table.clock[kept]
    count = f"{np.count_nonzero(kept):,} of {table.rows:,} rows"
    return replace(
        table,
        columns=columns,
        numbers={name: place for name, place in table.numbers.items() if name in columns},
        clock=None if clock is None else clock - clock[0],
        unsampled=None if table.unsampled is None else table.unsampled[kept],
        breaks=(),
        words={},
        sweeps=None,
        row_names=(),
        hollow=(*table.hollow, *hollow),
        notes=(f"rows where {label} is {word}: {count}", *table.notes),
    )


def _name_in(table: Table, label: str) -> str:
    """A column's name in the table, with or without its unit behind it."""
    known = [*table.words, *table.columns]
    for name in sorted(known, key=len, reverse=True):
        behind = label.removeprefix(name)
        if behind != label and (not behind or behind.lstrip()[0] in _BEFORE_A_UNIT):
            return name
    raise LogError(
        f"there is no column {label!r} whose words part the rows",
        remedy=f"Choose from {listed(known)}",
    )


def _words(table: Table, label: str) -> list[str]:
    """The words, or the numbers, of a column."""
    name = _name_in(table, label)
    if name in table.words:
        return [*table.words[name].words]
    values = table.columns[name]
    numbers = np.unique(values[np.isfinite(values)])
    if numbers.size > MOST_WORDS:
        problem = f"column {name} has {numbers.size:,} different numbers, above {MOST_WORDS}: they part no rows"
        raise LogError(problem, remedy="Name another column")
    return [f"{number:.15g}" for number in numbers]
