"""Intervals: the textbook's where rows are independent, honest ones where they are not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.special import stdtrit as student_quantile

from erclutch.fit.solver import intervals
from erclutch.fit.solver.intervals import as_json, bandwidth_of, correlated_rows, uncertainty
from tests.support.examples import examples
from tests.support.slow_params import slow_behind

Array = NDArray[np.float64]


def ar1(rng: np.random.Generator, rho: float, n: int, runs: int = 1) -> Array:
    """Rows of settled first-order autoregressive noise of variance one, shape (runs, n)."""
    drive = rng.normal(size=(runs, n)) * np.sqrt(1 - rho**2)
    drive[:, 0] /= np.sqrt(1 - rho**2)
    return np.asarray(lfilter([1.0], [1.0, -rho], drive, axis=1))


# --- independent rows -------------------------------------------------------------------------------------------------


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.integers(1, 60), st.floats(-5, 5))
def test_without_an_order_the_textbook(seed: int, p: int, spare: int, decades: float) -> None:
    rng = np.random.default_rng(seed)
    jacobian = rng.normal(size=(p + spare, p)) * 10.0 ** rng.uniform(-abs(decades), abs(decades), p)
    residual = rng.normal(size=p + spare)
    found = uncertainty(jacobian, residual, ordered=False)
    scale = np.linalg.norm(jacobian, axis=0)
    unit = jacobian / scale
    expected = np.linalg.inv(unit.T @ unit) * (residual @ residual) / spare / np.outer(scale, scale)
    assert np.allclose(found.errors, np.sqrt(np.diag(expected)), rtol=1e-6)
    assert np.allclose(
        found.covariance,
        expected,
        rtol=1e-5,
        atol=1e-9 * np.sqrt(np.outer(*[np.diag(expected)] * 2)).max(),
    )
    assert found.rank == p
    assert found.bandwidth == 1
    assert np.isclose(found.condition, np.linalg.cond(unit), rtol=1e-6)


@pytest.mark.parametrize("rows", [5, 10, 30])
def test_without_an_order_the_quantile_is_students(rows: int) -> None:
    rng = np.random.default_rng(rows)
    found = uncertainty(rng.normal(size=(rows, 3)), rng.normal(size=rows), ordered=False)
    assert np.allclose(found.quantile, student_quantile(rows - 3, 0.975), rtol=1e-3)


def test_white_residuals_in_time_are_about_the_textbook() -> None:
    rng = np.random.default_rng(1)
    jacobian, residual = (
        np.column_stack([np.ones(20_000), rng.normal(size=20_000)]),
        rng.normal(size=20_000),
    )
    plain, ordered = (uncertainty(jacobian, residual, ordered=o) for o in (False, True))
    assert ordered.bandwidth < 60
    assert np.allclose(ordered.errors, plain.errors, rtol=0.1)


def test_too_few_rows_for_a_bandwidth_are_taken_as_independent() -> None:
    rng = np.random.default_rng(2)
    jacobian = np.ones((40, 1))
    assert uncertainty(jacobian, ar1(rng, 0.9, 40)[0], ordered=True).bandwidth == 1


# --- rows that are alike ----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rho", "least"), slow_behind(1, [(0.9, 0.90), (0.0, 0.93), (0.5, 0.92), (0.97, 0.87)])
)
def test_coverage_of_a_mean(rho: float, least: float) -> None:
    """The interval of a mean of 1500 correlated rows holds the truth about as often as it says."""
    noise = ar1(np.random.default_rng(3), rho, 1500, runs=400)
    hits = 0
    for y in noise:
        found = uncertainty(np.ones((y.size, 1)), y - y.mean(), ordered=True)
        hits += int(abs(y.mean()) <= found.quantile[0] * found.errors[0])
    assert least <= hits / len(noise) <= 0.985


@pytest.mark.slow
def test_what_few_rows_tell_has_a_wider_interval() -> None:
    """Two bursts of ten rows tell the slope; all 1500 rows tell the mean."""
    rng = np.random.default_rng(11)
    x = np.zeros(1500)
    x[300:310] = x[900:910] = 1.0
    jacobian = np.column_stack([np.ones_like(x), x])
    hits = naive = 0
    runs = 200
    for _ in range(runs):
        e = rng.normal(size=x.size)
        c = np.linalg.lstsq(jacobian, e)[0]
        found = uncertainty(jacobian, e - jacobian @ c, ordered=True)
        assert found.quantile[0] < 2.05
        assert found.quantile[1] > 2.5
        hits += int(abs(c[1]) <= found.quantile[1] * found.errors[1])
        naive += int(abs(c[1]) <= found.quantile[0] * found.errors[1])
    assert hits / runs > 0.85
    assert naive < hits


def test_rows_that_tell_one_parameter_badly_take_no_freedom_from_the_others() -> None:
    """The residual swings as the first column does; the second column has no part in that."""
    rng = np.random.default_rng(3)
    swinging = [1.0, -2.0 * 0.99 * np.cos(2.0 * np.pi / 30.0), 0.99**2]
    slow, residual = lfilter([1.0], swinging, rng.standard_normal((2, 1000)))[:, 400:]
    jacobian = np.column_stack([slow, rng.standard_normal(600)])
    residual = residual - jacobian @ np.linalg.lstsq(jacobian, residual, rcond=None)[0]
    both = uncertainty(jacobian, residual, ordered=True)
    alone = uncertainty(jacobian[:, 1:], residual, ordered=True)
    assert both.quantile[0] > 2.09  # for the first column some 20 rows stand for 600
    assert both.quantile[1] == pytest.approx(alone.quantile[0], abs=0.01)


@pytest.mark.slow
def test_noise_that_resonates_at_the_pace_of_the_motion_widens_what_it_hides() -> None:
    """A resonance of 260 rows lies on a sine of the slip; before, a constant was held in 63 % of the runs."""
    rng = np.random.default_rng(12)
    resonance = [1.0, -2.0 * 0.98 * np.cos(2.0 * np.pi / 260.0), 0.98**2]
    rows: Array = np.arange(1500.0)
    runs = 200
    hits = np.zeros(2)
    for _ in range(runs):
        slow, quick = 2.0 * np.pi * rng.random(2)
        slip = 3.0 * np.sin(rows / 113.6 + slow) + 2.0 * np.sin(rows / 42.0 + quick)
        jacobian = np.column_stack([np.ones_like(slip), slip])
        noise = lfilter([1.0], resonance, rng.normal(size=2500))[1000:]
        error = np.linalg.lstsq(jacobian, noise)[0]
        found = uncertainty(jacobian, noise - jacobian @ error, ordered=True)
        hits += np.abs(error) <= found.quantile * found.errors
    assert np.all(hits / runs > 0.9)
    assert np.all(hits / runs < 0.99)


@pytest.mark.slow
def test_coverage_of_a_slope_on_a_slow_regressor() -> None:
    rng = np.random.default_rng(4)
    hits = naive = 0
    runs = 400
    for _ in range(runs):
        x, e = ar1(rng, 0.95, 2000)[0], ar1(rng, 0.9, 2000)[0]
        jacobian = np.column_stack([np.ones_like(x), x])
        c = np.linalg.lstsq(jacobian, e)[0]
        residual = e - jacobian @ c
        found, plain = (uncertainty(jacobian, residual, ordered=o) for o in (True, False))
        hits += int(abs(c[1]) <= found.quantile[1] * found.errors[1])
        naive += int(abs(c[1]) <= plain.quantile[1] * plain.errors[1])
    assert 0.90 <= hits / runs <= 0.985
    assert naive / runs < 0.6  # what is avoided


def test_the_bandwidth_grows_with_the_correlation() -> None:
    rng = np.random.default_rng(5)
    widths = [bandwidth_of(ar1(rng, rho, 20_000).T) for rho in (0.0, 0.5, 0.9, 0.99, 0.999)]
    assert widths == sorted(widths)
    assert widths[0] <= 15
    assert widths[-1] > 20 * max(widths[0], 1)
    assert widths[-1] <= 4000  # a fifth of the rows


def test_the_bandwidth_follows_andrews_for_one_column() -> None:
    rho, n = 0.8, 50_000
    expected = 1.1447 * (4 * rho**2 / (1 - rho**2) ** 2 * n) ** (1 / 3)
    assert np.isclose(bandwidth_of(ar1(np.random.default_rng(6), rho, n).T), expected, rtol=0.1)


def test_no_scores_no_bandwidth() -> None:
    assert bandwidth_of(np.zeros((100, 2))) == 1


def test_the_long_run_sum_is_that_of_its_definition() -> None:
    rng = np.random.default_rng(7)
    scores, width = rng.normal(size=(200, 3)), 9
    bartlett: Any = intervals._bartlett
    expected = scores.T @ scores
    for lag in range(1, width):
        gamma = scores[lag:].T @ scores[:-lag]
        expected = expected + (1 - lag / width) * (gamma + gamma.T)
    assert np.allclose(bartlett(scores, width), expected)


@pytest.mark.parametrize("share", [0.0, 0.02, 0.1, 0.5, 1.0])
def test_the_polynomial_of_kiefer_and_vogelsang(share: float) -> None:
    """Their 97.5 % critical values for the Bartlett kernel: 1.9600 + 2.9694 b + 0.4160 b^2 - 0.5324 b^3."""
    quantile: Any = intervals.fixed_bandwidth_quantile
    expected = 1.9600 + 2.9694 * share + 0.4160 * share**2 - 0.5324 * share**3
    assert np.isclose(quantile(10**7, share), expected, rtol=1e-4)


@pytest.mark.slow
def test_the_polynomial_is_that_of_its_own_simulation() -> None:
    """Fixed-b limit at b = 0.2, where the quotient of Brownian motions is simulated: about 2.57."""
    rng = np.random.default_rng(8)
    n, b = 400, 0.2
    bartlett: Any = intervals._bartlett
    quotients = []
    for _ in range(4000):
        e = rng.normal(size=n)
        quotients.append(
            abs(e.sum()) / np.sqrt(bartlett((e - e.mean())[:, None], int(b * n))[0, 0])
        )
    quantile: Any = intervals.fixed_bandwidth_quantile
    assert np.isclose(np.quantile(quotients, 0.95), quantile(10**7, b), rtol=0.06)


@pytest.mark.slow
def test_how_many_rows_carry_one_independent_row() -> None:
    rng = np.random.default_rng(9)
    for rho in (0.0, 0.5, 0.9):
        expected = (1 + rho) / (1 - rho)
        assert np.isclose(correlated_rows(ar1(rng, rho, 200_000)[0]), expected, rtol=0.12)
    assert correlated_rows(np.zeros(1000)) == 1.0
    assert correlated_rows(rng.normal(size=49)) == 1.0
    assert correlated_rows(np.tile([1.0, -1.0], 500)) == 1.0  # never below one


# --- what the data do not identify ------------------------------------------------------------------------------------


@pytest.mark.parametrize("ordered", [False, True])
def test_collinear_columns_are_infinite_and_others_are_not(ordered: bool) -> None:
    rng = np.random.default_rng(10)
    a, b = rng.normal(size=500), rng.normal(size=500)
    jacobian = np.column_stack([a, b, 2.0 * a])
    found = uncertainty(jacobian, rng.normal(size=500), ordered=ordered)
    assert np.isinf(found.errors).tolist() == [True, False, True]
    assert found.rank == 2
    alone = uncertainty(np.column_stack([a, b]), rng.normal(size=500), ordered=False)
    assert np.isclose(found.errors[1], alone.errors[1], rtol=0.2)
    assert np.isinf(found.covariance[0]).all()
    assert np.isfinite(found.covariance[1, 1])


def test_a_column_of_zeros_is_infinite_and_others_are_not() -> None:
    rng = np.random.default_rng(11)
    jacobian = np.column_stack([np.zeros(300), rng.normal(size=300)])
    found = uncertainty(jacobian, rng.normal(size=300), ordered=True)
    assert np.isinf(found.errors).tolist() == [True, False]
    assert found.rank == 1
    assert found.condition == np.inf


def test_no_free_parameter_at_all() -> None:
    found = uncertainty(np.zeros((100, 0)), np.ones(100), ordered=True)
    assert found.errors.size == 0
    assert found.rank == 0


def test_more_columns_than_rows_are_infinite() -> None:
    rng = np.random.default_rng(12)
    found = uncertainty(rng.normal(size=(3, 5)), rng.normal(size=3), ordered=False)
    assert found.rank == 3
    assert np.isinf(found.errors).all()


@pytest.mark.parametrize("ordered", [False, True])
def test_a_perfect_fit_has_no_error(ordered: bool) -> None:
    rng = np.random.default_rng(13)
    found = uncertainty(rng.normal(size=(200, 3)), np.zeros(200), ordered=ordered)
    assert found.errors.tolist() == [0.0, 0.0, 0.0]


def test_json_has_no_infinity() -> None:
    assert as_json(1.5) == 1.5
    assert as_json(np.inf) is None
    assert as_json(np.nan) is None


def test_nothing_to_fit_is_perfectly_known() -> None:
    assert uncertainty(np.zeros((100, 0)), np.ones(100), ordered=False).condition == 1.0
    assert intervals.unknown(np.zeros((100, 0))).condition == 1.0
    rng = np.random.default_rng(14)
    jacobian = rng.normal(size=(60, 3))
    found = intervals.unknown(jacobian)
    assert (found.rank, found.bandwidth, found.quantile.tolist()) == (3, 1, [1.96] * 3)
    assert found.condition == pytest.approx(
        np.linalg.cond(jacobian / np.linalg.norm(jacobian, axis=0))
    )
    assert np.isnan(found.errors).all()
    same = np.column_stack([jacobian, jacobian[:, 0]])
    assert (intervals.unknown(same).rank, intervals.unknown(same).condition) == (3, np.inf)


def test_fifty_rows_tell_of_a_correlation() -> None:
    slow = np.repeat(np.random.default_rng(15).normal(size=10), 5)
    assert correlated_rows(slow[:49]) == 1.0
    assert correlated_rows(slow) > 1.5
    assert correlated_rows(np.ones(100)) == 1.0
