"""A state whose travel has run to a bound is brought back; stages on the effort do not change what is solved."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from erclutch.fit.laws import fit_law
from erclutch.fit.laws.fit_law import fit_structure, reference_of
from erclutch.fit.laws.other_basins import best_basin
from erclutch.fit.solver.variable_projection import (
    Separable,
    coordinates,
    jacobian,
    parameters,
    project,
)
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from tests.support.slow_params import slow_behind

pytestmark = pytest.mark.slow

PERIOD, ROWS = 1e-3, 6000
CHAIN = "dahl-2/field+effort-lag+inertia"
TRUTH = {"w_s": 0.4, "n": 1.6, "r_1": 0.006, "r_2": 0.08, "tau_e": 0.004}


def structure(dynamics: str) -> Structure:
    return Structure("single", "bingham", law_from_name("bingham", "single"), dynamics, offset=True)


def recording(dynamics: str, truth: Mapping[str, float]) -> Dataset:
    """A law with memory, of known numbers, and one percent of noise."""
    rng = np.random.default_rng(5)
    t: Array = np.arange(ROWS, dtype=np.float64) * PERIOD
    slip = sum(
        a * np.sin(2 * np.pi * f * t + p)
        for a, f, p in ((1.0, 1.3, 0.0), (0.6, 4.1, 1.0), (0.4, 11.0, 2.0))
    )
    field = np.repeat(rng.uniform(0.0, 1.0, ROWS // 150), 150)
    clock = Clock(t, (Span(0, ROWS, PERIOD),))
    bare = Dataset(
        "single", (Element(field, np.asarray(slip)),), np.zeros(ROWS), clock, Units("N", "A", "m/s")
    )
    made = structure(dynamics)
    columns = made.columns(bare.elements, clock, reference_of(bare), list(truth.values()))
    effort: Array = np.sum(
        [c * g for c, g in zip(columns, (60.0, 15.0, 50.0, 30.0, 0.05, 3.0), strict=True)], axis=0
    )
    return Dataset(
        "single",
        bare.elements,
        effort + 0.01 * np.std(effort) * rng.normal(size=ROWS),
        clock,
        bare.units,
    )


def problem(data: Dataset, dynamics: str, rows: slice = slice(None)) -> Separable:
    made, reference = structure(dynamics), reference_of(data)
    return fit_law.separable(data, made, reference, made.shapes(reference.period), rows)


@pytest.fixture(scope="module")
def data() -> Dataset:
    return recording(CHAIN, TRUTH)


@pytest.mark.parametrize("travels", [(0.006, 10.0), (0.08, 10.0), (1e-4, 0.02), (10.0, 10.0)])
def test_a_state_at_its_bound_is_brought_back(data: Dataset, travels: tuple[float, float]) -> None:
    few, rough = (problem(data, CHAIN, slice(None, None, k)) for k in (4, 2))
    start = coordinates(few.shapes, [0.4, 1.6, *travels, 0.004])
    found = best_basin(few, rough, [start])
    numbers = dict(zip(TRUTH, parameters(few.shapes, found.point), strict=True))
    assert sorted([numbers["r_1"], numbers["r_2"]]) == pytest.approx([0.006, 0.08], rel=0.1)
    assert found.cost <= project(rough, list(TRUTH.values())).cost * 1.001


@pytest.mark.parametrize("scan", slow_behind(1, [12, 24, 48]))
def test_any_scan_comes_to_the_same_optimum(data: Dataset, scan: int) -> None:
    found = fit_structure(data, structure(CHAIN), scan=scan, intervals=False)
    best = project(problem(data, CHAIN), list(TRUTH.values())).cost
    assert found.train_cost < best
    assert found.train_cost == pytest.approx(best, rel=0.01)


def test_derivatives_of_the_sum_are_the_sum_of_the_derivatives(data: Dataset) -> None:
    behind = problem(data, CHAIN)
    made, reference = structure(CHAIN), reference_of(data)
    whole = Separable(
        lambda q: made.columns(data.elements, data.clock, reference, q),
        data.effort,
        behind.shapes,
        behind.gains,
    )
    u = coordinates(behind.shapes, [0.3, 1.2, 0.01, 0.1, 0.003])
    (columns, slopes, projection), (same, beside, other) = jacobian(behind, u), jacobian(whole, u)
    np.testing.assert_array_equal(columns, same)
    np.testing.assert_allclose(projection.gains, other.gains, rtol=1e-9)
    np.testing.assert_allclose(slopes, beside, rtol=1e-7, atol=1e-9 * np.abs(beside).max())
