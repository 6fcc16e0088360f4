"""A network on a law's residual never adds more than its limit, and nothing where there were no training rows."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import CheckError, RunError, SettingError
from erclutch.export import ExportOptions
from erclutch.export.recording.step_recording import SWITCHED_OFF
from erclutch.export.step_numbers import run
from erclutch.export.step_record import step_of, step_record
from erclutch.export.targets.python import compile_model
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.kinds.law_alone import structures_for
from erclutch.fit.kinds.law_with_network import residuals_for
from erclutch.fit.networks.fit_residual import fit_residual
from erclutch.logs.dataset import Dataset
from erclutch.models.covered_cells import CoveredCells, cells_of
from erclutch.models.laws import law_from_name
from erclutch.models.load import load_model
from erclutch.models.model_file import digest_of
from erclutch.models.networks import network_from_name
from erclutch.models.residual_model import ResidualModel, ResidualStructure, parts_of
from erclutch.models.stages import needs_time, stages_of
from erclutch.models.structure import Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from tests.support.examples import examples

pytestmark = pytest.mark.slow

PERIOD = 1e-3
DYNAMICS = "lag+dahl+effort-lag"


def device(rows: int = 6000, seed: int = 0, *, missed: float = 3.0, field: Any = None) -> Dataset:
    """A damper with a Bingham effort, and what no law of ours has: a bump at one field and slip."""
    rng = np.random.default_rng(seed)
    time = np.asarray(np.arange(rows) * PERIOD, np.float64)
    field = np.repeat(rng.uniform(0.0, 2.0, rows // 100), 100) if field is None else field
    slip = 20.0 * np.sin(2.0 * np.pi * 1.7 * time + 3.0 * np.sin(0.9 * time))
    bump = missed * np.exp(-((field - 1.0) ** 2) / 0.1 - (slip - 8.0) ** 2 / 30.0)
    effort = (
        (2.0 + 5.0 * field) * np.tanh(slip / 2.0) + 0.2 * slip + bump + rng.normal(0.0, 0.05, rows)
    )
    clock = Clock(time, (Span(0, rows, PERIOD),))
    return Dataset("single", (Element(field, slip),), effort, clock, Units("N", "A", "mm/s"))


def structure(dynamics: str = "none", network: str = "fnn-4") -> ResidualStructure:
    law = Structure("single", "bingham", law_from_name("bingham", "single"), dynamics, False, True)
    return ResidualStructure(law, network_from_name(network, "single", dynamics=dynamics))


@pytest.fixture(scope="module")
def data() -> Dataset:
    return device()


@pytest.fixture(scope="module")
def model(data: Dataset) -> ResidualModel:
    return fit_residual(data, structure()).model


@pytest.fixture(scope="module")
def with_memory() -> ResidualModel:
    """Of few rows: what is asked of it holds for any numbers."""
    return fit_residual(device(2000), structure(DYNAMICS)).model


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(x**2)))


def test_the_network_takes_what_the_law_misses(data: Dataset) -> None:
    model = fit_residual(data, structure(network="fnn-10")).model
    fresh = device(seed=1)
    alone, both = (_rms(fresh.effort - m.predict(fresh)) for m in (model.law, model))
    assert both < 0.4 * alone


def test_nothing_is_added_where_nothing_is_missed() -> None:
    found = fit_residual(device(missed=0.0), structure())
    fresh = device(seed=1, missed=0.0)
    alone, both = (_rms(fresh.effort - m.predict(fresh)) for m in (found.model.law, found.model))
    assert both < 1.01 * alone


ANY = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=examples(300), deadline=None)
@given(x=st.lists(st.tuples(ANY, ANY, ANY, ANY), min_size=1, max_size=5))
def test_the_limit_holds_for_any_input(
    with_memory: ResidualModel, x: list[tuple[float, ...]]
) -> None:
    correction = with_memory.correction
    inputs = np.array(x, np.float64).T[: len(correction.network.structure.inputs)]
    with np.errstate(all="ignore"):
        added = correction.of_inputs(inputs)
    assert np.all(np.abs(added) <= correction.limit)


@settings(max_examples=examples(200), deadline=None)
@given(field=st.floats(-1e3, 1e3), slip=st.floats(-1e5, 1e5))
def test_the_law_is_alone_outside_the_training_range(
    model: ResidualModel, field: float, slip: float
) -> None:
    reach = model.correction.covered.reach * (model.law.reference.field, 1.0)
    far = field < -reach[0] or field > 2.0 + reach[0] or abs(slip) > 20.0 + reach[1]
    at = [np.array([field])], [np.array([slip])]
    added = model.steady(*at) - model.law.steady(*at)
    assert abs(added[0]) <= model.correction.limit * (1.0 + 1e-9)
    if far:
        assert np.array_equal(model.steady(*at), model.law.steady(*at))


def test_the_weight_is_one_at_all_training_rows_and_zero_in_a_gap() -> None:
    rng = np.random.default_rng(2)
    x = rng.uniform(-1.0, 1.0, (2, 5000))
    x = x[:, ~((np.abs(x[0]) < 0.4) & (x[1] > 0.0))]  # a notch
    cells = cells_of(x)
    assert np.allclose(cells.weight(list(x)), 1.0)
    assert cells.weight([np.array([0.0]), np.array([0.6])])[0] == 0.0
    line = np.linspace(0.0, 3.0, 4001)
    weight = cells.weight([line, 0.5 + 0.0 * line])
    assert np.max(np.abs(np.diff(weight))) < 0.02  # smooth
    assert weight[-1] == 0.0


def test_a_constant_input_and_a_single_row_have_a_box() -> None:
    assert np.all(cells_of(np.ones((3, 1))).weight([np.ones(1)] * 3) == 1.0)
    close = np.array([[0.0, 1.0, np.nextafter(1.0, 2.0)]])  # no number lies between the last two
    assert np.all(cells_of(close).weight(list(close)) == 1.0)
    cells = cells_of(np.array([[2.0, 2.0, 2.0], [0.0, 1.0, 5.0]]))
    assert np.all(cells.reach > 0)


@pytest.mark.parametrize("kind", ["model", pytest.param("with_memory", marks=pytest.mark.slow)])
def test_a_file_gives_the_same_bits(kind: str, data: Dataset, tmp_path: Path, request: Any) -> None:
    model: ResidualModel = request.getfixturevalue(kind)
    (tmp_path / "m.json").write_text(json.dumps(model.to_dict()))
    again = load_model(tmp_path / "m.json")
    assert again.to_dict() == model.to_dict()
    assert np.array_equal(again.predict(data), model.predict(data))


def _limit_of_zero(body: dict[str, Any]) -> None:
    body["limit"] = 0.0


def _one_corner_less(body: dict[str, Any]) -> None:
    body["covered"]["low"] = body["covered"]["low"][:-1]


def _corners_swapped(body: dict[str, Any]) -> None:
    body["covered"]["low"], body["covered"]["high"] = (
        body["covered"]["high"],
        body["covered"]["low"],
    )


def _no_network(body: dict[str, Any]) -> None:
    del body["network"]


@pytest.mark.slow
@pytest.mark.parametrize("spoil", [_limit_of_zero, _one_corner_less, _corners_swapped, _no_network])
def test_a_spoilt_file_is_refused(spoil: Any, model: ResidualModel, tmp_path: Path) -> None:
    body = json.loads(json.dumps(model.to_dict()))
    spoil(body)
    (tmp_path / "m.json").write_text(json.dumps(body))
    with pytest.raises(RunError, match="do not match their digest"):
        load_model(tmp_path / "m.json")
    body["digest"] = digest_of({k: v for k, v in body.items() if k != "digest"})
    (tmp_path / "m.json").write_text(json.dumps(body))
    with pytest.raises(RunError, match="unfit entry"):
        load_model(tmp_path / "m.json")


@pytest.mark.usefixtures("compiled_plainly")
@pytest.mark.parametrize("kind", ["model", "with_memory"])
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_the_c_has_predicts_bits_and_off_those_of_the_law(
    kind: str, precision: Any, data: Dataset, request: Any
) -> None:
    model: ResidualModel = request.getfixturevalue(kind)
    options = ExportOptions(name="m", precision=precision, limits=(-1e3, 1e3))
    rows = np.column_stack([data.elements[0].field, data.elements[0].slip])[:2000]
    step = step_of(model, options)
    expected, _ = run(step, rows)
    if precision == "float64":
        assert np.array_equal(expected, model.predict(data)[:2000])
    else:
        assert np.max(np.abs(expected - model.predict(data)[:2000])) < 1e-3
    made = compile_model(step)
    assert np.array_equal(made.run(rows)[0], expected)
    law = np.array(compile_model(step_of(model.law, options)).run(rows)[0])
    assert not np.array_equal(law, expected)
    made.reset()
    made.use_residual(False)
    assert np.array_equal(made.run(rows)[0], law)
    made.use_residual(True)
    made.reset()
    assert np.array_equal(made.run(rows)[0], expected)


@pytest.mark.parametrize("kind", ["model", "with_memory"])
@pytest.mark.parametrize("on", [True, False])
def test_the_inverse_of_the_next_step_feels_the_switch(kind: str, on: bool, request: Any) -> None:
    made = compile_model(
        step_of(request.getfixturevalue(kind), ExportOptions(name="m", limits=(-1e3, 1e3)))
    )
    made.reset()
    made.use_residual(on)
    made.step(0.9, 7.5)
    wanted = made.step(0.9, 7.6) + 0.05
    field = made.inverse_now((0.0, 7.7), wanted)
    assert made.step(field, 7.7) == pytest.approx(wanted, abs=1e-9)


def test_the_state_has_the_switch_only_where_there_is_a_network_on_a_law(
    model: ResidualModel,
) -> None:
    assert SWITCHED_OFF in step_record(step_of(model)).record.after
    assert SWITCHED_OFF not in step_record(step_of(model.law)).record.after


def test_a_comparison_names_fits_and_says_what_the_network_adds() -> None:
    found = compare(
        device(30_000), Settings(models=("bingham", "bingham+fnn-4"), lag="none", test=0.3)
    )
    assert {e.name for e in found.entries} == {"bingham", "bingham+fnn-4"}
    entry = found.entry("bingham+fnn-4")
    assert entry.test.rmse.value < found.entry("bingham").test.rmse.value
    assert any("of the law alone" in note and "less" in note for note in entry.notes)
    assert found.recommended == "bingham+fnn-4"


def remembering(data: Dataset, travel: float = 3.0) -> Dataset:
    """The same device with a Dahl memory of the slip."""
    slip, field = data.elements[0].slip, data.elements[0].field
    memory = np.zeros(data.rows)
    for k in range(1, data.rows):
        step = PERIOD * slip[k]
        memory[k] = step / travel + memory[k - 1] * np.exp(-abs(step) / travel)
    return replace(data, effort=data.effort + (1.0 + 4.0 * field) * memory)


def test_the_default_tries_a_network_on_what_the_law_with_memory_misses() -> None:
    found = compare(remembering(device(30_000)), Settings(models=("bingham", "fnn-4")))
    best = found.entries[0]
    assert best.name == found.recommended
    assert best.name.startswith("bingham+fnn-4+")
    law = found.entry(best.name.replace("+fnn-4", ""))
    assert best.test.rmse.value < 0.7 * law.test.rmse.value
    both = best.outcome.model
    assert isinstance(both, ResidualModel)
    assert both.law.to_dict() == replace(law.outcome.model, band=None).to_dict()


def test_a_short_log_gets_no_network_with_more_weights_than_rows(data: Dataset) -> None:
    short = remembering(data).take(np.arange(data.rows) < 300)
    found = compare(short, Settings(models=("bingham", "fnn-50")))
    assert any(
        needs_time(stage)
        for e in found.entries
        for stage in stages_of(e.outcome.model.structure.dynamics)
    )
    networks = {entry.name: entry.outcome for entry in found.entries if entry.outcome.weights}
    assert "fnn-50" in networks
    assert all(outcome.weights < found.data.take(~found.test).rows for outcome in networks.values())


def test_a_block_that_holds_the_only_other_field_counts_as_not_helped() -> None:
    steps = device(field=np.where(np.arange(6000) < 1200, 0.5, 1.0))
    network = fit_residual(steps, structure()).model.correction.network
    assert 0.0 < float(network.about["share"]) <= 1.0


def test_names() -> None:
    assert parts_of("casson/power+fnn-10-6") == ("casson/power", "fnn-10-6")
    assert parts_of("bingham+fnn-16+lag+dahl") == ("bingham", "fnn-16")
    assert parts_of("bingham+lag+dahl") is None
    assert parts_of("bingham") is None
    assert parts_of("fnn-16") is None
    assert structure("lag").specification == "bingham+fnn-4"


@pytest.mark.parametrize(
    "name",
    ["bingam+fnn-16", "bingham+fnn-0", "fnn-4+fnn-4", "bingham+fnn-4+lags", "bingham+lag+fnn-4"],
)
def test_a_wrong_name_is_refused(name: str, data: Dataset) -> None:
    with pytest.raises(SettingError):
        compare(data, Settings(models=(name,)))


def test_a_name_may_hold_stages_of_its_own(data: Dataset) -> None:
    def asked(*models: str, lag: str = "none") -> list[tuple[str, str]]:
        return [
            (s.specification, s.dynamics)
            for s in residuals_for(data, Settings(models=models, lag=lag))
        ]

    both = "bingham+fnn-4"
    assert asked("bingham+fnn-4+lag+dahl", "bingham+lag", "fnn-4") == [(both, "lag+dahl")]
    assert asked("bingham+fnn-4", "bingham+fnn-4+dahl", lag="auto") == [
        (both, "none"),
        (both, "lag"),
        (both, "dahl"),
    ]
    assert not structures_for(data, Settings(models=("bingham+fnn-4+lag",)))


@pytest.mark.slow
def test_a_law_without_residual_needs_no_network(data: Dataset) -> None:
    still = replace(data, effort=0.0 * data.effort)
    with pytest.raises(CheckError):
        fit_residual(still, structure())


def test_cells_are_only_values() -> None:
    box = CoveredCells(np.zeros((1, 1)), np.ones((1, 1)), np.full(1, 0.5))
    assert box.weight([0.5]) == 1.0
    assert box.weight([1.25]) == pytest.approx(0.5)
    assert box.weight([float("nan")]) == 0.0


def test_the_equation_says_each_stage_once(with_memory: ResidualModel) -> None:
    said = with_memory.equation()
    for name in DYNAMICS.split("+"):
        assert sum(line.startswith(f"{name}: ") for line in said) == 1
