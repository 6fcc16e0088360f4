"""Levenberg-Marquardt works with bounds on the parameters, on a triangular linearisation.

The problem hands over, at a point u, the triangle R and vector z of its linear model: the cost of a step d is
|z - R d|**2 + rest. Whoever makes R and z (a full Jacobian, or a variable projection) does so by orthogonal
transformations, so nothing here squares a condition number. Trust region and scaling after Moré (1978, doi
10.1007/BFb0067700). Bounds: coordinates on a bound with the descent pointing outward are held; steps are clipped.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array

#: Share of a sum of squares that no rows can tell: of 10,000 rows a tenth of one row's noise.
_NEXT_TO_NOTHING = 1e-5
Stop = Literal["converged", "stalled", "iterations"]
_FIFTH_ROOT_OF_TINY = float(np.finfo(float).tiny ** 0.2)
_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Linearisation:
    """Local model of a sum of squares.

    Attributes:
        cost: the sum of squares at the point.
        triangle: R, shape (k, k); the cost of a step d is cost - |z|**2 + |z - R d|**2.
        vector: z, shape (k,).
    """

    cost: float
    triangle: Array
    vector: Array


@dataclass(frozen=True)
class Problem:
    """A sum of squares over k coordinates.

    Attributes:
        cost: sum of squares at a point; inf or nan where it cannot be evaluated.
        linearise: the local model at a point.
        lower, upper: bounds, shape (k,); infinite where there is none.
    """

    cost: Callable[[Array], float]
    linearise: Callable[[Array], Linearisation]
    lower: Array
    upper: Array


@dataclass(frozen=True)
class Minimum:
    """Outcome of a minimisation.

    Attributes:
        point: shape (k,).
        cost: sum of squares there.
        stop: "converged" (a tolerance was met), "stalled" (no step reduces the cost any more), "iterations".
        iterations: accepted and refused steps.
        at_lower, at_upper: which coordinates lie on a bound, shape (k,).
    """

    point: Array
    cost: float
    stop: Stop
    iterations: int
    at_lower: NDArray[np.bool_]
    at_upper: NDArray[np.bool_]


def minimise(
    problem: Problem,
    start: Array,
    *,
    tolerance: float = 1e-10,
    max_iterations: int = 100,
    reach: float = 10.0,
) -> Minimum:
    """Minimise a sum of squares from a start.

    Args:
        problem: cost, linearisation and bounds.
        start: shape (k,); clipped into the bounds.
        tolerance: relative; stops when predicted and actual reduction of the cost, or the step, fall below it.
        max_iterations: steps tried at most.
        reach: first trust radius, as a multiple of the start's scaled norm.
    """
    begin = np.asarray(start, np.float64)
    u: Array = np.clip(begin, problem.lower, problem.upper)
    model = problem.linearise(u)
    least = model.cost
    scale, radius = _fresh(model, u, reach)
    stop: Stop = "iterations"
    tries = 0
    fresh_starts = 5
    floor = 1e-8 * model.cost**0.5
    while tries < max_iterations:
        tries += 1
        step = _bounded_step(model, problem, u, scale, radius)
        trial = _clipped(u + step, problem)
        step = trial - u
        if not step.any():
            stationary = _stationary(model, problem, u, floor, tolerance)
            stop = "converged" if stationary or _at_a_kink(model, problem, u) else "stalled"
            break
        length = _length(scale * step)
        if tries == 1:
            radius = min(radius, length)
        # How much less the sum of squares is after the step: by the local model, and in fact.
        left = model.vector - model.triangle @ step
        predicted = float(model.vector @ model.vector - np.add.reduce(left**2))
        cost = problem.cost(trial)
        actual = model.cost - cost if math.isfinite(cost) else -math.inf
        ratio = actual / predicted if predicted > 0 else 0.0
        # A step that the radius cut short says nothing of how near the minimum is.
        whole = length < 0.9 * radius or tries == 1
        # Moré's rule: shrink after a poor step, grow after a good one that was not cut short by the radius' own slack.
        if ratio > 0.75:
            radius = max(radius, 2.0 * length)
        elif ratio < 0.25:
            very_poor = not math.isfinite(ratio) or ratio <= -10.0
            radius = (0.1 if very_poor else 0.25) * min(radius, 10.0 * length)
        flat = (
            whole and predicted <= tolerance * model.cost and abs(actual) <= tolerance * model.cost
        )
        if ratio > 1e-4:
            u, least = trial, cost
        if flat or least == 0.0:
            stop = "converged"
            break
        if ratio > 1e-4:
            model = problem.linearise(u)
            scale = np.maximum(scale, _norms(model.triangle))
        if radius <= tolerance * _length(scale * u):
            stationary = _stationary(model, problem, u, floor, tolerance)
            if stationary or fresh_starts == 0:
                stop = "converged" if stationary or _at_a_kink(model, problem, u) else "stalled"
                break
            # A steep place on the way has set the scale for good: begin anew from here, with this place's.
            fresh_starts -= 1
            scale, radius = _fresh(model, u, reach)
    # Nearer to a bound than a millionth of the bounds' distance counts as on the bound.
    distance = problem.upper - problem.lower
    finite = np.isfinite(distance)
    edge = 1e-6 * np.where(finite, distance, 0.0)
    at_lower = u <= problem.lower + edge
    at_upper = u >= problem.upper - edge
    return Minimum(u, least, stop, tries, at_lower, at_upper)


def _fresh(model: Linearisation, u: Array, reach: float) -> tuple[Array, float]:
    """Scale and trust radius at a place, without memory of others."""
    norms = _norms(model.triangle)
    scale: Array = np.where(norms > 0, norms, 1.0)
    return scale, reach * (_length(scale * u) or 1.0)


def _clipped(point: Array, problem: Problem) -> Array:
    """A point within the bounds; NumPy's own function takes three times as long for a few numbers."""
    return np.minimum(np.maximum(point, problem.lower), problem.upper)


def _length(vector: Array) -> float:
    """Of a vector; NumPy's own function takes twice as long for a few numbers."""
    return math.sqrt(float(vector @ vector))


def _norms(matrix: Array) -> Array:
    """Lengths of the columns of a matrix."""
    return np.sqrt(np.add.reduce(matrix * matrix, axis=0))


def _free(model: Linearisation, problem: Problem, u: Array) -> NDArray[np.bool_]:
    """Which coordinates are on no bound, or would leave it with the descent, shape (k,)."""
    descent = model.triangle.T @ model.vector
    held_below = (u <= problem.lower) & (descent <= 0)
    held_above = (u >= problem.upper) & (descent >= 0)
    return ~(held_below | held_above)


def _bounded_step(
    model: Linearisation,
    problem: Problem,
    u: Array,
    scale: Array,
    radius: float,
) -> Array:
    """Step over the free coordinates; those that would leave their bounds are put on them and the rest re-solved."""
    free = _free(model, problem, u)
    step = np.zeros(u.size)
    while free.any():
        vector = model.vector - model.triangle @ np.where(free, 0.0, step)
        triangle = model.triangle[:, free]
        step[free] = _trusted(triangle, vector, scale[free], radius)
        trial = u + step
        out = free & ((trial < problem.lower) | (trial > problem.upper))
        if not out.any():
            break
        to_bound = _clipped(trial, problem) - u
        step[out] = to_bound[out]
        free &= ~out
    return step


def _trusted(
    triangle: Array,
    vector: Array,
    scale: Array,
    radius: float,
) -> Array:
    """Min |z - R d|**2 subject to |D d| <= radius, to a tenth of the radius (Moré 1978), by singular values."""
    left, s, right = np.linalg.svd(triangle / scale, full_matrices=False)
    z = left.T @ vector
    # A singular value whose fourth power is next to no normal number tells no direction: it is divided by below.
    faintest = max(float(s[0]) * _EPS, _FIFTH_ROOT_OF_TINY)
    solid = s > faintest
    # In the coordinates of the singular values, a damping mu gives the step d; the lost directions stay where they are.
    mu = 0.0
    damped = np.where(solid, s * s + mu, 1.0)
    d = np.where(solid, s * z / damped, 0.0)
    if _length(d) <= 1.1 * radius:
        return (right.T @ d) / scale
    for _ in range(50):  # Newton on 1 / |D d|, monotone from the left
        length = _length(d)
        if abs(length - radius) <= 0.1 * radius:
            break
        steepness = np.where(solid, d * d / damped, 0.0)
        slope = -float(np.add.reduce(steepness)) / length
        mu = max(mu - (length - radius) / radius * length / slope, 0.0)
        damped = np.where(solid, s * s + mu, 1.0)
        d = np.where(solid, s * z / damped, 0.0)
    return (right.T @ d) / scale


def _at_a_kink(model: Linearisation, problem: Problem, u: Array) -> bool:
    """Whether the local model promises next to nothing more, where no step reduces the cost.

    A cost with kinks, such as that of a knee of a line, is flat nowhere near its minimum.
    """
    triangle = model.triangle[:, _free(model, problem, u)]
    step, *_ = np.linalg.lstsq(triangle, model.vector, rcond=None)
    left = model.vector - triangle @ step
    promised = float(model.vector @ model.vector - left @ left)
    return promised <= _NEXT_TO_NOTHING * model.cost


def _stationary(
    model: Linearisation,
    problem: Problem,
    u: Array,
    floor: float,
    tolerance: float,
) -> bool:
    """Whether the residual is at right angles to what the free coordinates can change."""
    free = _free(model, problem, u)
    gradient = model.triangle.T @ model.vector
    residual_size = max(model.cost**0.5, floor)
    norms = _norms(model.triangle) * residual_size + np.finfo(float).tiny
    cosines = np.abs(gradient / norms)
    small = max(1e-6, tolerance**0.5)
    return bool(np.all(cosines[free] < small))
