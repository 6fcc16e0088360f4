"""Fitting an FNN: Levenberg-Marquardt over all weights, some starts, spare neurons, coarse to fine on compressed rows.

A step is that of Levenberg-Marquardt plus its geodesic acceleration (Transtrum and Sethna 2012, arXiv:1201.5885),
which follows the narrow curved valleys of a network's cost: half as many steps, and better minima. Damping is by mu
times the diagonal of J'J with a floor; it grows and falls after Nielsen (1999), but falls more slowly. Starts run on
the coarsest grid with some neurons to spare, which go one by one (`pruning`); the worse starts are dropped on the way,
and the one that is best on the finest grid goes on there, and on all rows if asked. Deterministic for a seed, whatever
the number of threads: a start's arithmetic does not depend on its neighbours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.backprop import Point, Rows
from erclutch.fit.compress import Centroids, compress
from erclutch.fit.first_weights import Slips, first_weights, with_best_output
from erclutch.fit.lm import Stop
from erclutch.fit.pruning import smaller, without_least

Array = NDArray[np.float64]
_FALLING = 1e-6  # relative fall of the cost that counts as progress
_PRECISION: dict[Any, float] = {np.float32: 1e-6, np.float64: 1e-12}  # falls of the cost that rounding hides
_PATIENCE = 3  # steps without progress before it counts as converged
_LEAST_DAMPING, _FIRST_DAMPING, _MOST_TRIES = 1e-14, 1e-3, 20
_AFTER_LOSS = 1e-4  # damping after a neuron has gone
_HARDER = 3.0  # damping on the next level of compression over that on the last
_SLOWLY = 0.65  # of the damping that a good step leaves at least: a refused one costs half as much as a good one
_FLOOR = 1e-2  # of the damping's scale, over the largest diagonal element: weights that hardly matter do not run away
_MANY = 50_000  # rows above which the last steps on all of them are in single precision too
_MOST_BENT = 0.75  # twice the acceleration over the step


@dataclass(frozen=True)
class Round:
    """One round of a schedule.

    Attributes:
        level: of compression.
        steps: most steps of each start.
        kept: starts that go on, the best on this round's rows.
        spare: neurons of the last hidden layer beyond the final number that are left after the round.
    """

    level: int
    steps: int
    kept: int
    spare: int = 0


@dataclass(frozen=True)
class Schedule:
    """How much work a fit does.

    Attributes:
        starts: number of random starts.
        rounds: what they go through.
        spare: neurons of the last hidden layer beyond the final number that the starts have.
        between: most steps after a neuron has gone.
        polish: most steps on all rows; 0 for none.
    """

    starts: int
    rounds: tuple[Round, ...]
    spare: int = 0
    between: int = 15
    polish: int = 0

    @property
    def levels(self) -> set[int]:
        """Levels of compression that its rounds need."""
        return {round.level for round in self.rounds}


def schedule_for(hidden: Sequence[int], inputs: int, polish: bool = False) -> Schedule:
    """Small networks have more bad minima and cost less a start, so they get more starts and spare neurons.

    With many inputs the coarsest grid has too few cells along each to prune on.
    """
    small = sum(hidden) <= 8
    spare = 8 if small else max(3, round(0.375 * hidden[-1]))
    few, middle = min(spare, 2), 0 if inputs <= 3 else 1
    if polish:
        starts, kept = (24, 8) if small else (16, 6)
        last = Round(middle, 20, 3), Round(2, 30, 2), Round(2, 60, 1)
        return Schedule(starts, (Round(0, 30, starts, spare), Round(middle, 0, kept, few), *last), spare, polish=10)
    starts, kept = (8, 4) if small else (4, 2)
    last = Round(middle, 20 if small else 10, 2), Round(2, 0, 1), Round(2, 30 if middle else 20 if small else 16, 1)
    return Schedule(starts, (Round(0, 30, starts, spare), Round(middle, 0, kept, few), *last), spare)


@dataclass(frozen=True)
class Trained:
    """A trained weight vector.

    Attributes:
        theta: all weights, layer by layer (W, then b).
        cost: weighted sum of squares on the rows of the last round, in normalised units.
        steps: of all starts and rounds together.
        stop: how the last round ended.
        damping: that the next step would have had.
    """

    theta: Array
    cost: float
    steps: int
    stop: Stop
    damping: float = _FIRST_DAMPING


def levenberg_marquardt(rows: Rows, theta: Array, most: int, damping: float = _FIRST_DAMPING) -> Trained:
    """Accelerated steps until the cost falls no more, or ``most`` are done."""
    mu, idle, now = damping, 0, rows.at(theta)
    for step in range(1, most + 1):
        found = _step(rows, theta, now, mu)
        if found is None:
            return Trained(theta, now.cost, step, "converged", mu)
        before = now.cost
        theta, now, mu = found
        idle = idle + 1 if before - now.cost < _FALLING * before else 0
        if idle >= _PATIENCE:
            return Trained(theta, now.cost, step, "converged", mu)
    return Trained(theta, now.cost, most, "iterations", mu)


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
    polished = levenberg_marquardt(rows, best.theta, schedule.polish, _HARDER * best.damping)
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
    inputs, level = next(iter(cells.values())).x.shape[0], schedule.rounds[0].level
    sizes = (inputs, *hidden[:-1], hidden[-1] + schedule.spare, 1)
    rows = _rows(cells[level], sizes)
    random = [np.random.default_rng([seed, k]) for k in range(schedule.starts)]
    points = [with_best_output(rows, first_weights(rng, sizes, slips)) for rng in random]
    found = [Trained(theta, np.inf, 0, "iterations") for theta in points]
    steps = 0
    for part in schedule.rounds:
        neurons, harder = hidden[-1] + part.spare, 1.0 if part.level == level else _HARDER
        run = partial(_through, cells[part.level], sizes, neurons, part.steps, schedule.between, harder)
        with ThreadPoolExecutor(max_workers=max(1, min(workers, len(found)))) as pool:
            found = sorted(pool.map(run, found), key=lambda t: t.cost)
        steps += sum(t.steps for t in found)
        found, sizes, level = found[: part.kept], (*sizes[:-2], neurons, 1), part.level
    return replace(found[0], steps=steps)


def _through(
    c: Centroids, sizes: tuple[int, ...], neurons: int, most: int, between: int, harder: float, start: Trained
) -> Trained:
    """A start after a round: neurons go one by one until so many are left in the last hidden layer, then steps."""
    rows, found, steps = _rows(c, sizes), start, 0
    while rows.sizes[-2] > neurons:
        theta = without_least(rows, found.theta)
        rows = _rows(c, smaller(rows.sizes))
        found = levenberg_marquardt(rows, with_best_output(rows, theta), between, _AFTER_LOSS)
        steps += found.steps
    found = levenberg_marquardt(rows, found.theta, most, found.damping * harder)
    return replace(found, steps=steps + found.steps)


def _rows(c: Centroids, sizes: Sequence[int]) -> Rows:
    return Rows(c.x, c.y, c.count, sizes, single=True)
