"""Whether the rows of a table are those of one device, where a column of words parts them, only the user knows."""

from __future__ import annotations

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.draft import Draft
from erclutch.logs.names import words_of
from erclutch.logs.row_groups import EACH
from erclutch.logs.table import WordColumn, listed
from erclutch.signals.array import Array

#: Words for the parts of one measurement, whose rows are one log whichever part they are of.
_PARTS = (
    "trial test run direction cycle phase state status step rep repetition segment mode sweep load flag valid event "
    "comment remark note versuch lauf richtung zustand schritt essai sens etat prueba ensayo sentido estado"
)
#: Columns that tell one device or fluid from another; a model is of one of them.
_KINDS = "material sample specimen fluid oil grease batch company supplier maker motor damper device unit model product"

_SELDOM = 0.01  # of the rows


def ask_about_groups(draft: Draft) -> None:
    """Ask which rows are meant where a column of words parts points, or where time runs within its words only.

    Rows of one course of time are one log, whatever is written beside them; so are the trials of one measurement.
    """
    table = draft.table
    if not table.words or not table.path or draft.clock is None or draft.questions.keys() & {"slip", "effort"}:
        return
    points = draft.clock.kind == "points"
    stamps = table.columns.get(draft.clock.column)
    for name, column in table.words.items():
        called = {*words_of(name)}
        begins = 0 if points or stamps is None else _begins_anew(stamps, column)
        if not points and not begins:
            continue
        # A clock that begins anew now and then is followed without a word of the user.
        if called & {*_PARTS.split()} and begins <= _SELDOM * column.of_row.size:
            continue
        shown = listed(column.words, 6)
        problem = f"column {name} parts the rows into {len(column.words)}: {shown}"
        first = f"--variable {shell_word(f'{name}={column.words[0]}')}"
        each = f"--variable {shell_word(f'{name}={EACH}')}"
        remedy = f"Take one, such as {first}, or each as a log: {each}"
        of_kinds = bool(called & {*_KINDS.split()})
        draft.ask("variable", MappingError(problem, remedy=remedy), first if of_kinds else each)
        return


def _begins_anew(stamps: Array, column: WordColumn) -> int:
    """How often stamps go back from row to row; 0 where they do so within a word too."""
    courses = (stamps[column.of_row == number] for number in range(len(column.words)))
    within = all(bool(np.all(np.diff(course) >= 0.0)) for course in courses)
    return int(np.count_nonzero(np.diff(stamps) < 0.0)) if within else 0
