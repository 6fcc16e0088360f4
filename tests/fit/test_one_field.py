"""A device whose log has one field, or none: fitted without field terms, recovered, saved, exported."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from erclutch.errors import SettingError
from erclutch.export.step_numbers import run
from erclutch.export.step_record import step_of
from erclutch.fit.checks.data_check import STEADY_FIELD
from erclutch.fit.comparison import Comparison, Settings, compare
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.models.law_model import TorqueModel
from erclutch.models.load import load_model
from erclutch.models.networks.network_model import NetworkModel

W_S, T_Y, ETA, T_0, NOISE = 0.15, 12.0, 5.0, 0.7, 0.3


def one_field(field: float = 0.5, seed: int = 0, rows: int = 6000) -> Dataset:
    """A made-up brake at one field, with known numbers."""
    rng = np.random.default_rng(seed)
    t = np.arange(rows) / 1000
    slip = 2 * np.sin(2 * np.pi * 1.3 * t) + 1.1 * np.sin(2 * np.pi * 0.37 * t) + 0.3
    effort = T_Y * np.tanh(slip / W_S) + ETA * slip + T_0 + NOISE * rng.standard_normal(rows)
    signals = {"field": np.full(rows, field), "slip": slip, "effort": effort}
    return build_dataset(
        recording_from_arrays(
            signals, {"field": "A", "slip": "rad/s", "effort": "N*m"}, rate=1000.0
        )
    )


@pytest.fixture(scope="module")
def compared() -> Comparison:
    return compare(one_field(), Settings(models=("all", "fnn-6"), workers=1))


def model_of(comparison: Comparison, name: str) -> Any:
    return comparison.entry(name).outcome.model


@pytest.mark.slow
def test_the_truth_is_recovered(compared: Comparison) -> None:
    assert compared.recommended == "bingham/constant"
    found = {e.name: e for e in compared.entry("bingham/constant").outcome.estimates}
    assert list(found) == ["w_s", "T_y", "eta", "T_0"]
    for name, truth in {"w_s": W_S, "T_y": T_Y, "eta": ETA, "T_0": T_0}.items():
        assert found[name].low - 0.02 * truth < truth < found[name].high + 0.02 * truth, name
    assert compared.entries[0].test.rmse.value < 1.05 * NOISE


@pytest.mark.slow
def test_what_needs_a_field_is_left_out(compared: Comparison) -> None:
    names = {e.name for e in compared.entries}
    assert {"bingham/constant", "casson/constant", "fnn-6", "fnn-16", "rbfn-10"} <= names
    assert not any(
        name.startswith(("rbfm", "hem", "quadratic", "on-off")) or "+" in name for name in names
    )
    for entry in compared.entries:
        names = {e.name for e in entry.outcome.estimates}
        assert not names & {"n", "E_c", "T_f"}, entry.name
    network = model_of(compared, "fnn-6")
    assert network.structure.inputs == ("slip",)


@pytest.mark.slow
def test_the_findings_say_what_the_model_cannot_know(compared: Comparison) -> None:
    (finding,) = [f for f in compared.findings if f.subject == STEADY_FIELD]
    assert "the field is 0.5 A in all 6000 rows" in finding.message
    assert "cannot know the effort at any other field" in finding.message


@pytest.mark.slow
@pytest.mark.parametrize("field", [0.0, -2.0])
def test_any_field_will_do(field: float) -> None:
    found = compare(one_field(field, rows=3000), Settings(models=("bingham", "fnn-4"), workers=1))
    assert found.recommended == "bingham/constant"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bingham/constant", "fnn-6", "rbfn-10"])
def test_saved_and_exported(compared: Comparison, name: str, tmp_path: Path) -> None:
    model: TorqueModel | NetworkModel = model_of(compared, name)
    (tmp_path / "model.json").write_text(json.dumps(model.to_dict()))
    again = load_model(tmp_path / "model.json")
    data = one_field(seed=1, rows=500)
    assert_array_equal(model.predict(data), again.predict(data))
    step = step_of(again)
    assert step.inputs == ("field", "slip")
    rows = np.column_stack([data.elements[0].field, data.elements[0].slip])
    effort, flags = run(step, rows)
    assert_array_equal(effort, model.predict(data))
    # Another field changes nothing but the flag.
    rows[:, 0] = 0.9
    effort_there, flags_there = run(step, rows)
    assert_array_equal(effort, effort_there)
    assert not np.any(flags & 1)
    assert np.all(flags_there & 1)


@pytest.mark.parametrize(
    ("settings", "problem"),
    [
        (
            Settings(models=("bingham", "rbfm-5")),
            "rbfm-5 describes how the effort changes with the field",
        ),
        (Settings(models=("hem",)), "hem describes how"),
        (Settings(models=("quadratic",)), "quadratic describes how"),
        (Settings(models=("on-off",)), "on-off describes how"),
        (Settings(models=("bingham",), lag="lag"), "the stages lag follow a command that changes"),
        (
            Settings(models=("bingham",), friction=True),
            "friction and yield effort cannot be told apart",
        ),
    ],
)
def test_what_needs_a_field_and_was_asked_for(settings: Settings, problem: str) -> None:
    with pytest.raises(SettingError, match=re.escape(problem)) as caught:
        compare(one_field(rows=1000), settings)
    assert "the field is constant at 0.5 A in all rows" in str(caught.value)


@pytest.mark.slow
def test_a_memory_of_the_slip_needs_no_field() -> None:
    found = compare(one_field(rows=2000), Settings(models=("bingham",), lag="dahl", workers=1))
    assert found.recommended == "bingham/constant+dahl"
