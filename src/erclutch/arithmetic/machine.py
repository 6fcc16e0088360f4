"""One row of a record runs in machine code: one loop, which Numba compiles, for any record without state.

The numbers lie in registers, and an operation reads up to three of them. A register is a double, and its bits are the
same memory, so the result has the bits of the exported C.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.precision import FLOAT64
from erclutch.arithmetic.record import FUNCTIONS, Node, Record, traced
from erclutch.arithmetic.recursion import machine_code
from erclutch.signals.array import Array

#: In the order of the numbers that `_run` knows them by.
_OPERATIONS = (
    *("add", "multiply", "subtract", "divide", "negate", "less", "choose"),
    *("bits_add", "bits_subtract", "left_shift", "right_shift", "real_from_bits"),
)
_LARGEST = 1e60  # beyond it an intermediate number may overflow


@dataclass(frozen=True)
class Machine:
    """A record of inputs and one output, made to run.

    Attributes:
        code: for each operation its number, and the registers of the result and of three arguments, shape (n, 5).
        registers: the numbers before the first operation; the inputs come first.
        output: register of the output.
    """

    code: NDArray[np.uint32]
    registers: Array
    output: int

    def run(self, inputs: Array) -> float:
        """The output for one row; NaN where an input is not finite, or so large that a product may overflow."""
        return machine_code(_run)(self.code, self.registers, inputs, self.output)


def machine_of(record: Record) -> Machine:
    """The machine of a record without state."""
    inputs = [n.index for n in record.nodes if n.operation == "input"]
    count = len(inputs)
    writing = _Writing(registers=[np.uint64(0)] * count, depths=[0] * count)
    register_of = dict(zip(inputs, range(count), strict=True))
    output = writing.write(record, register_of)
    # Equal operations side by side: processors foresee which comes next.
    writing.code.sort(key=lambda line: (writing.depths[line[1]], line[0]))
    return Machine(
        np.array(writing.code, np.uint32),
        np.array(writing.registers).view(np.float64),
        output,
    )


@dataclass
class _Writing:
    """A machine in the making; the depth of a register is how many operations its number is away from the inputs."""

    registers: list[np.uint64]
    depths: list[int]
    code: list[tuple[int, ...]] = field(default_factory=list[tuple[int, ...]])

    def write(self, record: Record, places: dict[int, int]) -> int:
        """Append the operations of a record whose inputs lie in some registers; the register of its output."""
        for node in record.needed():
            if node.index in places:
                continue
            arguments = [places[a.index] for a in node.arguments]
            if node.operation in ("bits_of", "real_of_bits"):  # a register is both
                places[node.index] = arguments[0]
            elif node.operation in FUNCTIONS or node.operation in record.calls:
                called = record.calls.get(node.operation) or traced(node.operation, FLOAT64)
                inputs = [n.index for n in called.nodes if n.operation == "input"]
                places[node.index] = self.write(called, dict(zip(inputs, arguments, strict=True)))
            else:
                places[node.index] = self._written(node, arguments)
        return places[record.outputs[0].index]

    def _written(self, node: Node, arguments: list[int]) -> int:
        """A new register for an operation on registers, or for a constant."""
        register = len(self.registers)
        constant = node.value
        if node.operation != "constant":
            constant = 0
            a, b, c = (*arguments, 0, 0, 0)[:3]
            self.code.append((_OPERATIONS.index(node.operation), register, a, b, c))
        bits = np.uint64(constant) if node.kind == "bits" else np.float64(constant).view(np.uint64)
        self.registers.append(bits)
        deepest = max((self.depths[argument] for argument in arguments), default=0)
        self.depths.append(1 + deepest)
        return register


def _run(code: NDArray[np.uint32], registers: Array, inputs: Array, output: int) -> float:  # noqa: C901  # a switch
    real = registers.copy()
    bits = real.view(np.uint64)
    for k in range(inputs.size):
        if not abs(inputs[k]) < _LARGEST:
            return np.nan
        real[k] = inputs[k]
    for k in range(code.shape[0]):
        operation = code[k, 0]
        to = code[k, 1]
        a = code[k, 2]
        b = code[k, 3]
        c = code[k, 4]
        if operation == 0:
            real[to] = real[a] + real[b]
        elif operation == 1:
            real[to] = real[a] * real[b]
        elif operation == 2:
            real[to] = real[a] - real[b]
        elif operation == 3:
            real[to] = real[a] / real[b]
        elif operation == 4:
            real[to] = -real[a]
        elif operation == 5:
            bits[to] = real[a] < real[b]
        elif operation == 6:
            real[to] = real[b] if bits[a] else real[c]
        elif operation == 7:
            bits[to] = bits[a] + bits[b]
        elif operation == 8:
            bits[to] = bits[a] - bits[b]
        elif operation == 9:
            bits[to] = bits[a] << bits[b]
        elif operation == 10:
            bits[to] = bits[a] >> bits[b]
        elif operation == 11:
            real[to] = bits[a]
    return real[output]
