"""Two ways of the slip that differ: their numbers are found from nothing, and the data ask for them."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.choice.ladder import grown
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

pytestmark = pytest.mark.slow

ROWS = 6000
LAW = law_from_name("bingham", "single")


def damper(
    viscous: float = 0.0, of_yield: float = 0.0, way: float = 1.0, friction: float = 0.0
) -> Dataset:
    """A damper at five currents; rebound and compression differ by twice as much, its load cell may be turned round."""
    t = np.arange(float(ROWS)) * 2e-3
    slip = 0.2 * np.sin(5.7 * t) + 0.15 * np.sin(13.1 * t)
    field = np.repeat([0.0, 0.5, 1.0, 1.5, 2.0, 1.0], ROWS // 6)
    strength = (field / 2.0) ** 0.8
    force = (40.0 + 500.0 * strength) * np.tanh(slip / 0.01) + 1200.0 * slip + 150.0
    force += viscous * np.abs(slip)
    force += (friction + of_yield * strength) * np.abs(np.tanh(slip / 0.01))
    force += 4.0 * np.random.default_rng(5).standard_normal(ROWS)
    clock = Clock(t, (Span(0, ROWS, 2e-3),))
    return Dataset(
        "single", (Element(field, way * slip),), way * force, clock, Units("N", "A", "m/s")
    )


def structure(stages: str) -> Structure:
    return Structure("single", "bingham", LAW, stages, friction=True, offset=True)


def test_known_numbers_are_found() -> None:
    outcome = fit_structure(damper(-300.0, 60.0, friction=15.0), structure("sides"))
    found = {estimate.name: estimate for estimate in outcome.estimates}
    assert outcome.sound
    assert found["eta_a"].unit == "N/(m/s)"
    truth = {
        "eta_a": -300.0,
        "T_ay": 60.0,
        "T_a": 15.0,
        "eta": 1200.0,
        "T_y": 500.0,
        "T_f": 40.0,
        "T_0": 150.0,
    }
    for name, value in truth.items():
        assert found[name].low < value < found[name].high, name


def test_the_ways_change_places_where_the_slip_and_the_effort_turn_round() -> None:
    outcome = fit_structure(damper(-300.0, 60.0, way=-1.0), structure("sides"))
    found = {estimate.name: estimate for estimate in outcome.estimates}
    assert found["eta_a"].low < 300.0 < found["eta_a"].high
    assert found["T_ay"].low < -60.0 < found["T_ay"].high


def test_the_data_ask_for_it_only_where_the_ways_differ() -> None:
    among = ("dahl/field", "viscous", "sides")
    asked = grown(damper(-300.0, 60.0), structure("none"), among=among)
    assert asked[1].structure.dynamics == "sides"
    assert asked[1].error < 0.3 * asked[0].error
    alike = grown(damper(), structure("none"), among=among)
    assert [rung.structure.dynamics for rung in alike] == ["none"]
