"""Far outside its training rows a network changes as a law does: its effort stays near what a device can do."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import RunError
from erclutch.fit.candidate import Fitted
from erclutch.fit.fit_settings import Settings
from erclutch.fit.kinds.network_alone import Networks
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import Reference, Structure, TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.load import load_model
from erclutch.models.model import held_window
from erclutch.models.networks.network_model import NetworkModel
from erclutch.models.shared_answers import WORTH_LOADING
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import DeviceName, Element, Units
from tests.support.exported_models import network_model

PERIOD = 1e-3


def law_for(network: NetworkModel) -> TorqueModel:
    device = network.structure.device
    structure = Structure(device, "bingham", law_from_name("bingham", device), "none", False, False)
    reference = Reference(network.trained_on.field[1], 10.0, PERIOD)
    shape = {p.name: {"n": 1.4, "w_s": 0.05}[p.name] for p in structure.shapes(PERIOD)}
    gains = {g.name: 0.3 for g in structure.gains()}
    return TorqueModel(structure, reference, shape, gains, network.units, network.trained_on)


def both(device: DeviceName, dynamics: str = "none") -> tuple[NetworkModel, NetworkModel]:
    """A network alone, and the same with a law beyond its rows."""
    alone = network_model("fnn-6", device, dynamics)
    return alone, replace(alone, beyond=law_for(alone))


def clock_of(rows: int) -> Clock:
    return Clock(PERIOD * np.arange(float(rows)), (Span(0, rows, PERIOD),))


def elements_within(network: NetworkModel, rows: int, wide: float) -> tuple[Element, ...]:
    """Random signals over the training range, times a factor."""
    rng = np.random.default_rng(0)
    (low, high), (least, most) = network.trained_on.field, network.trained_on.slip
    count = 2 if network.structure.device == "coaxial" else 1
    return tuple(
        Element(wide * rng.uniform(low, high, rows), wide * rng.uniform(least, most, rows)) for _ in range(count)
    )


def edge_of(network: NetworkModel, elements: tuple[Element, ...]) -> tuple[Element, ...]:
    field, slip = held_window(network.trained_on.field), held_window(network.trained_on.slip)
    return tuple(Element(np.clip(e.field, *field), np.clip(e.slip, *slip)) for e in elements)


@pytest.mark.parametrize("device", ["single", "coaxial"])
@pytest.mark.parametrize("dynamics", ["none", "lag"])
def test_within_the_window_no_bit_changes(device: DeviceName, dynamics: str) -> None:
    alone, with_law = both(device, dynamics)
    elements = elements_within(alone, 500, 1.0)
    for exactly in (True, False):
        one, other = (m.effort(elements, clock_of(500), exactly=exactly) for m in (alone, with_law))
        assert np.array_equal(one, other)


@pytest.mark.parametrize("device", ["single", "coaxial"])
def test_far_outside_the_law_says_what_changes_from_the_edge_on(device: DeviceName) -> None:
    alone, with_law = both(device)
    elements = elements_within(alone, 500, 3.0)
    edge = edge_of(alone, elements)
    law, clock = law_for(alone), clock_of(500)
    wanted = alone.effort(edge, clock) + (law.effort(elements, clock) - law.effort(edge, clock))
    assert np.array_equal(with_law.effort(elements, clock), wanted)
    assert not np.allclose(alone.effort(elements, clock), wanted)
    signals = [e.field for e in elements], [e.slip for e in elements]
    assert np.allclose(with_law.steady(*signals), wanted, rtol=1e-12)


def test_there_is_no_jump_at_the_edge() -> None:
    alone, with_law = both("single")
    at = held_window(alone.trained_on.field)[1]
    field = at + 1e-9 * np.arange(-5.0, 6.0)
    efforts: Array = with_law.effort((Element(field, np.full(11, 3.0)),), clock_of(11))
    assert np.abs(np.diff(efforts)).max() < 1e-6


def test_a_lone_row_has_the_bits_of_many() -> None:
    alone, with_law = both("single")
    element = elements_within(alone, 20, 3.0)[0]
    many = with_law.effort((element,), clock_of(20))
    for k in range(20):
        row = Element(element.field[k : k + 1], element.slip[k : k + 1])
        for _ in range(WORTH_LOADING + 1 if k == 0 else 1):
            lone = with_law.effort((row,), clock_of(1))
        assert lone[0] == many[k]


def test_a_file_keeps_the_law_and_files_without_load_as_before(tmp_path: Path) -> None:
    alone, with_law = both("coaxial")
    path = tmp_path / "model.json"
    for model in (alone, with_law):
        path.write_text(json.dumps(model.to_dict()), encoding="utf-8")
        assert load_model(path).to_dict() == model.to_dict()
    assert "beyond" not in alone.to_dict()
    other = replace(with_law, beyond=replace(law_for(alone), units=Units("N", "A", "m/s")))
    path.write_text(json.dumps(other.to_dict()), encoding="utf-8")
    with pytest.raises(RunError, match="beyond the rows"):
        load_model(path)


def test_a_field_far_beyond_the_logs_is_met_whatever_the_start() -> None:
    """SYNTHETIC: yield effort in proportion to the field, fitted to 0.75 and asked at 1.2. A network alone flattens."""
    rng, rows = np.random.default_rng(0), 4000
    field, slip = rng.choice([0.0, 0.25, 0.5, 0.75], rows), rng.uniform(-2.0, 2.0, rows)

    def made(field: Array) -> Dataset:
        effort = 3.0 * field * np.tanh(slip / 0.1) + 0.1 * slip + 0.01 * rng.standard_normal(rows)
        return Dataset("single", (Element(field, slip),), effort, clock_of(rows), Units("N*m", "A", "rad/s"))

    train, far = made(field), made(np.full(rows, 1.2))
    for seed in range(2):
        candidate = Networks().candidates(Settings(("fnn-4",), "none", seed=seed), train)[0]
        outcome = candidate.fit(train, [], 1)
        again = candidate.refit(train, outcome, [Fitted(candidate, outcome)])
        for model in (outcome.model, again.model):
            error, raw = (far.effort - m.predict(far) for m in (model, replace(model, beyond=None)))
            assert np.sqrt(np.mean(error**2)) < 0.15 * np.std(far.effort)
            assert np.sqrt(np.mean(error**2)) < 0.5 * np.sqrt(np.mean(raw**2))
