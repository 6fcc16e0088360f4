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
from erclutch.export.recording.recorded_step import StepRecord

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

    def add(
        self,
        operator: str,
        arguments: Sequence[str],
        result: str = "",
        **attributes: Any,
    ) -> str:
        """One operator with one result; returns the result's name."""
        name = result or f"v{len(self.nodes)}"
        node = self.helper.make_node(operator, list(arguments), [name], **attributes)
        self.nodes.append(node)
        return name

    def split(self, tensor: str, names: Sequence[str], lengths: Sequence[int]) -> None:
        """A vector into parts."""
        if len(names) == 1:
            self.add("Identity", [tensor], names[0])
            return
        sizes = self.constant(lengths, np.int64)
        node = self.helper.make_node("Split", [tensor, sizes], list(names), axis=0)
        self.nodes.append(node)

    def value(self, node: Node) -> str:
        """Name of a node's value, after `record`."""
        return self._value[node.index]

    def record(self, record: Record) -> None:
        """All operators of a record without calls."""
        for node in record.needed():
            arguments = [self._value[argument.index] for argument in node.arguments]
            self._value[node.index] = self._operator(node, arguments)

    def _operator(self, node: Node, a: list[str]) -> str:
        operation = node.operation
        if operation == "input":
            return str(node.value)
        if operation == "state":
            return f"before_{node.value}"
        if operation == "delay":
            now, row_before = a
            name, rows = node.value
            start = self.constant([rows - 1], np.int64)
            stop = self.constant([rows], np.int64)
            back = self.add("Slice", [f"before_{name}", start, stop])
            return self.add("Where", [row_before, back, now])
        if operation == "constant":
            return self.constant([float(node.value or 0.0)])
        if operation in _PLAIN:
            return self.add(_PLAIN[operation], a)
        if operation == "finite":
            size = self.add("Abs", a)
            return self.add("Less", [size, self.constant([np.inf])])
        if operation == "nearest":
            magic = self.constant([format_of(self.step.precision).magic])
            shifted = self.add("Add", [a[0], magic])
            return self.add("Sub", [shifted, magic])
        if operation == "power":
            base, exponent = a
            smallest = self.constant([2.0 ** (1 - self.step.precision.bias)])
            held_base = self.add("Max", [base, smallest])
            return self.add("Pow", [held_base, exponent])
        if operation == "expm1":
            return self._expm1(a[0])
        if operation == "table":
            return self._entry(node, a)
        return self._network(a)

    def _entry(self, node: Node, a: list[str]) -> str:
        """An entry of a table, by row and column."""
        from onnx import TensorProto

        row, column = (self.add("Cast", [x], to=TensorProto.INT64) for x in a)
        columns = len(node.value[0])
        start = self.add("Mul", [row, self.constant([columns], np.int64)])
        entries = self.constant(np.ravel(node.value), np.bool_)
        return self.add("Gather", [entries, self.add("Add", [start, column])])

    def _expm1(self, x: str) -> str:
        """e^x - 1: near zero 2 t / (1 - t) with t = tanh(x / 2), as there is no such operator."""
        one = self.constant([1.0])
        two = self.constant([2.0])
        t = self.add("Tanh", [self.add("Div", [x, two])])
        twice = self.add("Mul", [two, t])
        near = self.add("Div", [twice, self.add("Sub", [one, t])])
        far = self.add("Sub", [self.add("Exp", [x]), one])
        is_near = self.add("Less", [self.add("Abs", [x]), one])
        return self.add("Where", [is_near, near, far])

    def _network(self, inputs: list[str]) -> str:
        model = self.step.network
        assert model is not None
        scaling = model.scaling
        weights = model.weights
        x = self.add("Concat", inputs, axis=0)
        x = self.add("Sub", [x, self.constant(scaling.offset)])
        x = self.add("Div", [x, self.constant(scaling.scale)])
        if model.structure.kind == "rbfn":
            difference = self.add("Sub", [x, self.constant(weights["centres"])])
            squares = self.add("Mul", [difference, difference])
            distance = self.add("ReduceSum", [squares, self.constant([1], np.int64)], keepdims=0)
            half = self.add("Mul", [distance, self.constant([-0.5])])
            exponent = self.add("Div", [half, self.constant(weights["spreads"] ** 2)])
            x = self.add("Exp", [exponent])
            out = weights["w"]
            start = weights["b"]
        else:
            for i in range(1, len(model.structure.hidden) + 1):
                product = self.add("MatMul", [self.constant(weights[f"W{i}"]), x])
                shifted = self.add("Add", [product, self.constant(weights[f"b{i}"])])
                x = self.add("Tanh", [shifted])
            out = weights["W_out"][0]
            start = weights["b_out"]
        product = self.add("MatMul", [self.constant(out[None, :]), x])
        y = self.add("Add", [product, self.constant(start)])
        y = self.add("Mul", [y, self.constant([scaling.effort_scale])])
        return self.add("Add", [y, self.constant([scaling.effort_offset])])


def onnx_model(step: ExportedStep, record: StepRecord) -> Any:
    """The ONNX model: ``input`` (1, n), perhaps ``state`` (S,); ``effort`` (1, 1), ``flags`` (1,), ``state_out`` (S,).

    A state of zeros is a reset.
    """
    from onnx import TensorProto, helper

    emit = Emitter(step, helper)
    flat = record.record.flat()
    real = TensorProto.FLOAT if step.precision.width == 32 else TensorProto.DOUBLE
    tensor = helper.make_tensor_value_info

    count = len(record.inputs)
    row = emit.add("Reshape", ["input", emit.constant([count], np.int64)])
    emit.split(row, record.inputs, [1] * count)
    inputs = [tensor("input", real, [1, count])]
    outputs = [tensor("effort", real, [1, 1]), tensor("flags", TensorProto.INT32, [1])]
    if record.size:
        # The state's numbers under their names, a truth as a truth, and each register whole.
        truths_kept = [name for name, node in flat.after.items() if node.kind == "truth"]
        registers = flat.registers()
        names = [
            f"number_{name}" if name in truths_kept else f"before_{name}"
            for name in (*flat.after, *registers)
        ]
        emit.split("state", names, [1] * len(flat.after) + list(registers.values()))
        for name in truths_kept:
            emit.add("Less", [emit.constant([0.5]), f"number_{name}"], f"before_{name}")
        inputs.append(tensor("state", real, [record.size]))
        outputs.append(tensor("state_out", real, [record.size]))

    emit.record(flat)
    effort, *truths = (emit.value(node) for node in flat.outputs)
    emit.add("Reshape", [effort, emit.constant([1, 1], np.int64)], "effort")
    zero = emit.constant([0], np.int32)
    raised = [
        emit.add("Where", [truth, emit.constant([bit], np.int32), zero])
        for bit, truth in zip(record.flags, truths, strict=True)
    ]
    flags = reduce(lambda a, b: emit.add("Add", [a, b]), raised)
    emit.add("Identity", [flags], "flags")
    if record.size:
        # The state after the step as one vector: numbers, then the registers with what enters each.
        parts: list[str] = []
        for node in flat.after.values():
            number = emit.value(node)
            parts.append(emit.add("Cast", [number], to=real) if node.kind == "truth" else number)
        entering = flat.entering()
        for name, length in flat.registers().items():
            now, row_before = (emit.value(node) for node in entering[name])
            moved = now
            if length > 1:
                start = emit.constant([0], np.int64)
                stop = emit.constant([length - 1], np.int64)
                kept = emit.add("Slice", [f"before_{name}", start, stop])
                moved = emit.add("Concat", [now, kept], axis=0)
            full = emit.add("Expand", [now, emit.constant([length], np.int64)])
            parts.append(emit.add("Where", [row_before, moved, full]))
        emit.add("Concat", parts, "state_out", axis=0)

    about = printable(f"{step.model.title}: {step.model.name}. Inputs: {', '.join(step.inputs)}.")
    graph = helper.make_graph(
        emit.nodes, step.name, inputs, outputs, emit.constants, doc_string=about
    )
    model = helper.make_model(
        graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION
    )
    model.producer_name = "erclutch"
    model.producer_version = __version__
    model.doc_string = about

    # What people want to know of the file, as text.
    trained_on = step.model.trained_on
    units = [f"{name} [{unit}]" for name, unit in zip(step.inputs, step.units, strict=True)]
    properties = {
        "digest": step.digest,
        "model": step.model.name,
        "erclutch": __version__,
        "inputs": ", ".join(units),
        "effort": step.model.units.effort or "1",
        "field range": "{:.9g} {:.9g}".format(*trained_on.field),
        "slip range": "{:.9g} {:.9g}".format(*trained_on.slip),
        "effort limits": "{:.9g} {:.9g}".format(*step.limits),
    }
    if step.period is not None:
        properties["period"] = f"{step.period:.9g}"
    helper.set_model_props(model, {key: printable(text) for key, text in properties.items()})
    return model
