"""Variable projection against least squares over all parameters at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import least_squares

from erclutch.fit.solver import variable_projection
from erclutch.fit.solver.levenberg_marquardt import minimise
from erclutch.fit.solver.variable_projection import (
    Separable,
    coordinates,
    jacobian,
    outer_problem,
    parameters,
    project,
    triangle_of,
)
from erclutch.models.laws import Dimension, Gain, ShapeParameter
from tests.support.examples import examples

Array = NDArray[np.float64]
X = np.linspace(0.0, 3.0, 120)
SHAPES = (ShapeParameter("a", "", 0.05, 20.0, scale="log"), ShapeParameter("b", "", -2.0, 2.0))


def gains(*nonnegative: bool) -> tuple[Gain, ...]:
    return tuple(
        Gain(f"c{i}", "", Dimension(effort=1), bound) for i, bound in enumerate(nonnegative)
    )


def columns(q: Sequence[Any]) -> Sequence[Any]:
    a, b = q
    return np.exp(-a * X), np.tanh(X - b), np.ones_like(X)


def separable(target: Array, *nonnegative: bool) -> Separable:
    return Separable(columns, target, SHAPES, gains(*nonnegative))


def noisy(
    seed: int, c: Sequence[float], a: float = 1.7, b: float = 0.6, noise: float = 0.05
) -> Array:
    rng = np.random.default_rng(seed)
    return np.column_stack(columns((a, b))) @ np.array(c) + noise * rng.normal(size=X.size)


def test_the_gains_of_a_step_that_was_tried_are_not_looked_for_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked: list[int] = []
    own = variable_projection.gains_of
    monkeypatch.setattr(
        variable_projection, "gains_of", lambda *given: (looked.append(1), own(*given))[1]
    )
    problem = outer_problem(separable(noisy(1, (1.0, 0.5, 0.2)), False, False, False))
    tried, other = np.array([0.3, 0.4]), np.array([0.5, 0.4])
    cost = problem.cost(tried)
    assert problem.linearise(tried.copy()).cost == cost
    assert len(looked) == 1
    assert problem.linearise(other).cost != cost
    assert len(looked) == 2


# --- triangles --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rows", "wide"), [(1, 3), (2, 5), (5, 5), (50, 4), (1025, 8), (40_000, 6), (70_001, 3)]
)
def test_the_triangle_is_numpys_up_to_signs(rows: int, wide: int) -> None:
    matrix = np.random.default_rng(rows).normal(size=(rows, wide))
    for ordered in (np.asfortranarray(matrix), np.ascontiguousarray(matrix)):
        r = triangle_of(ordered)
        assert r.shape == (wide, wide)
        assert np.array_equal(r, np.triu(r))
        peer = np.asarray(np.linalg.qr(matrix, mode="r"))
        assert np.allclose(np.abs(r[: peer.shape[0]]), np.abs(peer), rtol=1e-9, atol=1e-10)
        assert np.allclose(r.T @ r, matrix.T @ matrix, rtol=1e-9, atol=1e-9)


def test_the_triangle_of_no_rows_is_zero_and_nothing_is_printed(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """LAPACK wrote "On entry to DGEQRF parameter number 4 had an illegal value" to the user's terminal."""
    assert not triangle_of(np.empty((0, 3))).any()
    assert capfd.readouterr() == ("", "")


def test_the_triangle_of_slices_keeps_an_ill_conditioned_matrix() -> None:
    """Columns that differ by 1e-9 only: normal equations would lose the difference."""
    rng = np.random.default_rng(0)
    first = rng.normal(size=200_000)
    matrix = np.column_stack([first, first + 1e-9 * rng.normal(size=first.size)])
    peer = np.asarray(np.linalg.qr(matrix, mode="r"))
    assert np.isclose(abs(triangle_of(matrix)[1, 1]), abs(peer[1, 1]), rtol=1e-4)


# --- gains ------------------------------------------------------------------------------------------------------------


def test_gains_are_those_of_least_squares() -> None:
    y = noisy(1, (2.0, 0.7, -0.4))
    matrix = np.column_stack(columns((1.2, 0.3)))
    c, cost = np.linalg.lstsq(matrix, y)[:2]
    found = project(separable(y, True, True, False), (1.2, 0.3))
    assert np.allclose(found.gains, c)
    assert np.isclose(found.cost, float(cost[0]))
    assert not found.held.any()
    assert not found.dead.any()


def test_a_bounded_gain_is_held_and_the_cost_is_that_of_the_rest() -> None:
    y = noisy(2, (2.0, 0.7, -0.4))
    found = project(separable(y, True, True, True), (1.7, 0.6))
    assert found.held.tolist() == [False, False, True]
    assert not found.dead.any()
    matrix = np.column_stack(columns((1.7, 0.6)))
    assert np.isclose(found.cost, float(np.sum((y - matrix @ found.gains) ** 2)))


def test_unexcited_columns_are_dead() -> None:
    """A column that is next to nothing gets no gain, however well its noise would fit."""
    y = noisy(3, (2.0, 0.7, 0.0))
    rng = np.random.default_rng(3)
    for size, dead in ((0.0, True), (1e-5, True), (1.0, False)):
        column = size * rng.normal(size=X.size)
        problem = Separable(
            lambda q, c=column: (np.exp(-q[0] * X), c), y, SHAPES[:1], gains(True, False)
        )
        found = project(problem, (1.7,))
        assert found.dead.tolist() == [False, dead]
        assert found.held[1] == dead
        if dead:
            assert found.gains[1] == 0.0


def test_columns_that_overflow_cost_infinity() -> None:
    problem = Separable(
        lambda q: (np.exp(q[0] * 1e4 * X),), noisy(4, (1, 1, 0)), SHAPES[:1], gains(True)
    )
    found = project(problem, (1.0,))
    assert found.cost == np.inf
    assert found.gains.tolist() == [0.0]


def test_coordinates_and_back() -> None:
    q = [0.3, -1.2]
    u = coordinates(SHAPES, q)
    assert np.allclose(u, [np.log(0.3), -1.2])
    assert np.allclose(parameters(SHAPES, u), q)
    low, high = separable(X, True, True, True).bounds
    assert np.allclose(low, [np.log(0.05), -2.0])
    assert parameters(SHAPES, high + 1e-12) == [20.0, 2.0]
    assert parameters(SHAPES, low - 1e-12) == [0.05, -2.0]


# --- the reduced problem ----------------------------------------------------------------------------------------------


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-2.5, 2.5), st.floats(-1.8, 1.8), st.booleans())
def test_the_reduced_gradient_is_that_of_the_cost(
    seed: int, log_a: float, b: float, bounded: bool
) -> None:
    y = noisy(seed, (1.0, -0.5, 0.3), noise=0.3)
    problem = separable(y, bounded, bounded, bounded)
    u, step = np.array([log_a, b]), 1e-5
    one = project(problem, parameters(SHAPES, u))
    local = outer_problem(problem).linearise(u)
    assert np.isclose(local.cost, one.cost)
    gradient = -2.0 * local.triangle.T @ local.vector
    for i in range(2):
        d = step * (np.arange(2) == i)
        high, low = (project(problem, parameters(SHAPES, u + s)) for s in (d, -d))
        if not (np.array_equal(high.held, one.held) and np.array_equal(low.held, one.held)):
            continue  # the cost has a kink where a gain reaches its bound
        assert np.isclose(gradient[i], (high.cost - low.cost) / (2 * step), rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("bounded", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_the_minimum_is_that_over_all_parameters(seed: int, bounded: bool) -> None:
    y = noisy(seed, (2.0, 0.7, -0.4))
    problem = separable(y, bounded, bounded, bounded)
    found = minimise(outer_problem(problem), np.array([np.log(1.2), 0.4]), tolerance=1e-14)
    lowest = 0.0 if bounded else -np.inf
    peer = least_squares(
        lambda p: np.column_stack(columns(list(p[:2]))) @ p[2:] - y,
        [1.2, 0.4, 1.0, 1.0, 0.1],
        bounds=([0.05, -2.0] + [lowest] * 3, [20.0, 2.0] + [np.inf] * 3),
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-15,
        max_nfev=2000,
    )
    assert found.cost <= 2.0 * peer.cost * (1 + 1e-9)
    q = parameters(SHAPES, found.point)
    assert np.allclose(q, peer.x[:2], rtol=1e-4)
    assert np.allclose(project(problem, q).gains, peer.x[2:], atol=1e-4)


def test_the_jacobian_is_that_of_the_fitted_effort() -> None:
    y, u = noisy(7, (2.0, 0.7, -0.4)), np.array([0.4, 0.2])
    made, slopes, found = jacobian(separable(y, True, True, False), u)
    assert np.allclose(made, np.column_stack(columns(parameters(SHAPES, u))))
    for i in range(2):
        d = 1e-6 * (np.arange(2) == i)
        high, low = (
            np.column_stack(columns(parameters(SHAPES, u + s))) @ found.gains for s in (d, -d)
        )
        assert np.allclose(slopes[:, i], (high - low) / 2e-6, atol=1e-7)
