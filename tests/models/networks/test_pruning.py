"""A network with neurons to spare loses them one by one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.fit.networks.backprop import WeightedRows, tables_of, unpacked, weights_of
from erclutch.fit.networks.fit_fnn import Round, Schedule, schedule_for, train
from erclutch.fit.networks.geodesic import levenberg_marquardt
from erclutch.fit.networks.pruning import smaller, without_least
from erclutch.models.networks.forward import forward_fnn
from tests.support.examples import examples


def _rows(
    sizes: tuple[int, ...], theta: np.ndarray, rng: np.random.Generator
) -> tuple[WeightedRows, np.ndarray]:
    x = rng.uniform(-1.0, 1.0, (sizes[0], 500))
    y = forward_fnn(tables_of(theta, sizes), x)
    return WeightedRows(x, y, None, sizes, single=False), x


@pytest.mark.slow
@settings(max_examples=examples(30), deadline=None)
@given(
    seed=st.integers(0, 999),
    layers=st.sampled_from([(3, 6, 1), (2, 4, 5, 1), (1, 2, 1)]),
    data=st.data(),
)
def test_the_neuron_that_does_nothing_goes_first(
    seed: int, layers: tuple[int, ...], data: st.DataObject
) -> None:
    rng = np.random.default_rng(seed)
    theta = rng.normal(size=weights_of(layers))
    idle = data.draw(st.integers(0, layers[-2] - 1))
    unpacked(theta, layers)[-1][0][0, idle] = 0.0  # a view
    rows, x = _rows(layers, theta, rng)
    left = without_least(rows, theta)
    assert left.size == weights_of(smaller(layers))
    after = forward_fnn(tables_of(left, smaller(layers)), x)
    assert np.allclose(after, rows.y, atol=1e-12)


def test_the_other_weights_make_up_for_a_neuron_that_has_a_twin() -> None:
    rng = np.random.default_rng(3)
    sizes = (2, 3, 1)
    w, b, out = rng.normal(size=(3, 2)), rng.normal(size=3), np.array([0.8, 1.5, 0.8])
    w[2], b[2] = w[0], b[0]
    theta = np.concatenate([w.ravel(), b, out, [0.1]])
    rows, x = _rows(sizes, theta, rng)
    left = without_least(rows, theta)
    lost = forward_fnn(tables_of(left, smaller(sizes)), x) - rows.y
    assert np.sqrt(np.mean(lost**2)) < 1e-3 * rows.y.std()
    output = unpacked(left, smaller(sizes))[-1][0][0]
    assert np.sort(np.abs(output)) == pytest.approx([1.5, 1.6], rel=5e-2)


@pytest.mark.slow
@pytest.mark.parametrize("hidden", [(1,), (4,), (3, 2)])
def test_what_is_left_has_the_size_asked_for_even_with_few_rows(hidden: tuple[int, ...]) -> None:
    rng = np.random.default_rng(0)
    x = rng.uniform(-1.0, 1.0, (2, 40))  # fewer rows than the weights of the starts
    found = train((x, np.tanh(3.0 * x[0]) * x[1], x), hidden, 0, schedule_for(hidden, 2))
    assert found.theta.size == weights_of((2, *hidden, 1))
    assert np.all(np.isfinite(found.theta))


def test_weights_that_decay_end_where_the_cost_pulls_as_much_as_their_squares() -> None:
    rng = np.random.default_rng(1)
    sizes = (2, 3, 1)
    x = rng.uniform(-1.0, 1.0, (2, 200))
    rows = WeightedRows(
        x, np.tanh(2.0 * x[0]) + 0.1 * rng.normal(size=200), None, sizes, single=False
    )
    start = rng.normal(size=weights_of(sizes))
    decay = 1e-3
    ended = levenberg_marquardt(rows, start, 300, decay=decay).theta
    pull = decay * rows.at(start).cost
    slope = rows.gram(rows.at(ended))[:-1, -1]
    assert slope == pytest.approx(pull * ended, abs=1e-2 * pull)
    free = levenberg_marquardt(rows, start, 300)
    assert float(ended @ ended) < float(free.theta @ free.theta)
    assert rows.at(ended).cost > free.cost


def test_only_networks_of_many_inputs_decay_and_one_start_judges() -> None:
    assert schedule_for((16,), 3).decay == 0.0
    assert schedule_for((16,), 4).decay > 0.0
    assert schedule_for((16,), 4, judges=True).starts == 1


@pytest.mark.slow
def test_spare_neurons_lead_lower() -> None:
    rng = np.random.default_rng(5)
    x = rng.uniform(-1.0, 1.0, (2, 3000))
    y = np.tanh(20.0 * x[1]) * x[0] ** 2 + 0.3 * np.sin(3.0 * x[0])
    last = Round(0, 60, 1)
    rows = (x, y, x)
    plain = [
        train(rows, (5,), seed, Schedule(1, (Round(0, 30, 1), last))).cost for seed in range(8)
    ]
    spare = [
        train(rows, (5,), seed, Schedule(1, (Round(0, 30, 1, 5), last), 5)).cost
        for seed in range(8)
    ]
    assert np.median(spare) < 0.9 * np.median(plain)
