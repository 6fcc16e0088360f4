"""A calibration searches twice: wide (CMA-ES), then local: Levenberg-Marquardt for samples, rounds for figures.

Figures jitter, for a fit of other rows is another fit. So a round takes slopes over wide steps, tries steps of several
lengths side by side, and goes to the best.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import RunError, SettingError
from erclutch.fit.solver.levenberg_marquardt import Linearisation, Problem, minimise
from erclutch.signals.array import Array
from erclutch.wings.paper.sweep_points import Points

Residuals = Callable[[Sequence[Array]], list[Array]]
#: Called with the evaluations done and the best sum of squares so far.
SearchProgress = Callable[[int, float], None]

_TOLD = 8  # evaluations after which progress is told
_DAMPINGS = (0.0, 50.0, 200.0, 1000.0)  # of a round's steps; the prior's is 16
_FARTHEST = 0.25  # of a round's step in one parameter, as a share of the range
STEP = 0.04  # of a difference quotient, as a share of the range: wider than the jitter of figures
NARROW = 0.25 * STEP  # of residuals that are smooth
_POPULATION = 16
_FIRST_WIDTH = 0.08  # standard deviation of the first generation, as a share of the range


def journal_of(path: Path | None, settings: Mapping[str, Any]) -> Points:
    """What a search has evaluated so far; empty without a path.

    Raises:
        RunError: the journal is of another search, or cannot be read.
    """
    known = Points(path, {**settings, "population": _POPULATION}, "journal of a calibration")
    if known.others:
        raise RunError(
            "the journal is of a calibration with other settings",
            where=str(path),
            remedy="Delete the journal, or move it",
        )
    return known


def wide(
    residuals: Residuals,
    start: Array,
    seed: int,
    evaluations: int,
    known: Points,
    progress: SearchProgress,
) -> tuple[Array, int]:
    """Covariance matrix adaptation (CMA-ES) over the unit cube; resumes from the costs that are known.

    Returns:
        The best point evaluated and how many were.

    Raises:
        SettingError: the package cma is missing.
        RunError: the journal cannot be written.
    """
    try:
        import cma
    except ImportError as error:
        raise SettingError(
            "the wide search needs the package cma", remedy='Run: pip install "erclutch[calibrate]"'
        ) from error
    options = {
        "bounds": [0.0, 1.0],
        "popsize": _POPULATION,
        "seed": seed + 1,  # cma takes a seed of 0 for the clock
        "verbose": -9,
        "verb_log": 0,
    }
    strategy = cma.CMAEvolutionStrategy(start.tolist(), _FIRST_WIDTH, options)

    def costs_at(points: Sequence[Array]) -> list[float]:
        return [_cost(residual) for residual in residuals(points)]

    best = start
    best_cost = np.inf
    done = 0
    while done < evaluations:
        # The strategy draws the same points again, so what was interrupted needs their costs alone.
        generation = [np.asarray(point, np.float64) for point in strategy.ask()]
        costs = known.get(f"after {done}", partial(costs_at, generation))
        strategy.tell(generation, costs)
        done += len(generation)
        lowest = int(np.argmin(costs))
        if costs[lowest] < best_cost:
            best = generation[lowest]
            best_cost = costs[lowest]
        progress(done, best_cost)
    return best, done


def _cost(residual: Array) -> float:
    """The sum of squares; a rig that cannot be simulated costs more than any other."""
    if not np.all(np.isfinite(residual)):
        return 1e9
    return float(residual @ residual)


def difference_quotients(residuals: Residuals, u: Array, step: float = STEP) -> Array:
    """Slopes of the residuals by central differences, one-sided at the ends of the range, shape (rows, k)."""
    highs = [np.clip(u + step * axis, 0.0, 1.0) for axis in np.eye(u.size)]
    lows = [np.clip(u - step * axis, 0.0, 1.0) for axis in np.eye(u.size)]
    values = residuals([*highs, *lows])
    at_highs = values[: u.size]
    at_lows = values[u.size :]
    slopes: list[Array] = []
    for high, low, at_high, at_low in zip(highs, lows, at_highs, at_lows, strict=True):
        width = float((high - low).sum())  # the two differ in one coordinate
        slopes.append((at_high - at_low) / width)
    return np.column_stack(slopes)


def one_sided_quotients(residuals: Residuals, u: Array) -> Array:
    """Slopes by steps toward the middle of the range, shape (rows, k): half the price where slopes are rough anyway."""
    steps = np.where(u < 0.5, STEP, -STEP)
    neighbours = [u + steps * axis for axis in np.eye(u.size)]
    here, *there = residuals([u, *neighbours])
    pairs = zip(there, steps, strict=True)
    slopes = [(residual - here) / width for residual, width in pairs]
    return np.column_stack(slopes)


def local(residuals: Residuals, start: Array, progress: SearchProgress) -> tuple[Array, int]:
    """Levenberg-Marquardt in the unit cube with slopes by differences, for residuals that are smooth.

    Returns:
        The point found and how many were evaluated.
    """
    counted = Counted(residuals, progress)

    def cost(u: Array) -> float:
        (residual,) = counted([u])
        return _cost(residual)

    def linearise(u: Array) -> Linearisation:
        (residual,) = counted([u])
        slopes = difference_quotients(counted, u, NARROW)
        q, triangle = np.linalg.qr(slopes)
        return Linearisation(_cost(residual), triangle, -(q.T @ residual))

    lower = np.zeros(start.size)
    upper = np.ones(start.size)
    problem = Problem(cost, linearise, lower, upper)
    outcome = minimise(problem, start, tolerance=1e-6, max_iterations=30, reach=0.3)
    return outcome.point, counted.done


def in_rounds(
    residuals: Residuals,
    start: Array,
    rounds: int,
    progress: SearchProgress,
) -> tuple[Array, int]:
    """Damped steps of several lengths in each round, in the unit cube, for figures that jitter.

    Args:
        residuals: at several points.
        start: where it begins.
        rounds: at most; it ends with a round that finds nothing better.
        progress: called with the evaluations done and the best cost.

    Returns:
        The best point and how many were evaluated.
    """
    from scipy.optimize import lsq_linear

    counted = Counted(residuals, progress)
    best = start
    (residual,) = counted([start])
    for _ in range(rounds):
        slopes = one_sided_quotients(counted, best)
        # A step stays in the cube, and is no longer than the slopes are worth.
        lower = np.maximum(-best, -_FARTHEST)
        upper = np.minimum(1.0 - best, _FARTHEST)
        tried: list[Array] = []
        for damping in _DAMPINGS:
            damped = np.sqrt(damping) * np.eye(best.size)
            stacked = np.vstack([slopes, damped])
            wanted = np.concatenate([-residual, np.zeros(best.size)])
            step = lsq_linear(stacked, wanted, (lower - 1e-9, upper + 1e-9)).x
            tried.append(np.clip(best + step, 0.0, 1.0))
        residuals_of_tried = counted(tried)
        costs = [_cost(each) for each in residuals_of_tried]
        lowest = int(np.argmin(costs))
        if not costs[lowest] < _cost(residual):
            break
        best = tried[lowest]
        residual = residuals_of_tried[lowest]
    return best, counted.done


class Counted:
    """Residuals that tell how many points were evaluated so far, and the best cost.

    Attributes:
        done: points evaluated.
    """

    def __init__(self, residuals: Residuals, progress: SearchProgress) -> None:
        self.done = 0
        self._best = np.inf
        self._residuals = residuals
        self._progress = progress

    def __call__(self, points: Sequence[Array]) -> list[Array]:
        """Residuals at several points."""
        evaluated: list[Array] = []
        for first in range(0, len(points), _TOLD):
            some = self._residuals(points[first : first + _TOLD])
            self.done += len(some)
            self._best = min([self._best, *map(_cost, some)])
            self._progress(self.done, self._best)
            evaluated += some
        return evaluated
