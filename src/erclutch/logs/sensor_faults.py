"""Rows where a sensor did not measure are told apart: spikes, an effort at the end of its range, an effort that stuck.

Each is told by what only a fault does. A spike is one or two rows far beyond all others, with quiet rows on both sides:
a blow rings. A saturated effort is the same to the last digit whenever it is largest, in runs, far more often than
at any level beside it (the peak of a coarse sine is no end of a range), and comes near that end by many other values:
dry friction jumps there. A stuck effort keeps one value, met nowhere else, while the motion goes
on. Codes such as -999 are found by `erclutch.logs.sentinels`.

Faults of the logger show in several columns at once: a row that holds one number in all of them, far from the rows
beside it in two or more, and a stretch in which all of them stand still and then jump.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array, Mask

_JUMPS = 8.0  # times the 99 % quantile of a column's steps, by which two columns jump at once
_SHORT_DROP, _FROZEN = 20, 5  # rows of one number at most; rows that stand still at least

_FEWEST = 100  # rows, below which nothing is known of what is usual
_FEW = 0.0025  # share of the rows that may be spikes on either side
_BEYOND = 1.0  # ranges of all other rows, by which a spike is beyond them
_QUIET = np.array([-4, -3, 3, 4])  # rows beside a spike that are as usual
_SHORT = 2  # rows of a spike at most

_LEAST_SATURATED, _MOST_SATURATED = 0.005, 0.3  # shares of the rows
_RUN = 3.0  # rows that a saturated effort stays at the end, in the mean
_LEVELS = 64  # distinct values: fewer are levels, of which the last is one
_PILE, _BESIDE = 20, 5  # times the rows of any of so many levels beside the end
_NEAR, _APPROACHES = 0.1, 10  # of the range below the end; rows that are met there

_RUNS = 20  # of equal values, below which nothing is known of a usual one
_STUCK_ROWS, _STUCK, _MOVES = 50, 20.0, 0.2  # rows; times the longest usual run; of the range of the motion


def spikes(values: Array) -> Mask:
    """One or two rows at a time that lie beyond all others by more than their range, shape (n,)."""
    none = np.zeros(values.size, dtype=np.bool_)
    known = values[np.isfinite(values)]
    if known.size < _FEWEST:
        return none
    few = max(1, int(_FEW * known.size))
    ends = np.partition(known, (few, known.size - 1 - few))
    low, high = float(ends[few]), float(ends[known.size - 1 - few])
    reach = _BEYOND * (high - low)
    if reach <= 0.0:
        return none
    with np.errstate(invalid="ignore"):
        beyond = (values > high + reach) | (values < low - reach)
    for start, stop in _runs(beyond):
        beside = np.concatenate([start + _QUIET[:2], stop - 1 + _QUIET[2:]])
        inside = beside[(beside >= 0) & (beside < values.size)]
        quiet = bool(np.all((values[inside] >= low - 0.5 * reach) & (values[inside] <= high + 0.5 * reach)))
        if stop - start <= _SHORT and quiet and start > 0 and stop < values.size:
            none[start:stop] = True
    return none


def saturated(effort: Array) -> dict[float, Mask]:
    """Rows where an effort sits at an end of its sensor's range, by that end; shape (n,) each."""
    known = effort[np.isfinite(effort)]
    found: dict[float, Mask] = {}
    if known.size < _FEWEST or np.unique(known[: 20 * _LEVELS * _LEVELS]).size <= _LEVELS:
        return found
    low, high = float(known.min()), float(known.max())
    for end in (low, high):
        held = np.equal(effort, end)
        share = np.count_nonzero(held) / effort.size
        runs = _runs(held)
        with np.errstate(invalid="ignore"):
            near = np.count_nonzero((np.abs(effort - end) < _NEAR * (high - low)) & ~held)
        at_an_end = end != 0.0 and _LEAST_SATURATED < share < _MOST_SATURATED
        if at_an_end and np.count_nonzero(held) >= _RUN * len(runs) and near >= _APPROACHES and _piles_up(effort, end):
            found[end] = held
    return found


def _piles_up(effort: Array, end: float) -> bool:
    """Whether far more rows sit at an end than at any level beside it: a smooth peak has a few times more."""
    levels, rows = np.unique(effort[np.isfinite(effort)], return_counts=True)
    at = int(np.flatnonzero(levels == end)[0])
    beside = np.concatenate([rows[max(0, at - _BESIDE) : at], rows[at + 1 : at + 1 + _BESIDE]])
    return bool(rows[at] >= _PILE * beside.max())


def stuck(effort: Array, motion: Array) -> Mask:
    """Rows of the longest run in which an effort keeps a value hardly met elsewhere, while the motion goes on."""
    held = np.zeros(effort.size, dtype=np.bool_)
    cut = np.flatnonzero(np.concatenate(([True], np.diff(effort) != 0.0, [True])))
    lengths = np.diff(cut)
    if effort.size < _FEWEST or lengths.size < _RUNS:
        return held
    place = int(np.argmax(lengths))
    start, stop = int(cut[place]), int(cut[place + 1])
    if stop - start < max(_STUCK_ROWS, _STUCK * float(np.quantile(np.delete(lengths, place), 0.99, method="lower"))):
        return held
    elsewhere = int(np.count_nonzero(effort == effort[start])) - (stop - start)
    known = motion[np.isfinite(motion)]
    there = motion[start:stop][np.isfinite(motion[start:stop])]
    if not there.size:
        return held
    low, high = np.quantile(there, (0.1, 0.9))  # a motion that ends in the first rows does not go on
    moves = float(high - low) > _MOVES * float(np.ptp(known)) > 0.0
    held[start:stop] = moves and 10 * elsewhere < stop - start
    return held


def dropped(columns: Sequence[Array]) -> Mask:
    """Rows that hold one and the same number in all columns, where two or more jump there and back, shape (n,)."""
    rows = np.zeros(columns[0].size if columns else 0, dtype=np.bool_)
    if len(columns) < 2 or rows.size < _FEWEST:
        return rows
    alike = np.logical_and.reduce([np.equal(each, columns[0]) for each in columns[1:]])
    for start, stop in _runs(alike):
        inside = start > 0 and stop < rows.size and stop - start <= _SHORT_DROP
        if inside and min(_jumps(columns, start), _jumps(columns, stop)) >= 2:
            rows[start:stop] = True
    return rows


def frozen(columns: Sequence[Array]) -> Mask:
    """Rows that repeat the row before in all columns, in stretches that two enter in motion and one leaves by a jump.

    A device at rest stands still too; it comes to rest slowly and starts without a jump. The first row of a stretch was
    measured. Shape (n,).
    """
    rows = np.zeros(columns[0].size if columns else 0, dtype=np.bool_)
    if len(columns) < 2 or rows.size < _FEWEST:
        return rows
    still = np.zeros(rows.size, dtype=np.bool_)
    still[1:] = np.logical_and.reduce([np.equal(each[1:], each[:-1]) for each in columns])
    for start, stop in _runs(still):
        inside = start > 1 and stop < rows.size and stop - start >= _FROZEN
        arrived = inside and _moving(columns, start - 1) >= 2 and not _jumps(columns, start - 1)
        if arrived and _jumps(columns, stop):
            rows[start:stop] = True
    return rows


def _jumps(columns: Sequence[Array], row: int) -> int:
    """How many columns come to a row by far more than their usual step."""
    return sum(abs(each[row] - each[row - 1]) > _JUMPS * _usual_step(each) for each in columns)


def _moving(columns: Sequence[Array], row: int) -> int:
    """How many columns come to a row by no less than a tenth of their largest usual step, within ten rows."""
    before = slice(max(0, row - 10), row + 1)
    return sum(bool(np.ptp(each[before]) >= 0.1 * _usual_step(each)) for each in columns)


def _usual_step(values: Array) -> float:
    """The step that 1 % of all steps exceed, of those that are none; infinite for a column that keeps levels."""
    steps = np.abs(np.diff(values))
    moving = steps[steps > 0.0]
    return float(np.quantile(moving, 0.99)) if moving.size > 0.1 * steps.size else np.inf


def _runs(rows: Mask) -> list[tuple[int, int]]:
    """First row and the row behind the last of each run of marked rows."""
    edges: NDArray[np.int64] = np.flatnonzero(np.diff(np.concatenate(([False], rows, [False])).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
