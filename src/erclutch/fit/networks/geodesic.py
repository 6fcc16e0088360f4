"""An FNN trains on its rows by Levenberg-Marquardt over all weights, with geodesic acceleration.

A step is that of Levenberg-Marquardt plus its acceleration (Transtrum and Sethna 2012, arXiv:1201.5885), which follows
the narrow curved valleys of a network's cost: half as many steps, and better minima. Damping is by mu times the
diagonal of J'J with a floor; it grows and falls after Nielsen (1999), but falls more slowly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotrs

from erclutch.fit.networks.backprop import Point, WeightedRows
from erclutch.fit.solver.levenberg_marquardt import Stop
from erclutch.signals.array import Array

FIRST_DAMPING = 1e-3
_FALLING = 1e-6  # relative fall of the cost that counts as progress
#: Falls of the cost that rounding hides.
_PRECISION: dict[Any, float] = {np.float32: 1e-6, np.float64: 1e-12}
_PATIENCE = 3  # steps without progress before it counts as converged
_LEAST_DAMPING = 1e-14
_MOST_TRIES = 20
_SLOWLY = 0.65  # of the damping that a good step leaves at least: a refused one costs half as much as a good one
_FLOOR = 1e-2  # of the damping's scale, over the largest diagonal element: weights that hardly matter do not run away
_MOST_BENT = 0.75  # twice the acceleration over the step


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
    damping: float = FIRST_DAMPING


def levenberg_marquardt(
    rows: WeightedRows,
    theta: Array,
    most: int,
    damping: float = FIRST_DAMPING,
    decay: float = 0.0,
) -> Trained:
    """Accelerated steps until the cost falls no more, or ``most`` are done.

    Args:
        rows: weighted rows.
        theta: the weights to begin with.
        most: steps.
        damping: of the first step.
        decay: what the square of a weight costs, as a share of the cost at the beginning. The share says how noisy the
            rows are, so rows without noise pull no weight to zero.
    """
    mu = damping
    idle = 0  # steps without progress, one after another
    now = rows.at(theta)
    pull = decay * now.cost
    p = rows.count
    for step in range(1, most + 1):
        total = rows.gram(now)
        square = total[:p, :p]
        slope = total[:p, p]
        before = _with_decay(now, theta, pull)
        if pull:
            square[np.diag_indices(p)] += pull
            slope -= pull * theta
        scale = square.diagonal() + _FLOOR * square.diagonal().max()

        # A step that lowers the cost, what the weights give there, and the next damping.
        taken: tuple[Array, Point, float] | None = None
        harder = mu
        growth = 2.0  # of the damping after a step that is refused
        for _ in range(_MOST_TRIES):
            damped = square.copy(order="F")
            damped[np.diag_indices(p)] += harder * scale
            root, failed = dpotrf(damped, overwrite_a=True, clean=False)
            if not failed:  # else rounding left it indefinite
                d = dpotrs(root, slope)[0]
                if float(d @ slope) <= _PRECISION[rows.kind] * before:
                    break
                bent = dpotrs(root, -0.5 * rows.bend(now, d))[0]
                # The acceleration is cut where it is no longer small beside the step.
                length = np.sqrt(float(d @ (scale * d)))
                extra = np.sqrt(float(bent @ (scale * bent)))
                curved = d
                if extra > 0.0:
                    curved = d + bent * min(1.0, 0.5 * _MOST_BENT * length / extra)
                trial = theta + curved
                there = rows.at(trial)
                fall = before - _with_decay(there, trial, pull)
                if fall > 0.0:
                    predicted = 2.0 * float(d @ slope) - float(d @ square @ d)
                    # In single precision a tiny predicted fall may come out as anything.
                    gain = min(fall / max(predicted, 1e-300), 2.0)
                    easier = max(_SLOWLY, min(2.0, 1.0 - (2.0 * gain - 1.0) ** 3))
                    taken = trial, there, max(harder * easier, _LEAST_DAMPING)
                    break
            harder *= growth
            growth *= 4.0
        if taken is None:  # rounding leaves none
            return Trained(theta, now.cost, step, "converged", mu)

        theta, now, mu = taken
        after = _with_decay(now, theta, pull)
        hardly_falls = before - after < _FALLING * before
        idle = idle + 1 if hardly_falls else 0
        if idle >= _PATIENCE:
            return Trained(theta, now.cost, step, "converged", mu)
    return Trained(theta, now.cost, most, "iterations", mu)


def _with_decay(point: Point, theta: Array, pull: float) -> float:
    """The cost of a point and of its weights."""
    return point.cost + pull * float(theta @ theta)
