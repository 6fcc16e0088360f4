"""Faults of sensors and loggers are told by what only a fault does; `FAULTS` lists what is looked for.

A spike is one or two rows far beyond all others, with quiet rows on both sides: a blow rings. A saturated effort is the
same to the last digit whenever it is largest, in runs, far more often than at any level beside it (the peak of a coarse
sine is no end of a range), and comes near that end by many other values: dry friction jumps there. A stuck effort keeps
one value, met nowhere else, while the motion goes on.

Faults of the logger show in several columns at once: a row that holds one number in all of them, far from the rows
beside it in two or more, and a stretch in which all of them stand still and then jump.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from erclutch.signals.array import Array, Mask
from erclutch.signals.clock import stretches

#: Rows, below which nothing is known of what is usual.
_FEWEST = 100

#: Share of the rows that may be spikes on either side.
_FEW_SPIKES = 0.0025
#: Ranges of all other rows, by which a spike is beyond them.
_BEYOND = 1.0
#: Rows of a spike at most.
_LONGEST_SPIKE = 2
#: How many rows from a spike, on either side, rows are as usual: a blow goes up and down over several rows.
_BESIDE_SPIKE = (1, 3, 4)

#: Shares of the rows that a saturated effort stands at the end of its range.
_LEAST_SATURATED, _MOST_SATURATED = 0.005, 0.3
#: Rows that it stays there, in the mean.
_STAYS = 3.0
#: Distinct values: fewer are levels, of which the last is one.
_LEVELS = 64
#: Times the rows of any level beside the end, and how many such levels are looked at.
_PILE, _LEVELS_BESIDE = 20, 5
#: Share of the range below the end, and rows that are met there.
_NEAR, _APPROACHES = 0.1, 10

#: Runs of equal values, below which nothing is known of a usual run.
_FEWEST_RUNS = 20
#: Rows that an effort keeps its value where it may be stuck.
_STUCK_ROWS = 50
#: How many times longer that is than it usually keeps a value.
_STUCK_RUN = 20.0
#: Share of its range by which the motion goes on meanwhile.
_MOVES = 0.2

#: Times the usual largest step of a column, by which several columns jump at once.
_JUMPS = 8.0
#: Rows at most that hold one number in all columns.
_LONGEST_DROP = 20
#: Rows at least in which all columns stand still.
_SHORTEST_FREEZE = 5


@dataclass(frozen=True)
class Measured:
    """What the columns of a plan's signals hold.

    Attributes:
        columns: signal -> name of its column.
        values: name of a column -> samples, shape (n,); NaN in rows that are known to hold no measurement of it.
        motion: samples of the slip, or of the position, as logged, shape (n,); None where a plan has neither.
    """

    columns: Mapping[str, str]
    values: dict[str, Array]
    motion: Array | None


class SeenFault(NamedTuple):
    """One fault: in which columns, what they do as the rest of a sentence, and in which rows, shape (n,)."""

    columns: Sequence[str]
    what: str
    rows: Mask


def rows_lost_by_the_logger(measured: Measured) -> Iterator[SeenFault]:
    """One number in all columns, where two or more jump there and back."""
    columns = [*measured.values.values()]
    rows = dropped(columns)
    if rows.any():
        number = columns[0][np.argmax(rows)]
        yield SeenFault([*measured.values], f"all hold {number:.6g} and jump there and back", rows)


def rows_repeated_by_the_logger(measured: Measured) -> Iterator[SeenFault]:
    """All columns as in the row before, until they jump."""
    rows = frozen([*measured.values.values()])
    if rows.any():
        what = "stand still together and then jump, as where the logger repeats a row"
        yield SeenFault([*measured.values], what, rows)


def spikes_of_a_sensor(measured: Measured) -> Iterator[SeenFault]:
    """One or two rows of the slip or the effort far beyond all others."""
    for signal in ("slip", "effort", "T"):
        if signal in measured.columns:
            name = measured.columns[signal]
            values = measured.values[name]
            rows = spikes(values)
            if rows.any():
                yield SeenFault(
                    [name], f"has spikes (up to {np.abs(values[rows]).max():.4g})", rows
                )


def efforts_held_by_a_sensor(measured: Measured) -> Iterator[SeenFault]:
    """An effort at an end of its sensor's range; or, where it never is, one that is stuck."""
    for signal in ("effort", "T"):
        if signal not in measured.columns:
            continue
        name = measured.columns[signal]
        values = measured.values[name]
        ends = saturated(values)
        for end, rows in ends.items():
            yield SeenFault([name], f"sits at an end of its sensor's range ({end:.6g})", rows)
        if measured.motion is None or ends:
            continue
        rows = stuck(values, measured.motion)
        if rows.any():
            motion = measured.columns.get("slip") or measured.columns["position"]
            what = f"is stuck at {values[np.argmax(rows)]:.6g} while column {motion} moves"
            yield SeenFault([name], what, rows)


class Fault(NamedTuple):
    """One rule: the fault in a word, and the function that finds it in what was measured."""

    called: str
    rule: Callable[[Measured], Iterator[SeenFault]]


#: All faults that are looked for, in their order; each rule is given what the rules before have left.
FAULTS = (
    Fault("rows that the logger lost", rows_lost_by_the_logger),
    Fault("rows that the logger repeated", rows_repeated_by_the_logger),
    Fault("spikes", spikes_of_a_sensor),
    Fault("efforts at the end of a range, and stuck efforts", efforts_held_by_a_sensor),
)


def spikes(values: Array) -> Mask:
    """One or two rows at a time that lie beyond all others by more than their range, shape (n,)."""
    marked = np.zeros(values.size, dtype=np.bool_)
    known = values[np.isfinite(values)]
    if known.size < _FEWEST:
        return marked
    few = max(1, int(_FEW_SPIKES * known.size))
    many = known.size - 1 - few
    ordered = np.partition(known, (few, many))
    low = float(ordered[few])
    high = float(ordered[many])
    reach = _BEYOND * (high - low)
    if reach <= 0.0:
        return marked

    with np.errstate(invalid="ignore"):
        beyond = (values > high + reach) | (values < low - reach)
    for start, stop in stretches(beyond):
        short = stop - start <= _LONGEST_SPIKE
        if not short or start == 0 or stop == values.size:
            continue
        before = [start - rows for rows in _BESIDE_SPIKE]
        after = [stop - 1 + rows for rows in _BESIDE_SPIKE]
        beside = values[[row for row in (*before, *after) if 0 <= row < values.size]]
        if np.all((beside >= low - 0.5 * reach) & (beside <= high + 0.5 * reach)):
            marked[start:stop] = True
    return marked


def saturated(effort: Array) -> dict[float, Mask]:
    """Rows where an effort sits at an end of its sensor's range, by that end; shape (n,) each."""
    known = effort[np.isfinite(effort)]
    ends: dict[float, Mask] = {}
    if known.size < _FEWEST:
        return ends
    # To look at so many rows is enough: a column of few levels shows that soon.
    if np.unique(known[: 20 * _LEVELS * _LEVELS]).size <= _LEVELS:
        return ends

    low = float(known.min())
    high = float(known.max())
    for end in (low, high):
        at_end = np.equal(effort, end)
        count = np.count_nonzero(at_end)
        if end == 0.0 or not _LEAST_SATURATED < count / effort.size < _MOST_SATURATED:
            continue
        if count < _STAYS * len(stretches(at_end)):
            continue
        with np.errstate(invalid="ignore"):
            near = (np.abs(effort - end) < _NEAR * (high - low)) & ~at_end
        if np.count_nonzero(near) < _APPROACHES:
            continue
        # Far more rows sit there than at any level beside it; a smooth peak has a few times more.
        levels, rows = np.unique(known, return_counts=True)
        at = int(np.flatnonzero(levels == end)[0])
        before = rows[max(0, at - _LEVELS_BESIDE) : at]
        after = rows[at + 1 : at + 1 + _LEVELS_BESIDE]
        if rows[at] >= _PILE * np.concatenate([before, after]).max():
            ends[end] = at_end
    return ends


def stuck(effort: Array, motion: Array) -> Mask:
    """Rows of the longest run in which an effort keeps a value hardly met elsewhere, while the motion goes on."""
    marked = np.zeros(effort.size, dtype=np.bool_)
    changes = np.concatenate(([True], np.diff(effort) != 0.0, [True]))
    edges = np.flatnonzero(changes)
    lengths = np.diff(edges)
    if effort.size < _FEWEST or lengths.size < _FEWEST_RUNS:
        return marked

    longest = int(np.argmax(lengths))
    start = int(edges[longest])
    stop = int(edges[longest + 1])
    count = stop - start
    usual = float(np.quantile(np.delete(lengths, longest), 0.99, method="lower"))
    if count < max(_STUCK_ROWS, _STUCK_RUN * usual):
        return marked

    known = motion[np.isfinite(motion)]
    meanwhile = motion[start:stop]
    meanwhile = meanwhile[np.isfinite(meanwhile)]
    if not meanwhile.size:
        return marked
    # A motion that ends in the first rows does not go on.
    low, high = np.quantile(meanwhile, (0.1, 0.9))
    moves = float(high - low) > _MOVES * float(np.ptp(known)) > 0.0
    elsewhere = int(np.count_nonzero(effort == effort[start])) - count
    marked[start:stop] = moves and 10 * elsewhere < count
    return marked


def dropped(columns: Sequence[Array]) -> Mask:
    """Rows that hold one and the same number in all columns, where two or more jump there and back, shape (n,)."""
    marked = np.zeros(columns[0].size if columns else 0, dtype=np.bool_)
    if len(columns) < 2 or marked.size < _FEWEST:
        return marked
    first, *others = columns
    alike = np.logical_and.reduce([np.equal(other, first) for other in others])
    for start, stop in stretches(alike):
        inside = start > 0 and stop < marked.size
        if not inside or stop - start > _LONGEST_DROP:
            continue
        if _jumps(columns, start) >= 2 and _jumps(columns, stop) >= 2:
            marked[start:stop] = True
    return marked


def frozen(columns: Sequence[Array]) -> Mask:
    """Rows that repeat the row before in all columns, in stretches that two enter in motion and one leaves by a jump.

    A device at rest stands still too; it comes to rest slowly and starts without a jump. The first row of a stretch was
    measured. Shape (n,).
    """
    marked = np.zeros(columns[0].size if columns else 0, dtype=np.bool_)
    if len(columns) < 2 or marked.size < _FEWEST:
        return marked
    still = np.zeros(marked.size, dtype=np.bool_)
    repeats = [np.equal(column[1:], column[:-1]) for column in columns]
    still[1:] = np.logical_and.reduce(repeats)
    for start, stop in stretches(still):
        inside = start > 1 and stop < marked.size
        if not inside or stop - start < _SHORTEST_FREEZE:
            continue
        last_measured = start - 1
        before = slice(max(0, last_measured - 10), start)
        moving = 0  # columns that move by no less than a tenth of their largest usual step, within ten rows
        for column in columns:
            moving += bool(np.ptp(column[before]) >= 0.1 * _usual_step(column))
        comes_in_motion = moving >= 2 and not _jumps(columns, last_measured)
        if comes_in_motion and _jumps(columns, stop):
            marked[start:stop] = True
    return marked


def _jumps(columns: Sequence[Array], row: int) -> int:
    """How many columns come to a row by far more than their usual step."""
    jumps = 0
    for column in columns:
        step = abs(column[row] - column[row - 1])
        jumps += bool(step > _JUMPS * _usual_step(column))
    return jumps


def _usual_step(values: Array) -> float:
    """The step that 1 % of all steps exceed, of those that are none; infinite for a column that keeps levels."""
    steps = np.abs(np.diff(values))
    moving = steps[steps > 0.0]
    if moving.size <= 0.1 * steps.size:
        return np.inf
    return float(np.quantile(moving, 0.99))
