"""A record is evaluated on all rows at once; only what depends on its own past runs row by row.

The record is cut into its strongly connected parts. A node outside every cycle through the state is computed over all
rows together, a delay is a shift of rows, and the nodes of a cycle are computed one row after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.elementary import elementary, table_entry
from erclutch.arithmetic.precision import Precision
from erclutch.arithmetic.record import Node, Record

AnyArray = NDArray[Any]


class Arithmetic(Protocol):
    """How one operation is computed. The last axis of every value is that of the rows, or has length one."""

    def apply(self, node: Node, arguments: Sequence[Any]) -> Any:
        """The value of a node on some rows."""
        ...

    def zero(self, node: Node) -> Any:
        """A number of the state before the first row."""
        ...


@dataclass(frozen=True)
class Numbers:
    """Numbers of a precision, with the bits of the C.

    Attributes:
        precision: of every operation.
        network: the forward pass of a network, from inputs (inputs, n) to effort (n,).
    """

    precision: Precision
    network: Callable[[AnyArray], AnyArray] | None = None

    def apply(self, node: Node, arguments: Sequence[Any]) -> Any:
        """The value of a node on some rows."""
        if node.operation == "constant":
            return np.asarray(node.value, np.float64).astype(self.precision.dtype).reshape(1)
        if node.operation == "table":
            entry = table_entry(node.value, *arguments)
            return entry.astype(self.precision.dtype) if node.kind == "real" else entry
        if node.operation == "network":
            assert self.network is not None
            return self.network(np.array(np.broadcast_arrays(*arguments)))
        return (_NUMPY.get(node.operation) or self._functions[node.operation])(*arguments)

    @cached_property
    def _functions(self) -> Mapping[str, Callable[..., Any]]:
        return elementary(self.precision)

    def zero(self, node: Node) -> Any:
        """A number of the state before the first row."""
        return np.zeros(1, np.bool_ if node.kind == "truth" else self.precision.dtype)


_np: Any = np
_NUMPY: Mapping[str, Callable[..., Any]] = {
    "add": _np.add,
    "subtract": _np.subtract,
    "multiply": _np.multiply,
    "divide": _np.true_divide,
    "negate": _np.negative,
    "less": _np.less,
    "finite": _np.isfinite,
    "both": _np.logical_and,
    "either": _np.logical_or,
    "opposite": _np.logical_not,
    "choose": _np.where,
}


def evaluate(
    record: Record,
    inputs: Mapping[str, AnyArray],
    arithmetic: Arithmetic,
    given: Mapping[Node, AnyArray] | None = None,
    outputs: Sequence[Node] | None = None,
) -> list[AnyArray]:
    """The outputs of a record over a sequence of rows from a reset.

    Args:
        record: what to run.
        inputs: arrays by name, the last axis that of the rows.
        arithmetic: how an operation is computed.
        given: values that stand in place of those of some nodes.
        outputs: nodes that are asked for; None are the record's own. Only what they depend on is computed.
    """
    rows = max((np.shape(x)[-1] for x in inputs.values()), default=1)
    wanted = record.outputs if outputs is None else outputs
    run = _Run(record, inputs, arithmetic, rows, dict(given or {}))
    with np.errstate(all="ignore"):
        for part, cyclic in _parts(record, wanted, run.known):
            if cyclic:
                if not run.hold(part):
                    run.row_by_row(part)
            elif part[0] not in run.known:
                run.known[part[0]] = run.value(part[0])
    return [run.all_rows(n) for n in wanted]


@dataclass
class _Run:
    record: Record
    inputs: Mapping[str, AnyArray]
    arithmetic: Arithmetic
    rows: int
    known: dict[Node, Any] = field(default_factory=dict[Node, Any])

    def value(self, node: Node) -> Any:
        """A node over all rows, whose arguments are known."""
        if node.operation == "input":
            return self.inputs[str(node.value)]
        if node.operation == "state":
            later = self.all_rows(self.record.after[str(node.value)])
            first = np.broadcast_to(self.arithmetic.zero(node), (*later.shape[:-1], 1))
            return np.concatenate([first, later[..., :-1]], axis=-1)
        if node.operation == "delay":
            return self.all_rows(node.arguments[0])[..., self._rows_back(node)]
        return self._applied(node, [self.known[a] for a in node.arguments])

    def all_rows(self, node: Node) -> AnyArray:
        """The known value of a node, shape (..., rows)."""
        value = self.known[node]
        return np.broadcast_to(value, (*np.shape(value)[:-1], self.rows))

    def _applied(self, node: Node, arguments: Sequence[Any]) -> Any:
        if node.operation != "call":
            return self.arithmetic.apply(node, arguments)
        called = self.record.calls[str(node.value)]
        return evaluate(called, dict(zip(called.inputs(), arguments, strict=True)), self.arithmetic)[0]

    def _rows_back(self, node: Node) -> NDArray[np.int64]:
        """For each row the row that a delay reads: none ahead of the last row without one before it."""
        going = self.all_rows(node.arguments[1])
        at = np.arange(self.rows)
        first = np.maximum.accumulate(np.where(going, 0, at))
        return np.maximum(at - node.value[1], first)

    def hold(self, part: Sequence[Node]) -> bool:
        """The nodes of a cycle that only keeps a value until another replaces it; whether it is such a cycle."""
        inside, state = set(part), part[0]
        if state.operation != "state" or not all(_holds(node, inside) for node in part[1:]):
            return False
        zero = self.arithmetic.zero(state)
        found: dict[Node, tuple[Any, Any]] = {state: (np.ones(self.rows, np.bool_), zero)}  # kept?, else which value

        def of(node: Node) -> tuple[Any, Any]:
            return found[node] if node in inside else (np.zeros(self.rows, np.bool_), self.all_rows(node))

        for node in part[1:]:
            if node.operation == "choose":
                chosen = self.all_rows(node.arguments[0])
                (yes_kept, yes), (no_kept, no) = (of(a) for a in node.arguments[1:])
                found[node] = np.where(chosen, yes_kept, no_kept), np.where(chosen, yes, no)
            else:
                (kept, value), (_, other) = (of(a) for a in sorted(node.arguments, key=lambda a: a not in inside))
                found[node] = kept & ~other, value | other
        kept, value = found[self.record.after[str(state.value)]]
        last = np.maximum.accumulate(np.where(kept, -1, np.arange(self.rows)))
        after = np.where(last >= 0, np.broadcast_to(value, (*np.shape(zero)[:-1], self.rows))[..., last], zero)
        before = np.concatenate([np.broadcast_to(zero, (*after.shape[:-1], 1)), after[..., :-1]], axis=-1)
        for node, (kept, value) in found.items():
            self.known[node] = np.where(kept, before, value)
        return True

    def row_by_row(self, part: Sequence[Node]) -> None:
        """The nodes of a cycle."""
        inside = set(part)
        found: dict[Node, list[Any]] = {node: [] for node in part}
        back = {n: self._rows_back(n) for n in part if n.operation == "delay"}
        outer = {a: self.all_rows(a) for n in part for a in n.arguments if a not in inside}

        def at(node: Node, k: int) -> Any:
            return found[node][k] if node in inside else outer[node][..., k : k + 1]

        for k in range(self.rows):
            for node in part:
                if node.operation == "state":
                    later = self.record.after[str(node.value)]
                    value = found[later][k - 1] if k else self.arithmetic.zero(node)
                elif node.operation == "delay":
                    value = at(node.arguments[0], int(back[node][k]))
                else:
                    value = self._applied(node, [at(a, k) for a in node.arguments])
                found[node].append(value)
        for node, values in found.items():
            self.known[node] = np.concatenate(values, axis=-1)


def _holds(node: Node, inside: set[Node]) -> bool:
    """Whether an operation of a cycle passes a number of the state on, or puts a value from outside in its place."""
    within = [a in inside for a in node.arguments]
    if node.operation == "choose":
        return not within[0]
    return node.operation == "either" and within.count(True) == 1


def _parts(record: Record, outputs: Sequence[Node], known: Mapping[Node, Any]) -> list[tuple[list[Node], bool]]:
    """The strongly connected parts in the order of computation, each with its nodes in theirs, and whether it loops."""

    def needs(node: Node) -> tuple[Node, ...]:
        if node in known:
            return ()
        return (record.after[str(node.value)],) if node.operation == "state" else node.arguments

    parts = [sorted(part, key=lambda n: n.index) for part in _components(outputs, needs)]
    return [(part, len(part) > 1 or part[0] in needs(part[0])) for part in parts]


def _components(roots: Sequence[Node], needs: Callable[[Node], Sequence[Node]]) -> list[list[Node]]:
    """Strongly connected parts of all that the roots need, each after what it needs (Tarjan, without recursion)."""
    place: dict[Node, int] = {}
    lowest: dict[Node, int] = {}
    open_: dict[Node, None] = {}
    found: list[list[Node]] = []
    for root in roots:
        work = [] if root in place else [(root, iter(needs(root)))]
        while work:
            node, rest = work[-1]
            if node not in place:
                place[node] = lowest[node] = len(place)
                open_[node] = None
            for other in rest:
                if other not in place:
                    work.append((other, iter(needs(other))))
                    break
                if other in open_:
                    lowest[node] = min(lowest[node], place[other])
            else:
                work.pop()
                if work:
                    lowest[work[-1][0]] = min(lowest[work[-1][0]], lowest[node])
                if lowest[node] == place[node]:
                    part = [other for other in open_ if place[other] >= place[node]]
                    for other in part:
                        del open_[other]
                    found.append(part)
    return found
