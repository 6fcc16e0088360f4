"""A record is evaluated on all rows at once; only what depends on its own past runs row by row.

The record is cut into its strongly connected parts. A node outside every cycle through the state is computed over all
rows together, a delay is a shift of rows, and the nodes of a cycle are computed one row after the other.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import itemgetter
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.elementary import elementary, table_entry
from erclutch.arithmetic.precision import Precision
from erclutch.arithmetic.record import Node, Record

AnyArray = NDArray[Any]


class Arithmetic(Protocol):
    """How one operation is computed. The last axis of every value is that of the rows, or has length one.

    Attributes:
        on_numbers: operations that single numbers of NumPy give with the bits of arrays, in a fifth of their time.
    """

    @property
    def on_numbers(self) -> Mapping[str, Callable[..., Any]]:
        """See `Arithmetic`."""
        ...

    def apply(self, node: Node, arguments: Sequence[Any]) -> Any:
        """The value of a node on some rows."""
        ...

    def function_of(self, node: Node) -> Callable[..., Any]:
        """What `apply` does for this node, as a function of its arguments: for a node that runs row by row."""
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
        function = self._functions.get(node.operation)
        if function is not None:
            return function(*arguments)
        if node.operation == "constant":
            return np.asarray(node.value, np.float64).astype(self.precision.dtype).reshape(1)
        if node.operation == "table":
            entry = table_entry(node.value, *arguments)
            if node.kind == "real":
                return entry.astype(self.precision.dtype)
            return entry
        assert node.operation == "network"
        assert self.network is not None
        inputs = np.array(np.broadcast_arrays(*arguments))
        return self.network(inputs)

    def function_of(self, node: Node) -> Callable[..., Any]:
        """What `apply` does for this node."""
        known = self._functions.get(node.operation)
        return known or (lambda *arguments: self.apply(node, arguments))

    @property
    def on_numbers(self) -> Mapping[str, Callable[..., Any]]:
        """Operators and choices."""
        return _ON_NUMBERS

    @cached_property
    def _functions(self) -> Mapping[str, Callable[..., Any]]:
        return {**elementary(self.precision), **_NUMPY}

    def zero(self, node: Node) -> Any:
        """A number of the state before the first row."""
        if node.kind == "truth":
            return np.zeros(1, np.bool_)
        return np.zeros(1, self.precision.dtype)


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


def _absolute(x: Any) -> Any:
    return -x if x < 0.0 else x


def _both(a: Any, b: Any) -> Any:
    return a and b


def _either(a: Any, b: Any) -> Any:
    return a or b


def _chosen(condition: Any, yes: Any, no: Any) -> Any:
    return yes if condition else no


_python: Any = operator
_ON_NUMBERS: Mapping[str, Callable[..., Any]] = {
    "add": _python.add,
    "subtract": _python.sub,
    "multiply": _python.mul,
    "divide": _python.truediv,
    "negate": _python.neg,
    "absolute": _absolute,
    "less": _python.lt,
    "finite": math.isfinite,
    "both": _both,
    "either": _either,
    "opposite": _python.not_,
    "choose": _chosen,
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
    rows = max((np.shape(signal)[-1] for signal in inputs.values()), default=1)
    wanted = record.outputs if outputs is None else outputs
    run = _Run(record, inputs, arithmetic, rows, known=dict(given or {}))
    with np.errstate(all="ignore"):
        for part, cyclic in _parts(record, wanted, run.known):
            if not cyclic:
                (node,) = part
                if node not in run.known:
                    run.known[node] = run.value(node)
            elif not run.hold(part):  # all rows at once if the cycle only holds a value
                run.row_by_row(part)
    return [run.all_rows(node) for node in wanted]


#: How a node is computed (None: a delay), its place in a row, what takes its arguments out of a row, and the node.
_Step = tuple[Callable[..., Any] | None, int, Callable[[list[Any]], Sequence[Any]], Node]


@dataclass
class _Run:
    """A record on its way through some rows; `known` holds the nodes that have a value over all rows."""

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
            after = self.all_rows(self.record.after[str(node.value)])
            return _one_row_later(after, self.arithmetic.zero(node))
        if node.operation == "delay":
            delayed = self.all_rows(node.arguments[0])
            return delayed[..., self._rows_back(node)]

        arguments = [self.known[a] for a in node.arguments]
        if node.operation != "call":
            return self.arithmetic.apply(node, arguments)
        called = self.record.calls[str(node.value)]
        inputs = dict(zip(called.inputs(), arguments, strict=True))
        (output,) = evaluate(called, inputs, self.arithmetic)
        return output

    def all_rows(self, node: Node) -> AnyArray:
        """The known value of a node, shape (..., rows)."""
        value = self.known[node]
        return np.broadcast_to(value, (*np.shape(value)[:-1], self.rows))

    def _rows_back(self, node: Node) -> NDArray[np.int64]:
        """For each row the row that a delay reads: none ahead of the last row without one before it."""
        _, back = node.value  # rows
        has_one_before = self.all_rows(node.arguments[1])
        row = np.arange(self.rows)
        first = np.maximum.accumulate(np.where(has_one_before, 0, row))
        return np.maximum(row - back, first)

    def hold(self, part: Sequence[Node]) -> bool:
        """The nodes of a cycle that only keeps a value until another replaces it; whether it is such a cycle.

        Each node of such a cycle is in each row either the state as it was before, or a value from outside. So all
        rows are known at once: the state is the last value that came from outside.
        """
        inside = set(part)
        state = part[0]
        if state.operation != "state" or not all(_holds(node, inside) for node in part[1:]):
            return False
        zero = self.arithmetic.zero(state)
        nowhere = np.zeros(self.rows, np.bool_)
        everywhere = np.ones(self.rows, np.bool_)
        # Of each node the rows that keep the state, shape (rows,), and its value in all others.
        held: dict[Node, tuple[Any, Any]] = {state: (everywhere, zero)}

        def of(node: Node) -> tuple[Any, Any]:
            if node in inside:
                return held[node]
            return nowhere, self.all_rows(node)

        for node in part[1:]:
            if node.operation == "choose":
                condition, yes, no = node.arguments
                chosen = self.all_rows(condition)
                yes_kept, yes_value = of(yes)
                no_kept, no_value = of(no)
                held[node] = np.where(chosen, yes_kept, no_kept), np.where(chosen, yes_value, no_value)
            else:  # "either": a truth from outside makes it true, whatever the state
                within, outer = sorted(node.arguments, key=lambda a: a not in inside)
                kept, value = of(within)
                _, other = of(outer)
                held[node] = kept & ~other, value | other

        kept, value = held[self.record.after[str(state.value)]]
        values = np.broadcast_to(value, (*np.shape(zero)[:-1], self.rows))
        from_outside = np.where(kept, -1, np.arange(self.rows))
        last = np.maximum.accumulate(from_outside)  # row of the last value from outside; -1: none came yet
        after = np.where(last >= 0, values[..., last], zero)
        before = _one_row_later(after, zero)
        for node, (kept, value) in held.items():
            self.known[node] = np.where(kept, before, value)
        return True

    def row_by_row(self, part: Sequence[Node]) -> None:
        """The nodes of a cycle."""
        outer = {a for node in part for a in node.arguments if a not in part}
        states = [node for node in part if node.operation == "state"]
        after = [self.record.after[str(node.value)] for node in states]
        delayed = {node: self._rows_back(node).tolist() for node in part if node.operation == "delay"}

        # Calls are taken apart once, not in each row.
        places = {node: place for place, node in enumerate([*outer, *states])}
        steps: list[_Step] = []
        now: list[Any] = [None] * len(places)  # the values of the row, by place
        self._in_line(self.record, part, places, now, steps)

        before = [self.arithmetic.zero(node) for node in states]
        # Where all operations have them, the values of a row are numbers, else arrays of shape (..., 1).
        on_numbers = self.arithmetic.on_numbers
        in_numbers = all(np.ndim(self.known[node]) == 1 for node in outer)
        in_numbers &= all(function is None or node.operation in on_numbers for function, _, _, node in steps)
        if in_numbers:
            for at, (function, place, arguments, node) in enumerate(steps):
                steps[at] = (function and on_numbers[node.operation], place, arguments, node)
            now = [None if constant is None else constant[0] for constant in now]
            before = [zero[0] for zero in before]
        values: dict[Node, Sequence[Any]] = {}  # of each node from outside a value a row
        for node in outer:
            known = self.known[node]
            if np.shape(known)[-1] == 1:  # the same in all rows
                values[node] = [known[0] if in_numbers else known] * self.rows
            elif in_numbers:
                values[node] = list(known)
            else:
                values[node] = [known[..., row : row + 1] for row in range(self.rows)]

        outer_values = [(places[node], values[node]) for node in outer]
        state_places = [places[node] for node in states]
        after_places = [places[node] for node in after]
        all_of_part = _taker([places[node] for node in part])
        history: list[Sequence[Any]] = []  # of each row the values of the part
        place_in_part = {node: place for place, node in enumerate(part)}
        for row in range(self.rows):
            for place, of_rows in outer_values:
                now[place] = of_rows[row]
            for place, value in zip(state_places, before, strict=True):
                now[place] = value
            for function, place, arguments, node in steps:
                if function is not None:
                    now[place] = function(*arguments(now))
                    continue
                signal = node.arguments[0]
                row_back = delayed[node][row]
                if row_back == row:
                    now[place] = now[places[signal]]
                elif signal in values:
                    now[place] = values[signal][row_back]
                else:
                    now[place] = history[row_back][place_in_part[signal]]
            before = [now[place] for place in after_places]
            history.append(all_of_part(now))
        for node, of_rows in zip(part, zip(*history, strict=True), strict=True):
            self.known[node] = np.array(of_rows) if in_numbers else np.concatenate(of_rows, axis=-1)

    def _in_line(
        self,
        record: Record,
        nodes: Sequence[Node],
        places: dict[Node, int],
        now: list[Any],
        steps: list[_Step],
    ) -> None:
        """Give each node its place in a row, and append how it is computed there; of a call, how its inner nodes are.

        A called record has no state, so its constants are the same in all rows.
        """
        for node in nodes:
            if node in places:
                continue
            arguments = [places[a] for a in node.arguments]
            if node.operation == "call":
                called = record.calls[str(node.value)]
                inputs = [inner for inner in called.nodes if inner.operation == "input"]
                inside = dict(zip(inputs, arguments, strict=True))
                self._in_line(called, called.needed(), inside, now, steps)
                places[node] = inside[called.outputs[0]]
                continue
            places[node] = len(now)
            if node.operation == "constant":
                now.append(self.arithmetic.apply(node, ()))
            else:
                now.append(None)
                function = None if node.operation == "delay" else self.arithmetic.function_of(node)
                steps.append((function, places[node], _taker(arguments), node))


def _taker(places: Sequence[int]) -> Callable[[list[Any]], Sequence[Any]]:
    """What takes the values at some places out of a row: quicker than a loop over the places."""
    if len(places) == 1:
        (place,) = places
        return itemgetter(slice(place, place + 1))
    return itemgetter(*places)


def _one_row_later(values: AnyArray, zero: Any) -> AnyArray:
    """What each row knows of the row before, shape (..., rows); zero in the first."""
    first = np.broadcast_to(zero, (*values.shape[:-1], 1))
    return np.concatenate([first, values[..., :-1]], axis=-1)


def _holds(node: Node, inside: set[Node]) -> bool:
    """Whether an operation of a cycle passes a number of the state on, or puts a value from outside in its place."""
    within = [a in inside for a in node.arguments]
    if node.operation == "choose":
        return not within[0]
    return node.operation == "either" and within.count(True) == 1


def _parts(
    record: Record,
    outputs: Sequence[Node],
    known: Mapping[Node, Any],
) -> list[tuple[list[Node], bool]]:
    """The strongly connected parts in the order of computation, each with its nodes in theirs, and whether it loops.

    The record keeps them: a search asks for the same outputs many times.
    """
    asked = tuple(outputs), frozenset(known), tuple(record.after.items())
    if asked in record.orders:
        return record.orders[asked]

    def needs(node: Node) -> tuple[Node, ...]:
        if node in known:
            return ()
        if node.operation == "state":
            return (record.after[str(node.value)],)
        return node.arguments

    parts: list[tuple[list[Node], bool]] = []
    for component in _components(outputs, needs):
        part = sorted(component, key=lambda node: node.index)
        cyclic = len(part) > 1 or part[0] in needs(part[0])
        parts.append((part, cyclic))
    record.orders[asked] = parts
    return parts


def _components(roots: Sequence[Node], needs: Callable[[Node], Sequence[Node]]) -> list[list[Node]]:
    """Strongly connected parts of all that the roots need, each after what it needs (Tarjan, without recursion)."""
    place: dict[Node, int] = {}  # in the order of visits
    lowest: dict[Node, int] = {}  # place that can be reached from a node
    pending: dict[Node, None] = {}  # visited, in no part as yet
    parts: list[list[Node]] = []
    for root in roots:
        work = [] if root in place else [(root, iter(needs(root)))]
        while work:
            node, rest = work[-1]
            if node not in place:
                place[node] = len(place)
                lowest[node] = place[node]
                pending[node] = None

            unvisited: Node | None = None
            for other in rest:
                if other not in place:
                    unvisited = other
                    break
                if other in pending:
                    lowest[node] = min(lowest[node], place[other])
            if unvisited is not None:
                work.append((unvisited, iter(needs(unvisited))))
                continue

            work.pop()
            if work:
                above, _ = work[-1]
                lowest[above] = min(lowest[above], lowest[node])
            if lowest[node] == place[node]:  # nothing earlier can be reached: the part is complete
                part = [other for other in pending if place[other] >= place[node]]
                for other in part:
                    del pending[other]
                parts.append(part)
    return parts
