"""A neuron goes, a better one comes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.fit.networks.backprop import WeightedRows, tables_of, unpacked, weights_of
from erclutch.fit.networks.exchange import exchanged
from erclutch.fit.networks.first_weights import first_weights, new_neurons, with_best_output
from erclutch.fit.networks.fit_fnn import Round, Schedule, train
from erclutch.fit.networks.geodesic import Trained, levenberg_marquardt
from erclutch.models.networks.forward import forward_fnn
from tests.support.examples import examples


def _target(rng: np.random.Generator, rows: int = 600) -> tuple[np.ndarray, np.ndarray]:
    x = rng.uniform(-1.0, 1.0, (2, rows))
    return x, np.tanh(20.0 * x[1]) * x[0] ** 2 + 0.3 * np.sin(3.0 * x[0])


@pytest.mark.slow
@settings(max_examples=examples(15), deadline=None)
@given(
    seed=st.integers(0, 999),
    hidden=st.sampled_from([(2,), (4,), (3, 2), (2, 3)]),
    tries=st.integers(1, 3),
)
def test_an_exchange_keeps_the_size_and_never_costs_more(
    seed: int, hidden: tuple[int, ...], tries: int
) -> None:
    rng = np.random.default_rng(seed)
    x, y = _target(rng, 200)
    sizes = (2, *hidden, 1)

    def rows_of(layers: Sequence[int]) -> WeightedRows:
        return WeightedRows(x, y, None, layers, single=False)

    rows = rows_of(sizes)
    found = levenberg_marquardt(rows, with_best_output(rows, first_weights(rng, sizes)), 5)
    after = exchanged(rows_of, sizes, found, rng, None, tries, 2)
    assert after.theta.size == weights_of(sizes)
    assert after.cost <= found.cost
    assert rows.at(after.theta).cost == pytest.approx(after.cost, rel=1e-9)


@pytest.mark.slow
def test_a_neuron_that_is_missing_comes_and_an_idle_one_goes() -> None:
    rng = np.random.default_rng(2)
    sizes = (2, 3, 1)
    truth = np.concatenate(
        [rng.normal(size=(3, 2)).ravel() * 3.0, rng.normal(size=3), [0.8, -0.6, 0.7], [0.1]]
    )
    x = rng.uniform(-1.0, 1.0, (2, 500))
    y = forward_fnn(tables_of(truth, sizes), x)
    idle = truth.copy()
    unpacked(idle, sizes)[0][0][1] = 0.0  # a view: the second neuron is a constant

    def rows_of(layers: Sequence[int]) -> WeightedRows:
        return WeightedRows(x, y, None, layers, single=False)

    rows = rows_of(sizes)
    start = Trained(
        with_best_output(rows, idle), rows.at(with_best_output(rows, idle)).cost, 0, "iterations"
    )
    after = exchanged(rows_of, sizes, start, rng, None, 1, 6)
    assert start.cost > 1e-2 * float(y @ y)
    assert after.cost < 1e-3 * start.cost


def test_a_network_of_one_neuron_stays_as_it_is() -> None:
    rng = np.random.default_rng(0)
    found = Trained(rng.normal(size=5), 1.0, 7, "converged")

    def rows_of(layers: Sequence[int]) -> WeightedRows:
        raise AssertionError(layers)

    after = exchanged(rows_of, (2, 1, 1), found, rng, None, 2, 2)
    assert np.array_equal(after.theta, found.theta)
    assert after.steps == 0


@pytest.mark.slow
def test_exchanges_lead_lower_than_more_steps() -> None:
    x, y = _target(np.random.default_rng(5), 3000)
    plain = [
        train((x, y, x), (5,), seed, Schedule(1, (Round(0, 200, 1),))).cost for seed in range(8)
    ]
    last = Round(0, 0, 1, tries=4, exchanges=8)
    traded = [
        train((x, y, x), (5,), seed, Schedule(1, (Round(0, 30, 1), last))).cost for seed in range(8)
    ]
    assert np.median(traded) < 0.8 * np.median(plain)


def test_new_neurons_are_of_the_last_hidden_layer() -> None:
    w, b = new_neurons(np.random.default_rng(0), (3, 5, 4, 1), 7, None)
    assert w.shape == (7, 5)
    assert b.shape == (7,)
    w, _ = new_neurons(np.random.default_rng(0), (3, 5, 1), 7, None)
    assert w.shape == (7, 3)
