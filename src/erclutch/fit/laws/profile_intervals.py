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

from erclutch.fit.solver.intervals import Uncertainty, uncertainty
from erclutch.fit.solver.levenberg_marquardt import Linearisation, Problem, minimise
from erclutch.fit.solver.variable_projection import (
    Projection,
    Separable,
    linearised,
    outer_problem,
    triangle_of,
)
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


def interval_ends(
    few: Separable,
    optimum: Optimum,
    spread: Uncertainty,
    *,
    ordered: bool,
) -> tuple[Array, Array]:
    """Ends of the 95 % intervals of all parameters, (p,) each; infinite where the rows do not identify a parameter.

    Args:
        few: the problem on few rows.
        optimum: the optimum over all rows.
        spread: of the free parameters.
        ordered: whether rows follow in time.
    """
    # The ends of a parabola, and the parameters for which it says too little.
    half = np.full(optimum.point.size, np.inf)
    half[optimum.free] = spread.quantile * spread.errors
    low = optimum.point - half
    high = optimum.point + half
    lower, upper = _bounds(few)
    doubtful = (low < lower) | (high > upper)
    k = len(few.shapes)
    doubtful[:k] |= half[:k] > _WIDE
    if not doubtful[optimum.live].any():
        return low, high

    search = _Search.at(few, optimum, spread, ordered)
    some_held = bool(np.any(optimum.live & ~optimum.free))
    for j in np.flatnonzero(search.coupled(doubtful)).tolist():
        from_end = search.end(j, -1.0)
        to_end = search.end(j, 1.0)
        if some_held and not doubtful[j]:
            # Parameters on a bound that may leave it only widen what the free ones say.
            from_end = min(from_end, float(low[j]))
            to_end = max(to_end, float(high[j]))
        if from_end > lower[j] or to_end < upper[j]:
            low[j] = from_end
            high[j] = to_end
            continue
        # By the scores alone, without what the spectrum widens: does an end lie within the bounds?
        by_scores = search.by_scores
        is_told = by_scores.end(j, -1.0) > by_scores.lower[j]
        if is_told or by_scores.end(j, 1.0) < by_scores.upper[j]:
            # The misfit of a law moves as its slip does, and widens the interval; whether the rows tell a number of
            # one law from those of another is no matter of that.
            low[j] = lower[j]
            high[j] = upper[j]
        else:
            # From bound to bound: these rows do not identify the parameter.
            low[j] = -np.inf
            high[j] = np.inf
    return low, high


def _bounds(problem: Separable) -> tuple[Array, Array]:
    """Bounds of the coordinates and of the gains, shape (p,) each."""
    low, high = problem.bounds
    least_gains = np.where(problem.nonnegative, 0.0, -np.inf)
    most_gains = np.full(least_gains.size, np.inf)
    return np.concatenate([low, least_gains]), np.concatenate([high, most_gains])


@dataclass(frozen=True)
class _Search:
    """What the ends of all parameters share.

    Attributes:
        problem: the few rows, with the target that has the gradient of all.
        point: the optimum, shape (p,).
        live: which parameters the few rows excite, shape (p,).
        lower, upper: bounds; those of a parameter that nothing excites meet in its value.
        inverse: of the curvature over the few rows, shape (p, p).
        along: how far all parameters go with each of them where those on a bound stay, a column each, shape (p, p).
        limits: rise of the sum of squares at an end, shape (p,).
        first: half widths to try first, shape (p,).
        fitted: what the model predicts on the few rows.
        least: sum of squares at the optimum.
        widened: by how much the spectrum of the residual has widened each interval, shape (p,).
    """

    problem: Separable
    point: Array
    live: Mask
    lower: Array
    upper: Array
    inverse: Array
    along: Array
    limits: Array
    first: Array
    fitted: Array
    least: float
    widened: Array

    @classmethod
    def at(cls, few: Separable, optimum: Optimum, spread: Uncertainty, ordered: bool) -> _Search:
        """The search around an optimum."""
        k = len(few.shapes)
        share = few.target.size / optimum.residual.size  # of all rows, that the few are

        # What the model predicts on the few rows, and its derivatives there by all parameters.
        # Gains found anew would be off by rounding, and a gain of 1e-14 in place of nought brings a slope to life.
        gains = optimum.point[k:]
        stacked, by_shapes, _ = linearised(few, optimum.point[:k], Projection.of_known(gains))
        columns = stacked[:, :-1]
        fitted = columns @ gains
        slopes = np.column_stack([by_shapes, columns])
        norms: Array = np.sqrt(np.sum(slopes * slopes, axis=0))
        live = optimum.live & (norms > 0)
        norms[~live] = 1.0
        # The smallest residual whose gradient is that of all rows.
        gradient = share * optimum.slopes.T @ optimum.residual
        scaled_slopes = slopes / norms
        scaled_gradient = gradient / norms
        pull = np.linalg.lstsq(scaled_slopes.T, scaled_gradient, rcond=1e-9)[0]

        lower, upper = (np.where(live, ends, optimum.point) for ends in _bounds(few))

        triangle = triangle_of(slopes / norms)
        inverse = _inverse(triangle) / np.outer(norms, norms)

        # A parameter on a bound trades off with others there, far beyond where it can go: it stays for a first try.
        along = np.zeros_like(inverse)
        variances = np.diag(inverse).copy()
        for j in np.flatnonzero(live).tolist():
            moving = optimum.free.copy()
            moving[j] = True
            kept = np.flatnonzero(moving)
            scales = np.outer(norms[kept], norms[kept])
            of_moving = _inverse(triangle[:, kept]) / scales
            place = int(np.searchsorted(kept, j))
            variances[j] = of_moving[place, place]
            along[kept, j] = of_moving[:, place] / of_moving[place, place]

        # A perfect fit leaves rounding alone, whose square is the least rise that a profile can show.
        rounding = 1e-24 * float(fitted @ fitted) + 1e-200
        robust = spread
        if not optimum.free.all():  # the limits are those of all parameters, those on a bound too
            robust = uncertainty(optimum.slopes, optimum.residual, ordered=ordered)
        limits = np.maximum(share * rises_at_ends(optimum, robust), rounding)
        return cls(
            problem=replace(few, target=fitted + pull),
            point=optimum.point,
            live=live,
            lower=lower,
            upper=upper,
            inverse=inverse,
            limits=limits,
            along=along,
            first=np.sqrt(limits * variances),
            fitted=fitted,
            least=float(pull @ pull),
            widened=robust.widened,
        )

    @property
    def by_scores(self) -> _Search:
        """The same search with the limits that the scores alone would give."""
        return replace(self, limits=self.limits / self.widened**2, first=self.first / self.widened)

    def coupled(self, doubtful: Mask) -> Mask:
        """Which parameters are among these or trade off with some of them, shape (p,)."""
        errors = np.sqrt(np.diag(self.inverse))
        correlation = self.inverse / np.outer(errors, errors)
        together = np.abs(correlation)[:, doubtful] > _COUPLED
        return self.live & (together.any(axis=1) | doubtful)

    def end(self, j: int, side: float) -> float:
        """Where the profile of a parameter has risen to its limit, or the bound that it meets before."""
        bound = float(self.upper[j] if side > 0 else self.lower[j])
        start = float(self.point[j])
        if start == bound:
            return bound

        # The end lies between an inner value, where the profile is below its limit, and an outer one beyond.
        inner, inner_rise = start, 0.0
        outer = bound
        outer_rise = np.inf
        rest: Array | None = None  # the other coordinates at the inner value
        trial = start + side * float(self.first[j])
        for _ in range(_TRIES):
            trial = min(trial, bound) if side > 0 else max(trial, bound)
            rise, others = self._rise(j, trial, rest)
            if abs(rise - 1.0) < _NEAR:
                end = start + (trial - start) / rise
                return float(np.clip(end, self.lower[j], self.upper[j]))
            if rise < 1.0 and trial == bound:
                return bound
            if rise < 1.0:
                inner, inner_rise = trial, rise
                rest = others  # not from beyond the end, where the others may lie in another basin
            else:
                outer, outer_rise = trial, rise

            trial = next_value(inner, inner_rise, outer, outer_rise, start)
        return inner if np.isfinite(outer_rise) else side * np.inf

    def _rise(
        self,
        j: int,
        value: float,
        start: Array | None,
    ) -> tuple[float, Array]:
        """Root of the profile's rise as a share of its limit, and the other coordinates there."""
        k = len(self.problem.shapes)
        kept = np.delete(self.point[:k], j) if j < k else self.point[:k]
        starts = [kept if start is None else start]
        if start is None:
            # Along the valley of the parabola, or from the optimum where that leads into another basin.
            guess = self.point + (value - self.point[j]) * self.along[:, j]
            starts = [np.delete(guess[:k], j) if j < k else guess[:k], kept]

        least_rise = np.inf
        others = kept
        for first in starts:
            rise, place = self._rise_from(self.problem, self.least, j, value, first)
            if rise < -_NEAR * self.limits[j]:
                # Lower than the optimum: an artefact of the residual that stands for that of all rows.
                without = replace(self.problem, target=self.fitted)
                rise, place = self._rise_from(without, 0.0, j, value, first)
            if rise < least_rise:
                least_rise = rise
                others = place
            if least_rise < (1.0 + _NEAR) ** 2 * self.limits[j]:
                break
        share = max(least_rise, 0.0) / self.limits[j]
        return float(np.sqrt(share)), others

    def _rise_from(
        self,
        problem: Separable,
        least: float,
        j: int,
        value: float,
        start: Array,
    ) -> tuple[float, Array]:
        """Rise of the sum of squares over its least, by a search for the other coordinates from a start."""
        k = len(problem.shapes)
        if j < k:  # one of the coordinates stays at a value
            whole = outer_problem(problem)

            def linearise(rest: Array) -> Linearisation:
                model = whole.linearise(np.insert(rest, j, value))
                return replace(model, triangle=np.delete(model.triangle, j, axis=1))

            pinned = Problem(
                lambda rest: whole.cost(np.insert(rest, j, value)),
                linearise,
                np.delete(whole.lower, j),
                np.delete(whole.upper, j),
            )
        else:
            pinned = outer_problem(replace(problem, pinned={**problem.pinned, j - k: value}))
        # A hundredth of the limit and not of the cost, which is far above where a bound holds against a steep descent.
        tolerance = 1e-2 * float(self.limits[j] / (self.limits[j] + least))
        minimum = minimise(
            pinned,
            np.clip(start, pinned.lower, pinned.upper),
            tolerance=tolerance,
            max_iterations=15,
        )
        return minimum.cost - least, minimum.point


def _inverse(triangle: Array) -> Array:
    """Inverse of the curvature R'R by singular values of the triangle R; those of a valley are kept off zero."""
    _, s, right = np.linalg.svd(triangle, full_matrices=False)
    solid = np.maximum(s, 1e-12 * max(s[0], 1e-150))
    half = right.T / solid
    return half @ half.T


def rises_at_ends(optimum: Optimum, robust: Uncertainty) -> Array:
    """Rise of the sum of squares over all rows at the ends of the interval of each parameter, shape (p,)."""
    white = uncertainty(optimum.slopes, optimum.residual, ordered=False)
    known = np.isfinite(robust.errors) & (white.errors > 0)
    # Rotnitzky and Jewell's ratio of variances.
    ratio = np.full(known.size, np.nan)
    ratio[known] = (robust.errors[known] / white.errors[known]) ** 2
    # Along a valley the ratio at the optimum is not that at the end: none counts for less than the middle one.
    middle = np.median(ratio[known]) if known.any() else 1.0
    ratio = np.fmax(ratio, middle)
    freedom = max(optimum.residual.size - known.size, 1)
    variance = float(optimum.residual @ optimum.residual) / freedom
    return robust.quantile**2 * variance * ratio


def next_value(
    inner: float,
    inner_rise: float,
    outer: float,
    outer_rise: float,
    start: float,
) -> float:
    """The next value to try: between the two that enclose the end, else further out by what the rise asks for."""
    if np.isfinite(outer_rise):
        # By a straight line between both; a steep rise beyond says little of where the end is.
        share = (1.0 - inner_rise) / (min(outer_rise, _STEEP) - inner_rise)
        return inner + min(max(share, 0.05), 0.95) * (outer - inner)
    times_as_far = min(1.05 / max(inner_rise, 0.1), 4.0)
    return start + (inner - start) * times_as_far
