"""Whether the rows of a table are those of one device, where a column of words parts them, only the user knows."""

from __future__ import annotations

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.draft import Draft
from erclutch.logs.row_groups import EACH
from erclutch.logs.table import WordColumn, listed
from erclutch.signals.array import Array

#: Columns that tell one device or fluid from another; a model is of one of them.
_KINDS = "material sample specimen fluid oil grease batch company supplier maker motor damper device unit model product"


def ask_about_groups(draft: Draft) -> None:
    """Ask which rows are meant where a column of words parts points, or where time runs within its words only.

    Rows of one course of time are one log, whatever is written beside them.
    """
    table = draft.table
    slip = draft.signals.get("slip")
    if not table.words or not table.path or draft.questions.keys() & {"slip", "position", "effort"}:
        return
    points = "time" in draft.questions or (draft.clock is not None and draft.clock.kind == "points")
    if points and slip is None:
        return  # without a speed only the user's rate tells what the rows are
    stamps = table.columns.get(draft.clock.column) if draft.clock is not None and not points else None
    for name, column in table.words.items():
        if not points and (stamps is None or not _runs_within(stamps, column)):
            continue
        shown = listed(column.words, 6)
        problem = f"column {name} parts the rows into {len(column.words)}: {shown}"
        first = f"--variable {shell_word(f'{name}={column.words[0]}')}"
        each = f"--variable {shell_word(f'{name}={EACH}')}"
        remedy = f"Take one, such as {first}, or each as a log: {each}"
        of_kinds = bool({*name.lower().replace("_", " ").split()} & {*_KINDS.split()})
        draft.ask("variable", MappingError(problem, remedy=remedy), first if of_kinds else each)
        return


def _runs_within(stamps: Array, column: WordColumn) -> bool:
    """Whether stamps go back from row to row, and never within a word."""
    if not np.any(np.diff(stamps) < 0.0):
        return False
    courses = (stamps[column.of_row == number] for number in range(len(column.words)))
    return all(bool(np.all(np.diff(course) >= 0.0)) for course in courses)
