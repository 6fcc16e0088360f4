"""A bench sheet has a few dozen points, each a mean: laws are fitted to it, and whole fields choose among them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.errors import CheckError
from erclutch.fit.checks.data_check import check
from erclutch.fit.choice.ladder import grown
from erclutch.fit.choice.parts_left_out import parts_of_training
from erclutch.fit.choice.points_left_out import fields_left_out, points_left_out
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.training_range import range_of
from erclutch.logs import recording_from_arrays
from erclutch.logs.clock.timing import of_points
from erclutch.logs.covering_stretches import field_levels
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.held_out import hold_out
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from tests.support.slow_params import slow_behind

YIELD, VISCOSITY, FRICTION = 3.0, 0.005, 0.2


def sheet(fields: tuple[float, ...] = (0.0, 0.5, 1.0), speeds: int = 12) -> Dataset:
    """Points of a brake whose law is Bingham's with a yield effort that grows as the field, and noise."""
    rng = np.random.default_rng(3)
    field = np.repeat(fields, speeds)
    slip = np.tile(np.linspace(5.0, 60.0, speeds), len(fields))
    effort = FRICTION + YIELD * field + VISCOSITY * slip + 0.01 * rng.standard_normal(slip.size)
    return points_of(field, slip, effort)


def points_of(field: Array, slip: Array, effort: Array) -> Dataset:
    signals = {"field": field, "slip": slip, "effort": effort}
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    data = build_dataset(recording_from_arrays(signals, units, rate=1.0))
    return replace(data, notes=(*data.notes, *of_points(data.rows, 1.0).notes))


@pytest.mark.slow
def test_a_law_is_found_in_three_dozen_points() -> None:
    comparison = compare(sheet(), Settings(models=("bingham", "quadratic")))
    assert comparison.recommended == "bingham"
    assert comparison.chosen_by == "whole fields"
    entry = comparison.entry("bingham")
    assert entry.test.rmse.value < 0.02  # the noise is 0.01
    truth = {"T_y": YIELD, "eta": VISCOSITY, "n": 1.0}
    for estimate in entry.outcome.estimates:
        if estimate.name in truth:
            assert estimate.low <= truth[estimate.name] <= estimate.high


def test_fewer_than_a_dozen_points_are_refused_with_the_number_that_is_needed() -> None:
    data = sheet(speeds=4)
    held = np.zeros(data.rows, np.bool_)
    check(data, held)
    held[0] = True
    with pytest.raises(CheckError, match="11 rows to train on, at least 12 are needed"):
        check(data, held)


def test_points_between_two_of_one_field_are_near_and_those_of_other_fields_are_not() -> None:
    data = sheet(fields=(0.0, 0.2, 1.0), speeds=4)
    covered = range_of(data)
    slip = np.linspace(5.0, 60.0, 50)
    for field, is_near in ((0.0, True), (0.2, True), (0.6, False), (1.0, True)):
        element = replace(data.elements[0], field=np.full(50, field), slip=slip)
        assert covered.far(0, element.field, element.slip).any() != is_near


@pytest.mark.parametrize("speeds", [6, 8, 12])
def test_points_held_out_are_between_others_of_their_field(speeds: int) -> None:
    data = sheet(speeds=speeds)
    held = hold_out(data, 0.3)
    assert held.mean() == pytest.approx(0.3, abs=0.05)
    messages = [finding.message for finding in check(data, held)]
    assert not any("no training row comes near" in message for message in messages)


def test_whole_fields_are_left_out_in_turn_and_those_at_no_field_choose_nothing() -> None:
    parts = parts_of_training(sheet(fields=(0.0, 0.5, 1.0, 1.5)))
    assert parts is not None
    assert (parts.words, parts.further, parts.lowest, parts.fields) == ("whole fields", True, 1, 4)
    together = np.sum([mask.astype(int) for mask in parts.masks], axis=0)
    np.testing.assert_array_equal(together, 1)


def test_points_at_hardly_two_of_a_field_are_left_out_all_over() -> None:
    data = sheet(fields=tuple(np.linspace(0.0, 1.0, 20)), speeds=2)
    assert fields_left_out(data) == ([], 0)
    masks = points_left_out(data)
    np.testing.assert_array_equal(np.sum(masks, axis=0)[1:-1], 1)
    for mask in masks:
        assert np.ptp(data.elements[0].slip[mask]) > 0.0


def both_ways(softer: float, fields: tuple[float, ...], noise: float = 4.0) -> Dataset:
    """Points of a damper, a dozen at a field; its compression is so much softer than its rebound. SYNTHETIC."""
    rng = np.random.default_rng(7)
    one_way = np.linspace(0.05, 0.6, 6)
    slip = np.tile(np.concatenate([-one_way[::-1], one_way]), len(fields))
    field = np.repeat(fields, 12)
    turned = np.tanh(slip / 0.03)
    effort = 500.0 * field * turned + 500.0 * slip
    effort[slip < 0.0] *= softer
    effort += 100.0 * turned + 90.0
    effort += noise * rng.standard_normal(slip.size)
    return points_of(field, slip, effort)


@pytest.mark.parametrize("speeds", [10, 13])
@pytest.mark.parametrize("fields", [1, 2, 4])
def test_points_left_out_lie_between_others_of_their_field(fields: int, speeds: int) -> None:
    data = sheet(fields=tuple(np.linspace(0.0, 1.0, fields)), speeds=speeds)
    masks = points_left_out(data)
    slip = data.elements[0].slip
    together = np.sum(masks, axis=0)
    np.testing.assert_array_equal(together, (slip > 5.0) & (slip < 60.0))
    for mask in masks:  # no whole field, and no two neighbours
        at_field = mask.reshape(fields, speeds)
        assert not at_field.all(axis=1).any()
        assert not (at_field[:, 1:] & at_field[:, :-1]).any()
        assert not (at_field[1:] & at_field[:-1]).any()


@pytest.mark.slow
@pytest.mark.parametrize("fields", [(0.0, 0.8, 1.6), (0.0, 0.4, 0.8, 1.2, 1.6)])
def test_rebound_unlike_compression_is_found_in_a_sheet(fields: tuple[float, ...]) -> None:
    comparison = compare(both_ways(0.6, fields), Settings(models=("bingham",)))
    assert comparison.recommended == "bingham+sides"
    entry = comparison.entry("bingham+sides")
    assert entry.test.share.value < 0.02  # the law alone errs by a tenth
    assert entry.test.share.value < 0.2 * comparison.entry("bingham").test.share.value
    # Half the difference of the ways at the highest field, and the mean of both.
    truth = {"eta": 400.0, "eta_a": 100.0, "T_y": 640.0, "T_ay": 160.0}
    for estimate in entry.outcome.estimates:
        if estimate.name in truth:
            assert estimate.low <= truth[estimate.name] <= estimate.high


@pytest.mark.slow
@pytest.mark.parametrize(
    "asked", [Settings(models=("bingham+sides",)), Settings(models=("bingham",), lag="sides")]
)
def test_a_stage_that_needs_no_time_may_be_asked_for(asked: Settings) -> None:
    comparison = compare(both_ways(0.6, (0.0, 0.8, 1.6)), asked)
    assert comparison.recommended == "bingham+sides"


@pytest.mark.slow
def test_a_sheet_whose_ways_are_alike_gets_no_stage() -> None:
    data = both_ways(1.0, (0.0, 0.4, 0.8, 1.2, 1.6))
    comparison = compare(data, Settings(models=("bingham",)))
    assert comparison.recommended == "bingham"


def of_an_oil_damper(seed: int) -> Dataset:
    """Points of a damper whose valves blow off at 0.2 m/s and at -0.12 m/s. SYNTHETIC."""
    speed = np.linspace(0.02, 0.6, 24)
    slip = np.concatenate([-speed[::-1], speed])
    effort = 3000.0 * slip - 2400.0 * np.maximum(slip - 0.2, 0.0)
    effort -= 2000.0 * np.minimum(slip + 0.12, 0.0)
    effort += 3.0 * np.random.default_rng(seed).standard_normal(slip.size)
    return points_of(np.zeros(slip.size), slip, effort)


@pytest.mark.slow
@pytest.mark.parametrize("seed", slow_behind(1, [2, 3, 4]))
def test_knees_are_found_in_a_sheet_without_a_field(seed: int) -> None:
    data = of_an_oil_damper(seed)
    law = law_from_name("bingham/constant", "single")
    base = Structure("single", "bingham/constant", law, offset=True)
    rung = grown(data, base)[-1]
    assert rung.structure.dynamics == "knees"
    reference = np.sqrt(np.mean(data.elements[0].slip ** 2))
    assert rung.numbers["w_f"] * reference == pytest.approx(0.2, rel=0.03)
    assert rung.numbers["w_b"] * reference == pytest.approx(0.12, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_knees_are_found_beside_a_law_that_bends(seed: int) -> None:
    """Without a stage Casson's law errs by less: its curve stands in for the knees."""
    comparison = compare(of_an_oil_damper(seed), Settings(models=("casson", "bingham")))
    assert comparison.recommended in ("bingham/constant+knees", "casson/constant+knees")
    found = {e.name: e for e in comparison.entry(comparison.recommended).outcome.estimates}
    assert found["w_f"].value == pytest.approx(0.2, rel=0.03)
    assert found["w_b"].value == pytest.approx(0.12, rel=0.03)


def test_a_measured_field_that_scatters_is_one_level() -> None:
    data = sheet()
    rng = np.random.default_rng(1)
    field = data.elements[0].field + 0.004 * rng.standard_normal(data.rows)
    numbers = field_levels([replace(data.elements[0], field=field)])
    np.testing.assert_array_equal(numbers, np.repeat([0, 1, 2], 12))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_dry_friction_that_falls_gets_its_levels_and_not_the_constants_of_a_fluid(
    seed: int,
) -> None:
    one_way = np.geomspace(0.01, 1.0, 25)
    slip = np.concatenate([-one_way[::-1], one_way])
    effort = np.sign(slip) * (1.0 + 0.5 * np.exp(-((slip / 0.05) ** 2))) + 0.3 * slip
    effort += 0.02 * np.random.default_rng(seed).standard_normal(slip.size)
    data = points_of(np.zeros(slip.size), slip, effort)
    comparison = compare(data, Settings(models=("bingham", "cho-choi-jhon", "seo-seo")))
    assert comparison.recommended == "bingham/constant+stribeck"
    found = comparison.entry(comparison.recommended).outcome.estimates
    truth = {"T_y": 1.0, "T_st": 0.5, "w_st": 0.05, "eta": 0.3}
    inside = [each.low < truth[each.name] < each.high for each in found if each.name in truth]
    assert sum(inside) >= 3  # of four numbers with 95 % each
