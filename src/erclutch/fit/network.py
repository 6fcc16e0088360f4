"""Fitting an FNN: Levenberg-Marquardt over all weights, many starts, coarse to fine on compressed rows.

A step is that of Levenberg-Marquardt plus its geodesic acceleration (Transtrum and Sethna 2012, arXiv:1201.5885),
which follows the narrow curved valleys of a network's cost: half as many steps, and better minima. Damping is by mu
times the diagonal of J'J with a floor; it grows and falls after Nielsen (1999), but falls more slowly. Starts run on
the coarsest grid, the worse of them are dropped at each halving, the best one goes on to finer grids, and to all rows
if asked. Deterministic for a seed, whatever the number of threads: a start's arithmetic does not depend on its
neighbours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.backprop import Point, Rows
from erclutch.fit.compress import Centroids, compress
from erclutch.fit.first_weights import Slips, first_weights, with_best_output
from erclutch.fit.lm import Stop

Array = NDArray[np.float64]
_FALLING = 1e-6  # relative fall of the cost that counts as progress
_PRECISION: dict[Any, float] = {np.float32: 1e-6, np.float64: 1e-12}  # falls of the cost that rounding hides
_PATIENCE = 3  # steps without progress before it counts as converged
_LEAST_DAMPING, _FIRST_DAMPING, _MOST_TRIES = 1e-14, 1e-3, 20
_SLOWLY = 0.65  # of the damping that a good step leaves at least: a refused one costs half as much as a good one
_FLOOR = 1e-2  # of the damping's scale, over the largest diagonal element: weights that hardly matter do not run away
_MANY = 50_000  # rows above which the last steps on all of them are in single precision too
_MOST_BENT = 0.75  # twice the acceleration over the step


@dataclass(frozen=True)
class Schedule:
    """How much work a fit does.

    Attributes:
        starts: number of random starts.
        rounds: (level of compression, most steps, starts kept) of each round.
        polish: most steps on all rows; 0 for none.
    """

    starts: int
    rounds: tuple[tuple[int, int, int], ...]
    polish: int = 0

    @property
    def levels(self) -> set[int]:
        """Levels of compression that its rounds need."""
        return {level for level, _, _ in self.rounds}


def schedule_for(hidden: Sequence[int], polish: bool = False) -> Schedule:
    """Small networks have more bad minima and cost less a start, so they get more starts."""
    if sum(hidden) <= 8:
        return Schedule(24, ((0, 20, 10), (0, 40, 6), (1, 40, 3), (2, 40, 1)), 20 if polish else 0)
    if polish:
        return Schedule(12, ((0, 20, 6), (0, 40, 3), (1, 80, 2), (2, 100, 1)), 10)
    if len(hidden) > 1:
        return Schedule(6, ((0, 30, 3), (0, 60, 1), (1, 60, 1), (2, 15, 1)))
    return Schedule(6, ((0, 20, 3), (0, 40, 2), (1, 60, 1), (2, 20, 1)))


@dataclass(frozen=True)
class Trained:
    """A trained weight vector.

    Attributes:
        theta: all weights, layer by layer (W, then b).
        cost: weighted sum of squares on the rows of the last round, in normalised units.
        steps: of all starts and rounds together.
        stop: how the last round ended.
    """

    theta: Array
    cost: float
    steps: int
    stop: Stop


def levenberg_marquardt(rows: Rows, theta: Array, most: int) -> Trained:
    """Accelerated steps until the cost falls no more, or ``most`` are done."""
    mu, idle, now = _FIRST_DAMPING, 0, rows.at(theta)
    for step in range(1, most + 1):
        found = _step(rows, theta, now, mu)
        if found is None:
            return Trained(theta, now.cost, step, "converged")
        before = now.cost
        theta, now, mu = found
        idle = idle + 1 if before - now.cost < _FALLING * before else 0
        if idle >= _PATIENCE:
            return Trained(theta, now.cost, step, "converged")
    return Trained(theta, now.cost, most, "iterations")


def _step(rows: Rows, theta: Array, now: Point, mu: float) -> tuple[Array, Point, float] | None:
    """Weights after a step that lowers the cost, what they give, the next damping; None if rounding leaves none."""
    p = rows.count
    total = rows.gram(now)
    square, slope, growth = total[:p, :p], total[:p, p], 2.0
    scale = square.diagonal() + _FLOOR * square.diagonal().max()
    for _ in range(_MOST_TRIES):
        damped = square.copy()
        damped[np.diag_indices(p)] += mu * scale
        d = np.linalg.solve(damped, slope).astype(np.float64, copy=False)
        if float(d @ slope) <= _PRECISION[rows.kind] * now.cost:
            return None
        bent = np.linalg.solve(damped, -0.5 * rows.bend(now, d)).astype(np.float64, copy=False)
        after = theta + _curved(d, bent, scale)
        there = rows.at(after)
        fall = now.cost - there.cost
        if fall > 0.0:
            predicted = 2.0 * float(d @ slope) - float(d @ square @ d)
            # In single precision a tiny predicted fall may come out as anything.
            gain = min(fall / max(predicted, 1e-300), 2.0)
            easier = max(_SLOWLY, min(2.0, 1.0 - (2.0 * gain - 1.0) ** 3))
            return after, there, max(mu * easier, _LEAST_DAMPING)
        mu, growth = mu * growth, 4.0 * growth
    return None


def _curved(d: Array, bent: Array, scale: Array) -> Array:
    """The step with its acceleration, which is cut where it is no longer small beside the step."""
    length, extra = np.sqrt(float(d @ (scale * d))), np.sqrt(float(bent @ (scale * bent)))
    return d + bent * min(1.0, 0.5 * _MOST_BENT * length / extra) if extra > 0.0 else d


def train(
    x: Array,
    y: Array,
    hidden: Sequence[int],
    seed: int,
    schedule: Schedule,
    workers: int = 1,
    by: Array | None = None,
    slips: Slips | None = None,
) -> Trained:
    """Train a network on normalised rows.

    Args:
        x: inputs within -1 and 1, shape (inputs, n).
        y: effort of order one, shape (n,).
        hidden: neurons of each hidden layer.
        seed: of the starts.
        schedule: how much work to do.
        workers: starts side by side; changes no figure.
        by: what the grids are over in place of the inputs, see `compress`.
        slips: along which starts have transitions; None for starts that know nothing.
    """
    cells = {level: compress(x, y, level, by) for level in schedule.levels}
    best = train_on(cells, hidden, seed, schedule, workers, slips)
    if not schedule.polish:
        return best
    rows = Rows(x, y, None, (x.shape[0], *hidden, 1), single=y.size > _MANY)
    polished = levenberg_marquardt(rows, best.theta, schedule.polish)
    return replace(polished, steps=best.steps + polished.steps)


def train_on(
    cells: Mapping[int, Centroids],
    hidden: Sequence[int],
    seed: int,
    schedule: Schedule,
    workers: int = 1,
    slips: Slips | None = None,
) -> Trained:
    """The rounds of a schedule, on centroids by level of normalised rows; see `train`."""
    sizes = (next(iter(cells.values())).x.shape[0], *hidden, 1)
    random = [np.random.default_rng([seed, k]) for k in range(schedule.starts)]
    points = [first_weights(rng, sizes, slips) for rng in random]
    found: list[Trained] = []
    steps = 0
    for at, (level, most, kept) in enumerate(schedule.rounds):
        c = cells[level]

        def run(theta: Array, c: Centroids = c, most: int = most, first: bool = at == 0) -> Trained:
            rows = Rows(c.x, c.y, c.count, sizes, single=True)
            return levenberg_marquardt(rows, with_best_output(rows, theta) if first else theta, most)

        with ThreadPoolExecutor(max_workers=max(1, min(workers, len(points)))) as pool:
            found = sorted(pool.map(run, points), key=lambda t: t.cost)[:kept]
        steps += sum(t.steps for t in found)
        points = [t.theta for t in found]
    return replace(found[0], steps=steps)
