"""Networks: exact slopes, known truth, the same weights whatever the workers, files, further inputs, bad input."""

from __future__ import annotations

import itertools
import json
import pickle
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import CheckError, ErclutchError, MappingError, RunError, SettingError
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.networks.backprop import WeightedRows, tables_of, weights_of
from erclutch.fit.networks.first_weights import first_weights, with_best_output
from erclutch.fit.networks.fit_fnn import schedule_for, train
from erclutch.fit.networks.fit_network import (
    fit_network,
    mean_squares,
    scaling_of,
    slips_for,
    slips_of,
)
from erclutch.fit.networks.fit_rbfn import by_forward_selection, by_k_means, refined, weights_for
from erclutch.fit.networks.geodesic import levenberg_marquardt
from erclutch.fit.solver.centroids import compress
from erclutch.logs.dataset import Dataset
from erclutch.models.load import load_model
from erclutch.models.networks import is_network, network_from_name
from erclutch.models.networks.forward import forward_fnn, forward_rbfn
from erclutch.models.networks.network_file import network_from_dict
from erclutch.models.networks.network_inputs import inputs_of
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import DeviceName, Element, Units
from erclutch.signals.recording import TEMPERATURE
from tests.support.examples import examples
from tests.support.exported_models import network_model
from tests.support.pair import pair_rows
from tests.support.slow_params import slow_behind


@pytest.fixture(scope="module")
def data() -> Dataset:
    return pair_rows(12.0, seed=4)


def single(rows: int = 2000, seed: int = 0) -> Dataset:
    rng = np.random.default_rng(seed)
    field, slip = rng.uniform(0.0, 1.0, rows), rng.normal(0.0, 10.0, rows)
    effort = field**2 * np.tanh(slip) + 0.01 * slip
    clock = Clock(np.linspace(0.0, (rows - 1) * 1e-3, rows), (Span(0, rows, 1e-3),))
    return Dataset("single", (Element(field, slip),), effort, clock, Units("N*m", "1", "rad/s"))


# --- slopes and solver ------------------------------------------------------------------------------------------------


@pytest.mark.slow
@settings(max_examples=examples(20), deadline=None)
@given(
    hidden=st.lists(st.integers(1, 6), min_size=1, max_size=3),
    inputs=st.integers(1, 4),
    seed=st.integers(0, 999),
    kept=st.booleans(),
    one_block=st.booleans(),
)
def test_the_gram_matrix_is_that_of_the_slopes(
    hidden: list[int], inputs: int, seed: int, kept: bool, one_block: bool
) -> None:
    rng = np.random.default_rng(seed)
    sizes = (inputs, *hidden, 1)
    x, y, weight = rng.uniform(-1, 1, (inputs, 40)), rng.normal(size=40), rng.uniform(1, 9, 40)
    theta = first_weights(rng, sizes) + 0.1 * rng.normal(size=weights_of(sizes))

    def residual(t: Any) -> Any:
        return np.sqrt(weight / weight.mean()) * (y - forward_fnn(tables_of(t, sizes), x))

    step = 1e-6
    slopes = np.column_stack(
        [
            (residual(theta - step * e) - residual(theta + step * e)) / (2 * step)
            for e in np.eye(theta.size)
        ]
    )
    whole = np.column_stack([slopes, residual(theta)])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("erclutch.fit.networks.backprop._KEPT", 10**6 if kept else 0)
        patch.setattr("erclutch.fit.networks.backprop._WHOLE", 10**6 if one_block else 0)
        patch.setattr("erclutch.fit.networks.backprop._BLOCK", 16)
        rows = WeightedRows(x, y, weight, sizes, single=False)
    point = rows.at(theta)
    assert bool(point.active) is kept
    np.testing.assert_allclose(rows.gram(point), whole.T @ whole, rtol=1e-5, atol=1e-6)
    assert point.cost == pytest.approx(float(whole[:, -1] @ whole[:, -1]), rel=1e-12)
    along = rng.normal(size=theta.size)
    bent = (
        -(residual(theta + 1e-4 * along) - 2 * residual(theta) + residual(theta - 1e-4 * along))
        / 1e-8
    )
    np.testing.assert_allclose(rows.bend(point, along), slopes.T @ bent, rtol=1e-4, atol=1e-4)
    assert np.array_equal(
        np.concatenate([table.ravel() for table in tables_of(theta, sizes).values()]), theta
    )


@pytest.mark.slow
@settings(max_examples=examples(20), deadline=None)
@given(hidden=st.lists(st.integers(1, 8), min_size=1, max_size=2), seed=st.integers(0, 999))
def test_the_best_output_layer_leaves_no_slope(hidden: list[int], seed: int) -> None:
    rng = np.random.default_rng(seed)
    sizes = (2, *hidden, 1)
    rows = WeightedRows(
        rng.uniform(-1, 1, (2, 60)), rng.normal(size=60), rng.uniform(1, 9, 60), sizes, single=False
    )
    first = first_weights(rng, sizes)
    best = with_best_output(rows, first)
    output = hidden[-1] + 1
    assert np.array_equal(best[:-output], first[:-output])
    slope = rows.gram(rows.at(best))[-1 - output : -1, -1]
    assert np.abs(slope).max() < 0.02 * 60  # its small ridge leaves some
    assert rows.at(best).cost <= rows.at(first).cost


@pytest.mark.parametrize("name", ["fnn-16", "fnn-9-4"])
@pytest.mark.parametrize("device", ["single", "coaxial"])
def test_transitions_start_where_a_slip_is_zero(name: str, device: DeviceName) -> None:
    structure = network_from_name(name, device, extras=("x1",))
    rng = np.random.default_rng(4)
    x = rng.normal(
        3.0, [[1.0], [20.0], [30.0], [1.0]][: len(structure.inputs)], (len(structure.inputs), 500)
    )
    scaling = scaling_of(x, rng.normal(size=500), "fnn")
    slips = slips_for(structure, scaling, mean_squares(structure, x))
    seen = slips.slope @ scaling.inputs(x) + slips.offset[:, None]
    for k, slip in enumerate(slips_of(structure, x).values()):
        np.testing.assert_allclose(seen[k], slip / np.sqrt(np.mean(slip**2)), rtol=1e-9, atol=1e-12)
    n = structure.hidden[0]
    theta = first_weights(rng, (len(structure.inputs), *structure.hidden, 1), slips)
    w, b = theta[: n * len(structure.inputs)].reshape(n, -1), theta[n * len(structure.inputs) :][:n]
    # Where every slip is zero and the further input is at its middle.
    at_rest = np.linalg.lstsq(slips.slope[:, 1:], -slips.offset, rcond=None)[0]
    transitions = np.abs(w[:, 1:] @ at_rest + b) < 1e-9
    own = 3 if device == "coaxial" else 2
    assert transitions.sum() == len(slips.offset) * round(
        0.55 * own / (own + 1) * n / len(slips.offset)
    )
    assert np.abs(w[:, own:]).min() > 0.0  # a further input shifts each of them


@pytest.mark.slow
def test_a_known_network_is_found_again() -> None:
    rng = np.random.default_rng(1)
    sizes = (2, 3, 1)
    truth = first_weights(rng, sizes) + rng.normal(size=weights_of(sizes))
    x = rng.uniform(-1, 1, (2, 4000))
    y = forward_fnn(tables_of(truth, sizes), x)
    found = train((x, y / np.abs(y).max(), x), (3,), 0, schedule_for((3,), 2, polish=True))
    error = forward_fnn(tables_of(found.theta, sizes), x) * np.abs(y).max() - y
    assert np.sqrt(np.mean(error**2)) < 1e-4 * y.std()


@pytest.mark.slow
def test_polish_never_makes_it_worse(data: Dataset) -> None:
    rough, fine = (
        fit_network(data, network_from_name("fnn-6"), polish=p).train_cost for p in (False, True)
    )
    assert fine <= rough * (1 + 1e-9)


@pytest.mark.slow
def test_the_number_of_workers_changes_no_weight(data: Dataset) -> None:
    one, three = (
        fit_network(data, network_from_name("fnn-5-3"), seed=2, workers=w).model.to_dict()
        for w in (1, 3)
    )
    assert one == three
    assert fit_network(data, network_from_name("fnn-5-3"), seed=3).model.to_dict() != one


def test_a_start_that_cannot_be_improved_says_so() -> None:
    sizes = (1, 1, 1)
    rows = WeightedRows(np.array([[0.0, 0.5, 1.0]]), np.zeros(3), None, sizes, single=False)
    assert levenberg_marquardt(rows, np.zeros(4), 10).stop in ("stalled", "converged")


# --- compression ------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@settings(max_examples=examples(30), deadline=None)
@given(
    inputs=st.integers(1, 6),
    rows=st.integers(2, 300),
    level=st.integers(0, 2),
    seed=st.integers(0, 999),
)
def test_centroids_keep_rows_means_and_cost(inputs: int, rows: int, level: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(inputs, rows)), rng.normal(size=rows)
    c = compress(x, y, level)
    assert c.count.sum() == rows
    np.testing.assert_allclose(c.x @ c.count, x.sum(axis=1), atol=1e-9)
    np.testing.assert_allclose(c.y @ c.count, y.sum(), atol=1e-9)
    np.testing.assert_allclose(c.count @ c.y**2 + c.scatter, y @ y, rtol=1e-9)


def test_a_constant_input_is_one_cell_wide() -> None:
    c = compress(np.vstack([np.ones(50), np.arange(50.0)]), np.arange(50.0), 0)
    assert np.all(c.x[0] == 1.0)


# --- radial basis functions -------------------------------------------------------------------------------------------


def bumps() -> tuple[Any, Any, Any]:
    rng = np.random.default_rng(5)
    centres = rng.uniform(0.1, 0.9, (4, 2))
    x = rng.uniform(0, 1, (2, 3000))
    tables = {
        "centres": centres,
        "spreads": np.full(4, 0.25),
        "w": np.array([1.0, -2.0, 1.5, 0.7]),
        "b": np.ones(1),
    }
    return x, forward_rbfn(tables, x), centres


@pytest.mark.slow
def test_refined_centres_reach_a_known_network() -> None:
    x, y, _ = bumps()
    cells = compress(x, y, 2)
    start = by_forward_selection(cells, 4, 0)
    for one_spread in (True, False):
        found = refined(cells, start, one_spread=one_spread)
        before = weights_for(cells.x, cells.y, cells.count, start.centres, start.spreads)[1]
        after = weights_for(cells.x, cells.y, cells.count, found.centres, found.spreads)[1]
        assert after < 0.02 * before
    assert by_k_means(cells, 4, 0).centres.shape == (4, 2)


@pytest.mark.slow
def test_more_neurons_fit_better() -> None:
    x, y, _ = bumps()
    cells = compress(x, y, 1)
    costs = []
    for n in (1, 4, 12):
        found = by_forward_selection(cells, n, 0)
        costs.append(weights_for(cells.x, cells.y, cells.count, found.centres, found.spreads)[1])
    assert costs == sorted(costs, reverse=True)


# --- models -----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", slow_behind(4, ["fnn-4", "rbfn-6", "rbfn-6/kmeans", "rbfn-4/spreads", "fnn-3-2"])
)
def test_a_network_survives_its_file(data: Dataset, tmp_path: Path, name: str) -> None:
    model = fit_network(data, network_from_name(name)).model
    path = tmp_path / "model.json"
    path.write_text(json.dumps(model.to_dict()))
    back = load_model(path)
    assert back.to_dict() == model.to_dict()
    np.testing.assert_array_equal(back.predict(data), model.predict(data))
    assert not model.outside(data).any()
    assert pickle.loads(pickle.dumps(model)).name == model.name


@pytest.mark.slow
def test_equations_18_and_20_choose_the_inputs(data: Dataset) -> None:
    first, second = data.elements
    for name, expected in (
        ("rbfn-3", [first.field - second.field, first.slip, second.slip]),
        (
            "fnn-3",
            [
                first.field - second.field,
                (first.slip - second.slip) / 2,
                -(first.slip + second.slip) / 2,
            ],
        ),
    ):
        x = inputs_of(network_from_name(name), data.elements, data.clock, {}, {})
        np.testing.assert_allclose(x, expected)


def test_past_samples_stay_inside_their_stretch() -> None:
    log = single(6)
    cut = replace(log, clock=Clock(log.clock.time, (Span(0, 3, 1e-3), Span(3, 6, 1e-3))))
    structure = network_from_name("fnn-2", "single", past=(1, 2))
    x = inputs_of(structure, cut.elements, cut.clock, {}, {})
    slip = cut.elements[0].slip
    np.testing.assert_array_equal(x[3], slip[[0, 0, 1, 3, 3, 4]])
    np.testing.assert_array_equal(x[5], slip[[0, 0, 0, 3, 3, 3]])
    assert structure.inputs == ("field", "slip", "field[-1]", "slip[-1]", "field[-2]", "slip[-2]")


@pytest.mark.slow
def test_a_further_input_helps_and_must_be_there() -> None:
    log = single()
    hidden = np.sin(np.arange(log.rows) / 7.0)
    with_input = replace(log, effort=log.effort + 0.5 * hidden, extras={"A": hidden})
    blind = fit_network(with_input, network_from_name("fnn-6", "single"))
    seeing = fit_network(with_input, network_from_name("fnn-6", "single", extras=("A",)))
    assert seeing.train_cost < 0.05 * blind.train_cost
    with pytest.raises(MappingError, match="'A' is not in these rows"):
        seeing.model.predict(log)


@pytest.mark.slow
def test_the_equation_has_one_sign_for_a_negative_offset() -> None:
    log = single()
    for offset in (-1000.0, 1000.0):
        moved = replace(log, effort=log.effort + offset)
        first = fit_network(moved, network_from_name("fnn-2", "single")).model.equation()[0]
        assert re.search(r"effort = y [\d.]+ [-+] \d[\d.]+\.$", first), first
        assert ("+ " in first) == (offset > 0)


@pytest.mark.slow
def test_networks_stand_in_the_ranking(data: Dataset) -> None:
    found = compare(
        data, Settings(models=("bingham/forward", "fnn-4", "rbfn-5"), lag="auto", blocks=2)
    )
    names = {e.name for e in found.entries}
    assert {"fnn-4", "fnn-4+lag", "rbfn-5", "rbfn-5+lag", "bingham/forward"} <= names
    entry = found.entry("fnn-4+lag")
    assert entry.outcome.weights == entry.outcome.parameters == 4 * 4 + 5
    assert len(entry.folds) == 2
    assert all(np.isfinite(e.test.rmse.value) for e in found.entries)


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        "fnn-0",
        "fnn-100000",
        "fnn",
        "fnn-",
        "fnn-4-0",
        "fnn-1-1-1-1-1-1",
        "rbfn-3-3",
        "rbfn-3/magic",
        "fnn-3/kmeans",
        "fnn-x",
    ],
)
def test_networks_that_cannot_be(name: str) -> None:
    assert is_network(name)
    with pytest.raises(SettingError):
        network_from_name(name)


def test_fewer_rows_than_weights() -> None:
    with pytest.raises(CheckError, match="60 training rows for the 65 weights of fnn-16"):
        fit_network(single(60), network_from_name("fnn-16", "single"))


def test_a_constant_input() -> None:
    log = single()
    flat = replace(log, elements=(Element(np.full(log.rows, 0.3), log.elements[0].slip),))
    with pytest.raises(CheckError, match=r"input field is constant at 0.3"):
        fit_network(flat, network_from_name("fnn-4", "single"))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_rows_that_are_not_finite(bad: float) -> None:
    log = single()
    slip = log.elements[0].slip.copy()
    slip[3] = bad
    with pytest.raises(CheckError, match="input slip has 1 values that are not finite"):
        fit_network(
            replace(log, elements=(Element(log.elements[0].field, slip),)),
            network_from_name("fnn-4", "single"),
        )


@pytest.fixture(scope="module")
def body(data: Dataset) -> dict[str, Any]:
    """What the file of a network holds."""
    return fit_network(data, network_from_name("fnn-2")).model.to_dict()


@pytest.mark.parametrize("fall", [-4.0, 0.0, 14.0])
def test_a_yield_effort_that_rises_with_the_temperature_is_read_again(fall: float) -> None:
    """The range of b_y has both signs; a run with a negative one was written and could not be read."""
    model = network_model("fnn-3", "single", "softening", extras=(TEMPERATURE,))
    rising = replace(model, dynamics={**model.dynamics, "b_y": fall})
    assert network_from_dict(rising.to_dict()).dynamics["b_y"] == fall
    beyond = replace(model, dynamics={**model.dynamics, "b_y": -15.1})
    with pytest.raises(RunError, match=r"b_y is -15\.1, not from -15 to 15"):
        network_from_dict(beyond.to_dict())


@pytest.mark.slow
@pytest.mark.parametrize("change", ["digest", "weights", "inputs", "scaling", "schema", "network"])
def test_a_network_file_that_was_changed(body: dict[str, Any], change: str) -> None:
    from erclutch.models.model_file import digest_of

    wrong: dict[str, Any] = {
        "digest": "0",
        "weights": {**body["weights"], "b1": [0.0]},
        "inputs": ["E1-E2"],
        "scaling": {"offset": [0.0]},
        "schema": 99,
        "network": "fnn-3",
    }
    changed = {**body, change: wrong[change]}
    if change != "digest":
        changed["digest"] = digest_of({k: v for k, v in changed.items() if k != "digest"})
    with pytest.raises(RunError):
        network_from_dict(changed)


@pytest.mark.slow
def test_a_network_of_another_device(data: Dataset) -> None:
    model = fit_network(data, network_from_name("fnn-2")).model
    with pytest.raises(ErclutchError, match="for a model of coaxial"):
        model.predict(single())


@pytest.mark.slow
def test_every_pair_of_seeds_and_sizes_is_reproducible() -> None:
    log = single(500)
    for seed, size in itertools.product((0, 1), (1, 4)):
        structure = network_from_name(f"fnn-{size}", "single")
        first, again = (fit_network(log, structure, seed=seed).train_cost for _ in range(2))
        assert first == again


@pytest.mark.parametrize("name", ["fnn-²", "rbfn-③", f"fnn-{'9' * 5000}"])
def test_digits_that_are_no_number_of_neurons_are_refused(name: str) -> None:
    with pytest.raises(SettingError, match="unknown network"):
        network_from_name(name)
