"""Intervals from profiles: a parabola gives the standard error's ends, a bound gives those of a search over a grid."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear
from scipy.special import stdtrit as student_quantile

from erclutch.fit.laws import profile_intervals
from erclutch.fit.laws.profile_intervals import Optimum, interval_ends
from erclutch.fit.solver.intervals import uncertainty
from erclutch.fit.solver.levenberg_marquardt import minimise
from erclutch.fit.solver.variable_projection import Separable, jacobian, outer_problem
from erclutch.models.laws import Gain, ShapeParameter
from erclutch.models.laws.law import EFFORT
from tests.support.examples import examples

ROWS = 400
X = np.linspace(0.0, 4.0, ROWS)


def linear(target: Any, correlation: float) -> Separable:
    """Two gains, neither below zero, whose columns are correlated."""
    rng = np.random.default_rng(5)
    a, b = rng.standard_normal((2, ROWS))
    columns = [a, correlation * a + np.sqrt(1 - correlation**2) * b]
    gains = tuple(Gain(name, name, EFFORT, nonnegative=True) for name in ("c_1", "c_2"))
    return Separable(lambda _: columns, target(columns), (), gains)


def ends_of(problem: Separable, point: Any = ()) -> tuple[Any, Any, Any, Optimum]:
    columns, slopes, projection = jacobian(problem, np.asarray(point, float))
    slopes = np.column_stack([slopes, columns])
    residual = problem.target - columns @ projection.gains
    lower, upper = problem.bounds
    moving = (np.asarray(point) > lower) & (np.asarray(point) < upper)
    found = Optimum(
        np.concatenate([point, projection.gains]),
        slopes,
        residual,
        np.concatenate([moving, ~projection.held]).astype(bool),
        np.ones(slopes.shape[1], np.bool_),
    )
    spread = uncertainty(slopes[:, found.free], residual, ordered=False)
    return *interval_ends(problem, found, spread, ordered=False), spread, found


@pytest.mark.slow
@settings(max_examples=examples(25), deadline=None)
@given(st.floats(-0.9, 0.9), st.floats(0.0, 0.25), st.integers(0, 1000))
def test_beside_a_bound_the_ends_are_those_of_a_grid(
    correlation: float, second: float, seed: int
) -> None:
    noise = np.random.default_rng([7, seed]).standard_normal(
        ROWS
    )  # not the columns, whose seed is 5
    problem = linear(lambda c: 1.0 * c[0] + second * c[1] + noise, correlation)
    low, high, _, found = ends_of(problem)
    a = np.column_stack(problem.columns(()))
    least = lsq_linear(a, problem.target, (0.0, np.inf)).cost
    whole = uncertainty(found.slopes, found.residual, ordered=False)
    variance = float(found.residual @ found.residual) / (ROWS - 2)

    def rise(value: float) -> float:
        left = problem.target - value * a[:, 0]
        other = max(float(a[:, 1] @ left) / float(a[:, 1] @ a[:, 1]), 0.0)
        return float(np.sum((left - other * a[:, 1]) ** 2)) - 2 * least

    for end in (low[0], high[0]):
        if end > 0.0:
            assert np.sqrt(rise(end) / variance) == pytest.approx(whole.quantile, rel=0.08)


def test_far_from_bounds_the_ends_are_the_standard_errors() -> None:
    noise = 0.1 * np.random.default_rng(1).standard_normal(ROWS)
    low, high, spread, found = ends_of(linear(lambda c: 1.0 * c[0] + 1.0 * c[1] + noise, 0.5))
    assert low == pytest.approx(found.point - spread.quantile * spread.errors)
    assert high == pytest.approx(found.point + spread.quantile * spread.errors)


def decay(noise: float, seed: int = 3) -> Separable:
    """A decay whose rate the noise may hide: a nonlinear parameter in logarithms, from 0.001 to 1000."""
    rate = ShapeParameter("r", "rate", 1e-3, 1e3, scale="log")

    def columns(q: Sequence[Any]) -> Sequence[Any]:
        return [np.exp(-q[0] * X)]

    target = np.exp(-1.3 * X) + noise * np.random.default_rng(seed).standard_normal(ROWS)
    return Separable(columns, target, (rate,), (Gain("c", "height", EFFORT, nonnegative=True),))


def test_a_valley_gives_ends_of_unlike_height() -> None:
    problem = decay(2.0)
    point = minimise(outer_problem(problem), np.log([1.0])).point
    low, high, spread, found = ends_of(problem, point)
    assert low[0] < found.point[0] < high[0]
    assert not np.isclose(high[0] - found.point[0], found.point[0] - low[0], rtol=0.2)
    assert spread.rank == 2


def test_an_interval_as_wide_as_its_range_is_none() -> None:
    problem = decay(400.0)
    point = minimise(outer_problem(problem), np.log([1.0])).point
    low, high, *_ = ends_of(problem, point)
    assert np.isinf(high[0] - low[0])


def test_a_law_without_a_residual_has_intervals_without_width() -> None:
    low, high, _, found = ends_of(linear(lambda c: 1.0 * c[0], 0.5))
    assert low[0] == pytest.approx(1.0)
    assert high[0] == pytest.approx(1.0)
    assert np.all(low <= found.point)
    assert np.all(high >= found.point)


def test_the_rise_at_the_ends_is_students_for_independent_rows() -> None:
    rng = np.random.default_rng(0)
    slopes, residual = rng.normal(size=(12, 3)), rng.normal(size=12)
    expected = student_quantile(9, 0.975) ** 2 * (residual @ residual) / 9
    for identified in (True, False):
        slopes[:, 1] *= identified  # what is not identified counts as the middle one of the others
        for moving in (
            [True, True, True],
            [True, False, True],
        ):  # all, or but for a parameter on its bound
            free = np.array(moving)
            found: Any = SimpleNamespace(slopes=slopes, residual=residual, free=free)
            robust = uncertainty(slopes, residual, ordered=False)
            np.testing.assert_allclose(
                profile_intervals.rises_at_ends(found, robust), expected, rtol=2e-3
            )


def test_the_next_value_to_try() -> None:
    to: Any = profile_intervals.next_value
    assert to(1.0, 0.5, 2.0, 1.5, 0.0) == pytest.approx(1.5)
    assert to(1.0, 0.9, 2.0, 1.9, 0.0) == pytest.approx(1.1)
    assert to(1.0, 0.99, 2.0, 1.99, 0.0) == pytest.approx(
        1.05
    )  # not nearer than a twentieth to either end
    assert to(1.0, 0.0, 2.0, 1.01, 0.0) == pytest.approx(1.95)
    assert to(1.0, 0.5, 2.0, np.inf, 0.0) == pytest.approx(2.1)
    assert to(1.0, 0.05, 2.0, np.inf, 0.0) == pytest.approx(4.0)  # at most four times as far
    assert to(3.0, 0.5, 2.0, np.inf, 2.0) == pytest.approx(4.1)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_first_try_in_another_basin_does_not_end_an_interval(side: float) -> None:
    """The profile rises to its limit at 4; beyond 6 lies another basin, and a start from there stays in it."""

    def rise(_: int, value: float, start: Any) -> tuple[float, Any]:
        away = abs(value)
        lost = away >= 6.0 or (start is not None and abs(start[0]) >= 6.0)
        return (200.0 if lost else away / 4.0), np.array([value])

    far = np.array([1e6])
    search: Any = SimpleNamespace(
        point=np.zeros(1), lower=-far, upper=far, first=np.array([90.0]), _rise=rise
    )
    assert profile_intervals._Search.end(search, 0, side) == pytest.approx(side * 4.0, rel=0.1)


def test_a_steep_rise_beyond_the_end_says_not_where_it_is() -> None:
    to: Any = profile_intervals.next_value
    assert to(0.0, 0.1, 1.0, 200.0, 0.0) == to(0.0, 0.1, 1.0, 3.0, 0.0) == pytest.approx(0.9 / 2.9)
