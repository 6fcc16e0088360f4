"""The rows of a table may be of several devices or tests: a column of words or numbers parts them; the user says which.

Rows of devices take turns in time, as in a log of a bus; a word may part points, or rows whose time begins anew.
"""

from __future__ import annotations

import numpy as np

from erclutch.errors import MappingError, MissingColumnError, UnitError, listed, shell_word
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.columns.word_columns import times_begun_anew
from erclutch.logs.log_file import EACH
from erclutch.logs.planning.draft import Draft
from erclutch.logs.table import WordColumn
from erclutch.signals import units

#: Words for the parts of one measurement, whose rows are one log whichever part they are of.
_PARTS = frozenset(
    (
        "trial test run direction cycle phase state status step rep repetition segment mode "
        "sweep load flag valid event comment remark note versuch lauf richtung zustand schritt "
        "essai sens etat prueba ensayo sentido estado"
    ).split()
)
#: Columns that tell one device or fluid from another; a model is of one of them.
KINDS = frozenset(
    (
        "material sample specimen fluid oil grease batch company supplier maker motor damper "
        "device unit model product"
    ).split()
)
#: Whose rows they are: people, and pieces of a material.
WHOSE = frozenset(
    (
        "subject participant patient person athlete proband volunteer sujet sujeto soggetto "
        "paciente specimen sample batch probe eprouvette probeta"
    ).split()
)
_FEWEST_EACH = 3  # rows of a person or piece, on average
_SELDOM = 0.01  # of the rows
_ANOTHER_COURSE = 60.0  # s between two times: from then on they are of two courses
TAKE_TURNS = 0.6  # share of the rows that are of another device than the row before
_MOST_DEVICES = 64  # on a bus
#: What the number of a device on a bus is called.
OF_A_DEVICE = frozenset(
    {"id", "joint", "motor", "servo", "axis", "node", "device", "actuator", "channel", "address"}
)


def ask_about_woven_devices(draft: Draft) -> None:
    """Ask which device is meant where rows of several take turns."""
    table = draft.table
    if not table.path:
        return
    if _lacks_a_column(draft):
        return
    woven = _woven_devices(draft)
    if woven is not None:
        name, column = woven
        problem = (
            f"rows of {len(column.words)} take turns, by column {name}: {listed(column.words, 6)}"
        )
        motion = next((each for each in ("slip", "position") if each in draft.signals), "")
        moves = table.columns.get(draft.signals[motion].column) if motion else None
        word = column.words[0]
        if moves is not None:  # the device whose motion has the largest range
            ranges = [float(np.ptp(moves[column.of_row == n])) for n in range(len(column.words))]
            word = column.words[int(np.argmax(ranges))]
        one = f"--variable {shell_word(f'{name}={word}')}"
        remedy = (
            f"Take one, such as {one}, or each as a log: --variable {shell_word(f'{name}={EACH}')}"
        )
        draft.ask("variable", MappingError(problem, remedy=remedy, option=one), one)


def _woven_devices(draft: Draft) -> tuple[str, WordColumn] | None:
    """The column of words or numbers that tells which device a row is of, where rows of several take turns in time.

    So are logs of a bus, and tables of the joints of a robot, a row a joint: a stamp repeats for each of them.
    """
    clock = draft.clock
    stamps = None if clock is None or clock.kind == "points" else draft.seen.stamps
    if clock is not None and clock.kind == "column":
        stamps = draft.table.columns.get(clock.column)
    if stamps is None or not np.isfinite(stamps).all():
        return None
    parting = dict(draft.table.words)
    for column in draft.seen.without(draft.taken):
        if "".join(column.spoken.stem_words[-1:]) in OF_A_DEVICE:
            parting |= _by_number(column, _MOST_DEVICES)
    for name, column in parting.items():
        devices = len(column.words)
        rows = column.of_row.size
        turns = np.count_nonzero(np.diff(column.of_row)) / max(rows - 1, 1)
        known = column.of_row[column.of_row >= 0]
        shares = np.bincount(known, minlength=devices) / rows  # of the rows, by device
        if turns < TAKE_TURNS or devices > _MOST_DEVICES or shares.min() < 0.5 / devices:
            continue
        each_goes_on = True
        for number in range(devices):
            steps = np.diff(stamps[column.of_row == number])
            each_goes_on = each_goes_on and bool(np.all(steps > 0.0))
        if each_goes_on and np.all(np.diff(stamps) >= 0.0):
            return name, column
    return None


def _lacks_a_column(draft: Draft) -> bool:
    """Whether a signal besides the field has no column: then the log is asked for it first."""
    lacking = {name for name, each in draft.questions.items() if each.kind is MissingColumnError}
    return bool(lacking - {"field"})


def ask_about_groups(draft: Draft) -> None:
    """Ask which rows are meant where a column of words parts points, or where time runs within its words only.

    Rows of one course of time are one log, whatever is written beside them; so are the trials of one measurement.
    """
    table = draft.table
    if not table.path or "variable" in draft.questions:
        return
    if _lacks_a_column(draft):
        return
    clock = draft.clock
    if clock is not None:
        are_points = clock.kind == "points"
        stamps = table.columns.get(clock.column)
    else:
        # Rows with a speed and no time are taken as points: so the command says that answers the question.
        are_points = "slip" in draft.signals or "slip" in draft.questions
        stamps = None
    parting = dict(table.words)
    if table.clock is not None:
        # Times that never fall, none long after the time before, are of one course: each of them stands in many rows.
        steps = np.diff(table.clock)  # [s]
        if steps.size and np.all((steps >= 0.0) & (steps < _ANOTHER_COURSE)):
            parting.pop(table.clock_name, None)
    if are_points:
        for numbered in draft.seen.without(draft.taken):
            if numbered.spoken.says(WHOSE):
                parting |= _by_number(numbered, numbered.values.size / _FEWEST_EACH)
    for name, column in parting.items():
        if are_points:
            begins = 0
        elif stamps is not None:
            begins = times_begun_anew(stamps, column)
        else:
            # A share of a cycle, or a travel, falls back between the words: the rows of each are a course of their own.
            moving = [each for each in draft.seen.without(draft.taken) if not each.shape.constant]
            courses = [each.values for each in moving if np.isfinite(each.values).all()]
            begun = [times_begun_anew(course, column) for course in courses]
            between_words = len(column.words) - 1
            begins = between_words if between_words in begun else 0
        are_levels = name in table.words and _are_levels(column)
        if (not are_points and not begins) or are_levels:
            continue
        # A clock that begins anew now and then is followed without a word of the user.
        called = {*words_of(name)}
        if not called.isdisjoint(_PARTS) and begins <= _SELDOM * column.of_row.size:
            continue
        problem = (
            f"column {name} parts the rows into {len(column.words)}: {listed(column.words, 6)}"
        )
        first = f"--variable {shell_word(f'{name}={column.words[0]}')}"
        each = f"--variable {shell_word(f'{name}={EACH}')}"
        remedy = f"Take one, such as {first}, or each as a log: {each}"
        option = each if called.isdisjoint(KINDS) else first
        error = MappingError(problem, remedy=remedy, option=option)
        # A number of the row is then no field: it does not count the rows of a part one by one.
        others = draft.seen.without(draft.taken)
        if draft.field_is_open and any(other.shape.counts_rows for other in others):
            option += " --field none"
        draft.ask("variable", error, option)
        return


def _by_number(column: SeenColumn, most: float) -> dict[str, WordColumn]:
    """A column of two to ``most`` different whole numbers as words, by its name; nothing for another column."""
    values = column.values
    if not np.isfinite(values).all() or not are_whole(values):
        return {}
    numbers, of_row = np.unique(values, return_inverse=True)
    if not 1 < numbers.size <= most:
        return {}
    words = tuple(f"{number:.15g}" for number in numbers)
    return {column.name: WordColumn(words, of_row.astype(np.int32))}


def _are_levels(column: WordColumn) -> bool:
    """Whether the words are quantities, such as 2.5A: levels of something that was set, of one device."""
    for word in column.words:
        try:
            _, unit = units.quantity(word)
        except UnitError:
            return False
        if unit is not None and not units.is_unit(unit):
            return False
    return True
