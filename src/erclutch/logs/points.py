"""A table of points, such as a motor's curve of torque over speed, has no time and needs none."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from erclutch.logs.clock_planning import points
from erclutch.logs.draft import Draft
from erclutch.logs.seen_columns import SeenColumn
from erclutch.logs.table import WordColumn
from erclutch.signals.array import Array

_SPEEDS = ("rad/s", "m/s")
_FEWEST = 10  # rows: fewer may be in order by chance


def take_points(draft: Draft) -> None:
    """Take the rows as points in no time where the speed goes one way through the table, and no column may be a time.

    Where a column of words or of a few numbers parts the rows, such as the throttle, through the rows of each of these.

    A log of a motion turns back or rests, and its rate matters: there the user is asked for it.
    """
    question = draft.questions.get("time")
    untimed = question is not None and draft.told.time is None and question.problem.startswith("no time column")
    if not untimed or not draft.table.path:  # arrays in memory have a rate that their owner knows
        return
    slip = draft.signals.get("slip")
    effort = draft.signals.get("effort")
    if slip is None or effort is None or not slip.column or not effort.column:
        return
    if draft.seen.columns[slip.column].kind == "Pa":
        return  # points of a rheometer are for `erclutch flowcurve`

    columns = draft.seen.columns.values()
    speeds = [column for column in columns if "slip" in column.spoken.may_be or column.fits(_SPEEDS)]
    parted = [*draft.table.words.values(), *_levels(columns)]
    swept = [
        column.name
        for column in speeds
        if _goes_one_way(column.values) or any(_sweeps_within(column.values, words) for words in parted)
    ]
    if not swept or any(_may_be_time(column) for column in draft.seen.without(draft.taken)):
        return

    del draft.questions["time"]
    sentence = f"no time: column {swept[0]} goes one way through the table, so its rows are points, none after another"
    draft.clock = points(draft.seen.counters, sentence, f"{swept[0]} goes one way")


def _levels(columns: Iterable[SeenColumn]) -> Iterator[WordColumn]:
    """Columns that keep a few numbers, each for many rows, as columns of words."""
    for column in columns:
        if column.shape.keeps_levels and np.isfinite(column.values).all():
            levels, of_row = np.unique(column.values, return_inverse=True)
            yield WordColumn(tuple(map(str, levels)), of_row.astype(np.int32))


def _goes_one_way(speed: Array, fewest: int = _FEWEST) -> bool:
    """Whether a speed of one sign only grows, or only falls."""
    if speed.size < fewest or not np.isfinite(speed).all() or speed.min() == speed.max():
        return False
    if speed.min() < 0.0 < speed.max():
        return False
    steps = np.diff(speed)
    grows = np.all(steps >= 0.0)
    falls = np.all(steps <= 0.0)
    return bool(grows or falls)


def _sweeps_within(speed: Array, words: WordColumn) -> bool:
    """Whether a speed goes one way through the rows of each word."""
    sweeps = [speed[words.of_row == number] for number in range(len(words.words))]
    longest = max(sweep.size for sweep in sweeps)
    return longest >= _FEWEST and all(_goes_one_way(sweep, fewest=3) for sweep in sweeps)


def _may_be_time(column: SeenColumn) -> bool:
    """Whether a column rises as a time does, and neither its name nor its unit says what else it is."""
    known = column.unit or column.spoken.is_accounted or column.spoken.may_be - {"position"}
    return column.shape.rises and not column.shape.counts_rows and not known
