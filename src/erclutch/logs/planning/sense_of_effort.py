"""An effort that was logged as its size is doubted: it never changes its sign, though the motion goes to and fro."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from erclutch.logs.columns.shapes import FEW, known_rows, takes_both_signs
from erclutch.logs.planning.draft import Draft
from erclutch.signals.array import Array

_FAST = 0.3  # of the largest speed, above which a device moves
_NOUGHT = 0.4  # of the effort around a turn of the motion
_NEARLY_ALL = 0.9  # of the turns
_SELDOM = 0.1  # of the rows that move
_FEW_TURNS = 4
_ROWS_OF_A_TURN = 3
_ROWS_OF_A_STROKE = 5  # on average: of fewer the median is noise
_ALIKE = 0.15  # of a large effort


def doubt_an_effort_without_its_sense(draft: Draft) -> None:
    """Doubt a guessed effort that never changes its sign, beside a motion to and fro, and falls to nought as it turns.

    Such an effort was logged as its size. A weight or a preload is of one sign too, but does not fall to nought at
    both ends of a motion.
    """
    effort = draft.guessed("effort")
    motion = draft.signals.get("slip") or draft.signals.get("position")
    if effort is None or motion is None:
        return
    course = draft.table.columns.get(motion.column)
    measured = draft.table.columns.get(effort.column)
    if course is None or measured is None or course.size < FEW:
        return
    speed = course if motion.signal == "slip" else np.gradient(course)  # per row
    goes_to_and_fro = takes_both_signs(speed)
    has_a_sign = takes_both_signs(measured)
    if not goes_to_and_fro or has_a_sign:
        return
    falls = _falls_at_turns(speed, measured)
    if falls:
        doubt = f"which has no sign and falls to 0 wherever {motion.column} turns, as a size does"
    elif falls is None and _is_alike_both_ways(speed, measured):
        doubt = f"which has no sign and is alike both ways of {motion.column}, as a size is"
    else:
        return
    draft.doubt("effort", f"{doubt}: give a column whose sign turns")


def _is_alike_both_ways(speed: Array, effort: Array) -> bool:
    """Whether an effort is as large in a motion forth as in the next motion back; friction beside a weight is not."""
    v, f = known_rows(speed, effort)
    moving = np.flatnonzero(np.abs(v) > _FAST * np.abs(v).max(initial=0.0))
    senses = np.sign(v[moving])
    turned = np.flatnonzero(np.diff(senses) != 0) + 1
    borders = np.concatenate(([0], turned, [moving.size]))
    if turned.size < _FEW_TURNS or np.median(np.diff(borders)) < _ROWS_OF_A_STROKE:
        return False
    strokes = np.array([np.median(f[moving[a:b]]) for a, b in pairwise(borders)])
    more_forth = -np.diff(strokes) * senses[borders[:-2]]  # than in the stroke behind or in front
    largest = np.quantile(np.abs(f), _NEARLY_ALL)
    return bool(abs(np.median(more_forth)) < _ALIKE * largest)


def _falls_at_turns(speed: Array, effort: Array) -> bool | None:
    """Whether an effort is near nought at nearly each turn of a speed, and seldom in the motions around.

    None: the motion turns too fast, from one row to the next, to see the effort fall.
    """
    v, f = known_rows(speed, effort)
    size = np.abs(f)
    if size.size < FEW or not np.any(v):
        return False
    moving = np.flatnonzero(np.abs(v) > _FAST * np.abs(v).max())
    turns = np.flatnonzero(np.diff(np.sign(v[moving])) != 0)  # the last moving row before each
    if turns.size < _FEW_TURNS:
        return False  # such as a motor of one sense, whose speed is below 0 by its noise at rest
    seen = fallen = 0  # turns
    low = rows = 0  # in motion
    for turn, nxt in zip(turns, [*turns[1:], moving.size - 1], strict=True):
        before = moving[turn]
        after = moving[turn + 1]
        if after - before < _ROWS_OF_A_TURN:
            continue  # too few rows to see the effort fall
        forth = size[moving[max(turn - (nxt - turn), 0) : turn + 1]]
        back = size[moving[turn + 1 : nxt + 1]]
        around = min(np.median(forth), np.median(back))
        if around == 0.0:
            continue
        seen += 1
        fallen += bool(size[before : after + 1].min() <= _NOUGHT * around)
        low += np.count_nonzero(back <= _NOUGHT * around)
        rows += back.size
    if seen < _FEW_TURNS:
        return None
    return bool(fallen >= _NEARLY_ALL * seen and low <= _SELDOM * rows)
