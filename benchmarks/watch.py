"""A CPU clock that stands still while the benchmark scores a contender, and the trace that it leaves."""

from __future__ import annotations

import resource
import sys
from collections.abc import Callable
from time import perf_counter, process_time

import numpy as np
from numpy.typing import NDArray
from rows import Split

Array = NDArray[np.float64]
#: Effort of a split's rows, in the data's unit.
Predict = Callable[[Split], Array]

_APART = 1.05  # a point of the trace comes at least this factor after the one before


class OutOfTimeError(Exception):
    """A contender has used up its CPU time."""


class Watch:
    """CPU seconds of a contender and its test error over them.

    Attributes:
        limit: CPU seconds that a contender gets.
        points: (CPU seconds, test MSE), in time order.
        latest: how the contender predicted when last seen.
        best_cost: lowest training cost told to `better`.
        recorded: whether the contender was timed fit by fit, by `record`.
    """

    def __init__(self, test: Split, limit: float) -> None:
        self.limit = limit
        self.points: list[tuple[float, float]] = []
        self.latest: Predict | None = None
        self.best_cost = float("inf")
        self.recorded = False
        self._test = test
        self._cpu = self._wall = 0.0
        self.start()

    def start(self) -> None:
        """(Re)start the clock."""
        self._since, self._wall_since = process_time(), perf_counter()

    def stop(self) -> float:
        """Stop the clock; CPU seconds so far."""
        self._cpu += process_time() - self._since
        self._wall += perf_counter() - self._wall_since
        return self._cpu

    def seconds(self) -> float:
        """CPU seconds so far, of a running clock."""
        return self._cpu + process_time() - self._since

    @property
    def wall(self) -> float:
        """Wall seconds up to the last stop."""
        return self._wall

    def look(self, predict: Predict) -> None:
        """Score the contender as it stands, where enough time has passed since the last point.

        Raises:
            OutOfTimeError: the limit is reached.
        """
        now = self.stop()
        self.latest = predict
        if not self.points or now >= _APART * self.points[-1][0] + 0.01:
            self.points.append((now, mse(predict, self._test)))
        if now > self.limit:
            raise OutOfTimeError
        self.start()

    def better(self, cost: float) -> bool:
        """Whether a training cost is the lowest yet; for contenders that only show their trials."""
        lower = cost < self.best_cost
        self.best_cost = min(cost, self.best_cost)
        return lower

    def record(self, cpu: float, wall: float, predict: Predict) -> None:
        """A point of a fit that cannot be looked into: each is a fresh fit, with its own seconds. Clock stopped."""
        self._cpu, self._wall, self.latest, self.recorded = cpu, wall, predict, True
        self.points.append((cpu, mse(predict, self._test)))

    def finish(self, predict: Predict) -> None:
        """Last point of the trace. Clock stopped."""
        self.latest = predict
        self.points.append((self._cpu, mse(predict, self._test)))


def mse(predict: Predict, split: Split) -> float:
    """Mean squared error, in the effort's unit squared."""
    with np.errstate(all="ignore"):
        return float(np.mean((split.data.effort - predict(split)) ** 2))


def peak_megabytes() -> float:
    """Largest resident memory of this process so far."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)
