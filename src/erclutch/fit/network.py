"""Fitting an FNN: Levenberg-Marquardt over all weights, many starts, coarse to fine on compressed rows.

A step is that of Levenberg-Marquardt plus its geodesic acceleration (Transtrum and Sethna 2012, arXiv:1201.5885),
which follows the narrow curved valleys of a network's cost: half as many steps, and better minima. Damping is by mu
times the diagonal of J'J with a floor, updated after Nielsen (1999). Starts run on the coarsest grid, the worse of them
are dropped at each halving, the best one goes on to finer grids, and to all rows if asked.
Deterministic for a seed, whatever the number of threads: a start's arithmetic does not depend on its neighbours.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.backprop import Rows
from erclutch.fit.compress import Centroids, compress
from erclutch.fit.lm import Stop

Array = NDArray[np.float64]
_FALLING = 1e-6  # relative fall of the cost that counts as progress
_PRECISION: dict[Any, float] = {np.float32: 1e-6, np.float64: 1e-12}  # falls of the cost that rounding hides
_PATIENCE = 3  # steps without progress before it counts as converged
_LEAST_DAMPING, _FIRST_DAMPING, _MOST_TRIES = 1e-14, 1e-3, 20
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
        return Schedule(24, ((0, 20, 8), (0, 40, 3), (0, 80, 2), (1, 80, 1)), 20 if polish else 0)
    if polish:
        return Schedule(12, ((0, 30, 5), (0, 60, 3), (1, 100, 2), (2, 150, 1)), 10)
    if len(hidden) > 1:
        return Schedule(6, ((0, 30, 3), (0, 60, 1), (1, 60, 1), (2, 15, 1)))
    return Schedule(6, ((0, 30, 3), (0, 50, 2), (0, 60, 1), (1, 100, 1), (2, 15, 1)))


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
    p = rows.count
    total = rows.gram(theta)
    mu, idle = _FIRST_DAMPING, 0
    for step in range(1, most + 1):
        cost = total[p, p]
        found = _step(rows, theta, total, mu)
        if found is None:
            return Trained(theta, float(cost), step, "converged")
        theta, mu = found
        total = rows.gram(theta)
        idle = idle + 1 if cost - total[p, p] < _FALLING * cost else 0
        if idle >= _PATIENCE:
            return Trained(theta, float(total[p, p]), step, "converged")
    return Trained(theta, float(total[p, p]), most, "iterations")


def _step(rows: Rows, theta: Array, total: Array, mu: float) -> tuple[Array, float] | None:
    """Weights after a step that lowers the cost, and the next damping; None if rounding leaves none."""
    p = rows.count
    square, slope, cost, growth = total[:p, :p], total[:p, p], float(total[p, p]), 2.0
    scale = square.diagonal() + _FLOOR * square.diagonal().max()
    for _ in range(_MOST_TRIES):
        damped = square.copy()
        damped[np.diag_indices(p)] += mu * scale
        d = np.linalg.solve(damped, slope).astype(np.float64, copy=False)
        if float(d @ slope) <= _PRECISION[rows.kind] * cost:
            return None
        bent = np.linalg.solve(damped, -0.5 * rows.bend(theta, d)).astype(np.float64, copy=False)
        after = theta + _curved(d, bent, scale)
        fall = cost - rows.cost(after)
        if fall > 0.0:
            predicted = 2.0 * float(d @ slope) - float(d @ square @ d)
            # In single precision a tiny predicted fall may come out as anything.
            gain = min(fall / max(predicted, 1e-300), 2.0)
            easier = max(0.2, min(2.0, 1.0 - (2.0 * gain - 1.0) ** 3))
            return after, max(mu * easier, _LEAST_DAMPING)
        mu, growth = mu * growth, 2.0 * growth
    return None


def _curved(d: Array, bent: Array, scale: Array) -> Array:
    """The step with its acceleration, which is cut where it is no longer small beside the step."""
    length, extra = np.sqrt(float(d @ (scale * d))), np.sqrt(float(bent @ (scale * bent)))
    return d + bent * min(1.0, 0.5 * _MOST_BENT * length / extra) if extra > 0.0 else d


def first_weights(rng: np.random.Generator, sizes: Sequence[int]) -> Array:
    """Random weights after Nguyen and Widrow (1990, doi 10.1109/IJCNN.1990.137819) for inputs within -1 and 1."""
    parts: list[Array] = []
    for before, after in itertools.pairwise(sizes[:-1]):
        w = rng.uniform(-1.0, 1.0, (after, before))
        reach = 0.7 * after ** (1.0 / before)
        w *= reach / np.linalg.norm(w, axis=1, keepdims=True)
        b = reach * np.linspace(-1.0, 1.0, after) * np.sign(w[:, 0]) if after > 1 else np.zeros(1)
        parts += [w.ravel(), b]
    scale = 1.0 / np.sqrt(sizes[-2])
    return np.concatenate([*parts, rng.uniform(-scale, scale, sizes[-2]), np.zeros(1)])


def train(
    x: Array,
    y: Array,
    hidden: Sequence[int],
    seed: int,
    schedule: Schedule,
    workers: int = 1,
    by: Array | None = None,
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
    """
    best = train_on({level: compress(x, y, level, by) for level in schedule.levels}, hidden, seed, schedule, workers)
    if not schedule.polish:
        return best
    rows = Rows(x, y, None, (x.shape[0], *hidden, 1), single=y.size > _MANY)
    polished = levenberg_marquardt(rows, best.theta, schedule.polish)
    return replace(polished, steps=best.steps + polished.steps)


def train_on(
    cells: Mapping[int, Centroids], hidden: Sequence[int], seed: int, schedule: Schedule, workers: int = 1
) -> Trained:
    """The rounds of a schedule, on centroids by level of normalised rows; see `train`."""
    sizes = (next(iter(cells.values())).x.shape[0], *hidden, 1)
    random = [np.random.default_rng([seed, k]) for k in range(schedule.starts)]
    points = [first_weights(rng, sizes) for rng in random]
    found: list[Trained] = []
    steps = 0
    for level, most, kept in schedule.rounds:
        c = cells[level]

        def run(theta: Array, c: Centroids = c, most: int = most) -> Trained:
            return levenberg_marquardt(Rows(c.x, c.y, c.count, sizes, single=True), theta, most)

        with ThreadPoolExecutor(max_workers=max(1, min(workers, len(points)))) as pool:
            found = sorted(pool.map(run, points), key=lambda t: t.cost)[:kept]
        steps += sum(t.steps for t in found)
        points = [t.theta for t in found]
    return replace(found[0], steps=steps)
