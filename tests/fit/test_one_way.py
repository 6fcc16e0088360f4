"""A device that always turns one way: its log tells nothing of the sign's turn, and needs nothing of it."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.checks.data_check import check
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.kinds.law_alone import LawCandidate
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from tests.support.slow_params import slow_but

UNITS = {"field": "V", "slip": "rad/s", "effort": "N*m"}


def one_way(seed: int, sense: float, rows: int = 8000) -> Dataset:
    rng = np.random.default_rng(seed)
    t = np.arange(rows) / 1000
    field = np.repeat(rng.uniform(0.0, 5.0, rows // 100), 100)
    slip = rng.uniform(30.0, 200.0) + 10.0 * np.sin(4.4 * t) + 10.0 * np.sin(14.5 * t + 1.0)
    effort = 0.8 * (field / 5.0) ** 1.5 + 0.004 * slip + 0.05 + 0.005 * rng.standard_normal(rows)
    signals = {"field": field, "slip": sense * slip, "effort": sense * effort}
    return build_dataset(recording_from_arrays(signals, UNITS, rate=1000.0))


@pytest.mark.slow
@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("seed", slow_but(range(1), range(3)))
def test_the_law_that_made_the_log_is_recommended_and_known(seed: int, sense: float) -> None:
    found = compare(one_way(seed, sense), Settings(models=("bingham", "on-off"), lag="none"))
    assert found.recommended == "bingham"
    chosen = found.entry("bingham")
    assert chosen.sound
    assert chosen.test.rmse.value < 0.0053
    numbers = {e.name: e for e in chosen.outcome.estimates}
    assert "T_f" not in numbers
    assert numbers["eta"].low < 0.004 < numbers["eta"].high
    assert any("the slip keeps its sign" in finding.message for finding in found.findings)


@pytest.mark.slow
def test_friction_is_there_when_asked_for_and_where_the_slip_turns() -> None:
    data = one_way(0, 1.0)
    named = Settings(models=("bingham",), lag="none")
    asked = compare(data, Settings(models=("bingham",), lag="none", friction=True))
    assert "T_f" in {e.name for e in asked.entry("bingham").outcome.estimates}
    slip = data.elements[0].slip - data.elements[0].slip.mean()
    signals = {"field": data.elements[0].field, "slip": slip, "effort": data.effort * np.tanh(slip)}
    turns = build_dataset(recording_from_arrays(signals, UNITS, rate=1000.0))
    assert (data.one_way, turns.one_way) == (True, False)
    assert "T_f" in {e.name for e in compare(turns, named).entry("bingham").outcome.estimates}


@pytest.mark.slow
@pytest.mark.parametrize(("fields", "told"), [((0.2, 1.0), False), ((0.0, 0.3, 0.6, 1.0), True)])
def test_friction_goes_where_the_fields_are_fewer_than_the_numbers(
    fields: tuple[float, ...], told: bool
) -> None:
    """With two fields the friction ended at zero, sound by its bound, and the yield effort's interval missed it."""
    rng, t = np.random.default_rng(2), np.arange(1500) * 2e-3
    field = np.repeat(rng.choice(fields, 25), 60)
    slip = 3.0 * np.sin(4.4 * t) + 2.0 * np.sin(11.9 * t + 1.0)
    effort = (
        (0.8 * field**1.5 + 0.2 * told) * np.tanh(slip / 0.3)
        + 0.05 * slip
        + 0.02 * rng.standard_normal(1500)
    )
    log = recording_from_arrays({"field": field, "slip": slip, "effort": effort}, UNITS, rate=500.0)
    structure = Structure(
        "single", "bingham", law_from_name("bingham", "single"), friction=True, offset=True
    )
    estimates = {
        e.name: e for e in LawCandidate(structure).fit(build_dataset(log), (), 1).estimates
    }
    assert ("T_f" in estimates) == told
    assert estimates["T_y"].low < 0.8 < estimates["T_y"].high


def test_a_field_that_is_never_positive_is_told_with_its_remedy() -> None:
    data = one_way(0, 1.0)
    signals = {
        "field": -data.elements[0].field,
        "slip": data.elements[0].slip,
        "effort": data.effort,
    }
    found = check(
        build_dataset(recording_from_arrays(signals, UNITS, rate=1000.0)),
        np.zeros(data.rows, np.bool_),
    )
    assert any("--field '-NAME [unit]'" in finding.remedy for finding in found)
    assert not any(
        "never above zero" in finding.message
        for finding in check(data, np.zeros(data.rows, np.bool_))
    )
