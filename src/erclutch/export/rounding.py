"""How far rounding can take a step from what endless digits would give: first-order error analysis, row by row.

Every operation adds half a unit in the last place of its result to what its arguments bring; functions add what
docs/export.md states for them. A law of good condition comes out at a few units in the last place of its effort; one
whose terms cancel (kernels with gains of 1e7) does not. In float64 `TorqueModel.predict` and the C round alike, so they
agree to the bit even there; float32, and a runtime with functions of its own, stray as far as said here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ExportError
from erclutch.export.emulate import Held, base_of, receive, reference, run, run_lag
from erclutch.export.graph import Graph, Node
from erclutch.export.program import Program
from erclutch.export.vectors import ordinary
from erclutch.networks.model import NetworkModel
from erclutch.precision import FLOAT32, FLOAT64, Precision

Array = NDArray[np.float64]

#: Largest error of each function in units of the last place, as tests/test_elementary.py measures it.
ULPS: Mapping[str, Mapping[str, float]] = {
    "float32": {"exp": 1.0, "expm1": 1.5, "tanh": 6.0, "power": 1.2},
    "float64": {"exp": 1.0, "expm1": 2.0, "tanh": 2.6, "power": 1.2},
}


def bound(program: Program, rows: Array, precision: Precision | None = None) -> Array:
    """Largest rounding error of the effort at each row, shape (n,), in the effort's unit.

    Args:
        program: the step.
        rows: its inputs.
        precision: of the arithmetic; None is the program's.
    """
    p = precision or program.precision
    held = receive(program, np.asarray(rows, np.float64), FLOAT64)
    half = 0.5 * p.epsilon
    fields = [_fluid(program, x, p) for x in held.fields]
    slips = [(w, half * np.abs(w) if program.elements == 2 else 0.0 * w) for w in held.slips]
    if program.filter is not None:
        slips = [(w, e + _filter_error(program, p)) for w, e in slips]
    if program.law is None:
        return _network(program, fields, slips, held, p)
    names = [f"x{i + 1}" for i in range(program.elements)], [f"w{i + 1}" for i in range(program.elements)]
    inputs = {**dict(zip(names[0], fields, strict=True)), **dict(zip(names[1], slips, strict=True))}
    return _run(program.law, inputs, p)[0][1]


Uncertain = tuple[Any, Any]
"""A value and its largest error."""


#: Share of the largest effort that rounding may take before an export is refused.
_NOISE = 0.01


def measured(program: Program, count: int = 256) -> tuple[float, float]:
    """Largest difference from NumPy on random rows of the training range, and the largest bound there."""
    rows = ordinary(program, np.random.default_rng(0), count)
    at_speeds = replace(program, filter=None, limits=(-1e30, 1e30))
    difference = np.abs(run(at_speeds, rows)[0] - reference(at_speeds, rows)[0])
    limit = bound(at_speeds, rows) + bound(at_speeds, rows, FLOAT64)
    return float(difference.max()), float(limit.max())


def refuse_noise(program: Program) -> None:
    """Refuse a precision in which rounding drowns the model.

    Raises:
        ExportError: it does, by more than 1 % of the largest training effort.
    """
    difference, _ = measured(program)
    if difference > _NOISE * program.scale:
        raise ExportError(
            f"in {program.precision.name} effort is off by {100 * difference / program.scale:.3g} % of the largest: "
            "terms that nearly cancel leave no digits",
            where=program.model.name,
            remedy="Use --precision float64, which gives the bits of erclutch's own predictions",
        )


def _fluid(program: Program, field: Array, p: Precision) -> Uncertain:
    value, error = _run(program.command, {"field": (field, np.zeros_like(field))}, p)[0]
    lag = program.lag
    if lag is None:
        return value, error
    share = min(lag.rise, lag.rise if lag.fall is None else lag.fall)
    # The field in the fluid lies between commands; its recursion keeps a share of each error, the cubic weighs slopes.
    largest = np.full_like(value, np.max(np.abs(value)))
    slopes = 2.0 * lag.reach * (abs(lag.bend_before) + abs(lag.bend_after)) / min(lag.tau_rise, lag.tau_fall)
    weight = 1.0 + 2.0 * abs(lag.forward) + slopes
    return run_lag(lag, value), weight * (np.max(error) + 0.5 * p.epsilon * largest * (4.0 + 3.0 / share))


def _filter_error(program: Program, p: Precision) -> float:
    """Of a speed, from angles within half a turn (or, unturned, of size one)."""
    f = program.filter
    assert f is not None
    size = 1.0 if f.turn is None else f.turn
    return 4.0 * p.epsilon * size * max(f.h, 1e-3) / (program.period or 1.0) / max(f.g, 1e-3)


def _run(graph: Graph, inputs: Mapping[str, Uncertain], p: Precision) -> list[Uncertain]:
    known: dict[int, Uncertain] = {}
    with np.errstate(all="ignore"):
        for node in graph.needed():
            known[node.index] = _step(node, [known[a.index] for a in node.arguments], inputs, p)
    shape = np.shape(next(iter(inputs.values()))[0])
    found = [known[n.index] for n in graph.outputs]
    return [(np.broadcast_to(v, shape), np.broadcast_to(e, shape)) for v, e in found]


def _step(node: Node, a: list[Uncertain], inputs: Mapping[str, Uncertain], p: Precision) -> Uncertain:
    half, name = 0.5 * p.epsilon, node.operation
    if name == "input":
        return inputs[str(node.value)]
    if name == "constant":
        value = float(node.value or 0.0)
        return value, (half * abs(value) if p is FLOAT32 else 0.0)
    if name in ("negate", "absolute"):
        return (-a[0][0] if name == "negate" else np.abs(a[0][0])), a[0][1]
    if name in ("add", "subtract"):
        value = a[0][0] + a[1][0] if name == "add" else a[0][0] - a[1][0]
        return value, a[0][1] + a[1][1] + half * np.abs(value)
    if name == "multiply":
        value = a[0][0] * a[1][0]
        return value, np.abs(a[0][0]) * a[1][1] + np.abs(a[1][0]) * a[0][1] + half * np.abs(value)
    if name == "divide":
        value = a[0][0] / a[1][0]
        return value, (a[0][1] + np.abs(value) * a[1][1]) / np.abs(a[1][0]) + half * np.abs(value)
    return _function(name, a, ULPS[p.name][name] * p.epsilon)


def _function(name: str, a: list[Uncertain], own: float) -> Uncertain:
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


def _network(program: Program, fields: list[Uncertain], slips: list[Uncertain], held: Held, p: Precision) -> Array:
    model, half = program.model, 0.5 * p.epsilon
    assert isinstance(model, NetworkModel)
    values = base_of(program, [v for v, _ in fields], [v for v, _ in slips])
    error_field = sum(e for _, e in fields)
    error_slip = sum(e for _, e in slips)
    errors = [error_field if i == 0 else error_slip for i in range(len(values))]
    errors = [e + half * np.abs(v) for e, v in zip(errors, values, strict=True)]
    for _ in program.past:
        values, errors = values + values[: len(program.base)], errors + errors[: len(program.base)]
    x = np.array([*values, *held.extras], np.float64)
    # Past rows are taken for the present ones here: the error of a row is that of its own size.
    e = np.array([*errors, *(half * np.abs(v) for v in held.extras)], np.float64)
    scale, offset = model.scaling.scale[:, None], model.scaling.offset[:, None]
    z = (x - offset) / scale
    e = (e + half * (np.abs(x - offset) + (np.abs(offset) if p is FLOAT32 else 0.0))) / np.abs(scale)
    e = e + (2.0 if p is FLOAT32 else 1.0) * half * np.abs(z)
    a, e, weights, start = _rbfn(model, z, e, p) if model.structure.kind == "rbfn" else _fnn(model, z, e, p)
    terms = np.abs(weights[:, None] * a)
    count = len(weights) / 4.0 + 6.0
    error = np.abs(weights) @ e + half * count * (terms.sum(axis=0) + abs(start))
    unit = abs(model.scaling.effort_scale)
    return unit * error + 3.0 * half * (unit * (terms.sum(axis=0) + abs(start)) + abs(model.scaling.effort_offset))


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
