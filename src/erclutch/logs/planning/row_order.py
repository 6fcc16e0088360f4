"""What the rows of a table are is found: rows in time, points in no time, or rows of several devices.

A table of points, such as a motor's curve of torque over speed, has no time and needs none. A time that runs backwards
is no time of a log. A column of words may part the rows: by material, by device, by direction; the user says which.
"""

from __future__ import annotations

import numpy as np

from erclutch.errors import MappingError, UnitError, listed, shell_word
from erclutch.logs.clock.time_stamps import DISORDER
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.row_groups import EACH
from erclutch.logs.columns.seen_columns import SeenColumns
from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.planning.clock_planning import points
from erclutch.logs.planning.draft import Draft
from erclutch.logs.table import WordColumn
from erclutch.signals import units
from erclutch.signals.array import Array

_SPEEDS = ("rad/s", "m/s")
_FEWEST = 10  # rows: fewer may be in order by chance
_MOST_NOISY = 1000  # rows of a table that was swept with noise: more are those of a log
_NOISE = 0.01  # of its range, by which a swept speed that was measured goes back at most
IN_NO_ORDER = "are in no order"  # ends the reason for points that follow each other by chance
_FEWEST_MIXED = 200  # rows, for chance to be told from a course
_SPREAD_OF_CHANCE = 8.0  # times 1 / sqrt(rows): four deviations of that ratio
_FEW_POINTS = 100  # rows: of so few, a time that goes back once is the mean time of points
_NOISE_OF_POINTS = (
    0.05  # the same, where a column numbers the points: each of them was set, and wanders
)
#: What the column is called that numbers the points; a logger counts samples.
_POINTS_OF = frozenset(
    (
        "point",
        "points",
        "pt",
        "pts",
        "no",
        "nr",
        "number",
        "nummer",
        "punkt",
        "messpunkt",
        "measurement",
    )
)
_UNSTEADY = 0.1  # of a step, by which the steps of points differ at least
#: Words for the parts of one measurement, whose rows are one log whichever part they are of.
_PARTS = frozenset(
    (
        *(
            "trial",
            "test",
            "run",
            "direction",
            "cycle",
            "phase",
            "state",
            "status",
            "step",
            "rep",
            "repetition",
        ),
        *(
            "segment",
            "mode",
            "sweep",
            "load",
            "flag",
            "valid",
            "event",
            "comment",
            "remark",
            "note",
            "versuch",
        ),
        *(
            "lauf",
            "richtung",
            "zustand",
            "schritt",
            "essai",
            "sens",
            "etat",
            "prueba",
            "ensayo",
            "sentido",
        ),
        "estado",
    )
)
#: Columns that tell one device or fluid from another; a model is of one of them.
_KINDS = frozenset(
    (
        *(
            "material",
            "sample",
            "specimen",
            "fluid",
            "oil",
            "grease",
            "batch",
            "company",
            "supplier",
            "maker",
        ),
        *("motor", "damper", "device", "unit", "model", "product"),
    )
)
_SELDOM = 0.01  # of the rows
_TAKE_TURNS = 0.6  # share of the rows that are of another device than the row before
_MOST_DEVICES = 64  # on a bus
#: What the number of a device on a bus is called.
_OF_A_DEVICE = frozenset(
    {"id", "joint", "motor", "servo", "axis", "node", "device", "actuator", "channel", "address"}
)


def take_points(draft: Draft) -> None:
    """Take the rows as points in no time where the speed goes one way through the table, and no column may be a time.

    Where a column of words or of a few numbers parts the rows, such as the throttle, through the rows of each of these.

    A log of a motion turns back or rests, and its rate matters: there the user is asked for it.
    """
    question = draft.questions.get("time")
    untimed = (
        question is not None
        and draft.told.time is None
        and question.problem.startswith("no time column")
    )
    if not untimed or not draft.table.path:  # arrays in memory have a rate that their owner knows
        return
    slip = draft.signals.get("slip")
    effort = draft.signals.get("effort")
    if effort is None or not effort.column:
        return
    if slip is None or not slip.column:
        _say_what_is_a_map(draft)
        return
    if draft.seen.columns[slip.column].kind == "Pa":
        return  # points of a rheometer are for `erclutch flowcurve`

    swept = _swept_speed(draft.seen)
    columns = draft.table.columns
    mixed = not swept and all(_is_in_no_order(columns[each.column]) for each in (slip, effort))
    if not swept and not mixed:
        return
    for column in draft.seen.without(draft.taken):
        is_known = column.unit or column.spoken.is_accounted or column.spoken.may_be - {"position"}
        if column.shape.rises and not column.shape.counts_rows and not is_known:
            return  # it may be the time

    del draft.questions["time"]
    why = (
        f"columns {slip.column} and {effort.column} {IN_NO_ORDER}"
        if mixed
        else f"{swept} goes one way"
    )
    course = why if mixed else f"column {why} through the table"
    sentence = f"no time: {course}, so its rows are points, none after another"
    sentence += ' (--rate "RATE Hz" if they were sampled at a rate)'
    draft.clock = points(draft.seen.counters, sentence, why)


def _is_in_no_order(values: Array) -> bool:
    """Whether each number differs from the one before as from any other, as in rows that were drawn by chance.

    Of such numbers the mean square of the steps is twice the variance (von Neumann); of a course in time it is less.
    """
    known = values[np.isfinite(values)]
    if known.size < _FEWEST_MIXED or known.min() == known.max():
        return False
    scaled: Array = known / np.abs(known).max()  # no square of a large number overflows
    steps = np.diff(scaled)
    ratio = float(steps @ steps) / (steps.size * float(np.var(scaled)))
    return abs(ratio - 2.0) < _SPREAD_OF_CHANCE / np.sqrt(known.size)


def _swept_speed(seen: SeenColumns) -> str:
    """The first speed that goes one way through the table, or through the rows of each word or level; "" for none."""
    noise = _NOISE
    parting = [*seen.table.words.values()]
    for column in seen.columns.values():
        if column.shape.counts_rows and column.spoken.says(_POINTS_OF):
            noise = _NOISE_OF_POINTS
        if column.shape.keeps_levels and np.isfinite(column.values).all():
            # A few numbers, each for many rows, part the rows as words do.
            levels, of_row = np.unique(column.values, return_inverse=True)
            parting.append(WordColumn(tuple(map(str, levels)), of_row.astype(np.int32)))

    for column in seen.columns.values():
        if "slip" not in column.spoken.may_be and not column.fits(_SPEEDS):
            continue
        if _goes_one_way(column.values, noise=noise):
            return column.name
        for words in parting:
            sweeps = [column.values[words.of_row == number] for number in range(len(words.words))]
            longest = max(sweep.size for sweep in sweeps)
            if longest >= _FEWEST and all(_goes_one_way(sweep, fewest=3) for sweep in sweeps):
                return column.name
    return ""


def _goes_one_way(speed: Array, fewest: int = _FEWEST, noise: float = _NOISE) -> bool:
    """Whether a speed of one sign only grows, or only falls, up to its noise: a share of its range."""
    if speed.size < fewest or not np.isfinite(speed).all() or speed.min() == speed.max():
        return False
    if speed.min() < 0.0 < speed.max():
        return False
    back = noise * float(np.ptp(speed)) if _FEWEST <= speed.size <= _MOST_NOISY else 0.0
    grows = (np.maximum.accumulate(speed) - speed).max() <= back
    falls = (speed - np.minimum.accumulate(speed)).max() <= back
    return bool(grows or falls)


def _say_what_is_a_map(draft: Draft) -> None:
    """Say beside the question for a time where a position is swept anew for each level of another column.

    Such rows are a map of an effort at rest, as a calculation of a motor gives it: no rate makes a motion of it.
    """
    position = draft.signals.get("position")
    if position is None or not position.column or "slip" in draft.questions:
        return
    swept = draft.seen.columns[position.column].values
    for column in draft.seen.without([position.column]):
        levels = column.values
        if not column.shape.keeps_levels or not np.isfinite(levels).all():
            continue
        sweeps = [swept[levels == level] for level in np.unique(levels)]
        each_rises = all(sweep.size > 2 and np.all(np.diff(sweep) > 0.0) for sweep in sweeps)
        if each_rises and len(sweeps) > 2:
            question = draft.questions["time"]
            why = f"{position.column} goes one way anew for each {column.name}, as in a map of efforts at rest"
            problem = f"{question.problem}. {why}: that has no slip, at no rate"
            draft.ask("time", MappingError(problem, remedy=question.remedy), question.option)
            return


def ask_about_order(draft: Draft) -> None:
    """Ask what the time is where the column of that name runs backwards every few rows: each row has a time of its own.

    So are points of an instrument, which waits at each of them. A time that begins anew with each word is left alone,
    and so is a time that falls from each row to the next: such a log stands newest row first, and is refused as that.
    """
    table = draft.table
    clock = draft.clock
    if clock is None or clock.kind != "column" or draft.told.time is not None:
        return
    open_slip = draft.questions.get("slip")
    is_one_of_several = open_slip is not None and "may be any of" in open_slip.problem
    if "slip" not in draft.signals and not is_one_of_several:
        return

    stamps = table.columns[clock.column]
    steps = np.diff(stamps[np.isfinite(stamps)])  # what is missing has an error of its own
    back = np.count_nonzero(steps < 0.0)
    if back == 0 or back == stamps.size - 1:
        return
    forward = steps[steps > 0.0]
    are_few_points = 0 < forward.size < _FEW_POINTS and bool(np.isfinite(stamps).all())
    if (
        are_few_points
    ):  # a steady clock that goes back once is that of a log whose rows were mixed up
        are_few_points = bool(np.ptp(forward) > _UNSTEADY * np.median(forward))
    if back <= DISORDER * stamps.size and not are_few_points:
        return
    if any(_begins_anew(stamps, words) for words in table.words.values()):
        return
    draft.clock = None
    times = "1 time" if back == 1 else f"{back} times"
    problem = f"column {clock.column} runs backwards {times} in {stamps.size} rows, as no time of a log does"
    remedy = 'Take the rows as points (--time none), or name the time: --time "NAME [s]"'
    draft.ask("time", MappingError(problem, remedy=remedy), "--time none")


def ask_about_groups(draft: Draft) -> None:
    """Ask which rows are meant where a column of words parts points, or where time runs within its words only.

    Rows of one course of time are one log, whatever is written beside them; so are the trials of one measurement.
    """
    table = draft.table
    if not table.path:
        return
    if any(
        each.problem.startswith("no column")
        for name, each in draft.questions.items()
        if name != "field"
    ):
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
        draft.ask("variable", MappingError(problem, remedy=remedy), one)
        return
    clock = draft.clock
    if clock is not None:
        are_points = clock.kind == "points"
        stamps = table.columns.get(clock.column)
    else:
        # Rows with a speed and no time are taken as points: so the command says that answers the question.
        are_points = "slip" in draft.signals or "slip" in draft.questions
        stamps = None
    for name, column in table.words.items():
        begins = 0 if are_points or stamps is None else _begins_anew(stamps, column)
        if (not are_points and not begins) or _are_levels(column):
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
        option = each if called.isdisjoint(_KINDS) else first
        draft.ask("variable", MappingError(problem, remedy=remedy), option)
        return


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
        last = "".join(column.spoken.stem_words[-1:])
        values = column.values
        if last not in _OF_A_DEVICE or not np.isfinite(values).all() or not are_whole(values):
            continue
        numbers, of_row = np.unique(values, return_inverse=True)
        if 1 < numbers.size <= _MOST_DEVICES:
            words = tuple(f"{number:.15g}" for number in numbers)
            parting[column.name] = WordColumn(words, of_row.astype(np.int32))
    for name, column in parting.items():
        devices = len(column.words)
        rows = column.of_row.size
        turns = np.count_nonzero(np.diff(column.of_row)) / max(rows - 1, 1)
        known = column.of_row[column.of_row >= 0]
        shares = np.bincount(known, minlength=devices) / rows  # of the rows, by device
        if turns < _TAKE_TURNS or devices > _MOST_DEVICES or shares.min() < 0.5 / devices:
            continue
        each_goes_on = True
        for number in range(devices):
            steps = np.diff(stamps[column.of_row == number])
            each_goes_on = each_goes_on and bool(np.all(steps > 0.0))
        if each_goes_on and np.all(np.diff(stamps) >= 0.0):
            return name, column
    return None


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


def _begins_anew(stamps: Array, column: WordColumn) -> int:
    """How often stamps go back from row to row; 0 where they do so within a word too."""
    for number in range(len(column.words)):
        of_word = stamps[column.of_row == number]
        if not np.all(np.diff(of_word) >= 0.0):
            return 0
    return int(np.count_nonzero(np.diff(stamps) < 0.0))
