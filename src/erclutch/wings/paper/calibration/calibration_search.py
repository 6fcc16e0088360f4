"""A calibration searches twice: wide (CMA-ES), then local (Levenberg-Marquardt).

Figures jitter, for a fit of other rows is another fit. Their slopes are quotients over wide steps.
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


def difference_quotients(residuals: Residuals, u: Array, step: float = NARROW) -> Array:
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


def local(
    residuals: Residuals,
    slopes: Callable[[Residuals, Array], Array],
    start: Array,
    rounds: int,
    progress: SearchProgress,
) -> tuple[Array, int]:
    """Levenberg-Marquardt in the unit cube.

    Args:
        residuals: at several points.
        slopes: of the residuals at a point, shape (rows, k).
        start: where it begins.
        rounds: steps tried at most.
        progress: called with the evaluations done and the best cost.

    Returns:
        The point found and how many were evaluated.
    """
    count, best = 0, np.inf

    def counted(points: Sequence[Array]) -> list[Array]:
        nonlocal count, best
        found: list[Array] = []
        for first in range(0, len(points), _TOLD):
            found += residuals(points[first : first + _TOLD])
            best = min([best, *(_cost(r) for r in found)])
            count += len(found) - first
            progress(count, best)
        return found

    def linearise(u: Array) -> Linearisation:
        r = counted([u])[0]
        q, triangle = np.linalg.qr(slopes(counted, u))
        return Linearisation(_cost(r), triangle, -(q.T @ r))

    problem = Problem(lambda u: _cost(counted([u])[0]), linearise, np.zeros(start.size), np.ones(start.size))
    return minimise(problem, start, tolerance=1e-6, max_iterations=rounds, reach=0.3).point, count
