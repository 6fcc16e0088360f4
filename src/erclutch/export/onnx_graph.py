"""A step record as an ONNX model: one file, normalisation inside, fixed shapes, state in and out as one tensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch._version import __version__
from erclutch.export.graph import Node
from erclutch.export.program import Program
from erclutch.export.step_record import StepRecord
from erclutch.networks.model import NetworkModel

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
}


@dataclass
class Emitter:
    """Operators and constants while they are collected; every number is a tensor of shape (1,).

    Attributes:
        program: what is exported.
        helper: the module onnx.helper.
        nodes, constants: of the ONNX graph.
    """

    program: Program
    helper: Any
    nodes: list[Any] = field(default_factory=list[Any])
    constants: list[Any] = field(default_factory=list[Any])
    _known: dict[bytes, str] = field(default_factory=dict[bytes, str])
    _value: dict[int, str] = field(default_factory=dict[int, str])

    def constant(self, values: Any, dtype: Any = None) -> str:
        """Name of a constant tensor."""
        from onnx import numpy_helper

        held: NDArray[Any] = np.asarray(values, dtype or self.program.precision.dtype)
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

    def record(self, record: StepRecord) -> None:
        """All operators of the record."""
        for node in record.graph.needed():
            self._value[node.index] = self._operator(node, [self._value[a.index] for a in node.arguments])

    def _operator(self, node: Node, a: list[str]) -> str:
        operation = node.operation
        if operation == "input":
            return str(node.value)
        if operation == "constant":
            return self.constant([float(node.value or 0.0)])
        if operation in _PLAIN:
            return self.add(_PLAIN[operation], a)
        if operation == "less_select":
            return self.add("Where", [self.add("Less", a[:2]), *a[2:]])
        if operation == "power":
            smallest = self.constant([2.0 ** (1 - self.program.precision.bias)])
            return self.add("Pow", [self.add("Max", [a[0], smallest]), a[1]])
        if operation == "expm1":
            return self._expm1(a[0])
        return self._network(a)

    def _expm1(self, x: str) -> str:
        """e^x - 1: near zero 2 t / (1 - t) with t = tanh(x / 2), as there is no such operator."""
        one, two = self.constant([1.0]), self.constant([2.0])
        t = self.add("Tanh", [self.add("Div", [x, two])])
        near = self.add("Div", [self.add("Mul", [two, t]), self.add("Sub", [one, t])])
        far = self.add("Sub", [self.add("Exp", [x]), one])
        return self.add("Where", [self.add("Less", [self.add("Abs", [x]), one]), near, far])

    def _network(self, a: list[str]) -> str:
        model = self.program.model
        assert isinstance(model, NetworkModel)
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


def onnx_model(program: Program, record: StepRecord) -> Any:
    """The ONNX model: ``input`` (1, n), perhaps ``state`` (S,); ``effort`` (1, 1), ``flags`` (1,), ``state_out`` (S,).

    A state of zeros is a reset.
    """
    from onnx import TensorProto, helper

    emit = Emitter(program, helper)
    count = len(record.inputs)
    real = TensorProto.FLOAT if program.precision.width == 32 else TensorProto.DOUBLE
    row = emit.add("Reshape", ["input", emit.constant([count], np.int64)])
    emit.split(row, record.inputs, [1] * count)
    inputs = [helper.make_tensor_value_info("input", real, [1, count])]
    outputs = [helper.make_tensor_value_info("effort", real, [1, 1])]
    outputs += [helper.make_tensor_value_info("flags", TensorProto.INT32, [1])]
    if record.size:
        _unpack(emit, record)
        inputs += [helper.make_tensor_value_info("state", real, [record.size])]
        outputs += [helper.make_tensor_value_info("state_out", real, [record.size])]
    emit.record(record)
    emit.add("Reshape", [emit.value(record.effort), emit.constant([1, 1], np.int64)], "effort")
    emit.add("Cast", [emit.value(record.flags)], "flags", to=TensorProto.INT32)
    if record.size:
        _pack(emit, record)
    about = f"{program.model.title}: {program.model.name}. Inputs: {', '.join(program.inputs)}."
    graph = helper.make_graph(emit.nodes, program.name, inputs, outputs, emit.constants, doc_string=about)
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION)
    made.producer_name, made.producer_version, made.doc_string = "erclutch", __version__, about
    helper.set_model_props(made, _properties(program))
    return made


def _unpack(emit: Emitter, record: StepRecord) -> None:
    names = [*record.after, *(r.name for r in record.registers)]
    emit.split("state", names, [1] * len(record.after) + [r.length for r in record.registers])
    for register in record.registers:
        for k in register.reads:
            at = [emit.constant([i], np.int64) for i in (k - 1, k)]
            emit.add("Slice", [register.name, *at], f"{register.name}@{k}")


def _pack(emit: Emitter, record: StepRecord) -> None:
    parts = [emit.value(node) for node in record.after.values()]
    half = emit.constant([0.5])
    for register in record.registers:
        now = emit.value(register.now)
        moved = now
        if register.length > 1:
            at = [emit.constant([i], np.int64) for i in (0, register.length - 1)]
            moved = emit.add("Concat", [now, emit.add("Slice", [register.name, *at])], axis=0)
        going = emit.add("Less", [half, str(record.started)])
        parts.append(
            emit.add("Where", [going, moved, emit.add("Expand", [now, emit.constant([register.length], np.int64)])])
        )
    emit.add("Concat", parts, "state_out", axis=0)


def _properties(program: Program) -> dict[str, str]:
    model = program.model
    ranges = model.trained_on
    return {
        "digest": program.digest,
        "model": model.name,
        "erclutch": __version__,
        "inputs": ", ".join(f"{n} [{u}]" for n, u in zip(program.inputs, program.units, strict=True)),
        "effort": model.units.effort or "1",
        "field range": f"{ranges.field[0]:.9g} {ranges.field[1]:.9g}",
        "slip range": f"{ranges.slip[0]:.9g} {ranges.slip[1]:.9g}",
        "effort limits": f"{program.limits[0]:.9g} {program.limits[1]:.9g}",
        **({} if program.period is None else {"period": f"{program.period:.9g}"}),
    }
