"""Whether the rows of a table are those of one device, where a column of words parts them, only the user knows."""

from __future__ import annotations

import numpy as np

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.draft import Draft
from erclutch.logs.names import words_of
from erclutch.logs.row_groups import EACH
from erclutch.logs.table import WordColumn, listed
from erclutch.logs.timing import DISORDER
from erclutch.signals import units
from erclutch.signals.array import Array

#: Words for the parts of one measurement, whose rows are one log whichever part they are of.
_PARTS = (
    "trial test run direction cycle phase state status step rep repetition segment mode sweep load flag valid event "
    "comment remark note versuch lauf richtung zustand schritt essai sens etat prueba ensayo sentido estado"
)
#: Columns that tell one device or fluid from another; a model is of one of them.
_KINDS = "material sample specimen fluid oil grease batch company supplier maker motor damper device unit model product"

_SELDOM = 0.01  # of the rows
_POINTS = "--time none"


def ask_about_order(draft: Draft) -> None:
    """Ask what the time is where the column of that name runs backwards every few rows: each row has a time of its own.

    So are points of an instrument, which waits at each of them. A time that begins anew with each word is left alone,
    and so is a time that falls from each row to the next: such a log stands newest row first, and is refused as that.
    """
    table, clock, slip = draft.table, draft.clock, draft.signals.get("slip")
    if clock is None or clock.kind != "column" or draft.told.time is not None or slip is None:
        return
    stamps = table.columns[clock.column]
    back = np.count_nonzero(np.diff(stamps) < 0.0)
    if back <= DISORDER * stamps.size or back == stamps.size - 1:
        return
    if any(_begins_anew(stamps, words) for words in table.words.values()):
        return
    draft.clock = None
    problem = f"column {clock.column} runs backwards {back} times in {stamps.size} rows, as no time of a log does"
    remedy = 'Take the rows as points (--time none), or name the time: --time "NAME [s]"'
    draft.ask("time", MappingError(problem, remedy=remedy), _POINTS)


def ask_about_groups(draft: Draft) -> None:
    """Ask which rows are meant where a column of words parts points, or where time runs within its words only.

    Rows of one course of time are one log, whatever is written beside them; so are the trials of one measurement.
    """
    table = draft.table
    lacks = any(each.problem.startswith("no column") for name, each in draft.questions.items() if name != "field")
    if not table.words or not table.path or lacks:
        return
    clock = draft.clock
    # Without a time, rows with a speed are taken as points: so the command says that answers the question.
    points = clock.kind == "points" if clock is not None else bool({"slip"} & {*draft.signals, *draft.questions})
    stamps = None if clock is None else table.columns.get(clock.column)
    for name, column in table.words.items():
        called = {*words_of(name)}
        begins = 0 if points or stamps is None else _begins_anew(stamps, column)
        if (not points and not begins) or _are_levels(column):
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


def _are_levels(column: WordColumn) -> bool:
    """Whether the words are quantities, such as 2.5A: levels of something that was set, of one device."""
    try:
        found = [units.quantity(word) for word in column.words]
    except UnitError:
        return False
    return all(unit is None or units.is_unit(unit) for _, unit in found)


def _begins_anew(stamps: Array, column: WordColumn) -> int:
    """How often stamps go back from row to row; 0 where they do so within a word too."""
    courses = (stamps[column.of_row == number] for number in range(len(column.words)))
    within = all(bool(np.all(np.diff(course) >= 0.0)) for course in courses)
    return int(np.count_nonzero(np.diff(stamps) < 0.0)) if within else 0
