"""The rows of a table may be points in no time, such as a motor's curve of torque over speed.

A map of an effort at rest has no slip either, at no rate.
"""

from __future__ import annotations

from math import lgamma, log

import numpy as np

from erclutch.errors import MissingClockError
from erclutch.logs.columns.seen_columns import SeenColumns
from erclutch.logs.plan import Question
from erclutch.logs.planning.clock_planning import points
from erclutch.logs.planning.draft import Draft
from erclutch.logs.table import WordColumn
from erclutch.signals.array import Array

_SPEEDS = ("rad/s", "m/s")
_FEWEST = 10  # rows: fewer may be in order by chance
_MOST_NOISY = 1000  # rows of a table that was swept with noise: more are those of a log
_NOISE = 0.01  # of its range, by which a swept speed that was measured goes back at most
IN_NO_ORDER = "are in no order"  # ends the reason for points that follow each other by chance
_FEWEST_MIXED = 200  # rows, for chance to be told from a course
_SPREAD_OF_CHANCE = 8.0  # times 1 / sqrt(rows): four deviations of that ratio
_DIGITS_OF_A_STEP = 1e-6  # of a step, by which equal steps that are computed differ
#: The same as `_NOISE`, where a column numbers the points: each of them was set, and wanders.
_NOISE_OF_POINTS = 0.05
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


def take_points(draft: Draft) -> None:
    """Take the rows as points in no time where the speed goes one way through the table, and no column may be a time.

    Where a column of words or of a few numbers parts the rows, such as the throttle, through the rows of each of these.

    A log of a motion turns back or rests, and its rate matters: there the user is asked for it.
    """
    question = draft.questions.get("time")
    if question is None or not is_untimed(draft, question):
        return
    slip = draft.signals.get("slip")
    effort = draft.signals.get("effort")
    if slip is None or not slip.column:
        return
    if effort is None:
        return  # the log is asked for it first
    # A prediction is told an effort of 0, and has no column of it.
    needed = [slip.column, *([effort.column] if effort.column else [])]
    if draft.seen.columns[slip.column].kind == "Pa":
        return  # points of a rheometer are for `erclutch flowcurve`

    swept = _swept_speed(draft.seen)
    mixed = not swept and all(_is_in_no_order(draft.table.columns[name]) for name in needed)
    if not swept and not mixed:
        return
    for column in draft.seen.without(draft.taken):
        is_known = column.unit or column.spoken.is_accounted or column.spoken.may_be - {"position"}
        if column.shape.rises and not column.shape.counts_rows and not is_known:
            return  # it may be the time

    del draft.questions["time"]
    why = f"columns {' and '.join(needed)} {IN_NO_ORDER}" if mixed else f"{swept} goes one way"
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
        if seen.table.sweeps is not None and seen.table.sweeps.size == column.values.size:
            # They stood beside each other in rows, as no course of time does.
            numbers = seen.table.sweeps
            by_sweep = [column.values[numbers == number] for number in np.unique(numbers)]
            if all(_goes_one_way(sweep, fewest=3, either_sign=True) for sweep in by_sweep):
                return column.name
        for words in parting:
            sweeps = [column.values[words.of_row == number] for number in range(len(words.words))]
            # Rows are in order by chance less often the more there are in each of several sweeps.
            orders = sum(lgamma(sweep.size + 1) - log(2.0) for sweep in sweeps)
            told = orders >= lgamma(_FEWEST + 1) - log(2.0)
            if told and all(_goes_one_way(sweep, fewest=3) for sweep in sweeps):
                return column.name
    return ""


def _goes_one_way(
    speed: Array, fewest: int = _FEWEST, noise: float = _NOISE, either_sign: bool = False
) -> bool:
    """Whether a speed, of one sign or of either, only grows or falls, up to its noise: a share of its range.

    Through zero it does so by equal steps: those of a table. What was measured does not repeat its steps to the digit.
    """
    if speed.size < fewest or not np.isfinite(speed).all() or speed.min() == speed.max():
        return False
    if speed.min() < 0.0 < speed.max() and not either_sign:
        steps = np.diff(speed)
        if np.ptp(steps) > _DIGITS_OF_A_STEP * np.abs(steps).max():
            return False
    back = noise * float(np.ptp(speed)) if _FEWEST <= speed.size <= _MOST_NOISY else 0.0
    grows = (np.maximum.accumulate(speed) - speed).max() <= back
    falls = (speed - np.minimum.accumulate(speed)).max() <= back
    return bool(grows or falls)


def is_untimed(draft: Draft, question: Question) -> bool:
    """Whether no column is the time and the user said nothing of it; arrays in memory have a rate that he knows."""
    has_no_time = question.kind is MissingClockError
    return has_no_time and draft.told.time is None and bool(draft.table.path)


def say_what_is_a_map(draft: Draft) -> None:
    """Say beside the question for a time where a position is swept anew for each level of another column.

    Such rows are a map of an effort at rest, as a calculation of a motor gives it: no rate makes a motion of it.
    """
    question = draft.questions.get("time")
    if question is None or not is_untimed(draft, question):
        return
    position = draft.signals.get("position")
    effort = draft.signals.get("effort")
    slip = draft.signals.get("slip")
    if effort is None or not effort.column or (slip is not None and slip.column):
        return
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
            why = f"{position.column} goes one way anew for each {column.name}, as in a map of efforts at rest"
            draft.questions["time"] = question.adding(f"; {why}: that has no slip, at no rate")
            return
