"""A column of words or of few numbers may tell the field of its rows: the efforts at the same slip say so.

``label`` with red, green and blue, or a class from 0 to 2, tells nobody which field it was; that the rows of one have
twice the effort of those of another does. Then the user is asked.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from erclutch.errors import MappingError, listed, shell_word
from erclutch.logs.columns.levels_in_names import open_field_in, stated_in
from erclutch.logs.columns.names import words_of
from erclutch.logs.field_between_logs import efforts_of_two_words
from erclutch.logs.log_file import EACH
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.parted_rows import KINDS, OF_A_DEVICE, TAKE_TURNS, WHOSE
from erclutch.signals.array import Array

_MOST_WORDS = 20
#: What a column of senses of a motion is called.
_SENSES = frozenset(
    "direction dir richtung sens sense sentido direccion direzione riktning".split()
)
_OF_ONE_SENSE = 0.95  # of the way in the rows of a word, which goes one way
_FEWEST_ROWS = 10  # of a level, on average


def ask_about_the_only_word(draft: Draft) -> bool:
    """Ask whether a column that holds one text in all rows, such as ``d_0.5A``, tells the field.

    Returns:
        Whether such a text was found.
    """
    for name, word in draft.table.metadata.items():
        if name not in draft.table.unreadable:
            continue
        field = stated_in(word)
        text = f"{field.number:g} {field.unit}" if field is not None else ""
        open_number = open_field_in(word)
        if open_number:
            text = f"NUMBER {open_number.lstrip('+-0123456789_')}"
        if not text:
            continue
        option = f"--constant {shell_word(f'field={text}')}"
        problem = f"no column for field, and column {name} holds {word!r} in all rows"
        remedy = f"If that tells the field, give {option}; else --field none"
        draft.ask("field", MappingError(problem, remedy=remedy), option)
        return True
    return False


def ask_about_words(draft: Draft) -> bool:
    """Ask for the field of each word of a column, where the rows of two words have other efforts at the same slip.

    Returns:
        Whether such a column was found.
    """
    slip, effort = slip_and_effort(draft)
    if slip is None or effort is None or not draft.table.path:
        return False
    for name, column in draft.table.words.items():
        called = {*words_of(name)}
        turns = np.count_nonzero(np.diff(column.of_row)) / column.of_row.size
        are_devices = not called.isdisjoint(KINDS | WHOSE | OF_A_DEVICE) or turns >= TAKE_TURNS
        if (
            name == draft.table.clock_name
            or are_devices
            or not 1 < len(column.words) <= _MOST_WORDS
        ):
            continue
        apart = efforts_of_two_words(slip, effort, column.of_row)
        if apart is None:
            continue
        if not called.isdisjoint(_SENSES):
            shares_forth: list[float] = []  # of all that moves, what moves forth
            for word in (apart.more, apart.less):
                moved = slip[(column.of_row == word) & np.isfinite(slip)]
                size = float(np.abs(moved).sum())
                forth = float(np.maximum(moved, 0.0).sum())
                shares_forth.append(forth / size if size > 0.0 else 0.5)
            # The motion goes one way in the rows of one word, and the other way in those of the other.
            if max(shares_forth) >= _OF_ONE_SENSE and min(shares_forth) <= 1.0 - _OF_ONE_SENSE:
                continue
        more = column.words[apart.more]
        less = column.words[apart.less]
        problem = (
            f"no column for field, and at the same slip rows with {name} {more!r} have {apart.times:.2g} times the "
            f"effort of rows with {less!r}: the words {listed(column.words, 6)} may tell it"
        )
        option = f"--variable {shell_word(f'{name}={EACH}')}"
        remedy = f"Take the rows of each word as a log, and give the field of each: {option}; else --field none"
        draft.ask("field", MappingError(problem, remedy=remedy, option=option), option)
        return True
    return False


def levels_of_efforts(draft: Draft, taken: Iterable[str]) -> list[str]:
    """The only column of a few numbers that parts rows of other efforts at the same slip; none where several do."""
    slip, effort = slip_and_effort(draft)
    if slip is None or effort is None:
        return []
    levelled: list[str] = []
    for column in draft.seen.without(taken):
        if column.shape.constant or not np.isfinite(column.values).all():
            continue
        levels, of_row = np.unique(column.values, return_inverse=True)
        are_few = 1 < levels.size <= min(_MOST_WORDS, column.values.size / _FEWEST_ROWS)
        if are_few and efforts_of_two_words(slip, effort, of_row.astype(np.int32)) is not None:
            levelled.append(column.name)
    return levelled if len(levelled) == 1 else []


def slip_and_effort(draft: Draft) -> tuple[Array | None, Array | None]:
    """The numbers of slip and effort where each has a column, whatever their units."""
    columns: list[Array | None] = []
    for signal in ("slip", "effort"):
        plan = draft.signals.get(signal)
        columns.append(None if plan is None else draft.table.columns.get(plan.column))
    slip, effort = columns
    return slip, effort
