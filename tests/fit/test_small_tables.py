"""A bench sheet has a few dozen points, each a mean: laws are fitted to it, and whole fields choose among them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.errors import CheckError
from erclutch.fit.checks.data_check import check
from erclutch.fit.choice.points_left_out import fields_left_out, points_left_out
from erclutch.fit.choice.validation import parts_of_training
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.training_range import range_of
from erclutch.logs import recording_from_arrays
from erclutch.logs.clock.timing import of_points
from erclutch.logs.covering_stretches import field_levels
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.held_out import hold_out

YIELD, VISCOSITY, FRICTION = 3.0, 0.005, 0.2


def sheet(fields: tuple[float, ...] = (0.0, 0.5, 1.0), speeds: int = 12) -> Dataset:
    """Points of a brake whose law is Bingham's with a yield effort that grows as the field, and noise."""
    rng = np.random.default_rng(3)
    field = np.repeat(fields, speeds)
    slip = np.tile(np.linspace(5.0, 60.0, speeds), len(fields))
    effort = FRICTION + YIELD * field + VISCOSITY * slip + 0.01 * rng.standard_normal(slip.size)
    signals = {"field": field, "slip": slip, "effort": effort}
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    data = build_dataset(recording_from_arrays(signals, units, rate=1.0))
    return replace(data, notes=(*data.notes, *of_points(data.rows, 1.0).notes))


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
    np.testing.assert_array_equal(np.sum(masks, axis=0), 1)
    for mask in masks:
        assert np.ptp(data.elements[0].slip[mask]) > 0.0


def test_a_measured_field_that_scatters_is_one_level() -> None:
    data = sheet()
    rng = np.random.default_rng(1)
    field = data.elements[0].field + 0.004 * rng.standard_normal(data.rows)
    numbers = field_levels([replace(data.elements[0], field=field)])
    np.testing.assert_array_equal(numbers, np.repeat([0, 1, 2], 12))
