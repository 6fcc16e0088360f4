"""A time that runs backwards is no time of a log: the rows are points, or another column is the time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.errors import MappingError, SeveralColumnsError
from erclutch.logs.clock.mixed_rows import are_mixed_up
from erclutch.logs.clock.time_stamps import DISORDER
from erclutch.logs.columns.word_columns import times_begun_anew
from erclutch.logs.planning.draft import Draft

_FEW_POINTS = 100  # rows: of so few, a time that goes back once is the mean time of points
_UNSTEADY = 0.1  # of a step, by which the steps of points differ at least


def sort_mixed_rows(draft: Draft) -> None:
    """Sort rows that were mixed up, as for the training of a network, by stamps that are a steady clock then."""
    clock = draft.clock
    if clock is None or clock.kind != "column":
        return
    if not are_mixed_up(draft.table.planned(clock.column)):
        return
    draft.clock = replace(clock, is_mixed_up=True)
    order = f"they are sorted by column {clock.column}, whose steps are even then"
    draft.notes.append(f"the rows stand in no order: {order}")


def ask_about_order(draft: Draft) -> None:
    """Ask what the time is where the column of that name runs backwards every few rows: each row has a time of its own.

    So are points of an instrument, which waits at each of them. A time that begins anew with each word is left alone.
    So are the times of a log whose newest row stands first, and of one whose rows were mixed up: both are sorted.
    """
    table = draft.table
    clock = draft.clock
    if clock is None or clock.kind != "column" or clock.is_mixed_up or draft.told.time is not None:
        return
    open_slip = draft.questions.get("slip")
    is_one_of_several = open_slip is not None and open_slip.kind is SeveralColumnsError
    if "slip" not in draft.signals and not is_one_of_several:
        return

    stamps = table.columns[clock.column]
    steps = np.diff(stamps[np.isfinite(stamps)])  # what is missing has an error of its own
    back = np.count_nonzero(steps < 0.0)
    if back == 0 or back == stamps.size - 1:
        return
    forward = steps[steps > 0.0]
    are_few_points = 0 < forward.size < _FEW_POINTS and bool(np.isfinite(stamps).all())
    if are_few_points:
        # A steady clock that goes back once is that of a log whose rows were mixed up.
        are_few_points = bool(np.ptp(forward) > _UNSTEADY * np.median(forward))
    if back <= DISORDER * stamps.size and not are_few_points:
        return
    if any(times_begun_anew(stamps, words) for words in table.words.values()):
        return
    draft.clock = None
    times = "1 time" if back == 1 else f"{back} times"
    problem = f"column {clock.column} runs backwards {times} in {stamps.size} rows, as no time of a log does"
    remedy = 'Take the rows as points (--time none), or name the time: --time "NAME [s]"'
    draft.ask("time", MappingError(problem, remedy=remedy), "--time none")
