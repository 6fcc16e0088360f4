"""Where no training row was, a network gives way to a law: its effort stays near what a device can do."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import RunError
from erclutch.export import ExportOptions, step_of
from erclutch.export.step_numbers import reference, run
from erclutch.fit.candidate import Fitted
from erclutch.fit.fit_settings import Settings
from erclutch.fit.kinds.network_alone import Networks
from erclutch.fit.training_range import near_cells, range_of
from erclutch.logs.dataset import Dataset
from erclutch.models.load import load_model
from erclutch.models.networks.network_inputs import field_in_fluid
from erclutch.models.networks.network_model import NetworkModel
from erclutch.models.shared_answers import WORTH_LOADING
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import DeviceName, Element, Units
from tests.support.exported_models import network_model, with_law

PERIOD = 1e-3


def clock_of(rows: int) -> Clock:
    return Clock(PERIOD * np.arange(float(rows)), (Span(0, rows, PERIOD),))


def logged(device: DeviceName, levels: tuple[float, ...], rows: int = 2000) -> Dataset:
    """SYNTHETIC rows of a few fields, at slips within 2 rad/s. The effort grows with the field."""
    rng = np.random.default_rng(0)
    count = 2 if device == "coaxial" else 1
    elements = tuple(
        Element(rng.choice(levels, rows), rng.uniform(-2.0, 2.0, rows)) for _ in range(count)
    )
    sides = zip((1.0, -1.0), elements, strict=False)
    effort = sum(
        side * (3.0 * e.field * np.tanh(side * e.slip / 0.1) + 0.1 * e.slip) for side, e in sides
    )
    noisy = np.asarray(effort + 0.01 * rng.standard_normal(rows), np.float64)
    return Dataset(device, elements, noisy, clock_of(rows), Units("N*m", "A", "rad/s"))


def trained(device: DeviceName, dynamics: str = "none") -> tuple[NetworkModel, Dataset]:
    """A network with a law beyond the rows of three fields, between which no row is."""
    rows = logged(device, (0.0, 0.5, 1.0))
    network = replace(
        network_model("fnn-6", device, dynamics), trained_on=range_of(rows), units=rows.units
    )
    fluids = [
        field_in_fluid(e.field, network.structure, rows.clock, network.dynamics)
        for e in rows.elements
    ]
    elements = [Element(fluid, e.slip) for fluid, e in zip(fluids, rows.elements, strict=True)]
    made = with_law(replace(network, near=near_cells(network.trained_on, elements)))
    assert made.beyond is not None
    return replace(made, beyond=replace(made.beyond, units=rows.units)), rows


def with_fields(rows: Dataset, field: float) -> tuple[Element, ...]:
    return tuple(Element(np.full(rows.rows, field), e.slip) for e in rows.elements)


@pytest.mark.parametrize("device", ["single", "coaxial"])
@pytest.mark.parametrize("dynamics", ["none", "lag"])
def test_at_training_rows_the_law_changes_no_bit(device: DeviceName, dynamics: str) -> None:
    network, rows = trained(device, dynamics)
    for exactly in (True, False):
        one, other = (
            m.effort(rows.elements, rows.clock, exactly=exactly)
            for m in (network, replace(network, beyond=None))
        )
        assert np.array_equal(one, other)


@pytest.mark.parametrize("device", ["single", "coaxial"])
@pytest.mark.parametrize("field", [0.25, 0.75, 1.2, 5.0])
def test_at_a_field_that_no_row_had_the_law_is_alone(device: DeviceName, field: float) -> None:
    network, rows = trained(device)
    elements, law = with_fields(rows, field), network.beyond
    assert law is not None
    wanted = law.effort(elements, rows.clock)
    assert np.array_equal(network.effort(elements, rows.clock), wanted)
    assert np.array_equal(
        network.steady([e.field for e in elements], [e.slip for e in elements]), wanted
    )


@pytest.mark.slow
def test_between_both_nothing_jumps() -> None:
    network, _ = trained("single")
    field = np.linspace(-0.3, 1.3, 200_001)
    effort = network.effort((Element(field, np.full(field.size, 0.7)),), clock_of(field.size))
    law = network.beyond
    assert law is not None
    assert np.abs(np.diff(effort)).max() < 1e-3 * np.ptp(effort)
    share = network.nearness.share([field], [np.full(field.size, 0.7)], [])
    assert share.min() == 0.0
    assert share.max() == 1.0


def test_a_further_input_beyond_its_range_calls_the_law_too() -> None:
    network = with_law(network_model("fnn-3", "single", extras=("temperature",)))
    law = network.beyond
    assert law is not None
    low, high = network.extras["temperature"]
    wide = high - low
    element = Element(np.full(3, 100.0), np.full(3, 5.0))
    extras = {"temperature": np.array([high, high + 0.05 * wide, high + 0.1 * wide])}
    effort = network.effort((element,), clock_of(3), extras)
    alone = replace(network, beyond=None).effort((element,), clock_of(3), extras)
    beside = law.effort((element,), clock_of(3), extras)
    assert effort[0] == alone[0]
    assert min(alone[1], beside[1]) < effort[1] < max(alone[1], beside[1])
    assert effort[2] == beside[2]


@pytest.mark.slow
def test_a_lone_row_has_the_bits_of_many() -> None:
    network, _ = trained("single")
    rng = np.random.default_rng(1)
    element = Element(rng.uniform(-0.3, 1.3, 40), rng.uniform(-3.0, 3.0, 40))
    many = network.effort((element,), clock_of(40))
    amid = np.flatnonzero(network.nearness.amid([element.field], [element.slip], []))
    assert amid.size
    for k in [int(amid[0]), *range(40)]:
        row = Element(element.field[k : k + 1], element.slip[k : k + 1])
        for _ in range(WORTH_LOADING + 1 if k == amid[0] else 1):
            lone = network.effort((row,), clock_of(1))
        assert lone[0] == many[k]


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("dynamics", ["none", "lag", "inertia"])
def test_an_exported_step_fades_as_predict_does(precision: Any, dynamics: str) -> None:
    network, _ = trained("coaxial", dynamics)
    step = step_of(network, ExportOptions("m", precision, PERIOD))
    rng = np.random.default_rng(2)
    inputs = np.column_stack([rng.uniform(0.0, 1.05, (400, 2)), rng.uniform(-1.5, 1.5, (400, 2))])
    effort, wanted = run(step, inputs)[0], reference(step, inputs)[0]
    if precision == "float64":
        assert np.array_equal(effort, wanted)
    assert np.abs(effort - wanted).max() < 1e-4 * step.scale
    alone = reference(
        step_of(replace(network, beyond=None), ExportOptions("m", precision, PERIOD)), inputs
    )[0]
    assert np.abs(alone - wanted).max() > 0.1 * step.scale


def test_a_file_keeps_the_law_and_files_without_load_as_before(tmp_path: Path) -> None:
    network, _ = trained("coaxial")
    alone, path = replace(network, beyond=None), tmp_path / "model.json"
    for model in (alone, network):
        path.write_text(json.dumps(model.to_dict()), encoding="utf-8")
        assert load_model(path).to_dict() == model.to_dict()
    assert "beyond" not in alone.to_dict()
    assert "nothing bounds" in alone.unbounded
    assert network.unbounded == ""
    assert step_of(alone, ExportOptions("m", "float64", PERIOD)).notes == [alone.unbounded]
    assert network.beyond is not None
    other = replace(network, beyond=replace(network.beyond, units=Units("N", "A", "m/s")))
    path.write_text(json.dumps(other.to_dict()), encoding="utf-8")
    with pytest.raises(RunError, match="beyond the rows"):
        load_model(path)


def test_a_law_with_inputs_that_the_network_has_not_is_refused(tmp_path: Path) -> None:
    heated = with_law(network_model("fnn-3", "single", extras=("temperature",)))
    path = tmp_path / "model.json"
    path.write_text(
        json.dumps(replace(network_model("fnn-3", "single"), beyond=heated.beyond).to_dict())
    )
    with pytest.raises(RunError, match="inputs that the network has not"):
        load_model(path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("logs", "asked"), [((0.0, 0.25, 0.5, 0.75), 1.2), ((0.0, 0.5, 1.0), 0.25)]
)
def test_a_field_that_no_log_had_is_met_whatever_the_start(
    logs: tuple[float, ...], asked: float
) -> None:
    train = logged("single", logs)
    far = logged("single", (asked,))
    for seed in range(2):
        candidate = Networks().candidates(Settings(("fnn-4",), "none", seed=seed), train)[0]
        outcome = candidate.fit(train, [], 1)
        again = candidate.refit(
            train, np.ones(train.rows, np.bool_), outcome, [Fitted(candidate, outcome)]
        )
        for model in (outcome.model, again.model):
            assert rms(far.effort - model.predict(far)) < 0.15 * float(np.std(far.effort))


def rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x**2)))
