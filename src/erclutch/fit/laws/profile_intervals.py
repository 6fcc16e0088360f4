"""Beside a bound, or along a valley, an interval follows the sum of squares itself and not its curvature.

The profile of a parameter is the least sum of squares at each of its values, over all other parameters within their
bounds (Venzon and Moolgavkar 1988, doi 10.2307/2347496). The interval ends where the profile has risen by the square of
the standard error's multiple. Correlated residuals raise that limit: by the ratio of the robust variance of the
parameter to its variance for white residuals (Rotnitzky and Jewell 1990, doi 10.1093/biomet/77.3.485). Where the sum of
squares is a parabola and no bound is near, the ends are those of the standard error.

A few rows stand for all of them. Their target is what the model predicts at the optimum, plus the smallest residual
whose gradient is that of all rows: only parameters on a bound have a gradient there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from erclutch.fit.intervals import Uncertainty, uncertainty
from erclutch.fit.laws.variable_projection import Separable, jacobian, outer_problem, parameters, triangle_of
from erclutch.fit.levenberg_marquardt import Linearisation, Problem, minimise
from erclutch.signals.array import Array, Mask

#: Half a width in the solver's coordinates (logarithms of most parameters) from which on a parabola says too little.
_WIDE = 1.0
_NEAR = 0.1  # of the limit's root: from there a straight line goes to the end
_STEEP = 3.0  # times the limit's root: a rise beyond says nothing of where the end is
_COUPLED = 0.1  # correlation from which on two parameters trade off
_TRIES = 10


@dataclass(frozen=True)
class Optimum:
    """Where a fit ended, over all parameters: the solver's coordinates first, then the gains.

    Attributes:
        point: shape (p,).
        slopes: derivatives of the fitted effort over all rows, shape (n, p).
        residual: over all rows, shape (n,).
        free: which parameters are not held on a bound, shape (p,).
        live: which parameters the rows excite at all, shape (p,).
    """

    point: Array
    slopes: Array
    residual: Array
    free: Mask
    live: Mask


def no_intervals(parameters: int) -> tuple[Array, Array]:
    """Ends where no intervals were asked for."""
    return np.full(parameters, np.nan), np.full(parameters, np.nan)


def interval_ends(few: Separable, found: Optimum, spread: Uncertainty, *, ordered: bool) -> tuple[Array, Array]:
    """Ends of the 95 % intervals of all parameters, (p,) each; infinite where the rows do not identify a parameter.

    Args:
        few: the problem on few rows.
        found: the optimum over all rows.
        spread: of the free parameters.
        ordered: whether rows follow in time.
    """
    widths = np.full(found.point.size, np.inf)
    widths[found.free] = spread.quantile * spread.errors
    lower, upper = _bounds(few)
    low, high = found.point - widths, found.point + widths
    doubtful = (low < lower) | (high > upper)
    doubtful[: len(few.shapes)] |= widths[: len(few.shapes)] > _WIDE
    if not doubtful[found.live].any():
        return low, high
    search = _Search.at(few, found, ordered)
    for j in np.flatnonzero(search.coupled(doubtful)):
        low[j], high[j] = -np.inf, np.inf
        ends = (search.end(int(j), -1.0), search.end(int(j), 1.0))
        if ends[0] > lower[j] or ends[1] < upper[j]:
            low[j], high[j] = ends
    return low, high


def _bounds(problem: Separable) -> tuple[Array, Array]:
    """Bounds of the coordinates and of the gains."""
    low, high = problem.bounds
    gains = np.where(problem.nonnegative, 0.0, -np.inf)
    return np.concatenate([low, gains]), np.concatenate([high, np.full(gains.size, np.inf)])


@dataclass(frozen=True)
class _Search:
    """What the ends of all parameters share.

    Attributes:
        problem: the few rows, with the target that has the gradient of all.
        point: the optimum, shape (p,).
        live: which parameters the few rows excite, shape (p,).
        lower, upper: bounds; those of a parameter that nothing excites meet in its value.
        inverse: of the curvature over the few rows, shape (p, p).
        limits: rise of the sum of squares at an end, shape (p,).
        first: half widths to try first, shape (p,).
        least: sum of squares at the optimum.
    """

    problem: Separable
    point: Array
    live: Mask
    lower: Array
    upper: Array
    inverse: Array
    limits: Array
    first: Array
    least: float

    @classmethod
    def at(cls, few: Separable, found: Optimum, ordered: bool) -> _Search:
        """The search around an optimum."""
        k, share = len(few.shapes), few.target.size / found.residual.size
        q = parameters(few.shapes, found.point[:k])
        fitted = few.values(few.columns(q), q)[:, :-1] @ found.point[k:]
        columns, slopes, _ = jacobian(replace(few, target=fitted), found.point[:k])
        slopes = np.column_stack([slopes, columns])
        pull = np.linalg.lstsq(slopes.T, share * found.slopes.T @ found.residual, rcond=1e-9)[0]
        norms = np.linalg.norm(slopes, axis=0)
        live = found.live & (norms > 0)
        norms[~live] = 1.0
        lower, upper = (np.where(live, ends, found.point) for ends in _bounds(few))
        _, s, right = np.linalg.svd(triangle_of(slopes / norms))
        half = right.T / np.maximum(s, 1e-12 * max(s[0], 1e-150)) / norms[:, None]
        inverse = half @ half.T
        limits = np.maximum(share * _limits(found, ordered), 1e-24 * float(fitted @ fitted) + 1e-200)
        first = np.sqrt(limits * np.diag(inverse))
        problem = replace(few, target=fitted + pull)
        return cls(problem, found.point, live, lower, upper, inverse, limits, first, float(pull @ pull))

    def coupled(self, doubtful: Mask) -> Mask:
        """Which parameters are among these or trade off with some of them."""
        errors = np.sqrt(np.diag(self.inverse))
        together = np.abs(self.inverse / np.outer(errors, errors))[:, doubtful] > _COUPLED
        return self.live & (together.any(axis=1) | doubtful)

    def end(self, j: int, side: float) -> float:
        """Where the profile of a parameter has risen to its limit, or the bound that it meets before."""
        bound = float(self.upper[j] if side > 0 else self.lower[j])
        inner, inner_rise = float(self.point[j]), 0.0
        outer, outer_rise = bound, np.inf
        if inner == bound:
            return bound
        rest: Array | None = None
        trial = inner + side * float(self.first[j])
        for _ in range(_TRIES):
            trial = min(trial, bound) if side > 0 else max(trial, bound)
            rise, found = self._rise(j, trial, rest)
            if abs(rise - 1.0) < _NEAR:
                start = float(self.point[j])
                return float(np.clip(start + (trial - start) / rise, self.lower[j], self.upper[j]))
            if rise < 1.0:
                if trial == bound:
                    return bound
                inner, inner_rise, rest = trial, rise, found  # beyond the end the others may lie in another basin
            else:
                outer, outer_rise = trial, rise
            trial = _next(inner, inner_rise, outer, outer_rise, float(self.point[j]))
        return inner if np.isfinite(outer_rise) else side * np.inf

    def _rise(self, j: int, value: float, start: Array | None) -> tuple[float, Array]:
        """Root of the profile's rise as a share of its limit, and the other coordinates there."""
        k = len(self.problem.shapes)
        guess = self.point + (value - self.point[j]) * self.inverse[:, j] / self.inverse[j, j]
        if j < k:
            pinned = _without(outer_problem(self.problem), j, value)
            guess = np.delete(guess[:k], j)
        else:
            pinned = outer_problem(replace(self.problem, pinned={j - k: value}))
            guess = guess[:k]
        if start is None:
            start = np.clip(guess, pinned.lower, pinned.upper)
        found = minimise(pinned, start, tolerance=1e-2, max_iterations=15)
        return float(np.sqrt(max(found.cost - self.least, 0.0) / self.limits[j])), found.point


def _limits(found: Optimum, ordered: bool) -> Array:
    """Rise of the sum of squares over all rows at the ends of the interval of each parameter."""
    robust, white = (uncertainty(found.slopes, found.residual, ordered=o) for o in (ordered, False))
    known = np.isfinite(robust.errors) & (white.errors > 0)
    ratio = np.full(known.size, np.nan)
    ratio[known] = (robust.errors[known] / white.errors[known]) ** 2
    # Along a valley the ratio at the optimum is not that at the end: none counts for less than the middle one.
    ratio = np.fmax(ratio, np.median(ratio[known]) if known.any() else 1.0)
    variance = float(found.residual @ found.residual) / max(found.residual.size - known.size, 1)
    return robust.quantile**2 * variance * ratio


def _next(inner: float, inner_rise: float, outer: float, outer_rise: float, start: float) -> float:
    """The next value to try: between the two that enclose the end, else further out by what the rise asks for."""
    if np.isfinite(outer_rise):
        share = (1.0 - inner_rise) / (min(outer_rise, _STEEP) - inner_rise)
        return inner + min(max(share, 0.05), 0.95) * (outer - inner)
    return start + (inner - start) * min(1.05 / max(inner_rise, 0.1), 4.0)


def _without(problem: Problem, j: int, value: float) -> Problem:
    """The same sum of squares with one coordinate at a value."""

    def linearise(rest: Array) -> Linearisation:
        whole = problem.linearise(np.insert(rest, j, value))
        return replace(whole, triangle=np.delete(whole.triangle, j, axis=1))

    return Problem(
        lambda rest: problem.cost(np.insert(rest, j, value)),
        linearise,
        np.delete(problem.lower, j),
        np.delete(problem.upper, j),
    )
