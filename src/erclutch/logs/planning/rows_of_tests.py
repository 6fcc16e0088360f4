"""Where each row sums up a test, its rows are points: the command has its peaks or means, and no rate of sampling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.errors import MissingColumnError, shell_word
from erclutch.logs.columns.sums_of_tests import (
    LEAST,
    MEANS,
    MOST_TESTS,
    PEAKS,
    WORDS,
    amplitude_and_frequency,
    sum_of_a_test,
    sums_of,
)
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.points import is_untimed

_CANCELLED = 0.5  # of the largest effort, below which its mean is that of two strokes


def propose_rows_of_tests(draft: Draft) -> None:
    """Propose points of a motion and an effort that are summed up, where no column is a time.

    An amplitude that was guessed as a position is taken back: it is no course of a motion.
    """
    question = draft.questions.get("time")
    if question is None or not is_untimed(draft, question) or draft.table.rows > MOST_TESTS:
        return
    names = [column.name for column in draft.seen.columns.values()]
    efforts = sums_of(names, "effort")
    slips = sums_of(names, "slip")
    known = draft.signals.get("effort")
    if not efforts or (known is not None and known.column not in efforts):
        return
    pair = amplitude_and_frequency({name: draft.table.units.get(name) for name in names})
    position = draft.guessed("position")
    if position is not None:
        is_summed = sum_of_a_test(position.column) is not None
        if not is_summed and (pair is None or position.column not in pair):
            return
        draft.take_back("position")

    chosen = draft.signals.get("slip")
    if chosen is not None:
        slip = chosen.column
    else:
        slip = min(slips, key=lambda name: WORDS.index(slips[name]), default="")

    def speaks_against(name: str) -> tuple[bool, int]:
        """How far an effort is from the one that belongs to the slip."""
        return efforts[name] != slips.get(slip), WORDS.index(efforts[name])

    effort = min(efforts, key=speaks_against)
    if known is not None and known.column != effort and draft.guessed("effort") is not None:
        draft.take_back("effort")  # the mean force of a sine beside its peak speed
    why = f"each row sums up a test, as {effort} says"
    of_points = question.adding(f"; {why}, so its rows are points")
    draft.questions["time"] = replace(of_points, option="--time none")
    _propose(draft, "effort", effort)
    if slip:
        _propose(draft, "slip", slip)
    elif "slip" not in draft.questions:
        problem = f"no column for slip; {why}; the file has: {draft.table.listed}"
        remedy = "Put the speed of each test into a column"
        draft.ask("slip", MissingColumnError(problem, remedy=remedy))
    fields = sums_of(names, "field")
    if fields and "field" in draft.questions:
        # A field is set for a test: its mean says more than its largest value.
        _propose(draft, "field", min(fields, key=lambda name: fields[name] not in MEANS))


def doubt_the_mean_of_a_motion_to_and_fro(draft: Draft) -> None:
    """Doubt a guessed effort that is the mean of each test, beside a largest and a least one of opposite signs.

    Over a stroke forth and a stroke back the efforts of a device cancel out.
    """
    effort = draft.guessed("effort")
    efforts = sums_of([column.name for column in draft.seen.columns.values()], "effort")
    if effort is None or efforts.get(effort.column) not in MEANS:
        return
    largest = next((name for name, word in efforts.items() if word in PEAKS), "")
    least = next((name for name, word in efforts.items() if word in LEAST), "")
    if not largest or not least:
        return
    peaks = draft.seen.columns[largest].values
    has_both_signs = np.nanmedian(peaks) > 0.0 > np.nanmedian(draft.seen.columns[least].values)
    means = draft.seen.columns[effort.column].values
    if has_both_signs and np.nanmedian(np.abs(means)) < _CANCELLED * np.nanmedian(peaks):
        why = f"which is the mean of a test to and fro, beside {largest} and {least}"
        draft.doubt("effort", why, shell_word(draft.table.label(largest)))


def _propose(draft: Draft, signal: str, name: str) -> None:
    """Answer the question about a signal by a column, or ask that question where nothing was asked."""
    if signal in draft.signals:
        return
    option = f"--{signal} {shell_word(draft.table.label(name))}"
    remedy = f"If it is, give {option}"
    more = f"; {name} of each test may be it; the file has: {draft.table.listed}"
    asked = draft.questions.get(signal)
    if asked is None:
        missing = MissingColumnError(f"no column for {signal}{more}", remedy=remedy)
        draft.ask(signal, missing, option)
        return
    problem = asked.problem.partition(";")[0] + more
    draft.questions[signal] = replace(asked, problem=problem, remedy=remedy, option=option)
