"""A first-order error analysis says, row by row, how far rounding can take a step from endless digits.

Every operation adds half a unit in the last place of its result to what its arguments bring; functions add what
docs/export.md states for them. A law of good condition comes out at a few units in the last place of its effort; one
whose terms cancel (kernels with gains of 1e7) does not. In float64 `TorqueModel.predict` and the C round alike, so they
agree to the bit even there; float32, and a runtime with functions of its own, stray as far as said here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from erclutch.arithmetic.elementary import table_entry
from erclutch.arithmetic.evaluation import evaluate
from erclutch.arithmetic.precision import FLOAT32, FLOAT64, Precision
from erclutch.arithmetic.record import BINARY, Node
from erclutch.errors import ExportError
from erclutch.export.exported_step import ExportedStep
from erclutch.export.recording.stage_memory import suffix_of
from erclutch.export.step_numbers import named, numbers, reference, run
from erclutch.export.step_record import step_record
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
    record = step_record(step)
    p = precision or step.precision
    errors = Errors(step.network, p)
    in_float64 = numbers(step, FLOAT64)
    inputs = named(record, np.asarray(rows, np.float64))
    exact: dict[str, Array] = {}  # inputs without an error
    for name, signal in inputs.items():
        exact[name] = np.stack([signal, np.zeros_like(signal)])
    # Nodes whose errors decay: a bound operation by operation would grow instead.
    given: dict[Node, Array] = {}

    if step.filter is not None:
        own = filter_error(step, p)
        slips = evaluate(record.record, inputs, in_float64, outputs=record.slips)
        for node, slip in zip(record.slips, slips, strict=True):
            error = own + 0.5 * p.epsilon * np.abs(slip)
            given[node] = np.stack([slip, error])
    for stage, parameters in step.stages:
        if not isinstance(stage, Oscillator):
            continue
        # On the command each element has an oscillator of its own; on the effort the device has one.
        elements = ("0", "1", "") if stage.place == "command" else ("",)
        for element in elements:
            kept_output = record.record.after.get(f"x{suffix_of(stage, element)}")
            if kept_output is None:
                continue
            # The choice that gives the output: in the first row its third argument, that is the signal.
            node = kept_output.arguments[0]
            signal_node = node.arguments[2]
            value, signal = evaluate(record.record, inputs, in_float64, outputs=(node, signal_node))
            signal_error = evaluate(record.record, exact, errors, given, [signal_node])[0][1]
            period = step.period or 1.0  # [s]
            error = oscillator_error(parameters, period, value, signal, signal_error, p)
            given[node] = np.stack([value, error])
    _, error = evaluate(record.record, exact, errors, given, [record.value])[0]
    return error


def oscillator_error(
    parameters: Mapping[str, float],
    period: float,
    value: Array,
    signal: Array,
    signal_error: Array,
    p: Precision,
) -> Array:
    """Error of the output from the signal's: a bound operation by operation would grow as no oscillation does."""
    tau, zeta = parameters.values()
    a11, a12, a21, a22 = map(float, coefficients(tau, zeta, period))
    row_to_row = np.array([[a11, a12], [a21, a22]])
    from_signal = np.array([1.0 - a11, -a21])
    # What an error of the signal, or of the state, in any row before adds to the output.
    of_signal = of_state = 0.0
    state = np.eye(2)
    for _ in range(value.size):
        output = state[0]
        of_signal += abs(float(output @ from_signal))
        of_state += float(np.abs(output).sum())
        state = state @ row_to_row
    sizes = np.maximum(np.abs(value), np.abs(signal))
    largest = np.maximum.accumulate(sizes)
    # Two sums of three terms a row, each no larger than three times the largest value or its slope.
    return of_signal * np.maximum.accumulate(signal_error) + of_state * 6.0 * p.epsilon * largest


def filter_error(step: ExportedStep, p: Precision) -> float:
    """Of a speed, from angles within half a turn (or, unturned, of size one)."""
    gains = step.filter
    assert gains is not None
    size = 1.0 if gains.turn is None else gains.turn
    period = step.period or 1.0  # [s]
    return 4.0 * p.epsilon * size * max(gains.h, 1e-3) / period / max(gains.g, 1e-3)


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

    @property
    def on_numbers(self) -> Mapping[str, Callable[..., Any]]:
        """None: a value has its error beside it."""
        return {}

    def function_of(self, node: Node) -> Callable[..., Any]:
        """What `apply` does for this node."""
        return _ON_TRUTHS.get(node.operation) or (lambda *arguments: self.apply(node, arguments))

    def apply(self, node: Node, arguments: Sequence[Any]) -> Any:
        """The value of a node and its largest error."""
        if node.operation == "network":
            assert self.network is not None
            values = np.array(np.broadcast_arrays(*(value for value, _ in arguments)))
            errors = np.array(np.broadcast_arrays(*(error for _, error in arguments)))
            return np.stack(_network(self.network, values, errors, self.precision))
        if node.operation == "less":
            return arguments[0][0] < arguments[1][0]
        if node.operation == "finite":
            return np.isfinite(arguments[0][0])
        if node.operation == "table":
            return table_entry(node.value, *(place[0] for place in arguments))
        if node.operation in _ON_TRUTHS:
            return _ON_TRUTHS[node.operation](*arguments)
        value, error = _with_error(node, arguments, self.precision)
        if value.shape == error.shape:  # for a row alone, `stack` takes longer than the operation
            return np.array((value, error))
        return np.stack(np.broadcast_arrays(value, error))


_np: Any = np
_ON_TRUTHS: Mapping[str, Callable[..., Array]] = {
    "both": _np.logical_and,
    "either": _np.logical_or,
    "opposite": _np.logical_not,
    "choose": _np.where,
}

#: A value and its largest error.
Uncertain = tuple[Any, Any]
#: Share of the largest effort that rounding may take before an export is refused.
NOISE = 0.01


@lru_cache(maxsize=16)
def measured(step: ExportedStep, count: int = 256) -> tuple[float, float]:
    """Largest difference from NumPy on random rows of the training range, and the largest bound there."""
    rows = ordinary(step, np.random.default_rng(0), count)
    rows[:, step.model_inputs :] = np.nan  # nothing is measured: the model's own effort
    at_speeds = replace(step, filter=None, limits=(-1e30, 1e30))
    effort, _ = run(at_speeds, rows)
    of_numpy, _ = reference(at_speeds, rows)
    difference = np.abs(effort - of_numpy)
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


def _with_error(node: Node, arguments: Sequence[Uncertain], p: Precision) -> Uncertain:
    """The value of a node and its largest error, from those of its arguments."""
    half = 0.5 * p.epsilon
    name = node.operation
    if name == "constant":
        value = np.array([float(node.value or 0.0)])
        own = half if p is FLOAT32 else 0.0
        return value, own * np.abs(value)
    a, a_error = arguments[0]
    if name == "negate":
        return -a, a_error
    if name == "absolute":
        return np.abs(a), a_error
    if name == "nearest":
        # Whatever is computed from the whole number and from what is left meets at its steps.
        value = _np.round(a)
        return value, 0.0 * value

    # A function: its argument's error, and its own as a share of the value.
    if name not in BINARY:
        own = ULPS[p.name][name] * p.epsilon
        if name == "exp":
            value = np.exp(a)
            return value, value * a_error + own * value
        if name == "expm1":
            value = np.expm1(a)
            return value, (value + 1.0) * a_error + own * np.abs(value)
        if name == "tanh":
            value = np.tanh(a)
            return value, _spread(value, a_error) + own * np.abs(value)
        exponent, exponent_error = arguments[1]
        base = np.maximum(a, 1e-300)
        value = np.power(base, exponent)
        by_base = np.abs(exponent) * a_error / base
        by_exponent = np.abs(np.log(a)) * exponent_error
        return value, value * (by_base + by_exponent) + own * value

    b, b_error = arguments[1]
    if name == "add":
        value = a + b
        error = a_error + b_error
    elif name == "subtract":
        value = a - b
        error = a_error + b_error
    elif name == "multiply":
        value = a * b
        error = np.abs(a) * b_error + np.abs(b) * a_error
    else:
        value = a / b
        error = (a_error + np.abs(value) * b_error) / np.abs(b)
    return value, error + half * np.abs(value)


def _spread(value: Any, error: Any) -> Any:
    """What an error of its argument makes of tanh: its slope, which saturates."""
    return np.minimum((1.0 - value * value) * error + np.abs(value) * error * error, 2.0)


def _network(
    model: NetworkModel,
    x: Array,
    x_error: Array,
    p: Precision,
) -> tuple[Array, Array]:
    """The forward pass from inputs and their errors, shape (inputs, n)."""
    half = 0.5 * p.epsilon
    model = model.folded
    scale = model.scaling.scale[:, None]
    offset = model.scaling.offset[:, None]
    # In float32 the constants of the scaling are rounded too.
    of_offset = np.abs(offset) if p is FLOAT32 else 0.0
    z = (x - offset) / scale
    of_difference = half * (np.abs(x - offset) + of_offset)
    z_error = (x_error + of_difference) / np.abs(scale)
    z_error = z_error + (2.0 if p is FLOAT32 else 1.0) * half * np.abs(z)

    # The last activations with their errors, and the weights and the offset of the output.
    if model.structure.kind == "rbfn":
        own = ULPS[p.name]["exp"] * p.epsilon
        centres = model.weights["centres"]  # shape (hidden, inputs)
        spread = (model.weights["spreads"] ** 2)[:, None]
        square = np.zeros((len(centres), z.shape[1]))
        square_error = np.zeros_like(square)
        for j in range(len(z)):
            centre = centres[:, j : j + 1]
            distance = z[j] - centre
            of_centre = np.abs(centre) if p is FLOAT32 else 0.0
            distance_error = z_error[j] + half * (np.abs(distance) + of_centre)
            square += distance**2
            square_error += 2.0 * np.abs(distance) * distance_error + half * 3.0 * distance**2
        argument = 0.5 * square / spread
        argument_error = 0.5 * square_error / spread + 4.0 * half * argument
        a = np.exp(-argument)
        a_error = a * argument_error + own * a
        weights = model.weights["w"]
        start = float(model.weights["b"][0])
    else:
        own = ULPS[p.name]["tanh"] * p.epsilon
        a, a_error = z, z_error
        for layer in range(1, len(model.structure.hidden) + 1):
            w = model.weights[f"W{layer}"]
            b = model.weights[f"b{layer}"][:, None]
            size = np.abs(w) @ np.abs(a) + np.abs(b)
            a_error = np.abs(w) @ a_error + half * (len(a) + 2.0) * size
            a = np.tanh(w @ a + b)
            a_error = _spread(a, a_error) + own * np.abs(a)
        weights = model.weights["W_out"][0]
        start = float(model.weights["b_out"][0])

    terms = np.abs(weights[:, None] * a)
    size = terms.sum(axis=0) + abs(start)
    # Of four running sums side by side, and of what joins them.
    roundings = len(weights) / 4.0 + 6.0
    error = np.abs(weights) @ a_error + half * roundings * size
    return weights @ a + start, error
