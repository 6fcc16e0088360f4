"""The solver: bounds, stops, tolerance, linear problems, places where the cost cannot be evaluated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import least_squares, lsq_linear

from erclutch.fit.solver.levenberg_marquardt import Linearisation, Problem, minimise
from tests.support.examples import examples

Array = NDArray[np.float64]


def problem_of(
    residual: Callable[[Array], Array],
    slopes: Callable[[Array], Array],
    lower: list[float] | Array,
    upper: list[float] | Array,
) -> Problem:
    """A problem from its residual r(u), shape (n,), and dr/du, shape (n, k)."""

    def linearise(u: Array) -> Linearisation:
        r, k = residual(u), u.size
        triangle = np.asarray(np.linalg.qr(np.column_stack([-slopes(u), r]), mode="r"))
        triangle = np.vstack([triangle, np.zeros((max(k - triangle.shape[0], 0), k + 1))])
        return Linearisation(float(r @ r), triangle[:k, :k], triangle[:k, k])

    def cost(u: Array) -> float:
        return float(residual(u) @ residual(u))

    return Problem(cost, linearise, np.asarray(lower, float), np.asarray(upper, float))


def linear(matrix: Array, target: Array, lower: Array, upper: Array) -> Problem:
    return problem_of(lambda u: matrix @ u - target, lambda u: matrix, lower, upper)


def rosenbrock(lower: list[float], upper: list[float]) -> Problem:
    return problem_of(
        lambda u: np.array([10.0 * (u[1] - u[0] ** 2), 1.0 - u[0]]),
        lambda u: np.array([[-20.0 * u[0], 10.0], [-1.0, 0.0]]),
        lower,
        upper,
    )


FREE = [-np.inf, -np.inf], [np.inf, np.inf]


def test_rosenbrock_to_a_residual_of_zero() -> None:
    found = minimise(rosenbrock(*FREE), np.array([-1.2, 1.0]))
    assert found.stop == "converged"
    assert np.allclose(found.point, 1.0, atol=1e-8)
    assert found.cost < 1e-16
    assert not found.at_lower.any()
    assert not found.at_upper.any()


def test_a_start_at_the_solution_stays_there() -> None:
    found = minimise(rosenbrock(*FREE), np.array([1.0, 1.0]))
    assert found.stop == "converged"
    assert found.iterations == 1
    assert found.point.tolist() == [1.0, 1.0]


@pytest.mark.parametrize("seed", range(8))
def test_a_minimum_at_a_kink_of_the_cost_is_one(seed: int) -> None:
    """A line with a knee: the cost has a kink wherever the knee passes a row, and is flat nowhere."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(0.0, 2.0, 2000)
    y = 3.0 * np.maximum(x - 1.1, 0.0) + 0.3 * rng.standard_normal(x.size)

    def slopes(u: Array) -> Array:
        beyond = x > u[0]
        return np.column_stack([np.where(beyond, -u[1], 0.0), np.maximum(x - u[0], 0.0)])

    knee = problem_of(lambda u: u[1] * np.maximum(x - u[0], 0.0) - y, slopes, *FREE)
    found = minimise(knee, np.array([0.5, 1.0]), max_iterations=500)
    assert found.stop == "converged"
    assert found.point[0] == pytest.approx(1.1, abs=0.05)


@pytest.mark.parametrize(
    ("lower", "upper"), [([-2.0, -1.0], [0.5, 2.0]), ([1.5, -3.0], [3.0, 3.0])]
)
def test_a_solution_on_a_bound(lower: list[float], upper: list[float]) -> None:
    found = minimise(
        rosenbrock(lower, upper),
        np.array([0.5 * (a + b) for a, b in zip(lower, upper, strict=True)]),
    )
    peer = least_squares(
        lambda u: np.array([10.0 * (u[1] - u[0] ** 2), 1.0 - u[0]]),
        [0.5 * (a + b) for a, b in zip(lower, upper, strict=True)],
        bounds=(lower, upper),
        xtol=1e-14,
        ftol=1e-14,
        gtol=1e-14,
    )
    assert found.stop == "converged"
    assert np.allclose(found.point, peer.x, atol=1e-5)
    assert found.cost <= 2.0 * peer.cost * (1 + 1e-9)
    on_upper = upper[0] == 0.5
    assert found.at_upper.tolist() == [on_upper, False]
    assert found.at_lower.tolist() == [not on_upper, False]


def test_a_start_outside_is_clipped() -> None:
    seen: list[Array] = []
    inner = rosenbrock([-2.0, -2.0], [2.0, 2.0])

    def cost(u: Array) -> float:
        seen.append(u)
        return inner.cost(u)

    problem = Problem(cost, inner.linearise, inner.lower, inner.upper)
    found = minimise(problem, np.array([-50.0, 70.0]))
    assert np.allclose(found.point, 1.0, atol=1e-6)
    assert all(np.all(u >= -2.0) and np.all(u <= 2.0) for u in seen)


def test_no_point_outside_the_bounds_is_ever_tried() -> None:
    seen: list[Array] = []

    def residual(u: Array) -> Array:
        seen.append(u.copy())
        return np.array([np.log(u[0]) - 1.0, np.sqrt(u[1] - 1.0) - 0.3, u[0] * u[1]])

    def slopes(u: Array) -> Array:
        return np.array([[1 / u[0], 0.0], [0.0, 0.5 / np.sqrt(u[1] - 1.0)], [u[1], u[0]]])

    found = minimise(
        problem_of(residual, slopes, [1e-6, 1.0 + 1e-9], [50.0, 60.0]), np.array([40.0, 55.0])
    )
    points = np.array(seen)
    assert points.min(axis=0)[0] >= 1e-6
    assert points.min(axis=0)[1] >= 1.0 + 1e-9
    assert found.cost <= seen_costs(points).min() * (1 + 1e-12)


def seen_costs(points: Array) -> Array:
    a, b = points.T
    return (np.log(a) - 1.0) ** 2 + (np.sqrt(b - 1.0) - 0.3) ** 2 + (a * b) ** 2


@pytest.mark.slow
def test_converged_means_at_the_minimum_of_a_curved_valley() -> None:
    def residual(u: Array) -> Array:
        return np.array([np.log(u[0]) - 1.0, np.sqrt(u[1] - 1.0) - 0.3, u[0] * u[1]])

    def slopes(u: Array) -> Array:
        return np.array([[1 / u[0], 0.0], [0.0, 0.5 / np.sqrt(u[1] - 1.0)], [u[1], u[0]]])

    problem = problem_of(residual, slopes, [1e-6, 1.001], [50.0, 60.0])
    found = minimise(problem, np.array([40.0, 55.0]), max_iterations=10_000)
    peer = least_squares(
        residual,
        [40.0, 55.0],
        jac=slopes,
        bounds=([1e-6, 1.001], [50.0, 60.0]),
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-15,
    )
    assert found.stop == "converged"
    assert found.cost == pytest.approx(2.0 * peer.cost, rel=1e-6)


@pytest.mark.slow
@settings(max_examples=examples(150), deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.floats(0.05, 3.0))
def test_bounded_linear_problems_in_few_steps(seed: int, k: int, width: float) -> None:
    rng = np.random.default_rng(seed)
    matrix, target = rng.normal(size=(3 * k + 2, k)), rng.normal(size=3 * k + 2)
    lower, upper = np.full(k, -width), np.full(k, width)
    found = minimise(linear(matrix, target, lower, upper), np.zeros(k), tolerance=1e-12)
    peer = lsq_linear(matrix, target, (lower, upper), method="bvls")
    assert found.stop == "converged"
    assert found.iterations <= 4 * k + 4
    assert np.isclose(found.cost, 2.0 * peer.cost, rtol=1e-7, atol=1e-10)
    assert np.allclose(found.point, peer.x, atol=1e-4)


def test_a_free_linear_problem_takes_one_step_and_one_to_see_it() -> None:
    rng = np.random.default_rng(1)
    matrix, target = rng.normal(size=(30, 4)), rng.normal(size=30)
    free = np.full(4, np.inf)
    found = minimise(linear(matrix, target, -free, free), np.ones(4))
    assert found.iterations <= 2
    assert np.allclose(found.point, np.linalg.lstsq(matrix, target)[0], rtol=1e-10)


def test_badly_scaled_columns_do_not_matter() -> None:
    rng = np.random.default_rng(2)
    matrix, target, scale = (
        rng.normal(size=(30, 3)),
        rng.normal(size=30),
        np.array([1e-8, 1.0, 1e8]),
    )
    free = np.full(3, np.inf)
    found = minimise(linear(matrix * scale, target, -free, free), np.zeros(3))
    assert np.allclose(found.point * scale, np.linalg.lstsq(matrix, target)[0], rtol=1e-9)


def test_collinear_columns_end_at_a_minimum() -> None:
    matrix = np.column_stack([np.ones(10), np.ones(10)])
    found = minimise(
        linear(matrix, np.full(10, 3.0), np.full(2, -10.0), np.full(2, 10.0)), np.zeros(2)
    )
    assert found.stop == "converged"
    assert np.isclose(found.point.sum(), 3.0)
    assert found.cost < 1e-18


def test_a_column_of_zeros_is_left_where_it_was() -> None:
    matrix = np.column_stack([np.arange(10.0), np.zeros(10)])
    found = minimise(
        linear(matrix, np.arange(10.0) * 2, np.full(2, -10.0), np.full(2, 10.0)),
        np.array([0.0, 7.0]),
    )
    assert np.allclose(found.point, [2.0, 7.0])


def behind_a_wall(beyond: float) -> Problem:
    """Zero at u = 1.9; no cost from u = 2 on."""

    def residual(u: Array) -> Array:
        return np.array([100.0 * (1.0 / (2.0 - u[0]) - 1.0 / 0.1) if u[0] < 2.0 else beyond])

    return problem_of(
        residual, lambda u: np.array([[100.0 / (2.0 - u[0]) ** 2]]), [-np.inf], [np.inf]
    )


@pytest.mark.parametrize("beyond", [np.inf, np.nan, -np.inf])
def test_regions_without_a_cost_are_backed_out_of(beyond: float) -> None:
    """The first full steps go far beyond the wall."""
    found = minimise(behind_a_wall(beyond), np.array([-3.0]), max_iterations=200)
    assert np.isclose(found.point[0], 1.9, atol=1e-9)
    assert np.isfinite(found.cost)
    assert found.iterations < 50


def test_a_residual_of_zero_up_to_rounding_is_converged() -> None:
    assert minimise(behind_a_wall(np.inf), np.array([-3.0]), max_iterations=200).stop == "converged"


def test_too_few_iterations_are_said() -> None:
    found = minimise(rosenbrock(*FREE), np.array([-1.2, 1.0]), max_iterations=3)
    assert found.stop == "iterations"
    assert found.iterations == 3
    start = float(rosenbrock(*FREE).cost(np.array([-1.2, 1.0])))
    assert found.cost <= start


def test_a_tighter_tolerance_comes_closer() -> None:
    x = np.linspace(0.0, 4.0, 40)
    y = 2.0 * np.exp(-0.7 * x) + 0.05 * np.sin(9 * x)
    problem = problem_of(
        lambda u: u[0] * np.exp(-u[1] * x) - y,
        lambda u: np.column_stack([np.exp(-u[1] * x), -u[0] * x * np.exp(-u[1] * x)]),
        *FREE,
    )
    exact = minimise(problem, np.array([1.0, 1.0]), tolerance=1e-15, max_iterations=500).point
    errors, steps = [], []
    for tolerance in (1e-2, 1e-6, 1e-12):
        found = minimise(problem, np.array([1.0, 1.0]), tolerance=tolerance)
        assert found.stop == "converged"
        errors.append(float(np.abs(found.point - exact).max()))
        steps.append(found.iterations)
    assert errors[0] >= errors[1] >= errors[2]
    assert errors[2] < 1e-7
    assert steps == sorted(steps)


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_cost_never_rises_and_the_outcome_is_that_of_its_point(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.linspace(0.0, 3.0, 25)
    y = rng.normal(size=25)
    problem = problem_of(
        lambda u: u[0] * np.tanh(u[1] * x) + u[2] - y,
        lambda u: np.column_stack(
            [np.tanh(u[1] * x), u[0] * x / np.cosh(u[1] * x) ** 2, np.ones(25)]
        ),
        [-5.0] * 3,
        [5.0] * 3,
    )
    start = rng.uniform(-5, 5, 3)
    found = minimise(problem, start)
    assert found.cost <= problem.cost(start)
    assert np.isclose(found.cost, problem.cost(found.point))
    assert np.all(np.abs(found.point) <= 5.0)
    again = minimise(problem, start)
    assert np.array_equal(found.point, again.point)
    assert found.iterations == again.iterations


def test_no_coordinates_at_all() -> None:
    """A law without nonlinear parameters is already solved by its gains."""
    nothing = np.zeros(0)
    problem = Problem(
        lambda u: 4.0, lambda u: Linearisation(4.0, np.zeros((0, 0)), nothing), nothing, nothing
    )
    found = minimise(problem, nothing)
    assert found.stop == "converged"
    assert found.cost == 4.0


def test_slopes_whose_squares_are_beyond_double_precision_move_nothing() -> None:
    """A singular value of 1e-170 was divided by its square, which is zero."""
    slopes = np.array([[1e-170, 0.0], [0.0, 1e-170]])
    start = np.array([0.5, -0.5])
    everywhere = np.full(2, np.inf)
    found = minimise(linear(slopes, np.ones(2), -everywhere, everywhere), start)
    assert np.array_equal(found.point, start)
    assert found.cost == pytest.approx(2.0)


@pytest.mark.parametrize("flat", [1e-170, 1e-150, 1e-90])
def test_slopes_that_vanish_after_a_step_end_the_search(flat: float) -> None:
    """Beside the steep slopes of the start they are nothing, and a power of theirs was divided by."""
    everywhere = np.full(1, np.inf)

    def linearised(u: NDArray[np.float64]) -> Linearisation:
        slope = 1.0 if u[0] == 0.0 else flat
        return Linearisation(cost(u), np.array([[slope]]), np.ones(1))

    def cost(u: NDArray[np.float64]) -> float:
        return 1.0 / (1.0 + abs(float(u[0])))

    found = minimise(Problem(cost, linearised, -everywhere, everywhere), np.zeros(1))
    assert np.isfinite(found.point).all()
    assert found.cost < 1.0
