"""Logs are grouped by field and by motion, so that whole fields and whole motions can be left out of a fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import constant_stretches
from erclutch.signals.array import Array, largest_size, rms

#: Two logs have the same motion if slip and its rate differ by less than this factor, root mean square.
ALIKE = 1.25
#: Fields or motions from which on whole ones are left out of a fit.
FEWEST_GROUPS = 3
#: Of the largest field: a field that moves by less over a log is one field.
STEADY = 0.01
#: Mean squared change of a sine while its phase turns by 1 rad, over its variance.
_ONE_RADIAN = 2.0 * (1.0 - math.cos(1.0))
#: Of the times over which changes are looked at: each is so many times the one before.
_LONGER = 1.25
#: Changes that are enough for a mean square; of more, every so many one is used.
_MOST_CHANGES = 20_000


@dataclass(frozen=True)
class LogGroups:
    """Logs, or the stretches of one log that was taken at one field after another.

    Attributes:
        rows: start and stop of each.
        field: number of the field of each, from the lowest; all 0 where fields change within them.
        motion: number of the motion of each, in the order in which they come.
    """

    rows: Sequence[tuple[int, int]]
    field: Sequence[int]
    motion: Sequence[int]

    def log_of_row(self, rows: int) -> NDArray[np.intp]:
        """Number of the log of each of so many rows, shape (rows,)."""
        ends = np.array([stop for _, stop in self.rows])
        return np.digitize(np.arange(rows), ends)


def groups_of(data: Dataset) -> LogGroups:
    """The logs of some rows by field and motion; logs without rows are left out."""
    logs = [(start, stop) for start, stop in data.source_rows if stop > start]
    if len(logs) == 1:
        start, stop = logs[0]
        logs = constant_stretches(data, start, stop) or logs

    # Fields, in steps that are too small to tell two of them apart.
    fields = [element.field for element in data.elements]
    largest = max(largest_size(field) for field in fields)
    steady = STEADY * largest
    changing = False  # within a log
    levels: list[tuple[int, ...]] = []  # of each log, the mean field of each element in steps
    for start, stop in logs:
        changing = changing or any(np.ptp(field[start:stop]) > steady for field in fields)
        means = [float(np.mean(field[start:stop])) for field in fields]
        levels.append(tuple(round(mean / (steady or 1.0)) for mean in means))
    ascending = sorted(set(levels))
    field_of_log = [0 if changing else ascending.index(level) for level in levels]

    # Motions: each is that of the first log that is like it.
    known: list[Array] = []
    motion_of_log: list[int] = []
    for start, stop in logs:
        own = np.array(motion_of(data, slice(start, stop)))
        number = len(known)
        for k, other in enumerate(known):
            if np.all(np.abs(other - own) < np.log(ALIKE)):
                number = k
                break
        else:
            known.append(own)
        motion_of_log.append(number)
    return LogGroups(logs, field_of_log, motion_of_log)


def chessboard(logs: LogGroups) -> list[int]:
    """A number for each log, so that the odd ones have all fields and all motions, and so have the even ones.

    Logs of one field and one motion go to either side in turn.
    """
    met: dict[tuple[int, int], int] = {}
    numbers: list[int] = []
    for square in zip(logs.field, logs.motion, strict=True):
        numbers.append(sum(square) + met.get(square, 0))
        met[square] = met.get(square, 0) + 1
    return numbers


def quantile_over_logs(size: Array, log: NDArray[np.intp], share: float) -> float:
    """The magnitude that a share of the errors does not exceed, if each log counts the same."""
    _, number, rows = np.unique(log, return_inverse=True, return_counts=True)
    order = np.argsort(size)
    counted = np.cumsum(1.0 / rows[number[order]])
    ascending: list[float] = np.sort(size).tolist()
    at = np.searchsorted(counted, share * float(counted[-1]))
    return ascending[min(int(at), size.size - 1)]


def motion_of(data: Dataset, log: slice) -> list[float]:
    """Logarithms of the root mean squares of each slip and of its rate."""
    sizes: list[float] = []
    for element in data.elements:
        slip = element.slip[log]
        if slip.size:
            for size in (rms(slip), rate_of(slip, data.clock.time[log])):
                sizes.append(float(np.log(size + 1e-150)))  # of a signal that is zero throughout
    return sizes


def rate_of(slip: Array, time: Array) -> float:
    """Root mean square of the rate of a slip, per second, as a sine has it that turns as quickly.

    From one row to the next a sensor's noise may change more than the slip. So the time is sought over which the slip
    changes as much as a sine does while its phase turns by 1 rad: by then noise counts no more than in the slip itself.

    Args:
        slip: of a log, shape (n,).
        time: of its rows in s, shape (n,).
    """
    steps = np.diff(time)
    later = steps[steps > 0.0]
    spread = float(np.std(slip))
    if later.size == 0 or not spread > 0.0:
        return 0.0
    wanted = _ONE_RADIAN * spread**2
    before = changed_before = 0.0
    behind = 1  # rows
    while True:
        every = 1 + (slip.size - behind) // _MOST_CHANGES
        change = slip[behind::every] - slip[:-behind:every]
        changed = float(np.mean(change**2))
        longest = behind >= slip.size // 2
        if changed >= wanted or longest:
            break
        before, changed_before = behind, changed
        behind = min(max(behind + 1, int(_LONGER * behind)), slip.size // 2)

    # Between two times the mean squared change grows evenly.
    if changed > wanted:
        behind = before + (wanted - changed_before) / (changed - changed_before) * (behind - before)
    return spread / (behind * float(np.median(later)))
