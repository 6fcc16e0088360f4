"""A law of shear stress on the points of a flow curve: where its fit starts, what is minimised, what comes out.

Shear stress spans decades, so what is minimised is the residual of its logarithm. The laws are those of the clutches
at a constant field, so one definition serves both. Rates are divided by the smallest of the curve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import Dual, partial_of, value_of
from erclutch.errors import SettingError
from erclutch.fit.laws.law_starts import scan_points
from erclutch.fit.solver.intervals import uncertainty
from erclutch.fit.solver.levenberg_marquardt import Linearisation, Minimum, Problem, minimise
from erclutch.fit.solver.outcome import Estimate
from erclutch.fit.solver.variable_projection import (
    Separable,
    coordinates,
    parameters,
    project,
    stack,
    triangle_of,
)
from erclutch.models.laws import (
    Dimension,
    Gain,
    Law,
    ShapeParameter,
    at_one_field,
    ladder,
    law_from_name,
    without_yield,
)
from erclutch.signals.array import Array

_STIFF = 1e-9  # width of the sign, in normalised rates: all rates are positive, so the sign is no parameter
_FAINTEST = 1e-6  # of the smallest stress: the least that a gain may add
#: A gel's stress may hardly grow with the rate: lower than the flow index of a clutch.
_LEAST_INDEX = 0.02
#: A jamming paste turns up at its highest rates: higher than the flow index of a clutch.
_LARGEST_INDEX = 6.0
#: Rounds of the local solves: steps of each solve, and how many of the lowest go on. On nine curves, measured and made
#: up, to take all solves to the end found nothing lower by 1e-6, and took half as many steps again.
_ROUNDS = ((20, 4), (60, 2))
_ROUGH = 1e-6  # of the sum of squares: a step that brings less ends a solve of a round
_HUGE = 1e200  # Pa: more than a column at the edge of its shapes counts for
#: Unit of a parameter, by its dimension in stress and in rate.
_UNITS = {
    (1, 0): "Pa",
    (1, -1): "Pa*s",
    (0, -1): "s",
    (0, 0): "1",
    (0, 1): "1/s",
}


@cache
def flow_laws() -> tuple[str, ...]:
    """Our laws of shear stress that have a meaning at one field, from the simplest to the richest.

    A drag of eddy currents is no stress of a fluid.
    """
    own = dict.fromkeys(specification.partition("/")[0] for specification in ladder())
    of_fluids = [name for name in own if not without_yield(name)]
    return tuple(name for name in of_fluids if at_one_field(name) is not None)


@dataclass(frozen=True)
class Effort:
    """How much work a fit is.

    Attributes:
        points: shapes at which the relative residual is looked at.
        solves: how many of the best of them start a local solve.
        tolerance, iterations: where a local solve ends.
    """

    points: int
    solves: int
    tolerance: float
    iterations: int

    @classmethod
    def whole(cls, shapes: int) -> Effort:
        """For the fit to a whole curve. On eight files of curves four times as much found nothing better."""
        points = 120
        solves = 4
        if shapes > 2:  # three shapes leave many valleys
            points = 1500
            solves = 24
        return cls(points, solves, tolerance=1e-12, iterations=300)

    @classmethod
    def of_validation(cls, shapes: int) -> Effort:
        """For the fits without a stretch of rates, whose minimum lies near the minimum of all points."""
        whole = cls.whole(shapes)
        return cls(
            points=max(whole.points // 10, 20),
            solves=max(whole.solves // 6, 2),
            tolerance=1e-10,
            iterations=200,
        )


@dataclass(frozen=True)
class FlowLaw:
    """A law of shear stress on the rates of a flow curve.

    A point of a search holds the coordinates of the shape parameters, then the logarithms of the gains.

    Attributes:
        law: effort stands for stress, slip for rate over ``reference``; the field is 1.
        shapes: its shape parameters without the width of the sign, with bounds as wide as the rates.
        reference: smallest rate of the curve in 1/s.
    """

    law: Law
    shapes: tuple[ShapeParameter, ...]
    reference: float

    @classmethod
    def of(cls, name: str, rate: Array) -> FlowLaw:
        """The law of a name on rates in 1/s.

        Raises:
            SettingError: not a law of shear stress.
        """
        named = law_from_name(name)
        if named.name not in flow_laws():
            known = ", ".join(flow_laws())
            raise SettingError(
                f"{name} is no law of shear stress at one field", remedy=f"Choose from {known}"
            )
        law = law_from_name(f"{named.name}/square")
        reference = float(rate.min())
        highest = float((rate / reference).max())
        shapes: list[ShapeParameter] = []
        for shape in law.shape[1:]:  # without that of the transition
            # A time: as wide as the normalised rates, 1 to the highest.
            if shape.dimension == Dimension(slip=-1):
                shape = replace(shape, lower=1e-3 / highest, upper=1e3)
            elif shape.name == "m":
                shape = replace(shape, lower=_LEAST_INDEX, upper=_LARGEST_INDEX)
            shapes.append(shape)
        return cls(law, tuple(shapes), reference)

    @property
    def unknowns(self) -> int:
        """Number of parameters."""
        return len(self.shapes) + len(self.law.gains)

    def stress(self, rate: Array, point: Array) -> Array:
        """Shear stress in Pa at rates in 1/s, by a point of the search."""
        return np.asarray(self._stress(rate / self.reference, *self._numbers(point)))

    def problem(self, rate: Array, stress: Array) -> Problem:
        """The sum of squared residuals of ln(stress) at rates in 1/s, with the bounds of its coordinates."""
        x = rate / self.reference
        measured = np.log(stress)

        def cost(point: Array) -> float:
            with np.errstate(all="ignore"):
                residual = measured - np.log(self._stress(x, *self._numbers(point)))
            total = float(residual @ residual)
            return total if np.isfinite(total) else np.inf

        def linearise(point: Array) -> Linearisation:
            with np.errstate(all="ignore"):
                model = np.log(self._stress(x, *self._dual_numbers(point)))
            residual = measured - value_of(model)
            partials = [partial_of(model, place) for place in range(point.size)]
            triangle = triangle_of(stack(partials, residual))
            return Linearisation(float(residual @ residual), triangle[:-1, :-1], triangle[:-1, -1])

        lowest_shape = coordinates(self.shapes, [shape.lower for shape in self.shapes])
        highest_shape = coordinates(self.shapes, [shape.upper for shape in self.shapes])
        lowest_gains = np.log(self._faintest_gains(x, stress))
        highest_gains = np.full(len(self.law.gains), float(measured.max()) + 3.0)
        lower = np.concatenate([lowest_shape, lowest_gains])
        upper = np.concatenate([highest_shape, highest_gains])
        return Problem(cost, linearise, lower, upper)

    def fit(self, rate: Array, stress: Array, effort: Effort) -> Minimum:
        """The best of several local solves, each from a good point of a scan.

        Most solves creep along a flat valley that is not the lowest: a solve that is behind after a round of steps
        ends there, and only the lowest are taken to the last digit.
        """
        problem = self.problem(rate, stress)
        points = self._starts(rate, stress, effort)
        for steps, lasting in _ROUNDS:
            reached = [
                minimise(problem, point, tolerance=_ROUGH, max_iterations=steps) for point in points
            ]
            reached.sort(key=lambda minimum: minimum.cost)
            points = [minimum.point for minimum in reached[:lasting]]
        minima: list[Minimum] = []
        for point in points:
            minimum = minimise(
                problem,
                point,
                tolerance=effort.tolerance,
                max_iterations=effort.iterations,
            )
            minima.append(minimum)
        return min(minima, key=lambda minimum: minimum.cost)

    def _starts(self, rate: Array, stress: Array, effort: Effort) -> list[Array]:
        """The best points of a scan of the shape, with the gains that minimise the relative residual there."""
        x = rate / self.reference
        field = np.ones_like(x)
        # The stress in Pa that a gain of 1 stands for: a column of small numbers counts as dead.
        size = float(stress.max())

        def relative_columns(shape: Sequence[Any]) -> list[Any]:
            return [
                column * (size / stress) for column in self.law.columns(field, x, _STIFF, *shape)
            ]

        relative = Separable(relative_columns, np.ones_like(x), self.shapes, self.law.gains)
        scanned = [np.zeros(0)]  # a law without a shape has one
        if self.shapes:
            scanned = list(scan_points(*relative.bounds, effort.points))
        projected = [
            (project(relative, parameters(self.shapes, shape)), tuple(shape)) for shape in scanned
        ]
        projected.sort(key=lambda pair: pair[0].cost)

        faintest = 10.0 * self._faintest_gains(x, stress)  # a gain of zero has no logarithm
        starts: list[Array] = []
        for projection, shape in projected[: effort.solves]:
            gains = np.maximum(projection.gains * size, faintest)
            starts.append(np.concatenate([shape, np.log(gains)]))
        return starts

    def _faintest_gains(self, x: Array, stress: Array) -> Array:
        """The least gains: at the highest rate each adds less than `_FAINTEST` of the smallest stress, in any shape."""
        largest = np.full(len(self.law.gains), float(x.max()))
        for ends in product(*[(shape.lower, shape.upper) for shape in self.shapes]):
            with np.errstate(all="ignore"):
                columns = self.law.columns(np.ones(1), np.array([x.max()]), _STIFF, *ends)
            sizes = [float(np.abs(np.broadcast_to(column, 1))[0]) for column in columns]
            finite_sizes = np.where(np.isfinite(sizes), np.minimum(sizes, _HUGE), 0.0)
            largest = np.fmax(largest, finite_sizes)
        return _FAINTEST * float(stress.min()) / largest

    def _stress(self, x: Array, shape: Sequence[Any], gains: Sequence[Any]) -> Any:
        """Stress at normalised rates: numbers, or dual numbers where the parameters are dual."""
        first, *others = self.law.columns(np.ones_like(x), x, _STIFF, *shape)
        total = gains[0] * first
        for gain, column in zip(gains[1:], others, strict=True):
            total = total + gain * column
        return total

    def _numbers(self, point: Array) -> tuple[list[float], list[float]]:
        """The shape parameters and the gains of a point."""
        count = len(self.shapes)
        shape = list(parameters(self.shapes, point[:count]))
        gains = np.exp(point[count:]).tolist()
        return shape, gains

    def _dual_numbers(self, point: Array) -> tuple[list[Dual], list[Dual]]:
        """The same numbers, each with its derivative by its own coordinate."""
        shape, gains = self._numbers(point)
        # The coordinate of a linear parameter is the parameter, of each other number its logarithm.
        dual_shape: list[Dual] = []
        for i, (about, value) in enumerate(zip(self.shapes, shape, strict=True)):
            slope = 1.0 if about.scale == "linear" else value
            dual_shape.append(Dual(value, {i: slope}))
        dual_gains = [Dual(gain, {i: gain}) for i, gain in enumerate(gains, start=len(shape))]
        return dual_shape, dual_gains

    def estimates(self, problem: Problem, minimum: Minimum, points: int) -> tuple[Estimate, ...]:
        """Parameters in units of the curve, with 95 % intervals of their logarithms.

        Args:
            problem: that was solved.
            minimum: its solution.
            points: of the curve.
        """
        moving = ~(minimum.at_lower | minimum.at_upper)
        # The triangle has the Jacobian's column space; a residual of the right length gives the right variance.
        rows = problem.linearise(minimum.point).triangle[:, moving]
        padding = np.zeros((max(points - rows.shape[0], 0), rows.shape[1]))
        jacobian: Array = np.vstack([rows, padding])
        size = int(jacobian.shape[0])
        spread = uncertainty(jacobian, np.full(size, (minimum.cost / size) ** 0.5), ordered=False)

        about_all = (*self.shapes, *self.law.gains)
        half_widths = np.full(len(about_all), np.nan)  # of coordinates; of those at a bound unknown
        half_widths[moving] = spread.quantile * spread.errors
        covariance = np.zeros((len(about_all), len(about_all)))
        covariance[np.ix_(moving, moving)] = spread.covariance
        quantile = float(spread.quantile.max(initial=0.0))

        estimates: list[Estimate] = []
        for place, about in enumerate(about_all):
            middle = float(minimum.point[place])
            half_width = float(half_widths[place])
            unit = _UNITS[about.dimension.effort, about.dimension.slip]
            meaning = about.meaning.replace("effort", "stress").replace("slip", "rate")
            meaning = meaning.removesuffix(" at the reference field")
            if about.name == "K":
                middle, variance = self._consistency_at_one(place, minimum.point, covariance)
                half_width = quantile * float(np.sqrt(variance))
                unit = "Pa*s^m"
                meaning = "consistency: viscous stress at 1 1/s"

            ends = np.array([middle, middle - half_width, middle + half_width])
            with np.errstate(over="ignore"):
                if isinstance(about, Gain) or about.scale == "log":
                    ends = np.exp(ends)
                value, low, high = ends * self.reference**about.dimension.slip
            at_bound = None
            if minimum.at_lower[place]:
                at_bound = "lower"
            elif minimum.at_upper[place]:
                at_bound = "upper"
            estimates.append(
                Estimate(
                    about.name,
                    meaning,
                    unit,
                    value=float(value),
                    low=float(low),
                    high=float(high),
                    at_bound=at_bound,
                )
            )
        return tuple(estimates)

    def _consistency_at_one(
        self, place: int, point: Array, covariance: Array
    ) -> tuple[float, float]:
        """Logarithm of the consistency at 1 1/s in place of the reference rate, and its variance.

        The stress is the same by both, so ln K_1 = ln K - m ln(reference).

        Args:
            place: of the consistency among the parameters.
            point: coordinates of all parameters, shape (k,).
            covariance: of these, shape (k, k).
        """
        index = next(number for number, shape in enumerate(self.shapes) if shape.name == "m")
        shift = -float(np.log(self.reference))
        at_one = float(point[place]) + float(point[index]) * shift
        of_index = shift**2 * covariance[index, index]
        of_both = 2 * shift * covariance[place, index]
        variance = covariance[place, place] + of_index + of_both
        return at_one, float(variance)
