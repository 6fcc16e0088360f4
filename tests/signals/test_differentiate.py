from __future__ import annotations

import itertools
from typing import cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are

from erclutch.errors import SettingError
from erclutch.signals.clock import Clock, Span
from erclutch.signals.speed import (
    CAUSAL,
    DERIVATIVES,
    Derivative,
    DerivativeName,
    _gains,
    differentiate,
    live,
)
from tests.support.examples import examples

PERIOD = 1e-3


def clock_of(*rows: int, uniform: bool = True) -> Clock:
    edges = np.cumsum([0, *rows])
    time = np.arange(float(edges[-1])) * PERIOD
    if not uniform:
        time = time + 0.3 * PERIOD * np.sin(np.arange(time.size))
    spans = tuple(
        Span(int(a), int(b), PERIOD if uniform else None) for a, b in itertools.pairwise(edges)
    )
    return Clock(time, spans)


@pytest.mark.parametrize("name", ["central", "savgol"])
def test_look_ahead_filters_are_exact_on_lines_everywhere(name: DerivativeName) -> None:
    clock = clock_of(60, 40)
    x = 3.0 - 7.0 * clock.time
    np.testing.assert_allclose(differentiate(x, clock, Derivative(name)), -7.0, rtol=1e-9)


def test_savgol_is_exact_on_parabolas_everywhere_and_central_inside() -> None:
    clock = clock_of(60)
    t = clock.time
    x, slope = 1 - 2 * t + 300 * t**2, -2 + 600 * t
    np.testing.assert_allclose(
        differentiate(x, clock, Derivative("savgol", window=7)), slope, rtol=1e-8, atol=1e-8
    )
    np.testing.assert_allclose(
        differentiate(x, clock, Derivative())[1:-1], slope[1:-1], rtol=1e-8, atol=1e-8
    )


def test_central_needs_no_equal_steps() -> None:
    clock = clock_of(80, uniform=False)
    t = clock.time
    np.testing.assert_allclose(
        differentiate(5 * t**2, clock, Derivative("central"))[1:-1],
        10 * t[1:-1],
        rtol=1e-8,
        atol=1e-10,
    )


@pytest.mark.parametrize("name", CAUSAL)
def test_causal_filters_settle_on_the_slope_of_a_line(name: DerivativeName) -> None:
    clock = clock_of(400)
    speed = differentiate(100.0 + 4.0 * clock.time, clock, Derivative(name))
    assert speed[0] == 0.0  # a single position has no speed
    np.testing.assert_allclose(speed[200:], 4.0, rtol=1e-9)
    if name == "difference":
        np.testing.assert_allclose(speed[1:], 4.0, rtol=1e-9)


def test_difference_is_half_a_sample_late() -> None:
    clock = clock_of(100)
    t = clock.time
    np.testing.assert_allclose(
        differentiate(t**2, clock, Derivative("difference"))[1:],
        2 * (t[1:] - PERIOD / 2),
        rtol=1e-9,
        atol=1e-12,
    )


@pytest.mark.parametrize("name", CAUSAL)
@settings(max_examples=examples(20), deadline=None)
@given(seed=st.integers(0, 2**32 - 1), cutoff=st.floats(1.0, 450.0), offset=st.floats(-1e3, 1e3))
def test_live_equals_batch(name: DerivativeName, seed: int, cutoff: float, offset: float) -> None:
    rng = np.random.default_rng(seed)
    clock = clock_of(300, 150)
    x = offset + np.cumsum(rng.normal(size=450)) * 1e-2
    derivative = Derivative(name, cutoff=cutoff)
    batch = differentiate(x, clock, derivative)
    stepped: list[float] = []
    for span in clock.spans:  # a gap starts the filter anew
        filter_ = live(derivative, PERIOD)
        stepped.extend(filter_.step(float(v)) for v in x[span.start : span.stop])
    np.testing.assert_allclose(stepped, batch, rtol=1e-9, atol=1e-9 * np.abs(batch).max())


@pytest.mark.parametrize("cutoff", [1.0, 20.0, 150.0, 400.0])
def test_kalman_gains_are_the_steady_state_of_the_riccati_equation(cutoff: float) -> None:
    # White acceleration, constant over a sample; its ratio to the measurement's noise is Kalata's tracking index.
    index = (2 * np.pi * cutoff * PERIOD) ** 2
    A, H = np.array([[1.0, PERIOD], [0.0, 1.0]]), np.array([[1.0, 0.0]])
    G = np.array([[PERIOD**2 / 2], [PERIOD]])
    acceleration = (index / PERIOD**2) ** 2
    P = solve_discrete_are(A.T, H.T, G @ G.T * acceleration, np.eye(1))
    K = (P @ H.T / (H @ P @ H.T + 1.0)).ravel()
    g, h = _gains(Derivative("kalman", cutoff=cutoff), PERIOD)
    assert g == pytest.approx(K[0], rel=1e-6)
    assert h == pytest.approx(K[1] * PERIOD, rel=1e-6)


@pytest.mark.parametrize("name", ["lowpass", "kalman"])
@pytest.mark.parametrize("cutoff", [5.0, 20.0])
def test_the_cutoff_is_that_of_the_filter(name: DerivativeName, cutoff: float) -> None:
    """A low-pass loses 3 dB at its cutoff; the Kalman filter's poles have it as their natural frequency."""
    g, h = _gains(Derivative(name, cutoff=cutoff), PERIOD)
    if name == "kalman":
        poles = np.roots([1.0, g + h - 2.0, 1.0 - g])
        assert np.abs(np.log(poles.astype(complex)))[0] / (2 * np.pi * PERIOD) == pytest.approx(
            cutoff, rel=0.05
        )
    else:
        z = np.exp(-2j * np.pi * cutoff * PERIOD)
        assert abs(h / (1 - (1 - h) * z)) == pytest.approx(np.sqrt(0.5), rel=0.01)


def test_noise_on_a_13_bit_encoder() -> None:
    step = 2 * np.pi / 2**13
    assert step / PERIOD == pytest.approx(0.767, abs=5e-4)
    clock = clock_of(4000)
    true = 1.7 + 0.05 * np.sin(2 * np.pi * 0.5 * clock.time)
    measured = np.round(np.cumsum(true) * PERIOD / step) * step
    noise = {}
    for name in DERIVATIVES:
        error = differentiate(measured, clock, Derivative(name, cutoff=50.0)) - true
        noise[name] = float(np.std(error[500:-500]))
    raw = differentiate(measured, clock, Derivative("difference"))
    levels = np.unique(np.round(raw / (step / PERIOD), 6))
    assert np.array_equal(levels, np.round(levels))
    assert levels.size >= 2
    assert noise["difference"] > 3 * noise["lowpass"]
    assert noise["difference"] > 3 * noise["kalman"]
    assert noise["difference"] > noise["central"] > noise["savgol"]


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"name": "spline"}, "unknown derivative 'spline'"),
        ({"cutoff": 0.0}, "a cutoff of 0.0 Hz"),
        ({"cutoff": -5.0}, "a cutoff of -5.0 Hz"),
        ({"cutoff": float("nan")}, "a cutoff of nan Hz"),
        ({"cutoff": float("inf")}, "a cutoff of inf Hz"),
        ({"window": 3}, "a window of 3 rows"),
        ({"window": 8}, "a window of 8 rows"),
    ],
)
def test_settings_that_are_none(arguments: dict, problem: str) -> None:
    with pytest.raises(SettingError, match=problem):
        Derivative(**arguments)


@pytest.mark.parametrize("name", sorted(set(DERIVATIVES) - set(CAUSAL)))
def test_a_filter_that_looks_ahead_does_not_run_live(name: str) -> None:
    with pytest.raises(SettingError, match="needs samples of the future"):
        live(Derivative(cast(DerivativeName, name)), PERIOD)


def test_a_window_longer_than_a_segment() -> None:
    with pytest.raises(SettingError, match="a window of 9 rows on a segment of 8"):
        differentiate(np.arange(48.0), clock_of(40, 8), Derivative("savgol", window=9))


@pytest.mark.parametrize("name", sorted(set(DERIVATIVES) - {"central"}))
def test_filters_that_need_equal_steps(name: str) -> None:
    with pytest.raises(SettingError, match="needs equal time steps"):
        differentiate(
            np.arange(40.0), clock_of(40, uniform=False), Derivative(cast(DerivativeName, name))
        )
