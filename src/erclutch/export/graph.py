"""Straight-line arithmetic, recorded by running a NumPy function on operands that write down what is done to them.

The record keeps NumPy's order of operations. It is printed as C (`c_code`) and run again in NumPy in either precision
(`evaluate`), bit for bit what the C does, because IEEE arithmetic leaves no choice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from erclutch.elementary import BY_NAME, Recorder, absolute, elementary, format_of
from erclutch.errors import ExportError
from erclutch.precision import Precision

Kind = Literal["real", "bits"]

#: Operations and their operators in C. ``function`` nodes (exp, tanh, ...) are defined in `elementary`.
BINARY = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/"}
ON_BITS = {"bits_add": "+", "bits_subtract": "-", "bits_and": "&", "left_shift": "<<", "right_shift": ">>"}
FUNCTIONS = ("exp", "expm1", "tanh", "power", "absolute")


@dataclass(frozen=True, eq=False)
class Node:
    """One operation.

    Attributes:
        index: place in the record; arguments come before.
        operation: input, constant, negate, less_select, a key of BINARY, ON_BITS or a name of FUNCTIONS,
            bits_of, real_of_bits, real_from_bits.
        arguments: nodes.
        value: of a constant, or the name of an input.
        kind: a real number or its bits.
    """

    index: int
    operation: str
    arguments: tuple[Node, ...]
    value: float | int | str | None
    kind: Kind


@dataclass
class Graph:
    """A record. The same operation on the same nodes is recorded once.

    Attributes:
        nodes: in the order of computation.
        outputs: what is asked for.
    """

    nodes: list[Node] = field(default_factory=list[Node])
    outputs: list[Node] = field(default_factory=list[Node])
    _known: dict[Any, Node] = field(default_factory=dict[Any, Node])

    def node(
        self,
        operation: str,
        arguments: tuple[Node, ...] = (),
        value: float | int | str | None = None,
        kind: Kind = "real",
    ) -> Node:
        """The node of an operation, a new one if it is the first time."""
        key = (operation, tuple(a.index for a in arguments), repr(value), kind)
        if key not in self._known:
            self._known[key] = Node(len(self.nodes), operation, arguments, value, kind)
            self.nodes.append(self._known[key])
        return self._known[key]

    def input(self, name: str) -> Traced:
        """An operand for an input."""
        return Traced(self, self.node("input", (), name))

    def give(self, value: Any) -> None:
        """Make a traced value, or a plain number, an output."""
        self.outputs.append(value.node if isinstance(value, Traced) else self.node("constant", (), float(value)))

    def needed(self) -> list[Node]:
        """Nodes that the outputs depend on, in order."""
        wanted = {n.index for n in self.outputs}
        for node in reversed(self.nodes):
            if node.index in wanted:
                wanted.update(a.index for a in node.arguments)
        return [n for n in self.nodes if n.index in wanted]


class Traced(Recorder):
    """An operand that records; one number, though it passes for an array of one row."""

    __slots__ = ("graph", "node")
    size = 1

    def __init__(self, graph: Graph, node: Node) -> None:
        self.graph = graph
        self.node = node

    def __getitem__(self, rows: Any) -> Traced:
        return self

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        operation = _UFUNCS.get(ufunc)
        if operation is None or method != "__call__" or kwargs:
            raise ExportError(
                f"no C for NumPy's {ufunc.__name__}",
                remedy=f"Write the law with {', '.join(sorted(u.__name__ for u in _UFUNCS))}",
            )
        return Traced(self.graph, self._record(operation, [self.node_of(x) for x in inputs]))

    def record(self, operation: str, *arguments: Any, bits: bool = False) -> Traced:
        """A choice, or an operation on bits; a plain integer stands for bits."""
        nodes = [
            self.graph.node("constant", (), x, kind="bits") if bits and isinstance(x, int) else self.node_of(x)
            for x in arguments
        ]
        return Traced(self.graph, self.graph.node(operation, tuple(nodes), kind="bits" if bits else "real"))

    def node_of(self, x: Any) -> Node:
        """The node of an operand or of a number."""
        if isinstance(x, Traced):
            return x.node
        return self.graph.node("constant", (), float(np.asarray(x).reshape(())[()] if np.size(x) == 1 else np.nan))

    def _record(self, operation: str, nodes: list[Node]) -> Node:
        """A node, or a simpler one of exactly the same value."""
        constants = [n.value if n.operation == "constant" else None for n in nodes]
        if operation == "multiply" and 1.0 in constants:
            return nodes[1 - constants.index(1.0)]
        if operation == "multiply" and -1.0 in constants:
            return self.graph.node("negate", (nodes[1 - constants.index(-1.0)],))
        if operation == "power":
            return self._power(nodes, constants[1])
        if operation == "square":
            return self.graph.node("multiply", (nodes[0], nodes[0]))
        return self.graph.node(operation, tuple(nodes))

    def _power(self, nodes: list[Node], exponent: Any) -> Node:
        if exponent is None:
            raise ExportError("a power whose exponent is no constant", remedy="Write it with exp and a parameter")
        one = self.graph.node("constant", (), 1.0)
        exact = {0.0: one, 1.0: nodes[0]}
        if exponent in exact:
            return exact[exponent]
        if exponent == -1.0:
            return self.graph.node("divide", (one, nodes[0]))
        if exponent == 2.0:
            return self.graph.node("multiply", (nodes[0], nodes[0]))
        return self.graph.node("power", tuple(nodes))


_UFUNCS: dict[np.ufunc, str] = {
    np.add: "add",
    np.subtract: "subtract",
    np.multiply: "multiply",
    np.true_divide: "divide",
    np.negative: "negate",
    np.power: "power",
    np.square: "square",
    np.exp: "exp",
    np.expm1: "expm1",
    np.tanh: "tanh",
    np.absolute: "absolute",
}


def evaluate(graph: Graph, inputs: Mapping[str, NDArray[Any]], precision: Precision) -> list[NDArray[Any]]:
    """Run a record on arrays, bit for bit as the C does.

    Args:
        graph: what to run.
        inputs: arrays by name, all of one shape, of the precision's type.
        precision: of every operation.
    """
    known: dict[int, Any] = {}
    functions = elementary(precision)
    with np.errstate(all="ignore"):
        for node in graph.needed():
            arguments = [known[a.index] for a in node.arguments]
            known[node.index] = _value(node, arguments, inputs, precision, functions)
    shape = np.broadcast_shapes(*(np.shape(x) for x in inputs.values()))
    return [np.broadcast_to(np.asarray(known[n.index], precision.dtype), shape) for n in graph.outputs]


_NUMPY = {"add": np.add, "subtract": np.subtract, "multiply": np.multiply, "divide": np.true_divide}


def _value(
    node: Node, arguments: Sequence[Any], inputs: Mapping[str, Any], precision: Precision, functions: Mapping[str, Any]
) -> Any:
    if node.operation == "input":
        return inputs[str(node.value)]
    if node.operation == "constant":
        return np.asarray(node.value, np.float64).astype(precision.dtype)
    if node.operation in _NUMPY:
        return _NUMPY[node.operation](*arguments)
    if node.operation == "negate":
        return -arguments[0]
    return functions[node.operation](*arguments)


@cache
def traced(name: str, precision: Precision) -> Graph:
    """An elementary function as a record, with inputs x (and n)."""
    graph = Graph()
    arguments = [graph.input(a) for a in (("x", "n") if name == "power" else ("x",))]
    graph.give(absolute(*arguments) if name == "absolute" else BY_NAME[name](format_of(precision), *arguments))
    return graph
