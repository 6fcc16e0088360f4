"""Figures by hand, bands against what they should be, and the rule of docs/decisions/0004-recommendation.md."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.signal import lfilter

from erclutch.fit.choice import scoring
from erclutch.fit.choice.recommending import recommend
from erclutch.fit.choice.scoring import (
    BandedFigure,
    Score,
    block_rows,
    block_starts,
    excess,
    independent_rows,
    information_criteria,
    score,
)
from erclutch.fit.choice.standing import standing
from tests.support.examples import examples

Array = NDArray[np.float64]


def ar1(seed: int, rho: float, n: int) -> Array:
    drive = np.random.default_rng(seed).normal(size=n) * np.sqrt(1 - rho**2)
    return np.asarray(lfilter([1.0], [1.0, -rho], drive))


def test_an_effort_that_stands_still_in_a_resample_has_figures_without_a_warning() -> None:
    measured = np.r_[np.zeros(398), 9.0, -9.0]
    figures = score(measured, measured + 5.0, block=3)  # warnings are errors
    assert figures.rmse.value == pytest.approx(5.0)
    assert figures.r2.high < 0.0


def test_an_effort_that_stands_still_has_figures_in_order_and_words_for_it() -> None:
    """The ends of its R2 were printed with two hundred digits, and the lower one lay above the upper one."""
    figures = score(np.zeros(400), 0.5 + 0.1 * ar1(3, 0.9, 400))
    assert figures.r2.low <= figures.r2.value <= figures.r2.high < 0.0
    assert figures.share.low <= figures.share.value <= figures.share.high
    said = standing({"sound": True, "test": figures.to_dict()}, set())
    assert said.why_none.endswith(
        "nothing of the rows held out, over which the measured effort stands still"
    )


# --- figures ----------------------------------------------------------------------------------------------------------


def test_figures_by_hand() -> None:
    measured = np.array([1.0, 2.0, 3.0, 6.0])
    predicted = np.array([1.0, 2.5, 2.0, 7.0])  # errors 0, -0.5, 1, -1; variance 3.5
    found = score(measured, predicted, block=1)
    assert found.rows == 4
    assert np.isclose(found.mse.value, 2.25 / 4)
    assert np.isclose(found.rmse.value, np.sqrt(2.25 / 4))
    assert np.isclose(found.share.value, np.sqrt(2.25 / 4 / 3.5))
    assert np.isclose(found.r2.value, 1 - 2.25 / 4 / 3.5)
    assert found.largest.value == 1.0
    assert np.isclose(found.bias, -0.125)


def test_a_perfect_model() -> None:
    y = np.sin(np.arange(200) / 5)
    found = score(y, y)
    assert found.rmse.to_list() == [0.0, 0.0, 0.0]
    assert found.r2.to_list() == [1.0, 1.0, 1.0]
    assert found.largest.value == 0.0


def test_the_mean_as_a_model_explains_nothing() -> None:
    y = np.random.default_rng(0).normal(size=3000) + 1e6
    found = score(y, np.full(y.size, y.mean()))
    assert np.isclose(found.r2.value, 0.0, atol=1e-9)
    assert np.isclose(found.share.value, 1.0)
    assert np.isclose(found.share.low, 1.0, atol=5e-3)  # a far-off mean cancels nowhere
    assert np.isclose(found.share.high, 1.0, atol=5e-3)


@pytest.mark.parametrize("bad", [np.inf, -np.inf, np.nan])
def test_a_prediction_that_is_not_finite_is_infinitely_bad(bad: float) -> None:
    y = np.random.default_rng(0).normal(size=300)
    predicted = y.copy()
    predicted[17] = bad
    found = score(y, predicted)
    assert found.rmse.value == found.mse.value == found.share.value == found.largest.value == np.inf
    assert found.r2.value == -np.inf
    assert found.rmse.high == np.inf


def test_constant_effort_does_not_divide_by_zero() -> None:
    found = score(np.full(100, 2.0), np.full(100, 2.5))
    assert found.rmse.value == 0.5
    assert np.isfinite(found.to_dict()["r2"][0])


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(8, 300), st.floats(1e-6, 1e6))
def test_values_scale_with_the_unit_and_lie_near_their_bands(
    seed: int, n: int, unit: float
) -> None:
    rng = np.random.default_rng(seed)
    y, e = rng.normal(size=n), rng.normal(size=n)
    one, two = score(y, y - e), score(unit * y, unit * (y - e))
    assert np.isclose(two.rmse.value, unit * one.rmse.value)
    assert np.isclose(two.mse.value, unit**2 * one.mse.value)
    assert np.isclose(two.share.value, one.share.value)
    assert np.isclose(two.share.high, one.share.high)
    assert np.isclose(one.mse.value, one.rmse.value**2)
    assert np.isclose(one.r2.value, 1 - one.share.value**2)
    for figure in (one.mse, one.rmse, one.share, one.r2, one.largest):
        assert figure.low <= figure.high
    assert one.largest.high == one.largest.value  # no resample exceeds the largest error there is


# --- bands ------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_band_of_white_noise_is_the_analytic_one() -> None:
    """The mean square of n normal residuals has a standard deviation of sqrt(2 / n) of itself."""
    n = 20_000
    e = np.random.default_rng(1).normal(size=n)
    found = score(
        10 * np.random.default_rng(2).normal(size=n),
        10 * np.random.default_rng(2).normal(size=n) - e,
    )
    half = 1.96 * np.sqrt(1 / (2 * n)) * found.rmse.value
    assert np.isclose(found.rmse.value - found.rmse.low, half, rtol=0.2)
    assert np.isclose(found.rmse.high - found.rmse.value, half, rtol=0.2)


@pytest.mark.slow
def test_the_band_of_correlated_residuals_is_wider() -> None:
    """Squares of AR(1) residuals correlate with rho squared, so the band grows by sqrt((1 + rho^2) / (1 - rho^2))."""
    n, rho = 40_000, 0.95
    y = np.random.default_rng(3).normal(size=n)
    white, alike = (score(y, y - e) for e in (ar1(4, 0.0, n), ar1(4, rho, n)))
    growth = (alike.mse.high - alike.mse.low) / (white.mse.high - white.mse.low)
    expected = np.sqrt((1 + rho**2) / (1 - rho**2))
    assert np.isclose(growth, expected, rtol=0.3)


def test_a_band_of_a_few_bursts_does_not_reach_what_cannot_be() -> None:
    """No error at all, or an explained share of one, is no end of a band; ends that stay away from it are as ever."""
    y, quiet = np.sin(np.arange(2000.0)), 0.01 * np.random.default_rng(6).normal(size=2000)
    burst = quiet + np.where(np.arange(2000) // 60 % 16 == 3, 2.0, 0.0)
    found = score(y, y - burst)
    assert 0.0 < found.mse.low < 0.2 * found.mse.value
    assert 0.0 < found.rmse.low < found.rmse.value < found.rmse.high
    assert found.r2.value < found.r2.high < 1.0
    assert -1.0 < excess(burst, 30.0 * quiet).low < -0.5


@pytest.mark.slow
def test_the_band_covers_what_it_should() -> None:
    """The true RMSE lies in the band for about 95 % of the logs, also where residuals are correlated."""
    y = np.random.default_rng(5).normal(size=2000)
    for rho in (0.0, 0.9):
        hits = 0
        for seed in range(80):
            band = score(y, y - ar1(1000 + seed, rho, y.size), seed=seed).rmse
            hits += int(band.low <= 1.0 <= band.high)
        assert 0.86 <= hits / 80 <= 1.0


def test_the_same_seed_gives_the_same_band() -> None:
    y, e = np.random.default_rng(6).normal(size=(2, 500))
    assert score(y, y - e) == score(y, y - e)
    assert score(y, y - e, seed=1) != score(y, y - e, seed=2)


def test_blocks_start_anywhere() -> None:
    """They wrap around the end, so that every row is drawn equally often."""
    for rows, block in ((10, 1), (10, 10), (101, 7), (1000, 250)):
        starts = block_starts(rows, block, 0)
        assert starts.min() >= 0
        assert starts.max() <= rows - 1
        assert starts.shape[1] == max(1, round(rows / block))


def test_blocks_are_as_long_as_the_slowest_model_needs() -> None:
    white, slow = ar1(7, 0.0, 5000), ar1(7, 0.99, 5000)
    assert block_rows([white, slow]) == block_rows([slow])
    assert block_rows([slow]) > 5 * block_rows([white])
    assert block_rows([slow]) <= 1250


@pytest.mark.slow
@settings(max_examples=examples(80), deadline=None)
@given(st.lists(st.floats(0, 100), min_size=1, max_size=60), st.data())
def test_the_mean_of_each_block(values: list[float], data: st.DataObject) -> None:
    block = data.draw(st.integers(1, len(values)))
    resampled: Any = scoring._resampled
    starts = np.arange(len(values))[:, None]
    round_again = values + values
    expected = [np.mean(round_again[i : i + block]) for i in range(len(values))]
    assert np.allclose(resampled(np.array(values), block, starts), expected, atol=1e-9)


@pytest.mark.slow
@settings(max_examples=examples(80), deadline=None)
@given(st.lists(st.floats(0, 100), min_size=1, max_size=60), st.data())
def test_the_largest_value_of_each_block(values: list[float], data: st.DataObject) -> None:
    block = data.draw(st.integers(1, len(values)))
    maxima: Any = scoring._block_maxima
    round_again = values + values
    expected = [max(round_again[i : i + block]) for i in range(len(values))]
    assert maxima(np.array(values), block).tolist() == expected


# --- against the best -------------------------------------------------------------------------------------------------


def test_a_model_against_itself_is_no_worse() -> None:
    e = ar1(8, 0.8, 2000)
    assert excess(e, e, block=40).to_list() == [0.0, 0.0, 0.0]


def test_a_model_that_is_everywhere_ten_percent_worse_has_a_band_of_nothing() -> None:
    """Paired: the luck of the rows cancels."""
    e = ar1(9, 0.8, 2000)
    found = excess(-1.1 * e, e, block=40)
    assert np.allclose(found.to_list(), 0.1)


def test_the_paired_band_holds_the_truth() -> None:
    common, own = ar1(10, 0.9, 20_000), 0.4 * ar1(11, 0.9, 20_000)
    found = excess(common + own, common, block=200)
    assert found.low < np.sqrt(1 + 0.16) - 1 < found.high
    assert found.high - found.low < 0.1


def test_against_a_best_that_is_perfect() -> None:
    assert excess(ar1(12, 0.5, 400), np.zeros(400), block=10).value > 1e100


def test_a_perfect_model_against_itself_is_no_worse() -> None:
    assert excess(np.zeros(400), np.zeros(400), block=10).to_list() == [0.0, 0.0, 0.0]


def test_against_a_best_that_is_perfect_but_for_a_few_rows() -> None:
    # Most resamples meet none of these rows: the model is infinitely worse there, and no band is no number.
    best = np.zeros(400)
    best[7] = 1e-3
    found = excess(ar1(12, 0.5, 400), best, block=10)
    assert 1.0 < found.low <= found.value < found.high == np.inf


def test_a_model_that_is_not_finite_against_the_best() -> None:
    e = ar1(13, 0.5, 400)
    bad = e.copy()
    bad[3] = np.inf
    assert excess(bad, e, block=10).value == np.inf


# --- criteria ---------------------------------------------------------------------------------------------------------


def test_criteria_by_hand() -> None:
    found = information_criteria(cost=50.0, rows=200, independent=20.0, parameters=5)
    assert np.isclose(found["aic"], 200 * np.log(0.25) + 10)
    assert np.isclose(found["bic"], 200 * np.log(0.25) + 5 * np.log(200))
    assert np.isclose(found["aic_independent"], 20 * np.log(0.25) + 10)
    assert np.isclose(found["bic_independent"], 20 * np.log(0.25) + 5 * np.log(20))
    assert np.isfinite(information_criteria(0.0, 100, 0.5, 3)["bic_independent"])


def test_independent_rows() -> None:
    assert np.isclose(independent_rows(ar1(14, 0.9, 100_000)), 100_000 / 19, rtol=0.15)
    assert independent_rows(np.zeros(100)) == 100


# --- the recommendation -----------------------------------------------------------------------------------------------


def scored(rmse: float, high: float | None = None) -> Score:
    figure = BandedFigure(rmse, 0.9 * rmse, high or 1.2 * rmse)
    return Score(100, figure, figure, figure, figure, figure, 0.0)


def test_the_simplest_that_is_as_good() -> None:
    scores = {"rich": scored(1.0), "middle": scored(1.03), "simple": scored(1.15)}
    over = {
        "rich": BandedFigure(0, 0, 0),
        "middle": BandedFigure(0.03, 0.01, 0.05),
        "simple": BandedFigure(0.15, 0.1, 0.2),
    }
    assert recommend(scores, over, {"rich": 9, "middle": 6, "simple": 4}) == ("rich", "middle")


def test_a_difference_that_cannot_be_told_is_none() -> None:
    scores = {"rich": scored(1.0), "simple": scored(1.15)}
    wide, sure = {"rich": BandedFigure(0, 0, 0)}, {"rich": BandedFigure(0, 0, 0)}
    wide["simple"], sure["simple"] = BandedFigure(0.15, -0.02, 0.3), BandedFigure(0.15, 0.001, 0.3)
    parameters = {"rich": 9, "simple": 4}
    assert recommend(scores, wide, parameters) == ("rich", "simple")
    assert recommend(scores, sure, parameters) == ("rich", "rich")


def test_outside_the_bests_band_is_out_however_wide_the_paired_one() -> None:
    scores = {"rich": scored(1.0, high=1.1), "simple": scored(1.11)}
    over = {"rich": BandedFigure(0, 0, 0), "simple": BandedFigure(0.11, -1.0, 3.0)}
    assert recommend(scores, over, {"rich": 9, "simple": 4}) == ("rich", "rich")


def test_five_percent_is_the_edge() -> None:
    parameters = {"rich": 9, "simple": 4}
    scores = {"rich": scored(1.0), "simple": scored(1.05)}
    for value, wins in ((0.05, "simple"), (0.0501, "rich")):
        over = {"rich": BandedFigure(0, 0, 0), "simple": BandedFigure(value, 0.04, 0.06)}
        assert recommend(scores, over, parameters) == ("rich", wins)


def test_among_equally_simple_ones_the_more_accurate() -> None:
    scores = {"a": scored(1.02), "b": scored(1.01), "best": scored(1.0)}
    over = {name: BandedFigure(0.01, -0.1, 0.1) for name in scores}
    assert recommend(scores, over, {"a": 4, "b": 4, "best": 9}) == ("best", "b")


def test_of_models_as_good_physics_goes_first() -> None:
    scores = {"law": scored(1.01), "corrected": scored(1.0), "network": scored(1.0)}
    over = {name: BandedFigure(0.01, -0.1, 0.1) for name in scores}
    parameters = {"law": 9, "corrected": 4, "network": 2}
    freedom = {"law": 0, "corrected": 1, "network": 2}
    assert recommend(scores, over, parameters, freedom=freedom)[1] == "law"
    assert recommend(scores, over, parameters, {"corrected", "network"}, freedom)[1] == "corrected"


def test_only_sound_models_are_recommended_where_there_are_any() -> None:
    scores = {"rich": scored(1.0), "middle": scored(1.03), "simple": scored(1.04)}
    over = {name: BandedFigure(s.rmse.value - 1.0, -0.01, 0.1) for name, s in scores.items()}
    parameters = {"rich": 9, "middle": 6, "simple": 4}
    assert recommend(scores, over, parameters, {"rich", "middle"}) == ("rich", "middle")
    assert recommend(scores, over, parameters, set()) == ("rich", "simple")
    far = {"rich": scored(1.0), "sound": scored(2.0), "worse": scored(3.0)}
    over = {name: BandedFigure(s.rmse.value - 1.0, 0.5, 3.0) for name, s in far.items()}
    assert recommend(far, over, {"rich": 9, "sound": 6, "worse": 4}, {"sound", "worse"}) == (
        "rich",
        "sound",
    )


def test_models_that_failed_are_never_recommended() -> None:
    scores = {"good": scored(1.0), "wild": scored(np.inf)}
    over = {"good": BandedFigure(0, 0, 0), "wild": BandedFigure(np.inf, np.nan, np.nan)}
    assert recommend(scores, over, {"good": 9, "wild": 1}) == ("good", "good")
