"""A column of a few words parts the rows of a file; a column of remarks or of names has a new text in each row."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.errors import printable, shell_word
from erclutch.logs.table import Table, WordColumn
from erclutch.signals.array import Array

if TYPE_CHECKING:
    import pandas as pd

#: Words of a column that parts the rows, at most.
MOST_WORDS = 200
_FEWEST_ROWS = 3  # of a word, on average
_LONGEST = 60  # characters of a word


def parting_columns(texts: dict[str, pd.Series[Any]]) -> dict[str, WordColumn]:
    """Those columns of texts whose words part the rows; remarks and names, a new one in each row, part none."""
    import pandas as pd

    parting: dict[str, WordColumn] = {}
    for column, cells in texts.items():
        text_of_row, texts_once = pd.factorize(cells)  # -1 where a cell is empty
        if not 1 < len(texts_once) <= MOST_WORDS:
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


def only_words(texts: dict[str, pd.Series[Any]]) -> dict[str, str]:
    """The texts of those columns that hold one text in all rows, by column: what holds for the whole file."""
    only: dict[str, str] = {}
    for column, cells in texts.items():
        words = {str(text).strip() for text in cells.unique()[:2]}
        if len(cells) > 1 and len(words) == 1:
            (word,) = words
            if 0 < len(word) <= _LONGEST and not cells.isna().any():
                only[column] = printable(word)
    return only


def names_of_rows(texts: dict[str, pd.Series[Any]]) -> tuple[str, ...]:
    """What the first column of texts calls each row; nothing for many rows, or where a row has no name."""
    for cells in texts.values():
        if len(cells) > MOST_WORDS:
            return ()
        names = [printable(str(cell).strip()) for cell in cells.dropna()]
        if len(names) == len(cells) and all(0 < len(name) <= _LONGEST for name in names):
            return tuple(names)
    return ()


def parting_note(column: str, parting: WordColumn) -> str:
    """What is said of a column whose words part the rows."""
    choice = shell_word(f"{column}={parting.words[0]}")
    return (
        f"{_parts_rows(column)} {len(parting.words)} words: --variable {choice} takes those of one"
    )


def with_words_used_up(table: Table, column: str) -> Table:
    """The table in which the words of a column part no rows any more, since they were read as something else."""
    words = {name: parting for name, parting in table.words.items() if name != column}
    notes = [note for note in table.notes if not note.startswith(_parts_rows(column))]
    return replace(table, words=words, notes=tuple(notes))


def _parts_rows(column: str) -> str:
    return f"column {column} parts the rows by"


def times_begun_anew(stamps: Array, column: WordColumn) -> int:
    """How often stamps go back from row to row; 0 where they do so within a word too."""
    for number in range(len(column.words)):
        of_word = stamps[column.of_row == number]
        if not np.all(np.diff(of_word) >= 0.0):
            return 0
    return int(np.count_nonzero(np.diff(stamps) < 0.0))
