"""A device that always turns one way: its log tells nothing of the sign's turn, and needs nothing of it."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.comparison import Settings, compare
from erclutch.fit.data_check import check
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
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


def test_a_field_that_is_never_positive_is_told_with_its_remedy() -> None:
    data = one_way(0, 1.0)
    signals = {"field": -data.elements[0].field, "slip": data.elements[0].slip, "effort": data.effort}
    found = check(build_dataset(recording_from_arrays(signals, UNITS, rate=1000.0)), np.zeros(data.rows, np.bool_))
    assert any("--field '-NAME [unit]'" in finding.remedy for finding in found)
    assert not any("never above zero" in finding.message for finding in check(data, np.zeros(data.rows, np.bool_)))
