"""A step record becomes an ONNX model: one file, normalisation inside, fixed shapes, state in and out as one tensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch._version import __version__
from erclutch.arithmetic.elementary import format_of
from erclutch.arithmetic.record import Node, Record
from erclutch.errors import printable
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_recording import StepRecord

#: Version of the standard operators; ONNX Runtime 1.15 and later know it.
OPSET = 17
#: Version of the file format that goes with it.
IR_VERSION = 8

_PLAIN = {
    "add": "Add",
    "subtract": "Sub",
    "multiply": "Mul",
    "divide": "Div",
    "negate": "Neg",
    "absolute": "Abs",
    "exp": "Exp",
    "tanh": "Tanh",
    "less": "Less",
    "both": "And",
    "either": "Or",
    "opposite": "Not",
    "choose": "Where",
}


@dataclass
class Emitter:
    """Operators and constants while they are collected; every number is a tensor of shape (1,).

    Attributes:
        step: what is exported.
        helper: the module onnx.helper.
        nodes, constants: of the ONNX graph.
    """

    step: ExportedStep
    helper: Any
    nodes: list[Any] = field(default_factory=list[Any])
    constants: list[Any] = field(default_factory=list[Any])
    _known: dict[bytes, str] = field(default_factory=dict[bytes, str])
    _value: dict[int, str] = field(default_factory=dict[int, str])

    def constant(self, values: Any, dtype: Any = None) -> str:
        """Name of a constant tensor."""
        from onnx import numpy_helper

        held: NDArray[Any] = np.asarray(values, dtype or self.step.precision.dtype)
        key = held.tobytes() + str((held.shape, held.dtype)).encode()
        if key not in self._known:
            self._known[key] = f"k{len(self._known)}"
            self.constants.append(numpy_helper.from_array(held, self._known[key]))
        return self._known[key]

    def add(self, operator: str, arguments: Sequence[str], result: str = "", **attributes: Any) -> str:
        """One operator with one result; returns the result's name."""
        name = result or f"v{len(self.nodes)}"
        self.nodes.append(self.helper.make_node(operator, list(arguments), [name], **attributes))
        return name

    def split(self, tensor: str, names: Sequence[str], lengths: Sequence[int]) -> None:
        """A vector into parts."""
        if len(names) == 1:
            self.add("Identity", [tensor], names[0])
            return
        sizes = self.constant(lengths, np.int64)
        self.nodes.append(self.helper.make_node("Split", [tensor, sizes], list(names), axis=0))

    def value(self, node: Node) -> str:
        """Name of a node's value, after `record`."""
        return self._value[node.index]

    def record(self, record: Record) -> None:
        """All operators of a record without calls."""
        for node in record.needed():
            self._value[node.index] = self._operator(node, [self._value[a.index] for a in node.arguments])

    def _operator(self, node: Node, a: list[str]) -> str:
        operation = node.operation
        if operation == "input":
            return str(node.value)
        if operation == "state":
            return f"before_{node.value}"
        if operation == "delay":
            name, rows = node.value
            at = [self.constant([i], np.int64) for i in (rows - 1, rows)]
            return self.add("Where", [a[1], self.add("Slice", [f"before_{name}", *at]), a[0]])
        if operation == "constant":
            return self.constant([float(node.value or 0.0)])
        if operation in _PLAIN:
            return self.add(_PLAIN[operation], a)
        if operation == "finite":
            return self.add("Less", [self.add("Abs", a), self.constant([np.inf])])
        if operation == "nearest":
            magic = self.constant([format_of(self.step.precision).magic])
            return self.add("Sub", [self.add("Add", [a[0], magic]), magic])
        if operation == "power":
            smallest = self.constant([2.0 ** (1 - self.step.precision.bias)])
            return self.add("Pow", [self.add("Max", [a[0], smallest]), a[1]])
        if operation == "expm1":
            return self._expm1(a[0])
        if operation == "table":
            return self._entry(node, a)
        return self._network(a)

    def _entry(self, node: Node, a: list[str]) -> str:
        """An entry of a table, by row and column."""
        from onnx import TensorProto

        row, column = (self.add("Cast", [x], to=TensorProto.INT64) for x in a)
        start = self.add("Mul", [row, self.constant([len(node.value[0])], np.int64)])
        return self.add("Gather", [self.constant(np.ravel(node.value), np.bool_), self.add("Add", [start, column])])

    def _expm1(self, x: str) -> str:
        """e^x - 1: near zero 2 t / (1 - t) with t = tanh(x / 2), as there is no such operator."""
        one, two = self.constant([1.0]), self.constant([2.0])
        t = self.add("Tanh", [self.add("Div", [x, two])])
        near = self.add("Div", [self.add("Mul", [two, t]), self.add("Sub", [one, t])])
        far = self.add("Sub", [self.add("Exp", [x]), one])
        return self.add("Where", [self.add("Less", [self.add("Abs", [x]), one]), near, far])

    def _network(self, a: list[str]) -> str:
        model = self.step.network
        assert model is not None
        s, w = model.scaling, model.weights
        x = self.add("Concat", a, axis=0)
        x = self.add("Div", [self.add("Sub", [x, self.constant(s.offset)]), self.constant(s.scale)])
        if model.structure.kind == "rbfn":
            distance = self.add("Sub", [x, self.constant(w["centres"])])
            square = self.add(
                "ReduceSum", [self.add("Mul", [distance, distance]), self.constant([1], np.int64)], keepdims=0
            )
            half = self.add("Mul", [square, self.constant([-0.5])])
            x = self.add("Exp", [self.add("Div", [half, self.constant(w["spreads"] ** 2)])])
            out, start = w["w"], w["b"]
        else:
            for i in range(1, len(model.structure.hidden) + 1):
                product = self.add("MatMul", [self.constant(w[f"W{i}"]), x])
                x = self.add("Tanh", [self.add("Add", [product, self.constant(w[f"b{i}"])])])
            out, start = w["W_out"][0], w["b_out"]
        y = self.add("Add", [self.add("MatMul", [self.constant(out[None, :]), x]), self.constant(start)])
        scaled = self.add("Mul", [y, self.constant([s.effort_scale])])
        return self.add("Add", [scaled, self.constant([s.effort_offset])])


def onnx_model(step: ExportedStep, record: StepRecord) -> Any:
    """The ONNX model: ``input`` (1, n), perhaps ``state`` (S,); ``effort`` (1, 1), ``flags`` (1,), ``state_out`` (S,).

    A state of zeros is a reset.
    """
    from onnx import TensorProto, helper

    emit = Emitter(step, helper)
    flat, count = record.record.flat(), len(record.inputs)
    real = TensorProto.FLOAT if step.precision.width == 32 else TensorProto.DOUBLE
    row = emit.add("Reshape", ["input", emit.constant([count], np.int64)])
    emit.split(row, record.inputs, [1] * count)
    inputs = [helper.make_tensor_value_info("input", real, [1, count])]
    outputs = [helper.make_tensor_value_info("effort", real, [1, 1])]
    outputs += [helper.make_tensor_value_info("flags", TensorProto.INT32, [1])]
    if record.size:
        _unpack(emit, flat)
        inputs += [helper.make_tensor_value_info("state", real, [record.size])]
        outputs += [helper.make_tensor_value_info("state_out", real, [record.size])]
    emit.record(flat)
    effort, *truths = (emit.value(node) for node in flat.outputs)
    emit.add("Reshape", [effort, emit.constant([1, 1], np.int64)], "effort")
    zero = emit.constant([0], np.int32)
    raised = [
        emit.add("Where", [truth, emit.constant([bit], np.int32), zero])
        for bit, truth in zip(record.flags, truths, strict=True)
    ]
    emit.add("Identity", [reduce(lambda a, b: emit.add("Add", [a, b]), raised)], "flags")
    if record.size:
        _pack(emit, flat, real)
    about = printable(f"{step.model.title}: {step.model.name}. Inputs: {', '.join(step.inputs)}.")
    graph = helper.make_graph(emit.nodes, step.name, inputs, outputs, emit.constants, doc_string=about)
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION)
    made.producer_name, made.producer_version, made.doc_string = "erclutch", __version__, about
    helper.set_model_props(made, {key: printable(text) for key, text in _properties(step).items()})
    return made


def _unpack(emit: Emitter, record: Record) -> None:
    """The state's numbers under their names, a truth as one, and each register whole."""
    truths = [name for name, node in record.after.items() if node.kind == "truth"]
    registers = record.registers()
    names = [f"number_{name}" if name in truths else f"before_{name}" for name in (*record.after, *registers)]
    emit.split("state", names, [1] * len(record.after) + list(registers.values()))
    for name in truths:
        emit.add("Less", [emit.constant([0.5]), f"number_{name}"], f"before_{name}")


def _pack(emit: Emitter, record: Record, real: int) -> None:
    parts = [
        emit.add("Cast", [emit.value(node)], to=real) if node.kind == "truth" else emit.value(node)
        for node in record.after.values()
    ]
    entering = record.entering()
    for name, length in record.registers().items():
        now, going = (emit.value(node) for node in entering[name])
        moved = now
        if length > 1:
            at = [emit.constant([i], np.int64) for i in (0, length - 1)]
            moved = emit.add("Concat", [now, emit.add("Slice", [f"before_{name}", *at])], axis=0)
        full = emit.add("Expand", [now, emit.constant([length], np.int64)])
        parts.append(emit.add("Where", [going, moved, full]))
    emit.add("Concat", parts, "state_out", axis=0)


def _properties(step: ExportedStep) -> dict[str, str]:
    model = step.model
    ranges = model.trained_on
    return {
        "digest": step.digest,
        "model": model.name,
        "erclutch": __version__,
        "inputs": ", ".join(f"{n} [{u}]" for n, u in zip(step.inputs, step.units, strict=True)),
        "effort": model.units.effort or "1",
        "field range": f"{ranges.field[0]:.9g} {ranges.field[1]:.9g}",
        "slip range": f"{ranges.slip[0]:.9g} {ranges.slip[1]:.9g}",
        "effort limits": f"{step.limits[0]:.9g} {step.limits[1]:.9g}",
        **({} if step.period is None else {"period": f"{step.period:.9g}"}),
    }
