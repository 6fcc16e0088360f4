"""Time of one prediction of one sample: raw fields and slips (or inputs) in, effort out, same weights everywhere."""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from rows import HIDDEN, NETWORK, Split
from task import Task

from erclutch.fit.networks.backprop import tables_of
from erclutch.fit.networks.first_weights import first_weights
from erclutch.fit.training_range import range_of
from erclutch.models.networks import network_from_name
from erclutch.models.networks.network_model import NetworkModel
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element

Array = NDArray[np.float64]
Call = Callable[[], float]

_CALLS, _ROUNDS = 500, 15


def model_of(task: Task) -> NetworkModel:
    """A network with random weights: the time does not depend on them."""
    weights = tables_of(
        first_weights(np.random.default_rng(task.seed), (3, HIDDEN, 1)), (3, HIDDEN, 1)
    )
    data = task.train.data
    span = np.zeros((3, 2))
    return NetworkModel(
        network_from_name(NETWORK), task.scaling, weights, {}, data.units, range_of(data), span
    )


def erclutch(task: Task, model: NetworkModel) -> Call:
    """NetworkModel.effort from fields and slips."""
    elements = [Element(e.field[:1], e.slip[:1]) for e in task.train.data.elements]
    clock = Clock(np.zeros(1), (Span(0, 1, 0.001),))
    return lambda: float(model.effort(elements, clock)[0])


def _raw(split: Split, model: NetworkModel) -> Array:
    return split.x[0] * model.scaling.scale + model.scaling.offset


def scikit_learn(task: Task, model: NetworkModel) -> Call:
    """MLPRegressor.predict, normalisation by NumPy."""
    from sklearn.neural_network import MLPRegressor

    s, w, raw = model.scaling, model.weights, _raw(task.train, model)
    net = MLPRegressor(hidden_layer_sizes=(HIDDEN,), activation="tanh", random_state=0)
    net.partial_fit(task.train.x[:9], task.train.y[:9])
    net.coefs_, net.intercepts_ = [w["W1"].T, w["W_out"].T], [w["b1"], w["b_out"]]
    return lambda: float(
        net.predict(((raw - s.offset) / s.scale)[None])[0] * s.effort_scale + s.effort_offset
    )


def torch(task: Task, model: NetworkModel) -> Call:
    """A torch module in float64 under inference_mode, normalisation by NumPy."""
    import torch as t

    t.set_num_threads(task.threads)
    s, w, raw = model.scaling, model.weights, _raw(task.train, model)
    net = t.nn.Sequential(t.nn.Linear(3, HIDDEN), t.nn.Tanh(), t.nn.Linear(HIDDEN, 1)).double()
    tables = zip(net.parameters(), (w["W1"], w["b1"], w["W_out"], w["b_out"]), strict=True)
    with t.no_grad():
        for parameter, table in tables:
            parameter.copy_(t.from_numpy(np.array(table)))

    def call() -> float:
        with t.inference_mode():
            return (
                net(t.from_numpy((raw - s.offset) / s.scale)).item() * s.effort_scale
                + s.effort_offset
            )

    return call


MAKERS: dict[str, Callable[[Task, NetworkModel], Call]] = {
    "erclutch": erclutch,
    "scikit-learn": scikit_learn,
    "torch": torch,
}


def microseconds(task: Task, name: str) -> float:
    """Median over rounds of the time of a call; checks that the effort is the model's."""
    model = model_of(task)
    call = MAKERS[name](task, model)
    expected = float(model.forward(task.train.x[:1].T)[0])
    if abs(call() - expected) > 1e-9 * abs(expected):
        raise ArithmeticError(f"{name} gives {call()}, the model {expected}")
    rounds: list[float] = []
    for _ in range(_ROUNDS):
        began = perf_counter()
        for _ in range(_CALLS):
            call()
        rounds.append((perf_counter() - began) / _CALLS)
    return 1e6 * median(rounds)
