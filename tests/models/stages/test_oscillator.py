"""The numbers of an oscillator's step against complex functions and against the matrix exponential."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from erclutch.models.stages.oscillator import coefficients, decaying_waves


@pytest.mark.parametrize(
    "x", [0.0, 1e-12, -1e-12, 0.0099, -0.0099, 0.0101, -0.0101, 1.0, -1.0, 30.0, -30.0, 400.0]
)
def test_hyperbolic_and_trigonometric_functions_are_one(x: float) -> None:
    root = np.sqrt(complex(x))
    even, odd = np.exp(abs(root)) * np.array(decaying_waves(x, abs(root)))
    size = abs(np.cosh(root)) + 1.0
    assert even == pytest.approx(float(np.cosh(root).real), abs=1e-14 * size)
    assert odd == pytest.approx(float((np.sinh(root) / root).real) if x else 1.0, abs=1e-13 * size)


@pytest.mark.parametrize("zeta", [0.1, 0.7, 0.999, 1.0, 1.001, 3.0])
@pytest.mark.parametrize("step", [1e-4, 1e-2, 0.3, 30.0, 1e4])
def test_a_step_is_the_matrix_exponential(zeta: float, step: float) -> None:
    tau = 0.05
    exact = expm(np.array([[0.0, 1.0], [-1.0, -2.0 * zeta]]) * step / tau)
    found = np.array(coefficients(tau, zeta, step)).reshape(2, 2)
    np.testing.assert_allclose(found, exact, atol=1e-12)
