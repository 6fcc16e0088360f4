"""A NumPy function runs on operands that write down what is done to them; that is its record, with its state.

The record keeps NumPy's order of operations. It is printed as C and for other targets, and it is run again in NumPy in
either precision (`erclutch.arithmetic.evaluation`), bit for bit what the C does, because IEEE arithmetic leaves no
choice.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Literal

import numpy as np

from erclutch.arithmetic.elementary import BY_NAME, RecordingOperand, absolute, format_of
from erclutch.arithmetic.precision import Precision
from erclutch.errors import ExportError

ValueKind = Literal["real", "bits", "truth"]

#: Operations and their operators in C. ``function`` nodes (exp, tanh, ...) are defined in `elementary`.
BINARY = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/"}
ON_BITS = {
    "bits_add": "+",
    "bits_subtract": "-",
    "bits_and": "&",
    "left_shift": "<<",
    "right_shift": ">>",
}
FUNCTIONS = ("exp", "expm1", "tanh", "power", "absolute", "nearest")


@dataclass(frozen=True, eq=False)
class Node:
    """One operation.

    Attributes:
        index: place in the record; arguments come before.
        operation: one of
            input, state (the value after the row before, zero at first), constant, negate,
            a key of BINARY or ON_BITS, a name of FUNCTIONS, bits_of, real_of_bits, real_from_bits,
            less, finite, both, either, opposite (these give a truth), choose (by a truth),
            table (a truth, a whole number or a real one out of a nested table, at the whole parts of the arguments),
            delay (a signal some rows back, by whether there was a row before), earlier (what a delay register of
            another record holds so many rows back), call (of a record), network.
        arguments: nodes.
        value: of a constant; the name of an input, a state or a call; of a delay its register's name and the rows.
        kind: a real number, its bits, or a truth.
    """

    index: int
    operation: str
    arguments: tuple[Node, ...]
    value: Any
    kind: ValueKind

    def __repr__(self) -> str:
        value = "" if self.value is None else f" {self.value!r}"
        return (
            f"<node {self.index}: {self.operation}{value} of {[a.index for a in self.arguments]}>"
        )


@dataclass
class Record:
    """A record. The same operation on the same nodes is recorded once.

    Attributes:
        nodes: in the order of computation.
        outputs: what is asked for.
        after: new value of each number of the state.
        calls: records that are called, by name.
        labels: what a value is, by its node's index, for people who read what is printed.
        orders: orders of computation that `evaluate` has found, by what was asked for and what was known.
    """

    nodes: list[Node] = field(default_factory=list[Node])
    outputs: list[Node] = field(default_factory=list[Node])
    after: dict[str, Node] = field(default_factory=dict[str, Node])
    calls: dict[str, Record] = field(default_factory=dict[str, "Record"])
    labels: dict[int, str] = field(default_factory=dict[int, str])
    _known: dict[Any, Node] = field(default_factory=dict[Any, Node])
    orders: dict[Any, Any] = field(
        default_factory=dict[Any, Any],
        repr=False,
        compare=False,
    )

    def node(
        self,
        operation: str,
        arguments: tuple[Node, ...] = (),
        value: Any = None,
        kind: ValueKind = "real",
    ) -> Node:
        """The node of an operation, a new one if it is the first time."""
        key = (operation, tuple(a.index for a in arguments), repr(value), kind)
        if key not in self._known:
            new = Node(len(self.nodes), operation, arguments, value, kind)
            self.nodes.append(new)
            self._known[key] = new
        return self._known[key]

    def node_of(self, x: Any) -> Node:
        """The node of an operand or of a number."""
        if isinstance(x, Traced):
            return x.node
        number = np.nan
        if np.size(x) == 1:
            number = np.asarray(x).item()
        return self.node("constant", (), float(number))

    def operand(
        self,
        operation: str,
        *arguments: Any,
        value: Any = None,
        kind: ValueKind = "real",
    ) -> Traced:
        """The operand for an operation on operands and numbers."""
        nodes = tuple(self.node_of(x) for x in arguments)
        return Traced(self, self.node(operation, nodes, value, kind))

    def input(self, name: str) -> Traced:
        """An operand for an input."""
        return self.operand("input", value=name)

    def state(self, name: str, kind: ValueKind = "real") -> Traced:
        """An operand for a number of the state; `keep` sets its new value."""
        return self.operand("state", value=name, kind=kind)

    def keep(self, name: str, value: Any) -> None:
        """Set the new value of a number of the state."""
        self.after[name] = self.node_of(value)

    def label(self, x: Any, name: str) -> Any:
        """Say what a value is, as an identifier; the value comes back. The first label of a value stays."""
        if isinstance(x, Traced):
            self.labels.setdefault(x.node.index, name)
        return x

    def give(self, value: Any) -> Node:
        """Make a traced value, or a plain number, an output."""
        output = self.node_of(value)
        self.outputs.append(output)
        return output

    # Truths: operands of this kind, or a plain bool that is known while recording.

    def less(self, a: Any, b: Any) -> Traced:
        """Whether a < b."""
        return self.operand("less", a, b, kind="truth")

    def finite(self, x: Any) -> Traced:
        """Whether a number is neither infinite nor NaN."""
        return self.operand("finite", x, kind="truth")

    def both(self, a: Any, b: Any) -> Any:
        """Whether both are true."""
        if isinstance(a, bool) or isinstance(b, bool):
            known, other = (a, b) if isinstance(a, bool) else (b, a)
            return other if known else False
        return self.operand("both", a, b, kind="truth")

    def either(self, a: Any, b: Any) -> Any:
        """Whether at least one is true."""
        if isinstance(a, bool) or isinstance(b, bool):
            known, other = (a, b) if isinstance(a, bool) else (b, a)
            return True if known else other
        return self.operand("either", a, b, kind="truth")

    def opposite(self, a: Any) -> Traced:
        """Whether it is not true."""
        return self.operand("opposite", a, kind="truth")

    def choose(self, condition: Any, yes: Any, no: Any) -> Any:
        """One of two numbers by a truth."""
        if isinstance(condition, bool):
            return yes if condition else no
        return self.operand("choose", condition, yes, no)

    def call(self, name: str, function: Callable[..., Any], **arguments: Any) -> Any:
        """A function that is recorded by itself and called here; targets with functions print it once."""
        called = self.calls.get(name) or recorded(function, tuple(arguments))
        output = called.outputs[0]
        if output.operation == "input":  # it gives back what it gets
            return arguments[str(output.value)]
        self.calls[name] = called
        return self.operand("call", *arguments.values(), value=name)

    def needed(self) -> list[Node]:
        """Nodes that the outputs and the state depend on, in order."""
        roots = (*self.outputs, *self.after.values())
        wanted = {n.index for n in roots}
        for node in reversed(self.nodes):
            if node.index in wanted:
                wanted.update(a.index for a in node.arguments)
        return [n for n in self.nodes if n.index in wanted]

    def registers(self) -> dict[str, int]:
        """Delay registers by name: how many rows each goes back."""
        longest: dict[str, int] = {}
        for node in self.needed():
            if node.operation == "delay":
                name, rows = node.value
                longest[name] = max(rows, longest.get(name, 0))
        return longest

    def entering(self) -> dict[str, tuple[Node, Node]]:
        """What enters each delay register, and whether there was a row before: if not, it fills all of it."""
        entering: dict[str, tuple[Node, Node]] = {}
        for node in self.needed():
            if node.operation == "delay":
                name, _ = node.value
                signal, has_row_before = node.arguments
                entering[name] = signal, has_row_before
        return entering

    def inputs(self) -> list[str]:
        """Names of the inputs, in the order in which they were made."""
        return [str(n.value) for n in self.nodes if n.operation == "input"]

    def flat(self) -> Record:
        """The same with what it calls in place of the calls."""
        flat = Record()
        copies = _copy(self, flat, {})
        flat.outputs = [copies[n.index] for n in self.outputs]
        flat.after = {name: copies[n.index] for name, n in self.after.items()}
        return flat


def _copy(
    record: Record,
    into: Record,
    known: dict[int, Node],
) -> dict[int, Node]:
    """The copies of a record's nodes by their index; some, such as its inputs, are known before."""
    for node in record.needed():
        if node.index in known:
            continue
        arguments = tuple(known[a.index] for a in node.arguments)
        if node.operation == "call":
            called = record.calls[str(node.value)]
            places = [n.index for n in called.nodes if n.operation == "input"]
            inner = _copy(called, into, dict(zip(places, arguments, strict=True)))
            known[node.index] = inner[called.outputs[0].index]
        else:
            known[node.index] = into.node(node.operation, arguments, node.value, node.kind)
    return known


def recorded(function: Callable[..., Any], names: Sequence[str]) -> Record:
    """The record of a function of inputs with these names."""
    record = Record()
    inputs = [record.input(name) for name in names]
    record.give(function(*inputs))
    return record


class Traced(RecordingOperand):
    """An operand that records; one number, though it passes for an array of one row."""

    __slots__ = ("node", "owner")
    size = 1

    def __init__(self, owner: Record, node: Node) -> None:
        self.owner = owner
        self.node = node

    def __getitem__(self, rows: Any) -> Traced:
        return self

    def __bool__(self) -> bool:
        raise ExportError("a branch (if, and, or, np.where) has no C", remedy=_NO_BRANCH)

    def __lt__(self, other: Any) -> Any:
        raise ExportError("a comparison has no C here", remedy=_NO_BRANCH)

    __le__ = __gt__ = __ge__ = __lt__

    def __and__(self, other: Any) -> Any:
        """Both truths."""
        return self.owner.both(self, other)

    def __array_ufunc__(
        self,
        ufunc: np.ufunc,
        method: str,
        *inputs: Any,
        **kwargs: Any,
    ) -> Any:
        operation = _UFUNCS.get(ufunc)
        if operation is None or method != "__call__" or kwargs:
            raise ExportError(
                f"no C for NumPy's {ufunc.__name__}",
                remedy=f"Write the law with {', '.join(sorted(u.__name__ for u in _UFUNCS))}",
            )
        nodes = [self.owner.node_of(x) for x in inputs]
        return Traced(self.owner, self._record(operation, nodes))

    def record(self, operation: str, *arguments: Any, bits: bool = False) -> Traced:
        """A choice, or an operation on bits; a plain integer stands for bits."""
        record = self.owner
        if operation == "less_select":
            a, b, yes, no = arguments
            return record.choose(record.less(a, b), yes, no)
        if operation == "less":
            return record.less(*arguments)
        if operation == "table":
            table, *places = arguments
            kinds: dict[str, ValueKind] = {"b": "truth", "i": "bits", "f": "real"}
            kind = kinds[np.array(table).dtype.kind]
            return record.operand("table", *places, value=table, kind=kind)
        nodes: list[Node] = []
        for x in arguments:
            if bits and isinstance(x, int):
                nodes.append(record.node("constant", (), x, kind="bits"))
            else:
                nodes.append(record.node_of(x))
        kind = "bits" if bits else "real"
        return Traced(record, record.node(operation, tuple(nodes), kind=kind))

    def _record(self, operation: str, nodes: list[Node]) -> Node:
        """A node, or a simpler one of exactly the same value."""
        constants = [n.value if n.operation == "constant" else None for n in nodes]
        if operation == "multiply" and 1.0 in constants:
            return nodes[1 - constants.index(1.0)]
        if operation == "multiply" and -1.0 in constants:
            return self.owner.node("negate", (nodes[1 - constants.index(-1.0)],))
        if operation == "power":
            return self._power(nodes, constants[1])
        if operation == "square":
            return self.owner.node("multiply", (nodes[0], nodes[0]))
        return self.owner.node(operation, tuple(nodes))

    def _power(self, nodes: list[Node], exponent: Any) -> Node:
        if exponent is None:
            raise ExportError(
                "a power whose exponent is no constant", remedy="Write it with exp and a parameter"
            )
        base = nodes[0]
        one = self.owner.node("constant", (), 1.0)
        if exponent == 0.0:
            return one
        if exponent == 1.0:
            return base
        if exponent == -1.0:
            return self.owner.node("divide", (one, base))
        if exponent == 2.0:
            return self.owner.node("multiply", (base, base))
        return self.owner.node("power", tuple(nodes))


_NO_BRANCH = "Write it without branches, with np.abs and, of erclutch.models.laws.smooth, direction and power"
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


@cache
def traced(name: str, precision: Precision) -> Record:
    """An elementary function as a record, with inputs x (and n)."""
    record = Record()
    names = ("x", "n") if name == "power" else ("x",)
    arguments = [record.input(name_of) for name_of in names]
    if name == "absolute":
        record.give(absolute(*arguments))
    else:
        record.give(BY_NAME[name](format_of(precision), *arguments))
    return record
