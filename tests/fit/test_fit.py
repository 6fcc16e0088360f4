"""Known truths come back; what data cannot tell is said; the same data give the same numbers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from erclutch.fit.laws.fit_law import fit_structure, reference_of
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from tests.support.slow_params import slow_behind

Array = NDArray[np.float64]
UNITS = Units("N*m", "V", "rad/s")


def structure(
    name: str = "bingham", dynamics: Any = "none", friction: bool = False, offset: bool = False
) -> Structure:
    return Structure("single", name, law_from_name(name), dynamics, friction, offset)


def rows_of(n: int = 3000, seed: int = 0, steps: int = 60, noise: float = 0.0) -> Dataset:
    """Random steps of the field and a random motion at 1 kHz, without effort but noise."""
    rng = np.random.default_rng(seed)
    field = np.repeat(rng.uniform(0.0, 1000.0, -(-n // steps)), steps)[:n]
    t = np.arange(n) / 1000.0
    slip = sum(a * np.sin(f * t + p) for a, f, p in rng.uniform([2, 3, 0], [9, 40, 6], (6, 3)))
    return Dataset(
        "single",
        (Element(field, np.asarray(slip)),),
        noise * rng.normal(size=n),
        Clock(t, (Span(0, n, 1e-3),)),
        UNITS,
    )


def with_effort(data: Dataset, truth: TorqueModel) -> Dataset:
    clean = truth.effort(data.elements, data.clock)
    return Dataset("single", data.elements, clean + data.effort, data.clock, UNITS)


@pytest.mark.parametrize("largest", [3.0, 4.58e178])
def test_the_size_of_a_further_input(largest: float) -> None:
    """A log may hold what a model that diverged says: its squares are beyond double precision."""
    data = replace(rows_of(), extras={"position": np.resize([largest, -largest], 3000)})
    assert reference_of(data, ["position"]).extras == pytest.approx((largest,))


def truth_of(data: Dataset, made: Structure, shape: list[float], gains: list[float]) -> TorqueModel:
    reference = reference_of(data)
    outcome = fit_structure(data, made)  # for its frame alone
    names = [s.name for s in made.shapes(reference.period)]
    return TorqueModel(
        made,
        reference,
        dict(zip(names, shape, strict=True)),
        dict(zip((g.name for g in made.gains()), gains, strict=True)),
        UNITS,
        outcome.model.trained_on,
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "dynamics", "shape", "gains"),
    slow_behind(
        4,
        [
            ("bingham", "none", [0.1, 1.6], [0.5, 0.2]),
            ("bingham", "lag", [0.1, 1.6, 0.0023, 0.008], [0.5, 0.2]),
            ("bingham/saturating", "none", [0.1, 1.4, 0.6], [0.5, 0.2]),
            ("herschel-bulkley", "none", [0.1, 0.6, 1.6], [0.5, 0.2]),
            ("bingham", "rise-fall", [0.1, 1.6, 0.003, 0.006, 0.02], [0.5, 0.2]),
            ("casson", "none", [0.1, 0.3, 1.6], [0.5]),
            ("hem/square", "lag", [0.1, 2.0, 1.5, 0.002, 0.005], [0.5, 0.1]),
        ],
    ),
)
def test_a_truth_comes_back_with_intervals_that_hold_it(
    name: str, dynamics: str, shape: list[float], gains: list[float]
) -> None:
    made = structure(name, dynamics)
    data = rows_of(noise=0.005, seed=3)
    truth = truth_of(data, made, shape, gains)
    outcome = fit_structure(with_effort(data, truth), made)
    assert outcome.converged
    assert outcome.rank == outcome.unknowns
    rmse = np.sqrt(outcome.train_cost / outcome.train_rows)
    assert np.isclose(rmse, 0.005, rtol=0.1)
    for found, true in zip(outcome.model.shape.values(), shape, strict=True):
        assert np.isclose(found, true, rtol=0.15, atol=1e-4)
    for found, true in zip(outcome.model.gains.values(), gains, strict=True):
        assert np.isclose(found, true, rtol=0.1)
    held = [e.low <= e.value <= e.high for e in outcome.estimates]
    assert all(held)


@pytest.mark.slow
def test_coverage_of_the_intervals_over_repetitions() -> None:
    """Four parameters in 30 logs with white noise: 95 % intervals miss few."""
    made = structure()
    data = rows_of(n=1500, noise=0.02)
    truth = truth_of(data, made, [0.1, 1.6], [0.5, 0.2])
    clean = with_effort(Dataset("single", data.elements, np.zeros(1500), data.clock, UNITS), truth)
    hits = 0
    reference = truth.reference
    true = [0.1 * reference.slip, 1.6, 0.5, 0.2 / reference.slip]
    for seed in range(30):
        noise = 0.02 * np.random.default_rng(seed).normal(size=1500)
        noisy = Dataset("single", data.elements, clean.effort + noise, data.clock, UNITS)
        outcome = fit_structure(noisy, made)
        hits += sum(e.low <= v <= e.high for e, v in zip(outcome.estimates, true, strict=True))
    assert 0.88 <= hits / 120 <= 1.0


@pytest.mark.slow
def test_the_same_data_give_the_same_numbers() -> None:
    data = rows_of(noise=0.01)
    truth = truth_of(data, structure(dynamics="lag"), [0.1, 1.6, 0.002, 0.008], [0.5, 0.2])
    data = with_effort(data, truth)
    one, two = (fit_structure(data, structure(dynamics="lag")) for _ in range(2))
    assert one.to_dict() == two.to_dict()


@pytest.mark.slow
def test_a_gain_that_wants_to_be_negative_is_on_its_bound() -> None:
    data = rows_of(noise=0.01)
    truth = truth_of(data, structure(), [0.1, 1.6], [0.5, -0.2])
    outcome = fit_structure(with_effort(data, truth), structure())
    eta = next(e for e in outcome.estimates if e.name == "eta")
    assert eta.value == 0.0
    assert eta.at_bound == "lower"
    assert "eta" in outcome.at_bounds
    assert eta.low == 0.0
    assert 0.0 < eta.high < 0.1 * outcome.estimates[-2].value


def test_what_nothing_excites_is_not_identified() -> None:
    """Without any field there is no yield effort to tell."""
    n = 500
    rng = np.random.default_rng(1)
    slip = 10 * np.sin(np.arange(n) * 0.05)
    data = Dataset(
        "single",
        (Element(np.zeros(n), slip),),
        0.02 * slip + 0.001 * rng.normal(size=n),
        Clock(np.arange(n) / 1000, (Span(0, n, 1e-3),)),
        UNITS,
    )
    outcome = fit_structure(data, structure())
    assert outcome.model.gains["T_y"] == 0.0
    T_y, eta = (next(e for e in outcome.estimates if e.name == name) for name in ("T_y", "eta"))
    assert np.isinf(T_y.high - T_y.low)
    assert T_y.at_bound is None
    assert eta.low < 0.02 < eta.high


@pytest.mark.slow
@pytest.mark.parametrize(("hold", "seconds"), slow_behind(1, [(0.25, 14.0), (1.0, 12.0)]))
def test_a_lag_is_found_however_fast_and_regularly_its_command_is_sampled(
    hold: float, seconds: float
) -> None:
    n, rng, period = round(1e4 * seconds), np.random.default_rng(5), 1e-4
    t = np.arange(n, dtype=np.float64) * period
    field = rng.uniform(0.0, 2.0, 100)[(t / hold).astype(int)]
    slip = 20.0 * np.sin(8.0 * t) * (0.6 + 0.4 * np.sin(t))
    fluid = (
        lfilter([-np.expm1(-period / 8e-3)], [1.0, -np.exp(-period / 8e-3)], field - field[0])
        + field[0]
    )
    effort = 0.5 * fluid**1.5 * np.tanh(slip / 0.6) + 0.008 * slip + 0.01 * rng.standard_normal(n)
    data = Dataset(
        "single", (Element(field, slip),), effort, Clock(t, (Span(0, n, period),)), UNITS
    )
    found = fit_structure(data, structure(dynamics="lag"))
    tau, delay = (next(e for e in found.estimates if e.name == name) for name in ("tau", "delay"))
    assert tau.low < 8e-3 < tau.high < 8.2e-3
    assert delay.value < 1e-4


@pytest.mark.slow
def test_a_start_of_the_users_is_tried() -> None:
    data = rows_of(noise=0.01)
    truth = truth_of(data, structure(), [0.1, 1.6], [0.5, 0.2])
    data = with_effort(data, truth)
    given = fit_structure(data, structure(), starts=[[0.1, 1.6]], scan=1)
    scanned = fit_structure(data, structure())
    assert np.isclose(given.train_cost, scanned.train_cost, rtol=1e-6)


@pytest.mark.slow
def test_units_do_not_change_the_fit() -> None:
    """The same log in kV, deg/s and mN m: the same residuals, parameters in those units."""
    data = rows_of(noise=0.01)
    data = with_effort(data, truth_of(data, structure(), [0.1, 1.6], [0.5, 0.2]))
    element = data.elements[0]
    scaled = Dataset(
        "single",
        (Element(element.field * 1e-3, element.slip * 57.3),),
        data.effort * 1e3,
        data.clock,
        Units("mN*m", "kV", "deg/s"),
    )
    one, two = fit_structure(data, structure()), fit_structure(scaled, structure())
    assert np.isclose(two.train_cost, one.train_cost * 1e6, rtol=1e-6)
    for a, b, factor in zip(
        one.estimates, two.estimates, (57.3, 1.0, 1e3, 1e3 / 57.3), strict=True
    ):
        assert np.isclose(b.value, a.value * factor, rtol=1e-4)
        assert np.isclose(b.high - b.low, (a.high - a.low) * factor, rtol=1e-3)
    assert two.estimates[3].unit == "mN*m/(deg/s)"
