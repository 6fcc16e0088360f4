"""Laws of shear stress: known truths come back with intervals that hold them, and validation chooses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from erclutch.errors import CheckError, SettingError
from erclutch.fit.solver.outcome import Estimate
from erclutch.wings.rheology.flow_curve import (
    FlowCurve,
    FlowFit,
    fit_flow_curve,
    ranked,
    yield_text,
)
from erclutch.wings.rheology.flow_law import flow_laws
from erclutch.wings.rheology.flow_plateau import plateau_of
from tests.support.examples import examples

Array = NDArray[np.float64]
RATES = np.logspace(-2, 3, 40)

#: The laws as their sources print them, apart from the code under test, with parameters in 1/s and Pa.
LAWS: dict[str, tuple[Callable[..., Array], dict[str, float]]] = {
    "bingham": (lambda g, T_y, eta: T_y + eta * g, {"T_y": 12.0, "eta": 0.3}),
    "casson": (
        lambda g, T_y, r: (np.sqrt(T_y) + np.sqrt(r * T_y * g)) ** 2,
        {"T_y": 12.0, "r": 0.02},
    ),
    "herschel-bulkley": (lambda g, T_y, K, m: T_y + K * g**m, {"T_y": 12.0, "K": 3.0, "m": 0.45}),
    "seo-seo": (
        lambda g, T_sy, eta, a, b: T_sy * (1 - (1 - np.exp(-a * g)) / (1 + (a * g) ** b)) + eta * g,
        {"T_sy": 30.0, "eta": 0.2, "a": 1.5, "b": 0.6},
    ),
    "cho-choi-jhon": (
        lambda g, T_y, eta, t_1, a, t_2, b: (
            T_y / (1 + (t_1 * g) ** a) + eta * (1 + (t_2 * g) ** -b) * g
        ),
        {"T_y": 40.0, "eta": 0.2, "t_1": 3.0, "a": 1.2, "t_2": 0.02, "b": 0.7},
    ),
}


def curve_of(name: str, noise: float = 0.0, seed: int = 0, rates: Array = RATES) -> FlowCurve:
    law, parameters = LAWS[name]
    stress = law(rates, **parameters) * np.exp(
        noise * np.random.default_rng(seed).normal(size=rates.size)
    )
    return FlowCurve(name, rates, stress)


def estimates_of(fit: FlowFit) -> dict[str, Estimate]:
    return {e.name: e for e in fit.estimates}


def test_the_laws_here_are_all_there_are() -> None:
    assert set(LAWS) == set(flow_laws())


@pytest.mark.slow
@pytest.mark.parametrize("name", flow_laws())
def test_a_truth_without_noise_comes_back(name: str) -> None:
    fit = fit_flow_curve(curve_of(name), name)
    assert fit.log_rmse < 1e-6
    found = estimates_of(fit)
    assert set(found) == set(LAWS[name][1])
    for parameter, true in LAWS[name][1].items():
        assert np.isclose(found[parameter].value, true, rtol=1e-3), parameter
        assert found[parameter].at_bound is None
    assert np.allclose(fit.predicted, curve_of(name).stress, rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow) if n == "cho-choi-jhon" else n for n in flow_laws()],
)
def test_intervals_hold_the_truth(name: str) -> None:
    """95 % intervals of noisy curves: few misses."""
    hits = count = 0
    for seed in range(10):
        fit = fit_flow_curve(curve_of(name, noise=0.01, seed=seed), name)
        assert fit.stop == "converged"
        assert np.isclose(fit.log_rmse, 0.01 / np.log(10), rtol=0.5)
        for parameter, true in LAWS[name][1].items():
            estimate = estimates_of(fit)[parameter]
            assert 0.0 < estimate.low <= estimate.value <= estimate.high
            hits += int(estimate.low <= true <= estimate.high)
            count += 1
    assert hits / count >= 0.85


@pytest.mark.slow
def test_intervals_are_no_wider_than_they_must_be() -> None:
    """The width of Bingham's yield stress against the spread of its estimate over 200 curves."""
    values, halves = [], []
    for seed in range(200):
        estimate = estimates_of(
            fit_flow_curve(curve_of("bingham", 0.02, seed, RATES[::2]), "bingham")
        )["T_y"]
        values.append(np.log(estimate.value))
        halves.append(0.5 * np.log(estimate.high / estimate.low))
    assert np.isclose(np.mean(halves), 2.1 * np.std(values), rtol=0.2)


@pytest.mark.slow
@settings(max_examples=examples(20), deadline=None)
@given(st.floats(-3, 3), st.floats(-3, 3))
def test_units_of_rate_and_stress_only_scale(log_rate: float, log_stress: float) -> None:
    rate, stress = 10.0**log_rate, 10.0**log_stress
    curve = curve_of("bingham", noise=0.05, seed=1)
    one = fit_flow_curve(curve, "bingham")
    two = fit_flow_curve(FlowCurve("scaled", curve.rate * rate, curve.stress * stress), "bingham")
    assert np.isclose(one.log_rmse, two.log_rmse, rtol=1e-5)
    for name, factor in (("T_y", stress), ("eta", stress / rate)):
        assert np.isclose(
            estimates_of(two)[name].value, estimates_of(one)[name].value * factor, rtol=1e-4
        )


@pytest.mark.slow
def test_consistency_is_that_at_one_per_second() -> None:
    """K in Pa s^m does not depend on where the rates begin, and neither does its interval."""
    law, parameters = LAWS["herschel-bulkley"]
    rates = np.logspace(1.5, 4, 40)
    stress = law(rates, **parameters) * np.exp(0.003 * np.random.default_rng(2).normal(size=40))
    K = estimates_of(fit_flow_curve(FlowCurve("fast", rates, stress), "herschel-bulkley"))["K"]
    assert K.unit == "Pa*s^m"
    assert K.low < 3.0 < K.high
    assert np.isclose(K.value, 3.0, rtol=0.2)
    # The delta method by hand: the same fit with K at 1 1/s as the parameter.
    fit = fit_flow_curve(FlowCurve("fast", rates, stress), "herschel-bulkley")
    found = {name: e.value for name, e in estimates_of(fit).items()}
    model = found["T_y"] + found["K"] * rates ** found["m"]
    slopes = np.column_stack(
        [
            found["T_y"] / model,
            found["K"] * rates ** found["m"] / model,
            found["K"] * rates ** found["m"] * np.log(rates) / model,
        ]
    )
    residual = np.log(stress / model)
    spread = np.sqrt(np.linalg.inv(slopes.T @ slopes)[1, 1] * (residual @ residual) / 37)
    half = 0.5 * np.log(K.high / K.low)
    assert np.isclose(half, 2.026 * spread, rtol=0.08)  # Student's 97.5 % for 37


@pytest.mark.slow
def test_units_of_the_parameters() -> None:
    units = {
        name: e.unit
        for name, e in estimates_of(fit_flow_curve(curve_of("seo-seo"), "seo-seo")).items()
    }
    assert units == {"T_sy": "Pa", "eta": "Pa*s", "a": "s", "b": "1"}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bingham", "casson", "herschel-bulkley"])
def test_the_law_that_made_a_curve_wins_mostly(name: str) -> None:
    """Herschel-Bulkley holds Bingham, so by luck it wins now and then."""
    wins = 0
    for seed in range(10):
        fits = ranked(
            curve_of(name, noise=0.01, seed=seed), ("bingham", "casson", "herschel-bulkley")
        )
        assert [f.validated for f in fits[1:]] == sorted(f.validated for f in fits[1:])
        wins += int(fits[0].law == name)
    assert wins >= 6


@pytest.mark.slow
def test_richer_laws_never_fit_worse() -> None:
    curve = curve_of("herschel-bulkley", noise=0.03, seed=4)
    errors = {
        name: fit_flow_curve(curve, name).log_rmse for name in ("herschel-bulkley", "bingham")
    }
    assert errors["herschel-bulkley"] <= errors["bingham"] * (1 + 1e-6)


@pytest.mark.slow
def test_few_points_have_no_criterion_but_a_rank() -> None:
    curve = curve_of("bingham", noise=0.01, rates=np.logspace(0, 2, 4))
    fits = ranked(curve)
    assert {fit.law for fit in fits} == set(flow_laws())
    rich = next(fit for fit in fits if fit.law == "cho-choi-jhon")
    assert rich.aicc == np.inf
    assert rich.to_dict()["aicc"] is None


def test_a_curve_in_any_order() -> None:
    curve, shuffle = curve_of("bingham", 0.01), np.random.default_rng(0).permutation(RATES.size)
    other = FlowCurve("shuffled", curve.rate[shuffle], curve.stress[shuffle])
    assert np.isclose(
        fit_flow_curve(curve, "bingham").log_rmse,
        fit_flow_curve(other, "bingham").log_rmse,
        rtol=1e-8,
    )


# --- bad curves -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("which", ["rate", "stress"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_what_has_no_logarithm_is_refused(which: str, value: float) -> None:
    columns = {"rate": RATES.copy(), "stress": 5 + RATES}
    columns[which][7] = value
    with pytest.raises(CheckError, match=rf"sample: the shear {which} of point 8 is {value:g}"):
        fit_flow_curve(FlowCurve("sample", columns["rate"], columns["stress"]), "bingham")


def test_too_few_points_and_other_laws_are_refused() -> None:
    with pytest.raises(CheckError, match="3 points, at least 4"):
        fit_flow_curve(FlowCurve("sample", RATES[:3], RATES[:3]), "bingham")
    for name in ("hem", "rbfm-5", "on-off"):
        with pytest.raises(SettingError):
            fit_flow_curve(curve_of("bingham"), name)


@pytest.mark.parametrize("name", ["on-off", "quadratic"])
def test_laws_without_a_flow_curve_are_named_as_such(name: str) -> None:
    with pytest.raises(SettingError, match="no law of shear stress"):
        fit_flow_curve(curve_of("bingham"), name)


def test_rates_that_are_all_the_same_end_somewhere() -> None:
    """One rate cannot tell yield from flow: no crash, and no certainty."""
    curve = FlowCurve("same", np.full(8, 3.0), 5 + 0.1 * np.arange(8.0))
    found = estimates_of(fit_flow_curve(curve, "bingham"))
    assert any(
        e.at_bound or np.isinf(e.high - e.low) or e.high > 100 * e.low for e in found.values()
    )


def test_a_curve_without_noise_at_all() -> None:
    """A residual of exactly zero has no logarithm."""
    curve = FlowCurve("flat", np.array([1.0, 2.0, 4.0, 8.0, 16.0]), np.full(5, 3.0))
    assert estimates_of(fit_flow_curve(curve, "bingham"))["T_y"].value == pytest.approx(
        3.0, rel=1e-3
    )


# --- the choice -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_richer_law_that_follows_noise_is_not_chosen() -> None:
    chosen = [
        ranked(curve_of("herschel-bulkley", noise=0.02, seed=seed))[0].law for seed in range(6)
    ]
    assert chosen.count("herschel-bulkley") >= 5


@pytest.fixture(scope="module")
def of_all_laws() -> list[FlowFit]:
    """All laws on a curve of Herschel and Bulkley's."""
    return ranked(curve_of("herschel-bulkley", noise=0.01))


@pytest.mark.slow
def test_held_out_rates_judge_a_law_that_is_wrong(of_all_laws: list[FlowFit]) -> None:
    fits = {fit.law: fit for fit in of_all_laws}
    assert fits["bingham"].validated > 5 * fits["herschel-bulkley"].validated
    assert fits["herschel-bulkley"].validated < 0.02


@pytest.mark.slow
def test_the_yield_stress_that_the_curve_shows_is_reported(of_all_laws: list[FlowFit]) -> None:
    fit = of_all_laws[0]
    assert fit.yield_shown
    assert yield_text(fit).startswith("12")


@pytest.mark.slow
def test_a_yield_stress_that_the_curve_does_not_show_is_not_identified() -> None:
    power_law = FlowCurve("power law", RATES, 3.0 * RATES**0.5)
    assert plateau_of(power_law.rate, power_law.stress) is None
    assert yield_text(ranked(power_law, ["herschel-bulkley"])[0]) == "not identified"
    level = curve_of("herschel-bulkley")
    below = replace(
        fit_flow_curve(level, "herschel-bulkley"),
        estimates=(Estimate("T_y", "", "Pa", 0.5, 0.4, 0.6),),
    )
    low, high = plateau_of(level.rate, level.stress) or (0.0, 0.0)
    assert low <= 12.0 <= high
    assert yield_text(replace(below, yield_shown=False)) == "not identified"


@pytest.mark.slow
def test_few_points_are_ranked_without_validation() -> None:
    few = curve_of("bingham", rates=np.logspace(0, 2, 5))
    fits = ranked(few)
    assert all(np.isinf(fit.validated) for fit in fits if fit.law in ("seo-seo", "cho-choi-jhon"))


@pytest.mark.slow
@given(yield_stress=st.floats(1.0, 100.0), viscosity=st.floats(0.01, 1.0))
@settings(max_examples=examples(20))
def test_a_curve_that_a_law_meets_to_the_last_bit_has_a_finite_criterion(
    yield_stress: float, viscosity: float
) -> None:
    rates = np.logspace(0, 2, 8)
    exact = FlowCurve("exact", rates, yield_stress + viscosity * rates)
    assert np.isfinite(fit_flow_curve(exact, "bingham").aicc)
