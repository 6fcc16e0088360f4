"""A kept model is adapted to a new log: known changes are found, useless ones are refused, bounds and errors hold."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from erclutch.errors import CheckError, ErclutchError, MappingError, SettingError
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.networks.fit_network import fit_network
from erclutch.fit.networks.fit_residual import fit_residual
from erclutch.fit.recalibration import AS_IT_IS, _change, _surely, blocks_of, recalibrate
from erclutch.fit.recalibration_ways import ways_of
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.load import Model
from erclutch.models.networks import network_from_name
from erclutch.models.residual_model import ResidualStructure
from erclutch.models.structure import Structure
from erclutch.runs.recalibrated_run import adapted_outcome
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from tests.support.examples import examples


def made(
    seed: int,
    *,
    gain: float = 1.0,
    offset: float = 0.0,
    exponent: float = 1.4,
    eta: float = 0.3,
    rows: int = 4000,
) -> Dataset:
    """A Bingham device under a switched field, with correlated noise."""
    rng = np.random.default_rng(seed)
    field = np.repeat(
        rng.uniform(0.0, 1.0, rows // 50 + 1) * (rng.random(rows // 50 + 1) > 0.3), 50
    )[:rows]
    t = np.arange(rows) / 1000.0
    slip = np.sin(
        2 * np.pi * rng.uniform(0.5, 8.0, (6, 1)) * t + rng.uniform(0.0, 6.0, (6, 1))
    ).sum(axis=0)
    effort = 2.0 * field**exponent * np.tanh(slip / 0.2) + eta * slip
    noise = 0.03 * lfilter([(1 - 0.9**2) ** 0.5], [1.0, -0.9], rng.normal(size=rows))
    clock = Clock(t, (Span(0, rows, 1e-3),))
    return Dataset(
        "single",
        (Element(field, slip),),
        gain * effort + offset + noise,
        clock,
        Units("N", "V", "m/s"),
    )


def law(dynamics: str = "none") -> Structure:
    return Structure("single", "bingham", law_from_name("bingham", "single"), dynamics)


def rmse(model: Model, data: Dataset) -> float:
    return float(np.sqrt(np.mean((data.effort - model.predict(data)) ** 2)))


@cache
def base_of(kind: str) -> Model:
    data, plain = made(0), network_from_name("fnn-6", "single")
    if kind == "residual":
        return fit_residual(data, ResidualStructure(law(), plain)).model
    if kind in NETWORKS:
        return fit_network(
            data, plain if kind == "fnn" else network_from_name("rbfn-10", "single")
        ).model
    return fit_structure(data, law("lag" if "lag" in kind else "none"), intervals=False).model


NETWORKS = ("fnn", "rbfn")  # which miss some of this device with their few neurons
KINDS = [
    "law",
    "law with a lag",
    *(pytest.param(kind, marks=pytest.mark.slow) for kind in (*NETWORKS, "residual")),
]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_gain_is_found_within_its_error(kind: str) -> None:
    found = recalibrate(base_of(kind), made(1, gain=1.15))
    assert found.way == "common gain"
    value, low, high = found.numbers["gain"]
    assert low < 1.15 < high
    assert high - low < (0.2 if kind in NETWORKS else 0.05)
    assert value == pytest.approx(1.15, abs=0.05 if kind in NETWORKS else 0.02)
    if kind not in NETWORKS:
        assert rmse(found.model, made(2, gain=1.15)) < 0.4 * rmse(base_of(kind), made(2, gain=1.15))


@pytest.mark.slow
@pytest.mark.parametrize("gain", [0.05, 5.0, 20.0, 200.0])
def test_a_gain_far_from_one_is_found_too(gain: float) -> None:
    """What the gain explains was taken for noise: of 20 the interval was 3.3 to 12.8, of 200 none was found."""
    data = made(1)
    found = recalibrate(base_of("law"), replace(data, effort=gain * data.effort))
    assert found.way == "common gain"
    value, low, high = found.numbers["gain"]
    assert value == pytest.approx(gain, rel=0.03)
    assert 0.95 * gain < low < high < 1.05 * gain


@pytest.mark.slow
def test_intervals_of_a_gain_hold_it_as_often_as_they_say() -> None:
    outcomes = [
        recalibrate(base_of("law"), made(seed, gain=1.15, rows=2000)) for seed in range(100, 200)
    ]
    ends = [found.numbers["gain"][1:] for found in outcomes if found.way == "common gain"]
    assert len(ends) >= 90
    assert 0.88 <= np.mean([low < 1.15 < high for low, high in ends]) <= 1.0


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_an_offset_is_found(kind: str) -> None:
    new = made(1, offset=0.5)
    found = recalibrate(base_of(kind), new)
    assert "offset" in found.way
    assert rmse(found.model, new) < (0.7 if kind in NETWORKS else 0.3) * rmse(base_of(kind), new)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["law", "law with a lag"])
def test_what_helps_nothing_keeps_the_base_and_says_so(kind: str) -> None:
    outcomes = [recalibrate(base_of(kind), made(seed, rows=1000)) for seed in range(1, 11)]
    kept = [found for found in outcomes if found.way == AS_IT_IS]
    assert len(kept) >= 8
    for found in kept:
        assert found.model is base_of(kind)
        assert found.numbers == {}
        assert "nothing helps for sure" in found.reason


@pytest.mark.slow
def test_one_gain_of_two_moves_all_gains() -> None:
    found = recalibrate(base_of("law"), made(1, eta=0.6))
    assert found.way == "gains"
    assert isinstance(found.model, TorqueModel)
    assert not found.model.structure.offset
    _, low, high = found.numbers["eta"]
    assert low < found.model.gains["eta"] < high
    assert found.model.gains["eta"] == pytest.approx(2 * base_of("law").numbers["eta"], rel=0.05)


@pytest.mark.slow
def test_another_exponent_moves_all_numbers() -> None:
    found = recalibrate(base_of("law"), made(1, exponent=2.2))
    assert found.way == "all numbers"
    assert isinstance(found.model, TorqueModel)
    assert found.model.shape["n"] == pytest.approx(2.2, abs=0.1)
    numbers = found.model.numbers
    assert {name: value for name, (value, _, _) in found.numbers.items()} == pytest.approx(
        {n: numbers[n] for n in found.numbers}
    )
    said = adapted_outcome(fit_structure(made(0), law()), found).estimates
    assert all(each.low <= each.value <= each.high for each in said), said
    assert {e.name for e in said if e.value == numbers.get(e.name)} >= {"n"}
    again = fit_structure(made(1, exponent=2.2), law(), intervals=False).model
    fresh = made(2, exponent=2.2)
    assert rmse(found.model, fresh) < 1.02 * rmse(again, fresh)


@pytest.mark.slow
def test_another_surface_moves_the_output_layer() -> None:
    for kind in ("fnn", "rbfn"):
        new, fresh = made(1, exponent=2.2, eta=0.6), made(2, exponent=2.2, eta=0.6)
        found = recalibrate(base_of(kind), new)
        assert found.way == "all numbers"
        assert rmse(found.model, fresh) < 0.9 * rmse(base_of(kind), fresh)


@pytest.mark.slow
@pytest.mark.parametrize("seen", [np.arange(4000), np.ones(3999, np.bool_), np.ones((4000, 1))])
def test_what_is_no_mask_of_the_rows_is_refused(seen: Any) -> None:
    """Numbers of rows were taken for truths, so that all rows but the first were looked at."""
    with pytest.raises(SettingError, match="no mask of 4000 rows"):
        recalibrate(base_of("law"), made(1, gain=1.3), seen)


def test_few_rows_suffice() -> None:
    new, seen = made(1, gain=1.3), np.zeros(4000, np.bool_)
    for at in range(0, 4000, 400):
        seen[at : at + 4] = True
    found = recalibrate(base_of("law"), new, seen)
    again = fit_structure(new, law(), intervals=False).model
    assert rmse(found.model, new) < 1.1 * rmse(again, new)


@pytest.mark.slow
def test_efforts_that_are_not_seen_have_no_say() -> None:
    new, seen = made(1, gain=1.3), np.arange(4000) < 2000
    other = replace(new, effort=np.where(seen, new.effort, 1e6))
    one, two = (recalibrate(base_of("law with a lag"), each, seen) for each in (new, other))
    assert one.numbers == two.numbers


@pytest.mark.slow
def test_gains_that_cannot_be_negative_stay_so() -> None:
    found = recalibrate(base_of("law"), made(1, gain=-1.0))
    assert isinstance(found.model, TorqueModel)
    assert min(found.model.gains.values()) >= 0.0


@pytest.mark.slow
def test_a_model_says_what_it_was_recalibrated_to() -> None:
    new = made(1, gain=3.0)
    found = recalibrate(base_of("law"), new).model
    assert isinstance(found, TorqueModel)
    assert "4000 rows of log" in found.about["recalibrated"]
    assert found.trained_on.effort[1] >= new.effort.max()


@pytest.mark.slow
def test_errors_are_a_line_each() -> None:
    new = made(1)
    with pytest.raises(CheckError, match="19 rows to recalibrate with, at least 20"):
        recalibrate(base_of("law"), new, np.arange(4000) < 19)
    with pytest.raises(ErclutchError, match="effort in kN, field in V"):
        recalibrate(base_of("law"), replace(new, units=Units("kN", "V", "m/s")))
    with pytest.raises(ErclutchError, match="device coaxial"):
        recalibrate(base_of("law"), replace(new, device="coaxial", elements=new.elements * 2))
    structure = replace(law(), extras=("acceleration",))
    more = fit_structure(
        replace(new, extras={"acceleration": np.cos(new.clock.time)}), structure, intervals=False
    )
    with pytest.raises(MappingError, match="acceleration"):
        recalibrate(more.model, new)


@pytest.mark.slow
@settings(max_examples=examples(50), deadline=None)
@given(
    seed=st.integers(0, 10_000),
    rows=st.integers(20, 200),
    trouble=st.sampled_from(["none", "stuck", "spikes", "flipped", "zero", "huge"]),
)
def test_hostile_logs_end_in_a_model_or_in_an_error(seed: int, rows: int, trouble: str) -> None:
    data, base = made(seed, rows=rows), base_of("law")
    rng, effort = np.random.default_rng(seed), data.effort.copy()
    if trouble == "stuck":
        effort[:] = effort[0]
    elif trouble == "spikes":
        effort[rng.integers(0, rows, 3)] *= 1e6
    elif trouble == "flipped":
        effort *= -1.0
    elif trouble == "zero":
        effort[:] = 0.0
    elif trouble == "huge":
        effort *= 1e12
    found = recalibrate(base, replace(data, effort=effort))
    assert np.all(np.isfinite(found.model.predict(data)))
    if found.way != AS_IT_IS:
        blocks = [np.mean(np.square(found.folds[way])) for way in (found.way, AS_IT_IS)]
        assert blocks[0] <= blocks[1]


@cache
def small(kind: str) -> Any:
    """A model that is quick to fit."""
    data, plain = (
        made(0, rows=400),
        network_from_name("fnn-2" if kind == "fnn" else "rbfn-3", "single"),
    )
    if kind == "residual":
        return fit_residual(data, ResidualStructure(law("lag"), plain)).model
    if kind in NETWORKS:
        return fit_network(data, plain).model
    return fit_structure(
        data, law("lag" if kind == "law with a lag" else "none"), intervals=False
    ).model


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["law", "law with a lag", "residual", *NETWORKS])
def test_ways_start_at_the_base_and_their_slopes_are_those_of_their_models(kind: str) -> None:
    base, data, rows = small(kind), made(1, rows=300), np.arange(5, 300, 3)
    effort = base.predict(data)[rows]
    ways = list(ways_of(base, data, rows, effort))
    few = ["common gain", "common gain and offset"]
    gains = ["gains", "gains and offset"] if kind not in NETWORKS else []
    assert [way.name for way in ways] == [*few, *gains, *["all numbers"] * (kind != "residual")]

    def predicted(way: Any, numbers: np.ndarray) -> np.ndarray:
        return way.model(numbers).predict(data)[rows]

    for way in ways:
        columns = way.columns if way.slopes is None else way.slopes(way.start)
        assert columns.shape == (rows.size, len(way.numbers))
        np.testing.assert_allclose(predicted(way, way.start), effort, rtol=1e-9, atol=1e-12)
        for k, number in enumerate(way.numbers):
            assert number.lower <= number.start <= number.upper
            assert number.reach > 0.0
            step = np.zeros(way.start.size)
            step[k] = 1e-5 * number.reach
            slope = (predicted(way, way.start + step) - predicted(way, way.start - step)) / (
                2 * step[k]
            )
            if (
                kind == "law with a lag" and way.slopes is not None
            ):  # numbers at their bounds, where slopes jump
                continue
            np.testing.assert_allclose(
                slope, columns[:, k], rtol=2e-4, atol=1e-5 * np.abs(effort).max()
            )
        # The model keeps its kind and its shape: nothing but these numbers moves.
        moved = way.model(way.start + 0.1 * np.array([number.reach for number in way.numbers]))
        assert type(moved) is type(base)
        if way.slopes is None and isinstance(moved, TorqueModel):
            assert dict(moved.shape) == dict(base.shape)


def test_blocks_are_as_long_as_the_error_is_correlated() -> None:
    rng = np.random.default_rng(0)
    for error, count in ((rng.normal(size=1000), 10), (np.repeat(rng.normal(size=8), 125), 5)):
        blocks = blocks_of(error)
        assert len(blocks) == count
        assert (blocks[0].start, blocks[-1].stop) == (0, error.size)
        assert all(a.stop == b.start for a, b in pairwise(blocks))
        assert max(b.stop - b.start for b in blocks) - min(b.stop - b.start for b in blocks) <= 1


def test_what_is_sure_and_how_much_it_changes() -> None:
    values = np.array([1.0, 2.0, 3.0, 2.0])  # mean 2, standard error 0.4082
    assert _surely(values)
    assert _surely(values - 1.38)
    assert not _surely(values - 1.40)
    assert _change(np.array([4.0, 4.0]), np.array([1.0, 1.0])) == pytest.approx(1.0)
    assert _change(np.array([0.25, 0.25]), np.array([0.5, 1.5])) == pytest.approx(-0.5)
    assert _change(np.zeros(2), np.zeros(2)) == -1.0


@pytest.mark.slow
def test_most_rows_are_thinned_and_twenty_are_enough() -> None:
    base, new = base_of("law"), made(1, gain=1.3)
    assert recalibrate(base, new, np.arange(4000) < 20).way is not None
    found = recalibrate(base, new)
    assert found.numbers["gain"][0] == pytest.approx(1.3, rel=0.02)
    assert found.reason.startswith(f"common gain: gain {found.numbers['gain'][0]:.4g} (")
    assert found.reason.endswith("less than as it is")
    low, high = base.trained_on.effort
    assert isinstance(found.model, TorqueModel)
    assert found.model.trained_on.effort == (
        min(low, new.effort.min()),
        max(high, new.effort.max()),
    )
