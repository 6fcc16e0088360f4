"""Laws against the equations in print, and against each other in their limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.models.laws import law_from_name
from erclutch.models.laws.smooth import OFF_ZERO
from erclutch.models.laws.yield_stress import CRITICAL, POWER, SATURATING, SQUARE, TANH
from tests.support.examples import examples

E = np.linspace(0.05, 1.0, 20)[:, None]
W = np.array([-3.0, -0.6, -0.05, 0.05, 0.3, 1.0, 2.0])[None, :]
STIFF = 1e-3  # far below all slips above: the sign is the sign
SIGN = np.sign(W)
free = settings(max_examples=examples(30), deadline=None)


def same(got: Any, expected: Any, rtol: float = 1e-12) -> None:
    np.testing.assert_allclose(
        *np.broadcast_arrays(np.asarray(got, float), np.asarray(expected, float)),
        rtol=rtol,
        atol=1e-14,
    )


def columns_of(specification: str, *shape: float) -> tuple[Any, ...]:
    return law_from_name(specification).columns(E, W, STIFF, *shape)


@free
@given(n=st.floats(0.2, 4.0))
def test_bingham_is_equation_1(n: float) -> None:
    standing, viscous = columns_of("bingham/power", n)
    same(standing, E**n * SIGN, 1e-9)
    same(viscous, W)


@pytest.mark.parametrize("form", ["square", "power", "critical", "saturating", "tanh"])
def test_what_reduces_to_bingham(form: str) -> None:
    field = {
        "square": (),
        "power": (1.4,),
        "critical": (0.3,),
        "saturating": (1.3, 0.8),
        "tanh": (0.8,),
    }[form]
    bingham = columns_of(f"bingham/{form}", *field)
    for specification, shape in (
        ("herschel-bulkley", (1.0,)),  # m
        ("hem", (0.0, 3.0)),  # kappa, beta
        ("seo-seo", (0.0, 1.3)),  # a, b
    ):
        for got, expected in zip(
            columns_of(f"{specification}/{form}", *shape, *field), bingham, strict=True
        ):
            same(got, expected)
    standing, viscous = columns_of(
        f"cho-choi-jhon/{form}", 0.0, 2.0, 1e12, 1.0, *field
    )  # t_1, a, t_2, b
    same(standing, bingham[0])
    same(viscous, bingham[1], 1e-9)


def test_smallest_times_in_bounds_are_nearly_bingham() -> None:
    """t_1 -> 0 and a -> 0 as far as the bounds go."""
    bingham = columns_of("bingham/square")
    same(columns_of("seo-seo/square", 1e-3, 1.0)[0], bingham[0], 4e-3)
    same(columns_of("cho-choi-jhon/square", 1e-3, 2.0, 1.0, 0.5)[0], bingham[0], 2e-5)


def test_seo_seo_as_published() -> None:
    a, b = 2.5, 1.3
    standing, viscous = columns_of("seo-seo/square", a, b)
    g = np.abs(W)
    same(standing, E**2 * (1 - (1 - np.exp(-a * g)) / (1 + (a * g) ** b)) * SIGN, 1e-9)
    same(viscous, W)
    # The structure forms again: the static value comes back at high slip, and the dip is never deeper than 63 %.
    far = law_from_name("seo-seo/square").columns(np.ones(1), np.array([1e6]), STIFF, a, b)[0]
    assert far[0] == pytest.approx(1.0, abs=1e-6)
    for b in (0.05, 0.5, 1.16, 6.0):
        fall = law_from_name("seo-seo/square").columns(
            np.ones(4000), np.geomspace(0.05, 1e3, 4000), STIFF, 1.0, b
        )[0]
        assert 1 - np.exp(-1) >= 1 - fall.min() >= 0.316


def test_cho_choi_jhon_as_published() -> None:
    t_1, a, t_2, b = 3.0, 1.7, 0.8, 0.6
    standing, viscous = columns_of("cho-choi-jhon/square", t_1, a, t_2, b)
    g = np.abs(W)
    same(standing, E**2 / (1 + (t_1 * g) ** a) * SIGN, 1e-9)
    same(viscous, (1 + 1 / (t_2 * g) ** b) * W, 1e-9)


def test_herschel_bulkley_as_published() -> None:
    same(columns_of("herschel-bulkley/square", 0.6)[1], np.abs(W) ** 0.6 * SIGN, 1e-9)


@free
@given(r=st.floats(0.01, 100.0), T_y=st.floats(0.1, 10.0))
def test_casson_adds_roots(r: float, T_y: float) -> None:
    law = law_from_name("casson/square")
    (column,) = law.columns(E, W, STIFF, r)
    torque = T_y * column
    assert law.paper_form is not None
    published = law.paper_form({"r": r}, {"T_y": T_y}, 1.0)
    expected = (np.sqrt(published["tau_y"] * E**2) + np.sqrt(published["eta"] * np.abs(W))) ** 2
    # The regularised roots differ by 0.75e-12 / y**2 and 0.75e-12 / w**2, y = E**2.
    small = 1e-12 / E**4 + 1e-12 / W**2
    assert np.all(np.abs(torque - expected * SIGN) <= np.abs(expected) * (1e-12 + small))


@pytest.mark.slow
@free
@given(
    k_2=st.floats(0.01, 5.0),
    beta_1=st.floats(-0.9, 20.0),
    beta_2=st.floats(-10.0, 10.0).filter(lambda b: abs(b) > 1e-3),
    largest=st.floats(0.1, 2000.0),
)
def test_hem_is_equation_9_in_the_data_s_units(
    k_2: float, beta_1: float, beta_2: float, largest: float
) -> None:
    """k_2 (beta_1 + exp(beta_2 E)) with E in the user's unit, through our eta_0, kappa and beta, and back."""
    law = law_from_name("hem/square")
    beta_2 = beta_2 / largest
    eta_0, kappa = k_2 * (beta_1 + 1), np.expm1(beta_2 * largest) / (beta_1 + 1)
    standing, viscous = law.columns(E, W, STIFF, kappa, beta_2 * largest)
    field = E * largest
    same(standing, (field / largest) ** 2 * SIGN)
    terms = beta_1, np.exp(beta_2 * field)
    # The law's rate is OFF_ZERO beside beta; where the terms cancel, that is seen beside them, not beside their sum.
    off = np.abs(eta_0 * viscous - k_2 * (terms[0] + terms[1]) * W)
    assert np.all(off <= OFF_ZERO * k_2 * (abs(terms[0]) + terms[1]) * np.abs(W))
    assert law.paper_form is not None
    published = law.paper_form({"kappa": kappa, "beta": beta_2}, {"eta_0": eta_0}, largest)
    assert published == pytest.approx(
        {"k_2": k_2, "beta_1": beta_1, "beta_2": beta_2}, rel=1e-9, abs=1e-9
    )


@pytest.mark.parametrize("n", [2, 5, 10])
@free
@given(seed=st.integers(0, 2**32 - 1))
def test_rbfm_is_equations_12_to_14(n: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    law = law_from_name(f"rbfm-{n}/square")
    gains = dict(zip((g.name for g in law.gains), rng.normal(size=n + 1), strict=True))
    assert law.paper_form is not None
    k = [law.paper_form({}, gains, 1.0)["k_1"], *(gains[f"k_{i}"] for i in range(2, n + 1))]
    # The paper's field: 0 .. 0.5.
    largest, sigma_1, sigma_2 = 0.5, 0.01, 1.0
    field = E * largest
    eta = np.zeros_like(field)
    for i in range(1, n + 1):
        mu = (i - 1) / (n - 1) * largest
        sigma = sigma_1 + (i - 1) / (n - 1) * (sigma_2 - sigma_1)
        eta = eta + k[i - 1] * np.exp(-((field - mu) ** 2) / (2 * sigma**2))
    k_0 = gains["T_y"] / largest**2
    got = sum(g * c for g, c in zip(gains.values(), law.columns(E, W, STIFF), strict=True))
    np.testing.assert_allclose(got, k_0 * field**2 * SIGN + eta * W, rtol=0, atol=1e-12 * n)
    # The constraint of (16) is the bound of eta_0: the viscosity without field.
    zero = sum(
        g * c
        for g, c in zip(gains.values(), law.columns(np.zeros(1), np.ones(1), STIFF), strict=True)
    )
    assert zero == pytest.approx([gains["eta_0"]], rel=1e-12)


@free
@given(w_c=st.floats(0.1, 100.0))
def test_eddy_currents_drag_most_at_the_critical_slip(w_c: float) -> None:
    """T = 2 T_d / (w / w_c + w_c / w): Wouterse 1991 writes it with the reciprocals."""
    drag, viscous = columns_of("eddy-current/square", w_c)
    same(drag, E**2 * 2.0 / (W / w_c + w_c / W), 1e-9)
    same(viscous, W)
    law = law_from_name("eddy-current/square")
    at_rest, half, largest, twice, far = law.columns(
        np.ones(5), np.array([0.0, 0.5, 1.0, 2.0, 1e9]) * w_c, STIFF, w_c
    )[0]
    assert at_rest == 0.0
    assert largest == pytest.approx(1.0)
    assert half == pytest.approx(0.8)
    assert twice == pytest.approx(0.8)
    assert far == pytest.approx(0.0, abs=1e-8)


def test_quadratic_is_bingham_with_the_square_form() -> None:
    law = law_from_name("quadratic")
    assert law.stimulus is not None
    got = law.columns(law.stimulus(E), W, STIFF)
    for column, expected in zip(got, columns_of("bingham/square"), strict=True):
        same(column, expected)


def test_on_off_is_a_step_over_its_threshold() -> None:
    law = law_from_name("on-off")
    assert law.stimulus is not None
    field = np.array([0.0, 0.2, 0.3, 0.4, 0.5, 1.0, -1.0])
    np.testing.assert_allclose(law.stimulus(field, 0.4), [0, 0, 0, 0.5, 1, 1, 1], atol=1e-4)


# --- yield stress -----------------------------------------------------------------------------------------------------


@free
@given(E_c=st.floats(0.05, 20.0))
def test_critical_form_as_published(E_c: float) -> None:
    x = E / E_c
    unscaled = E**2 * np.tanh(np.sqrt(x)) / np.sqrt(x)
    at_reference = np.tanh(np.sqrt(1 / E_c)) / np.sqrt(1 / E_c)
    same(CRITICAL.factor(E, E_c), unscaled / at_reference, 1e-6)


@free
@given(E_c=st.floats(0.05, 1.0))
def test_critical_form_scaled(E_c: float) -> None:
    """T = 1.313 X**1.5 tanh sqrt X with T = y(E) / y(E_c), X = E / E_c (Chung, Jhon and Choi)."""
    X = E / E_c
    scaled = CRITICAL.factor(E, E_c) / CRITICAL.factor(np.array(E_c), E_c)
    same(scaled, X**1.5 * np.tanh(np.sqrt(X)) / np.tanh(1.0), 1e-7)
    same(scaled, 1.313 * X**1.5 * np.tanh(np.sqrt(X)), 1e-4)


def exponent(E_c: float, at: float) -> float:
    ahead, behind = CRITICAL.factor(np.array([at * 1.001, at / 1.001]), E_c)
    return float(np.log(ahead / behind) / (2 * np.log(1.001)))


def test_exponents_of_the_critical_form() -> None:
    assert exponent(20.0, 0.02) == pytest.approx(2.0, abs=1e-3)
    assert exponent(0.05, 1.3) == pytest.approx(1.5, abs=1e-2)
    assert exponent(0.05, 5.0) == pytest.approx(1.5, abs=1e-6)
    assert all(1.5 <= exponent(E_c, 0.5) <= 2.0 for E_c in np.geomspace(0.05, 20, 20))


@free
@given(n=st.floats(0.2, 4.0), E_s=st.floats(0.2, 20.0))
def test_saturating_form_follows_a_small_field_and_levels_off(n: float, E_s: float) -> None:
    same(SATURATING.factor(E, n, E_s), np.tanh((E / E_s) ** n) / np.tanh((1 / E_s) ** n), 1e-6)
    same(SATURATING.factor(np.array([1.0]), n, E_s), np.ones(1))
    same(TANH.factor(E, E_s), SATURATING.factor(E, 1.0, E_s), 1e-6)


def test_power_form_with_exponent_two_is_the_square_form() -> None:
    same(POWER.factor(E, 2.0), SQUARE.factor(E))
