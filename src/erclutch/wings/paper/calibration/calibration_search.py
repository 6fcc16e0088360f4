"""A calibration searches twice: wide (CMA-ES), then local: Levenberg-Marquardt for samples, rounds for figures.

Figures jitter, for a fit of other rows is another fit. So a round takes slopes over wide steps, tries steps of several
lengths side by side, and goes to the best.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import RunError, SettingError
from erclutch.fit.levenberg_marquardt import Linearisation, Problem, minimise
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
        problem, remedy = "the journal is of a calibration with other settings", "Delete the journal, or move it"
        raise RunError(problem, where=str(path), remedy=remedy)
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
    options = {"bounds": [0.0, 1.0], "popsize": _POPULATION, "seed": seed + 1, "verbose": -9, "verb_log": 0}
    strategy = cma.CMAEvolutionStrategy(start.tolist(), _FIRST_WIDTH, options)
    best, best_cost, done = start, np.inf, 0
    while done < evaluations:
        points = [np.asarray(p, np.float64) for p in strategy.ask()]
        costs = known.get(f"after {done}", lambda points=points: [_cost(r) for r in residuals(points)])
        strategy.tell(points, costs)
        done += len(points)
        if min(costs) < best_cost:
            best, best_cost = points[int(np.argmin(costs))], min(costs)
        progress(done, best_cost)
    return best, done


def _cost(r: Array) -> float:
    return float(r @ r) if np.all(np.isfinite(r)) else 1e9


def difference_quotients(residuals: Residuals, u: Array, step: float = STEP) -> Array:
    """Slopes of the residuals by central differences, one-sided at the ends of the range, shape (rows, k)."""
    highs = [np.clip(u + step * e, 0.0, 1.0) for e in np.eye(u.size)]
    lows = [np.clip(u - step * e, 0.0, 1.0) for e in np.eye(u.size)]
    values = residuals([*highs, *lows])
    widths = [float((h - low).sum()) for h, low in zip(highs, lows, strict=True)]
    pairs = zip(values[: u.size], values[u.size :], widths, strict=True)
    return np.column_stack([(high - low) / width for high, low, width in pairs])


def one_sided_quotients(residuals: Residuals, u: Array, step: float = STEP) -> Array:
    """Slopes by steps toward the middle of the range, shape (rows, k): half the price where slopes are rough anyway."""
    steps = np.where(u < 0.5, step, -step)
    here, *there = residuals([u, *(u + steps * e for e in np.eye(u.size))])
    return np.column_stack([(value - here) / width for value, width in zip(there, steps, strict=True)])


def local(residuals: Residuals, start: Array, progress: SearchProgress) -> tuple[Array, int]:
    """Levenberg-Marquardt in the unit cube with slopes by differences, for residuals that are smooth.

    Returns:
        The point found and how many were evaluated.
    """
    counted = Counted(residuals, progress)

    def linearise(u: Array) -> Linearisation:
        r = counted([u])[0]
        q, triangle = np.linalg.qr(difference_quotients(counted, u, NARROW))
        return Linearisation(_cost(r), triangle, -(q.T @ r))

    problem = Problem(lambda u: _cost(counted([u])[0]), linearise, np.zeros(start.size), np.ones(start.size))
    return minimise(problem, start, tolerance=1e-6, max_iterations=30, reach=0.3).point, counted.done


def in_rounds(residuals: Residuals, start: Array, rounds: int, progress: SearchProgress) -> tuple[Array, int]:
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
    best, r = start, counted([start])[0]
    for _ in range(rounds):
        slopes = one_sided_quotients(counted, best)
        least, most = np.maximum(-best, -_FARTHEST), np.minimum(1.0 - best, _FARTHEST)
        tried: list[Array] = []
        for damping in _DAMPINGS:
            stacked = np.vstack([slopes, np.sqrt(damping) * np.eye(best.size)])
            wanted = np.concatenate([-r, np.zeros(best.size)])
            step = lsq_linear(stacked, wanted, (least - 1e-9, most + 1e-9)).x
            tried.append(np.clip(best + step, 0.0, 1.0))
        found = counted(tried)
        k = int(np.argmin([_cost(each) for each in found]))
        if not _cost(found[k]) < _cost(r):
            break
        best, r = tried[k], found[k]
    return best, counted.done


class Counted:
    """Residuals that tell how many points were evaluated so far, and the best cost.

    Attributes:
        done: points evaluated.
    """

    def __init__(self, residuals: Residuals, progress: SearchProgress) -> None:
        self.done = 0
        self._best = np.inf
        self._residuals, self._progress = residuals, progress

    def __call__(self, points: Sequence[Array]) -> list[Array]:
        """Residuals at several points."""
        found: list[Array] = []
        for first in range(0, len(points), _TOLD):
            more = self._residuals(points[first : first + _TOLD])
            self.done += len(more)
            self._best = min([self._best, *map(_cost, more)])
            self._progress(self.done, self._best)
            found += more
        return found
