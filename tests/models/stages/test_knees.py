"""Knees of an oil damper: their numbers are found from nothing, and the data ask for them only where there are any."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.choice.ladder import grown
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.stages import slip_stages
from erclutch.models.stages.stage import SlipAndStrength
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

ROWS = 6000
NAME = "bingham/constant"
LAW = law_from_name(NAME, "single")


def damper(forward: float = 0.0, backward: float = 0.0, power: float = 1.0) -> Dataset:
    """An oil damper whose steepness changes by so much beyond 0.12 m/s forward and beyond 0.08 m/s backward."""
    t = np.arange(float(ROWS)) * 2e-3
    slip = 0.2 * np.sin(5.7 * t) + 0.15 * np.sin(13.1 * t)
    force = 3000.0 * np.sign(slip) * np.abs(slip) ** power + 40.0 * np.tanh(slip / 0.01)
    force += forward * np.maximum(slip - 0.12, 0.0) + backward * np.minimum(slip + 0.08, 0.0)
    force += 4.0 * np.random.default_rng(5).standard_normal(ROWS)
    clock = Clock(t, (Span(0, ROWS, 2e-3),))
    return Dataset("single", (Element(np.zeros(ROWS), slip),), force, clock, Units("N", "A", "m/s"))


def structure(stages: str) -> Structure:
    return Structure("single", NAME, LAW, stages, friction=False, offset=True)


def columns_at(slip: Array) -> tuple[Array, Array]:
    forward, backward = slip_stages("knees")[0].settled(
        SlipAndStrength(slip, np.ones_like(slip)), {"w_f": 0.5, "w_b": 0.25}
    )
    return forward, backward


def test_below_its_knees_a_damper_is_as_the_law_says_and_beyond_them_the_columns_grow_with_the_slip() -> (
    None
):
    forward, backward = columns_at(np.array([-1.25, -0.25, 0.0, 0.5, 2.0]))
    assert forward.tolist() == [0.0, 0.0, 0.0, 0.0, 1.5]
    assert backward.tolist() == [-1.0, 0.0, 0.0, 0.0, 0.0]


@pytest.mark.slow
def test_known_numbers_are_found() -> None:
    outcome = fit_structure(damper(-1800.0, -2500.0), structure("knees"))
    found = {estimate.name: estimate for estimate in outcome.estimates}
    assert outcome.sound
    assert found["eta_f"].unit == "N/(m/s)"
    assert found["w_f"].unit == "m/s"
    truth = {"eta_f": -1800.0, "eta_b": -2500.0, "w_f": 0.12, "w_b": 0.08, "eta": 3000.0}
    for name, value in truth.items():
        assert found[name].low < value < found[name].high, name
        assert found[name].value == pytest.approx(value, rel=0.02), name


@pytest.mark.slow
def test_the_data_ask_for_it_only_where_there_are_knees() -> None:
    among = ("dahl/field", "viscous", "sides", "knees")
    asked = grown(damper(-1800.0, -2500.0), structure("none"), among=among)
    assert asked[1].structure.dynamics == "knees"
    assert asked[1].error < 0.2 * asked[0].error
    for without in (damper(), damper(power=0.6)):
        rungs = grown(without, structure("none"), among=among)
        assert "knees" not in rungs[-1].structure.dynamics
