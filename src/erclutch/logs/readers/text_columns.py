"""The columns of a text are sorted: numbers, constants of its header, a clock, words of rows, and what is left out."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.word_columns import (
    names_of_rows,
    only_words,
    parting_columns,
    parting_note,
)
from erclutch.logs.readers import dates
from erclutch.logs.readers.dialect import Dialect
from erclutch.logs.readers.list_cells import without_lists
from erclutch.logs.readers.text_cells import CORRECT, TornColumnError, read_cells
from erclutch.logs.readers.unit_cells import units_beside
from erclutch.signals.array import Array

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class SortedColumns:
    """What the columns of a text hold; see `Table`.

    Attributes:
        columns: numbers by label, shape (rows,).
        of_lists: those of them that are places of lists in the cells of one column.
        constants: columns that are filled in their first row only.
        hollow: labels of empty columns.
        unreadable: what stands against a column, by its label.
        torn: those of them of which a few cells are no numbers.
        clock: seconds since the first row, shape (rows,); None without dates or times of day.
        clock_name: of the columns that it is read from.
        units_behind: units that stand in a column of their own, by the label of the column before.
        words: of the columns that part the rows into groups.
        only_words: texts that a column holds in all rows.
        row_names: what the rows are called.
        notes: a sentence on each change.
    """

    columns: dict[str, Array]
    of_lists: tuple[str, ...]
    constants: dict[str, float]
    hollow: tuple[str, ...]
    unreadable: dict[str, str]
    torn: dict[str, Array]
    clock: Array | None
    clock_name: str
    units_behind: dict[str, str]
    words: dict[str, Any]
    only_words: dict[str, str]
    row_names: Any
    notes: list[str] = field(default_factory=list[str])


def sorted_columns(frame: pd.DataFrame, body: str, dialect: Dialect) -> SortedColumns:
    """Sort the columns of a text by what their cells hold.

    Args:
        frame: the cells of all rows; columns behind the named ones are passed over.
        body: the rows as text.
        dialect: of the text.

    Raises:
        LogError: no column holds numbers, and what stands against the first.
    """
    columns: dict[str, Array] = {}
    constants: dict[str, float] = {}
    hollow: list[str] = []
    texts: dict[str, pd.Series[Any]] = {}
    unreadable: dict[str, str] = {}
    torn: dict[str, Array] = {}
    notes: list[str] = []
    for index, label in enumerate(dialect.names):
        cells = frame.iloc[:, index]
        try:
            numbers, told_of_cells = read_cells(cells, index, body, dialect)
        except LogError as error:
            unreadable[label] = error.problem
            if isinstance(error, TornColumnError):
                torn[label] = error.numbers
            continue
        notes += told_of_cells
        if numbers is None:
            texts[label] = cells
            continue
        filled = int(np.count_nonzero(~np.isnan(numbers)))
        if filled == 0 and len(numbers) > 0:
            hollow.append(label)
            notes.append(f"column {label} is empty: left out")
        elif filled == 1 < len(numbers) and not np.isnan(numbers[0]):
            constants[label] = float(numbers[0])
            notes.append(
                f"column {label} is filled in its first row only: kept as the constant {numbers[0]:g}"
            )
        else:
            columns[label] = numbers

    of_lists, told_of_lists = without_lists(texts)
    columns |= {name: numbers for name, numbers in of_lists.items() if name not in columns}
    notes += told_of_lists
    clock_name, clock = dates.clock_of_dates(texts)
    words = parting_columns(texts)
    units_behind = units_beside(dialect.names, texts)
    for label, unit in units_behind.items():
        notes.append(f"column {label} is in {unit}, as the column behind it says")

    # What is left are words: of the groups that rows are of, or of nobody knows what.
    for label, cells in texts.items():
        if label in (clock_name, *clock_name.split(" and ")):
            continue
        present = cells.dropna()
        first = str(present.iloc[0]).strip()[:30] if len(present) else ""
        problem = f"column {label} holds text ({first!r}) in {len(present)} of {len(cells)} rows"
        unreadable[label] = problem
        is_of_groups = label in words
        notes.append(parting_note(label, words[label]) if is_of_groups else f"{problem}: left out")
    if unreadable and not columns:
        raise LogError(next(iter(unreadable.values())), remedy=CORRECT)
    for label, problem in unreadable.items():
        if label not in texts:
            notes.append(f"column {label} is left out: {problem}")
    return SortedColumns(
        columns=columns,
        of_lists=tuple(of_lists),
        constants=constants,
        hollow=tuple(hollow),
        unreadable=unreadable,
        torn=torn,
        clock=clock,
        clock_name=clock_name,
        units_behind=units_behind,
        words=words,
        only_words=only_words(texts),
        row_names=names_of_rows(texts),
        notes=notes,
    )
