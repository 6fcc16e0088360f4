"""The solver with learned curvature comes to the same minimum, in fewer steps where residuals are large."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from erclutch.fit.laws.curvature import with_curvature
from erclutch.fit.solver.levenberg_marquardt import Linearisation, Problem, minimise
from erclutch.signals.array import Array
from tests.support.examples import examples

T = np.linspace(0.0, 1.0, 40)


def problem(target: Array) -> Problem:
    """Two rates of a sum of exponentials, far from any of which the target may lie."""

    def residual(u: Array) -> Array:
        return target - np.exp(-u[0] * T) - 0.5 * np.exp(-u[1] * T)

    def linearise(u: Array) -> Linearisation:
        slopes = np.column_stack([-T * np.exp(-u[0] * T), -0.5 * T * np.exp(-u[1] * T)])
        q, r = np.linalg.qr(slopes)
        left = residual(u)
        return Linearisation(float(left @ left), r, q.T @ left)

    limits = np.array([-3.0, -3.0]), np.array([9.0, 9.0])
    return Problem(lambda u: float(residual(u) @ residual(u)), linearise, *limits)


@pytest.mark.slow
@settings(deadline=None, max_examples=examples(30))
@given(st.integers(0, 999), st.floats(0.0, 0.5))
def test_the_minimum_is_no_worse(seed: int, size: float) -> None:
    """With more noise than that the problem has several minima, and the solvers may end in different ones."""
    rng = np.random.default_rng(seed)
    target = np.exp(-T) + 0.5 * np.exp(-4.0 * T) + size * rng.normal(size=T.size)
    plain, learned = (
        minimise(p, np.array([0.5, 5.0]), tolerance=1e-12, max_iterations=300)
        for p in (problem(target), with_curvature(problem(target)))
    )
    # Where both rates meet, all slopes of the problem vanish: a saddle that holds either solver.
    assume(abs(learned.point[0] - learned.point[1]) > 1e-2)
    assert learned.cost <= plain.cost * (1 + 1e-6) + 1e-15


def test_large_residuals_take_fewer_steps() -> None:
    target = np.exp(-T) + 2.0 * np.sin(9.0 * T)
    plain, learned = (
        minimise(p, np.array([0.5, 5.0]), tolerance=1e-12, max_iterations=300)
        for p in (problem(target), with_curvature(problem(target)))
    )
    np.testing.assert_allclose(learned.cost, plain.cost, rtol=1e-9)
    assert learned.iterations < plain.iterations
