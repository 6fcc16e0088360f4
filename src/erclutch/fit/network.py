"""Fitting an FNN: Levenberg-Marquardt over all weights, many starts, coarse to fine on compressed rows.

The Jacobian is analytic and made in blocks that stay in the cache; only J'J and J'r are kept (Hagan and Menhaj 1994,
doi 10.1109/72.329697). Damping is by mu times the identity, updated after Nielsen (1999). Starts run on the coarsest
grid, the worse of them are dropped at each halving, the best one goes on to finer grids, and to all rows if asked.
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

from erclutch.fit.compress import Centroids, compress
from erclutch.fit.lm import Stop

Array = NDArray[np.float64]
Floats = NDArray[Any]

_BLOCK = 1024
_FALLING = 1e-6  # relative fall of the cost that counts as progress
_PRECISION: dict[Any, float] = {np.float32: 1e-6, np.float64: 1e-12}  # falls of the cost that rounding hides
_PATIENCE = 3  # steps without progress before it counts as converged
_LEAST_DAMPING, _FIRST_DAMPING, _MOST_TRIES = 1e-14, 1e-3, 20


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


def schedule_for(hidden: Sequence[int], polish: bool = False) -> Schedule:
    """Small networks have more bad minima and cost less a start, so they get more starts."""
    weights = sum(hidden)
    if weights <= 8:
        rounds, starts = ((0, 30, 12), (0, 40, 4), (0, 80, 2), (1, 80, 1)), 48
    elif len(hidden) > 1:
        rounds, starts = ((0, 40, 3), (0, 80, 1), (1, 60, 1), (2, 20, 1)), 6
    else:
        rounds, starts = ((0, 40, 3), (0, 80, 2), (0, 100, 1), (1, 150, 1), (2, 15, 1)), 6
    return Schedule(starts, rounds, 60 if polish else 0)


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


class Rows:
    """Weighted rows of one round, ready for the Gram matrix; rows come in the precision of the round."""

    def __init__(self, x: Floats, y: Floats, weight: Floats | None, sizes: Sequence[int], single: bool) -> None:
        kind: Any = np.float32 if single else np.float64
        self.x, self.y = np.ascontiguousarray(x, kind), np.ascontiguousarray(y, kind)
        self.weight = None if weight is None else np.sqrt(weight / weight.mean()).astype(kind)
        self.sizes, self.kind = tuple(sizes), kind
        self.count = weights_of(sizes)
        self._store = np.empty((self.count + 1, _BLOCK), kind)

    def gram(self, theta: Array) -> Array:
        """J'J with J'r in its last row and column and r'r in the corner, shape (p + 1, p + 1)."""
        layers = unpacked(theta.astype(self.kind), self.sizes)
        total = np.zeros((self.count + 1, self.count + 1))
        for at in range(0, self.y.size, _BLOCK):
            block = slice(at, min(at + _BLOCK, self.y.size))
            j = self._store[:, : block.stop - block.start]
            _slopes(layers, self.x[:, block], self.y[block], j)
            if self.weight is not None:
                j *= self.weight[block]
            total += j @ j.T  # NumPy sees the transpose and does half the work
        return total


def weights_of(sizes: Sequence[int]) -> int:
    """Number of weights of a network with these layers, inputs and output included."""
    return sum(after * (before + 1) for before, after in itertools.pairwise(sizes))


def unpacked(theta: Floats, sizes: Sequence[int]) -> list[tuple[Floats, Floats]]:
    """(W, b) of each layer."""
    layers: list[tuple[Floats, Floats]] = []
    at = 0
    for before, after in itertools.pairwise(sizes):
        middle, end = at + after * before, at + after * (before + 1)
        layers.append((theta[at:middle].reshape(after, before), theta[middle:end]))
        at = end
    return layers


def tables_of(theta: Array, sizes: Sequence[int]) -> dict[str, Array]:
    """Weights as the tables of a NetworkModel."""
    *hidden, (w, b) = unpacked(theta, sizes)
    tables: dict[str, Array] = {}
    for i, (weight, bias) in enumerate(hidden, start=1):
        tables |= {f"W{i}": weight.copy(), f"b{i}": bias.copy()}
    return {**tables, "W_out": w.copy(), "b_out": b.copy()}


def theta_of(tables: Mapping[str, Array]) -> Array:
    """Back from tables."""
    return np.concatenate([table.ravel() for table in tables.values()])


def _slopes(layers: Sequence[tuple[Floats, Floats]], x: Floats, y: Floats, j: Floats) -> None:
    """Derivatives of the output by all weights, and the residual, into the rows of j, shape (p + 1, m)."""
    active: list[Floats] = [x]
    for w, b in layers[:-1]:
        active.append(np.tanh(w @ active[-1] + b[:, None]))
    last_w, last_b = layers[-1]
    np.subtract(y, (last_w @ active[-1])[0] + last_b[0], out=j[-1])
    end = j.shape[0] - 1
    j[end - 1] = 1.0
    j[end - 1 - last_w.size : end - 1] = active[-1]
    end -= 1 + last_w.size
    delta: Floats = np.broadcast_to(last_w[0][:, None], active[-1].shape)
    for i in range(len(layers) - 2, -1, -1):
        w, _ = layers[i]
        delta = delta * (1.0 - active[i + 1] ** 2)
        rows, columns = w.shape
        j[end - rows : end] = delta
        np.multiply(
            delta[:, None, :], active[i][None], out=j[end - rows - w.size : end - rows].reshape(rows, columns, -1)
        )
        end -= rows + w.size
        if i:
            delta = w.T @ delta


def levenberg_marquardt(rows: Rows, theta: Array, most: int) -> Trained:
    """Steps of (J'J + mu I) d = J'r until the cost falls no more, or ``most`` are done."""
    p = rows.count
    total = rows.gram(theta)
    mu, idle = _FIRST_DAMPING, 0
    for step in range(1, most + 1):
        cost = total[p, p]
        found = _step(rows, theta, total, mu)
        if found is None:
            return Trained(theta, float(cost), step, "converged")
        theta, total, mu = found
        idle = idle + 1 if cost - total[p, p] < _FALLING * cost else 0
        if idle >= _PATIENCE:
            return Trained(theta, float(total[p, p]), step, "converged")
    return Trained(theta, float(total[p, p]), most, "iterations")


def _step(rows: Rows, theta: Array, total: Array, mu: float) -> tuple[Array, Array, float] | None:
    """A step that lowers the cost, the Gram matrix there and the next damping; None if rounding leaves none."""
    p = rows.count
    square, slope, growth = total[:p, :p], total[:p, p], 2.0
    for _ in range(_MOST_TRIES):
        damped = square.copy()
        damped[np.diag_indices(p)] += mu * square.diagonal().max()
        d = np.linalg.solve(damped, slope)
        if float(d @ slope) <= _PRECISION[rows.kind] * total[p, p]:
            return None
        after = rows.gram(theta + d)
        if after[p, p] < total[p, p]:
            predicted = 2.0 * float(d @ slope) - float(d @ square @ d)
            # In single precision a tiny predicted fall may come out as anything.
            gain = min(float(total[p, p] - after[p, p]) / max(predicted, 1e-300), 2.0)
            easier = max(0.2, min(2.0, 1.0 - (2.0 * gain - 1.0) ** 3))
            return theta + d, after, max(mu * easier, _LEAST_DAMPING)
        mu, growth = mu * growth, 2.0 * growth
    return None


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
    sizes = (x.shape[0], *hidden, 1)
    cells = {level: compress(x, y, level, by) for level in {level for level, _, _ in schedule.rounds}}
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
    best = found[0]
    if schedule.polish:
        best = levenberg_marquardt(Rows(x, y, None, sizes, single=False), best.theta, schedule.polish)
        steps += best.steps
    return replace(best, steps=steps)
