"""One definition of a row that a model guesses at: the check before a fit, the model and the exported step share it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.export import step_of
from erclutch.export.exported_step import OUTSIDE
from erclutch.export.step_numbers import run
from erclutch.fit.checks.data_check import check
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.training_range import range_of
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.model import CELLS, Range
from erclutch.models.structure import Structure
from erclutch.signals.array import Array, Mask
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from erclutch.signals.percent import percent

UNITS = Units("N*m", "V", "rad/s")
ANY_PLACE = st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0))


def rows_at(field: Array, slip: Array) -> Dataset:
    effort = 1e-3 * field * np.tanh(slip) + 0.01 * slip
    clock = Clock(np.arange(field.size, dtype=np.float64) * 1e-3, (Span(0, field.size, 1e-3),))
    return Dataset("single", (Element(field, slip),), effort, clock, UNITS)


def within(places: list[tuple[float, float]]) -> Dataset:
    """Rows at places of the ranges 0 .. 800 and -30 .. 50, two ends of which are always there."""
    x = np.array([(0.0, 0.0), (1.0, 1.0), *places])
    return rows_at(800.0 * x[:, 0], 80.0 * x[:, 1] - 30.0)


@pytest.mark.slow
@settings(deadline=None)
@given(st.lists(ANY_PLACE, max_size=30), st.lists(ANY_PLACE, min_size=1, max_size=30))
def test_near_is_a_sixteenth_of_the_range_and_an_eighth_is_far(
    trained: list[tuple[float, float]], asked: list[tuple[float, float]]
) -> None:
    covered = range_of(within(trained))
    outside = covered.outside(within(asked))[2:]
    seen, wanted = np.array([(0.0, 0.0), (1.0, 1.0), *trained]), np.array(asked)
    distance = np.abs(wanted[:, None] - seen).max(axis=2).min(axis=1)
    slack = 1e-9
    assert not np.any(outside[distance < 1.0 / CELLS - slack])
    assert np.all(outside[distance > 2.0 / CELLS + slack])


def test_beyond_the_ranges_all_is_far_and_on_their_ends_nothing_is() -> None:
    covered = range_of(within([]))
    field = np.array([0.0, 800.0, -7.9, 807.9, -8.1, 808.1, 1e300, -np.inf])
    slip = np.array([-30.0, 50.0, -30.7, 50.7, -30.0, 50.0, 50.0, -30.0])
    assert covered.outside(rows_at(field, slip)).tolist() == [False] * 4 + [True] * 4


def split() -> tuple[Dataset, Mask]:
    """Fields 0, 200, ... 800; all rows at 400 are held out."""
    rng = np.random.default_rng(0)
    field = rng.choice(np.arange(0.0, 801.0, 200.0), 4000)
    return rows_at(field, rng.uniform(-30.0, 50.0, field.size)), field == 400.0


@pytest.mark.slow
def test_the_check_the_model_and_the_step_count_the_same_rows() -> None:
    data, test = split()
    finding = next(f for f in check(data, test) if f.subject == "coverage")
    structure = Structure("single", "bingham", law_from_name("bingham", "single"))
    model = fit_structure(data.take(~test), structure, intervals=False).model
    outside = model.outside(data)
    assert outside[test].all()
    assert not outside[~test].any()
    assert finding.message.startswith(f"{percent(outside[test].mean(), 1)} of the test rows")
    rows = np.column_stack([data.elements[0].field, data.elements[0].slip])
    assert np.array_equal((run(step_of(model), rows)[1] & OUTSIDE) != 0, outside)


def test_without_a_grid_the_box_stands_for_it() -> None:
    data, test = split()
    covered = range_of(data.take(~test))
    box = Range(covered.field, covered.slip, covered.effort)
    assert covered.outside(data)[test].all()
    assert not box.outside(data).any()
    assert replace(covered, near=()) == box
    assert "near" not in box.to_dict()


def test_each_element_of_a_pair_has_its_own_cells() -> None:
    one, other = (within([(0.5, k)]) for k in (0.1, 0.9))
    pair = replace(one, device="coaxial", elements=(one.elements[0], other.elements[0]))
    covered = range_of(pair)
    swapped = replace(pair, elements=pair.elements[::-1])
    assert not covered.outside(pair).any()
    assert covered.outside(swapped).tolist() == [False, False, True]
