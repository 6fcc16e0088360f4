"""The C's own exp, tanh and powers: within the ulp that docs/export.md states, coefficients as the study finds them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from erclutch.arithmetic.elementary import COEFFICIENTS, elementary
from erclutch.arithmetic.precision import PRECISIONS, PrecisionName
from erclutch.export.rounding import ULPS

COUNT = 100_000


def largest_ulp(found: np.ndarray, exact: np.ndarray) -> float:
    unit = np.spacing(np.abs(exact).astype(found.dtype)).astype(np.longdouble)
    return float(np.max(np.abs(found.astype(np.longdouble) - exact) / unit))


def arguments(dtype: Any, largest: float) -> np.ndarray:
    rng = np.random.default_rng(0)
    wide = rng.uniform(-largest, largest, COUNT)
    near = rng.uniform(-2.0, 2.0, COUNT)
    small = np.sign(near) * 10.0 ** rng.uniform(-20.0, 1.0, COUNT)
    return np.concatenate([wide, near, small]).astype(dtype)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("name", ["exp", "expm1", "tanh"])
def test_functions_are_as_precise_as_stated(precision: PrecisionName, name: str) -> None:
    p = PRECISIONS[precision]
    x = arguments(p.dtype, 80.0 if p.width == 32 else 700.0)
    exact = getattr(np, name)(x.astype(np.longdouble))
    assert largest_ulp(elementary(p)[name](x), exact) <= ULPS[precision][name]


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("exponent", [-0.975, -0.75, 0.1, 1 / 3, 0.5, 1.5, 2.9])
def test_powers_are_as_precise_as_stated(precision: PrecisionName, exponent: float) -> None:
    p = PRECISIONS[precision]
    n = p.dtype.type(exponent)
    x = (10.0 ** np.random.default_rng(1).uniform(-12.0, 8.0, COUNT)).astype(p.dtype)
    exact = np.power(x.astype(np.longdouble), np.longdouble(n))
    assert largest_ulp(elementary(p)["power"](x, n), exact) <= ULPS[precision]["power"]


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_functions_stay_finite_for_anything(precision: PrecisionName) -> None:
    p = PRECISIONS[precision]
    info = np.finfo(p.dtype)
    x = np.array(
        [np.nan, np.inf, -np.inf, info.max, -info.max, info.smallest_subnormal, -0.0, 0.0], p.dtype
    )
    functions = elementary(p)
    with np.errstate(all="ignore"):
        for name, function in functions.items():
            if name in (
                "absolute",
                "nearest",
            ):  # what is not finite stays so; no such angle is ever rounded
                continue
            # A function of a held argument is only ever called behind its hold.
            first = functions[name.replace("_held", "_hold")](x) if name.endswith("_held") else x
            found = function(first, p.dtype.type(0.5)) if name == "power" else function(first)
            assert np.all(np.isfinite(found)), name


@pytest.mark.slow
def test_coefficients_are_those_of_the_study() -> None:
    from tests.support.elementary_coefficients import found

    assert {name: list(numbers) for name, numbers in COEFFICIENTS.items()} == found()
