"""A law that is doubted: the criterion is that of a model with an offset in each cell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.wings.design.courses import Bounds, GrowingSequence
from erclutch.wings.design.doubt import CellGrid, Doubt, RowsOfUse
from erclutch.wings.design.fill import Cells
from erclutch.wings.design.information import Criterion, Knowledge
from erclutch.wings.design.limits import RigLimits
from erclutch.wings.design.stretches import StretchMaker

GRID = CellGrid(1.0, 10.0)
NUMBERS = 3


def some_rows(seed: int, rows: int = 300) -> tuple[Array, Cells]:
    rng = np.random.default_rng(seed)
    return rng.standard_normal((rows, NUMBERS)), rng.integers(0, 40, rows).astype(np.intp)


def brake(field: Array, slip: Array, effort: Array) -> Dataset:
    signals = {"field": field, "slip": slip, "effort": effort}
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    return build_dataset(recording_from_arrays(signals, rate=1000.0, units=units))


def noisy_brake(rng: np.random.Generator, rows: int) -> tuple[Dataset, TorqueModel]:
    """SYNTHETIC rows of a Bingham brake with white noise, and the law that is fitted to them."""
    time = np.arange(rows) * 1e-3
    field = 0.5 + 0.5 * np.sin(7.0 * time)
    slip = 10.0 * np.sin(11.0 * time)
    data = brake(
        field, slip, field * np.tanh(slip) + 0.02 * slip + 0.05 * rng.standard_normal(rows)
    )
    structure = Structure(
        "single", "bingham", law_from_name("bingham", "single"), "none", True, True
    )
    return data, fit_structure(data, structure, intervals=False).model


def test_the_offsets_are_integrated_out() -> None:
    """Beside the whole matrix of the numbers and of the first hundred offsets; no row asks for more."""
    weight, deviation = 2.0, 0.7
    derivatives, cells = some_rows(0)
    nothing = Doubt(GRID, deviation, np.zeros(GRID.size), np.zeros((GRID.size, NUMBERS)))
    doubt = nothing.plus(cells, derivatives, weight)
    prior = 0.1 * np.eye(NUMBERS)
    offsets = np.zeros((cells.size, 100))
    offsets[np.arange(cells.size), cells] = 1.0
    both = np.hstack([derivatives, offsets])
    whole = weight * both.T @ both
    whole[:NUMBERS, :NUMBERS] += prior
    whole[NUMBERS:, NUMBERS:] += deviation**-2 * np.eye(100)

    of_numbers = doubt.left_to_numbers(prior + weight * derivatives.T @ derivatives)

    new, at = some_rows(1, 20)
    at[:5] = 90  # a cell without rows
    row = np.zeros((20, NUMBERS + 100))
    row[:, :NUMBERS] = new
    row[np.arange(20), NUMBERS + at] = 1.0
    wanted = np.sum((row @ np.linalg.inv(whole)) * row, axis=1)
    used = RowsOfUse.of(new, at, GRID)
    variance = np.sum(
        doubt.squares(used) * np.linalg.inv(of_numbers)
    ) / used.rows + doubt.own_variance(used)
    np.testing.assert_allclose(variance, np.mean(wanted))
    without_rows = RowsOfUse.of(new[:5], at[:5], GRID)
    np.testing.assert_allclose(doubt.own_variance(without_rows), deviation**2)


def test_a_cell_tells_field_and_speed_and_whether_each_rises_or_falls() -> None:
    time = np.arange(1000) * 1e-3
    field = np.abs(np.sin(9.0 * time))
    slip = 10.0 * np.cos(5.0 * time)
    data = brake(field, slip, slip)
    cells = GRID.cells(data)
    assert cells.min() >= 0
    assert cells.max() < GRID.size
    assert np.unique(cells).size > 20
    still = GRID.cells(brake(np.full(50, 0.5), np.full(50, 2.0), np.zeros(50)))
    assert np.unique(still).size == 1
    turned = GRID.cells(brake(field, -slip, slip))
    assert not np.any(turned == cells)


@pytest.mark.slow
def test_a_law_is_doubted_as_far_as_its_residual_is_no_noise() -> None:
    data, right = noisy_brake(np.random.default_rng(0), 4000)
    sure = Knowledge(right, data, 1000.0, "I")
    assert sure.doubt is None or sure.doubt.deviation < 0.5 * sure.noise

    time = np.arange(data.rows) * 1e-3
    unexplained = 0.2 * np.sin(3.0 * np.sin(11.0 * time)) * np.cos(11.0 * time)
    late = replace(data, effort=data.effort + unexplained)
    wrong = Knowledge(right, late, 1000.0, "I")
    assert wrong.doubt is not None
    assert wrong.doubt.deviation > 0.8 * wrong.noise
    assert Knowledge(right, late, 1000.0).doubt is None


@pytest.mark.slow
@pytest.mark.parametrize("criterion", ["D", "I"])
def test_a_stretch_that_was_looked_at_teaches_what_it_would_teach_unseen(
    criterion: Criterion, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(0)
    data, model = noisy_brake(rng, 3000)
    sequence = GrowingSequence(
        Bounds.of(RigLimits(field=1.0, speed=10.0, acceleration=500.0), 1000.0, 5.0)
    )
    maker = StretchMaker(sequence, rng, 1000.0, signed=False, one_way=False)
    offers = [maker.draw() for _ in range(4)]

    unseen = Knowledge(model, data, 1000.0, criterion)
    unseen.take(sequence, offers[2])
    seen = Knowledge(model, data, 1000.0, criterion)
    seen.gains(sequence, offers)
    with monkeypatch.context() as patched:  # the derivatives are there: nothing is computed anew
        patched.setattr(Knowledge, "_rows", None)
        seen.take(sequence, offers[2])
    np.testing.assert_allclose(seen.information, unseen.information, rtol=1e-12)
    np.testing.assert_allclose(seen.errors(), unseen.errors(), rtol=1e-9)
    seen.take(
        sequence, offers[2]
    )  # once more: the sequence has grown, so its derivatives are others
    assert seen.information[-1, -1] > unseen.information[-1, -1]
