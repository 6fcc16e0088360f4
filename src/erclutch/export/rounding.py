"""A first-order error analysis says, row by row, how far rounding can take a step from endless digits.

Every operation adds half a unit in the last place of its result to what its arguments bring; functions add what
docs/export.md states for them. A law of good condition comes out at a few units in the last place of its effort; one
whose terms cancel (kernels with gains of 1e7) does not. In float64 `TorqueModel.predict` and the C round alike, so they
agree to the bit even there; float32, and a runtime with functions of its own, stray as far as said here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from erclutch.arithmetic.elementary import table_entry
from erclutch.arithmetic.evaluation import evaluate
from erclutch.arithmetic.precision import FLOAT32, FLOAT64, Precision
from erclutch.arithmetic.record import Node
from erclutch.errors import ExportError
from erclutch.export.exported_step import ExportedStep
from erclutch.export.stage_memory import suffix_of
from erclutch.export.step_numbers import named, numbers, reference, run
from erclutch.export.step_record import step_record
from erclutch.export.step_recording import StepRecord
from erclutch.export.step_vectors import ordinary
from erclutch.models.networks.network_model import NetworkModel
from erclutch.models.stages.oscillator import Oscillator, coefficients
from erclutch.signals.array import Array

#: Largest error of each function in units of the last place, from tests/arithmetic/test_elementary.py
#: and studies/elementary.py.
ULPS: Mapping[str, Mapping[str, float]] = {
    "float32": {"exp": 1.0, "expm1": 1.5, "tanh": 6.6, "power": 1.2},
    "float64": {"exp": 1.0, "expm1": 2.0, "tanh": 2.6, "power": 1.2},
}


def bound(step: ExportedStep, rows: Array, precision: Precision | None = None) -> Array:
    """Largest rounding error of the effort at each row, shape (n,), in the effort's unit.

    Args:
        step: the step.
        rows: its inputs.
        precision: of the arithmetic; None is the step's.
    """
    made, p = step_record(step), precision or step.precision
    inputs = named(made, np.asarray(rows, np.float64))
    given: dict[Node, Array] = {}
    if step.filter is not None:  # its errors decay, but a bound that follows them operation by operation would grow
        slips = evaluate(made.record, inputs, numbers(step, FLOAT64), outputs=made.slips)
        own = _filter_error(step, p)
        given = {n: np.stack([w, own + 0.5 * p.epsilon * np.abs(w)]) for n, w in zip(made.slips, slips, strict=True)}
    exact = {name: np.stack([x, np.zeros_like(x)]) for name, x in inputs.items()}
    for node, q in _oscillating(step, made):
        value, signal = evaluate(made.record, inputs, numbers(step, FLOAT64), outputs=(node, node.arguments[2]))
        error = evaluate(made.record, exact, Errors(step.network, p), given, [node.arguments[2]])[0][1]
        given[node] = np.stack([value, _oscillator_error(q, step.period or 1.0, value, signal, error, p)])
    return evaluate(made.record, exact, Errors(step.network, p), given, [made.value])[0][1]


def _oscillating(step: ExportedStep, made: StepRecord) -> Iterator[tuple[Node, Mapping[str, float]]]:
    """The choice that gives the output of each oscillator: in the first row, its third argument, that is the signal."""
    for stage, q in step.stages:
        if isinstance(stage, Oscillator):
            for element in ("0", "1", "") if stage.place == "command" else ("",):
                name = f"x{suffix_of(stage, element)}"
                if name in made.record.after:
                    yield made.record.after[name].arguments[0], q


def _oscillator_error(
    q: Mapping[str, float], period: float, value: Array, signal: Array, error: Array, p: Precision
) -> Array:
    """Of the output, from that of the signal: a bound operation by operation would grow as no oscillation does."""
    tau, zeta = q.values()
    a11, a12, a21, a22 = map(float, coefficients(tau, zeta, period))
    passes, state = np.array([[a11, a12], [a21, a22]]), np.eye(2)
    into, of_signal, of_state = np.array([1.0 - a11, -a21]), 0.0, 0.0
    for _ in range(value.size):
        of_signal += abs(float(state[0] @ into))
        of_state += float(np.abs(state[0]).sum())
        state = state @ passes
    most = np.maximum.accumulate(np.maximum(np.abs(value), np.abs(signal)))
    # Two sums of three terms a row, each no larger than three times the largest value or its slope.
    return of_signal * np.maximum.accumulate(error) + of_state * 6.0 * p.epsilon * most


def _filter_error(step: ExportedStep, p: Precision) -> float:
    """Of a speed, from angles within half a turn (or, unturned, of size one)."""
    f = step.filter
    assert f is not None
    size = 1.0 if f.turn is None else f.turn
    return 4.0 * p.epsilon * size * max(f.h, 1e-3) / (step.period or 1.0) / max(f.g, 1e-3)


@dataclass(frozen=True)
class Errors:
    """Values with their largest errors, shape (2, n). A choice takes the arm of the value: the arms of a step meet.

    Attributes:
        network: what a network node stands for.
        precision: of the arithmetic that is bounded.
    """

    network: NetworkModel | None
    precision: Precision

    def zero(self, node: Node) -> Any:
        """A number of the state before the first row."""
        return np.zeros(1, np.bool_) if node.kind == "truth" else np.zeros((2, 1))

    def apply(self, node: Node, arguments: Sequence[Any]) -> Any:
        """The value of a node and its largest error."""
        if node.operation == "network":
            assert self.network is not None
            values, errors = (np.array(np.broadcast_arrays(*(a[k] for a in arguments))) for k in (0, 1))
            return np.stack(_network(self.network, values, errors, self.precision))
        if node.operation == "less":
            return arguments[0][0] < arguments[1][0]
        if node.operation == "finite":
            return np.isfinite(arguments[0][0])
        if node.operation == "table":
            return table_entry(node.value, *(place[0] for place in arguments))
        if node.operation in _ON_TRUTHS:
            return _ON_TRUTHS[node.operation](*arguments)
        return np.stack(np.broadcast_arrays(*_with_error(node, arguments, self.precision)))


_np: Any = np
_ON_TRUTHS: Mapping[str, Callable[..., Array]] = {
    "both": _np.logical_and,
    "either": _np.logical_or,
    "opposite": _np.logical_not,
    "choose": _np.where,
}


Uncertain = tuple[Any, Any]
"""A value and its largest error."""


#: Share of the largest effort that rounding may take before an export is refused.
NOISE = 0.01


@lru_cache(maxsize=16)
def measured(step: ExportedStep, count: int = 256) -> tuple[float, float]:
    """Largest difference from NumPy on random rows of the training range, and the largest bound there."""
    rows = ordinary(step, np.random.default_rng(0), count)
    rows[:, step.model_inputs :] = np.nan  # nothing is measured: the model's own effort
    at_speeds = replace(step, filter=None, limits=(-1e30, 1e30))
    difference = np.abs(run(at_speeds, rows)[0] - reference(at_speeds, rows)[0])
    limit = bound(at_speeds, rows) + bound(at_speeds, rows, FLOAT64)
    return float(difference.max()), float(limit.max())


def refuse_noise(step: ExportedStep) -> None:
    """Refuse a precision in which rounding drowns the model.

    Raises:
        ExportError: it does, by more than 1 % of the largest training effort.
    """
    difference, _ = measured(step)
    if difference > NOISE * step.scale:
        raise ExportError(
            f"in {step.precision.name} effort is off by {100 * difference / step.scale:.3g} % of the largest: "
            "terms that nearly cancel leave no digits",
            where=step.model.name,
            remedy="Use --precision float64, which gives the bits of erclutch's own predictions",
        )


def _with_error(node: Node, a: Sequence[Any], p: Precision) -> Uncertain:
    half, name = 0.5 * p.epsilon, node.operation
    if name == "constant":
        value = np.array([float(node.value or 0.0)])
        return value, (half * np.abs(value) if p is FLOAT32 else 0.0 * value)
    if name in ("negate", "absolute"):
        return (-a[0][0] if name == "negate" else np.abs(a[0][0])), a[0][1]
    if name in ("add", "subtract"):
        value = a[0][0] + a[1][0] if name == "add" else a[0][0] - a[1][0]
        return value, a[0][1] + a[1][1] + half * np.abs(value)
    if name == "multiply":
        value = a[0][0] * a[1][0]
        return value, np.abs(a[0][0]) * a[1][1] + np.abs(a[1][0]) * a[0][1] + half * np.abs(value)
    if name == "nearest":  # whatever is computed from the whole number and from what is left meets at its steps
        value = _np.round(a[0][0])
        return value, 0.0 * value
    if name == "divide":
        value = a[0][0] / a[1][0]
        return value, (a[0][1] + np.abs(value) * a[1][1]) / np.abs(a[1][0]) + half * np.abs(value)
    return _function(name, a, ULPS[p.name][name] * p.epsilon)


def _function(name: str, a: Sequence[Any], own: float) -> Uncertain:
    x, error = a[0]
    if name == "exp":
        value = np.exp(x)
        return value, value * error + own * value
    if name == "expm1":
        value = np.expm1(x)
        return value, (value + 1.0) * error + own * np.abs(value)
    if name == "tanh":
        value = np.tanh(x)
        return value, _spread(value, error) + own * np.abs(value)
    n = a[1][0]
    value = np.power(np.maximum(x, 1e-300), n)
    return value, value * (np.abs(n) * error / np.maximum(x, 1e-300) + np.abs(np.log(x)) * a[1][1]) + own * value


def _spread(value: Any, error: Any) -> Any:
    """What an error of its argument makes of tanh: its slope, which saturates."""
    return np.minimum((1.0 - value * value) * error + np.abs(value) * error * error, 2.0)


def _network(model: NetworkModel, x: Array, e: Array, p: Precision) -> tuple[Array, Array]:
    """The forward pass from inputs and their errors, shape (inputs, n)."""
    half, model = 0.5 * p.epsilon, model.folded
    to = model.scaling
    scale, offset = to.scale[:, None], to.offset[:, None]
    z = (x - offset) / scale
    e = (e + half * (np.abs(x - offset) + (np.abs(offset) if p is FLOAT32 else 0.0))) / np.abs(scale)
    e = e + (2.0 if p is FLOAT32 else 1.0) * half * np.abs(z)
    a, e, weights, start = _rbfn(model, z, e, p) if model.structure.kind == "rbfn" else _fnn(model, z, e, p)
    terms = np.abs(weights[:, None] * a)
    error = np.abs(weights) @ e + half * (len(weights) / 4.0 + 6.0) * (terms.sum(axis=0) + abs(start))
    return weights @ a + start, error


def _fnn(model: NetworkModel, a: Array, e: Array, p: Precision) -> tuple[Array, Array, Array, float]:
    half, own = 0.5 * p.epsilon, ULPS[p.name]["tanh"] * p.epsilon
    for layer in range(1, len(model.structure.hidden) + 1):
        w, b = model.weights[f"W{layer}"], model.weights[f"b{layer}"][:, None]
        size = np.abs(w) @ np.abs(a) + np.abs(b)
        e = np.abs(w) @ e + half * (len(a) + 2.0) * size
        a = np.tanh(w @ a + b)
        e = _spread(a, e) + own * np.abs(a)
    return a, e, model.weights["W_out"][0], float(model.weights["b_out"][0])


def _rbfn(model: NetworkModel, z: Array, e: Array, p: Precision) -> tuple[Array, Array, Array, float]:
    half, own = 0.5 * p.epsilon, ULPS[p.name]["exp"] * p.epsilon
    centres, spread = model.weights["centres"], (model.weights["spreads"] ** 2)[:, None]
    square = np.zeros((len(centres), z.shape[1]))
    error = np.zeros_like(square)
    for j in range(len(z)):
        c = centres[:, j : j + 1]
        distance = z[j] - c
        own_error = e[j] + half * (np.abs(distance) + (np.abs(c) if p is FLOAT32 else 0.0))
        square += distance**2
        error += 2.0 * np.abs(distance) * own_error + half * 3.0 * distance**2
    argument = 0.5 * square / spread
    a = np.exp(-argument)
    return (
        a,
        a * (0.5 * error / spread + 4.0 * half * argument) + own * a,
        model.weights["w"],
        float(model.weights["b"][0]),
    )
