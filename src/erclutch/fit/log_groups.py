"""Logs are grouped by field and by motion, so that whole fields and whole motions can be left out of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import constant_stretches
from erclutch.signals.array import Array, largest_size

#: Two logs have the same motion if slip and its rate differ by less than this factor, root mean square.
ALIKE = 1.25
#: Fields or motions from which on whole ones are left out of a fit.
FEWEST_GROUPS = 3
#: Of the largest field: a field that moves by less over a log is one field.
STEADY = 0.01


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
    return LogGroups(logs, field=_fields(data, logs), motion=_motions(data, logs))


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


def _fields(data: Dataset, logs: Sequence[tuple[int, int]]) -> list[int]:
    """Number of the field of each log, from the lowest; all 0 where a field changes within a log."""
    fields = [element.field for element in data.elements]
    largest = max(largest_size(field) for field in fields)
    steady = STEADY * largest
    levels: list[tuple[int, ...]] = []  # of each log, the mean field of each element in steps
    for start, stop in logs:
        if any(np.ptp(field[start:stop]) > steady for field in fields):
            return [0] * len(logs)
        means = [float(np.mean(field[start:stop])) for field in fields]
        levels.append(tuple(round(mean / (steady or 1.0)) for mean in means))
    ascending = sorted(set(levels))
    return [ascending.index(level) for level in levels]


def _motions(data: Dataset, logs: Sequence[tuple[int, int]]) -> list[int]:
    """Number of the motion of each log, in the order in which motions come."""
    known: list[Array] = []
    numbers: list[int] = []
    for start, stop in logs:
        own = np.array(motion_of(data, slice(start, stop)))
        number = len(known)
        for k, other in enumerate(known):
            if np.all(np.abs(other - own) < np.log(ALIKE)):
                number = k
                break
        else:
            known.append(own)
        numbers.append(number)
    return numbers


def motion_of(data: Dataset, log: slice) -> list[float]:
    """Logarithms of the root mean squares of each slip and of its rate."""
    steps = np.diff(data.clock.time[log])
    sizes: list[float] = []
    for element in data.elements:
        slip = element.slip[log]
        later = steps > 0
        rate = np.diff(slip)[later] / steps[later]
        for signal in (slip, rate):
            if signal.size:
                rms = np.sqrt(np.mean(signal**2))
                sizes.append(float(np.log(rms + 1e-150)))  # of a signal that is zero throughout
    return sizes
