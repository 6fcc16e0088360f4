"""A column may part the rows of a file: by material, by test, by direction. The rows of one word are a recording.

Such a recording is named ``COLUMN=WORD``, behind the name of a sheet or a table ``SHEET; COLUMN=WORD``; with ``all`` in
place of the word, the rows of each word are one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from erclutch.errors import LogError, listed, printable, shell_word
from erclutch.logs.columns.labels import split_label
from erclutch.logs.table import Table, WordColumn
from erclutch.signals.array import Array

if TYPE_CHECKING:
    import pandas as pd

EACH = "all"  # in place of a word
_MOST_WORDS = 200
_FEWEST_ROWS = 3  # of a word, on average; a column of remarks or of names has a word a row
_LONGEST = 60  # characters of a word


class Group(NamedTuple):
    """Which rows of which recording are wanted."""

    recording: str | None
    column: str
    word: str


def group_of(variable: str | None) -> Group | None:
    """``COLUMN=WORD`` or ``RECORDING; COLUMN=WORD``; None for the name of a recording."""
    recording, parted, choice = (variable or "").rpartition("; ")
    column, equals, word = choice.partition("=")
    if not equals or not column.strip() or not word.strip():
        return None
    return Group(recording if parted else None, column.strip(), word.strip())


def wants_each(variable: str | None) -> bool:
    """Whether each recording of a file, or the rows of each word of a column, are wanted as logs."""
    group = group_of(variable)
    return variable == EACH or (group is not None and group.word == EACH)


def words_of(texts: dict[str, pd.Series[Any]]) -> dict[str, WordColumn]:
    """Those columns of texts whose words part the rows; remarks and names, a new one in each row, part none."""
    import pandas as pd

    parting: dict[str, WordColumn] = {}
    for column, cells in texts.items():
        text_of_row, texts_once = pd.factorize(cells)  # -1 where a cell is empty
        if not 1 < len(texts_once) <= _MOST_WORDS:
            continue
        # Texts that differ in blanks are one word.
        written = [printable(str(text).strip()) for text in texts_once]
        words = [*dict.fromkeys(written)]
        if any(not 0 < len(word) <= _LONGEST for word in words):
            continue
        filled = text_of_row >= 0
        if len(words) > 1 and np.count_nonzero(filled) >= _FEWEST_ROWS * len(words):
            word_of_text = np.asarray([words.index(word) for word in written], np.int32)
            word_of_row = np.where(filled, word_of_text[text_of_row], -1)
            parting[column] = WordColumn(tuple(words), word_of_row.astype(np.int32))
    return parting


def names_of_rows(texts: dict[str, pd.Series[Any]]) -> tuple[str, ...]:
    """What the first column of texts calls each row; nothing for many rows, or where a row has no name."""
    for cells in texts.values():
        if len(cells) > _MOST_WORDS:
            return ()
        names = [printable(str(cell).strip()) for cell in cells.dropna()]
        if len(names) == len(cells) and all(0 < len(name) <= _LONGEST for name in names):
            return tuple(names)
    return ()


def parting_note(column: str, parting: WordColumn) -> str:
    """What is said of a column whose words part the rows."""
    choice = shell_word(f"{column}={parting.words[0]}")
    return f"column {column} parts the rows by {len(parting.words)} words: --variable {choice} takes those of one"


def groups_in(table: Table, column: str) -> list[str]:
    """The rows that a column parts, named ``COLUMN=WORD``, in the order of the file.

    Raises:
        LogError: no such column, or numbers that part nothing.
    """
    return [f"{_name_in(table, column)}={word}" for word in _words(table, column)]


def rows_of(table: Table, group: Group) -> Table:
    """The rows of one word of a column.

    Raises:
        LogError: no such column or word.
    """
    words = _words(table, group.column)
    if group.word not in words:
        problem = f"no row has {group.column} {group.word!r} (there are: {listed(words)})"
        raise LogError(
            problem,
            remedy=f"Choose one, such as --variable {shell_word(f'{group.column}={words[0]}')}",
        )
    name = _name_in(table, group.column)
    if name in table.words:
        column = table.words[name]
        kept = column.of_row == column.words.index(group.word)
    else:
        kept = table.columns[name] == float(group.word)
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
        row_names=(),
        hollow=(*table.hollow, *hollow),
        notes=(f"rows where {group.column} is {group.word}: {count}", *table.notes),
    )


def _name_in(table: Table, label: str) -> str:
    """A column's name in the table, with or without its unit behind it."""
    for name in (label, split_label(label)[0]):
        if name in table.words or name in table.columns:
            return name
    known = [*table.words, *table.columns]
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
    if numbers.size > _MOST_WORDS:
        problem = f"column {name} has {numbers.size:,} different numbers, above {_MOST_WORDS}: they part no rows"
        raise LogError(problem, remedy="Name another column")
    return [f"{number:.15g}" for number in numbers]
