"""A record is evaluated on all rows at once; only what depends on its own past runs row by row.

The record is cut into its strongly connected parts. A node outside every cycle through the state is computed over all
rows together, a delay is a shift of rows, and the nodes of a cycle are computed one row after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.record import Node, Record
from erclutch.arithmetic.record_parts import parts_of
from erclutch.arithmetic.row_arithmetic import AnyArray, Arithmetic


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
        for part, cyclic in parts_of(record, wanted, run.known):
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
        if state.operation != "state":
            return False
        for node in part[1:]:
            # Each passes a number of the state on, or puts a value from outside in its place.
            within_cycle = [argument in inside for argument in node.arguments]
            if node.operation == "choose":
                holds = not within_cycle[0]
            else:
                holds = node.operation == "either" and within_cycle.count(True) == 1
            if not holds:
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
                held[node] = (
                    np.where(chosen, yes_kept, no_kept),
                    np.where(chosen, yes_value, no_value),
                )
            else:  # "either": a truth from outside makes it true, whatever the state
                within, outer = sorted(node.arguments, key=lambda a: a not in inside)
                kept, value = of(within)
                _, other = of(outer)
                held[node] = kept & ~other, value | other

        kept, value = held[self.record.after[str(state.value)]]
        values = np.broadcast_to(value, (*np.shape(zero)[:-1], self.rows))
        from_outside = np.where(kept, -1, np.arange(self.rows))
        last = np.maximum.accumulate(from_outside)  # row of that value; -1: none came yet
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
        delayed = {
            node: self._rows_back(node).tolist() for node in part if node.operation == "delay"
        }

        # Calls are taken apart once, not in each row.
        places = {node: place for place, node in enumerate([*outer, *states])}
        steps: list[_Step] = []
        now: list[Any] = [None] * len(places)  # the values of the row, by place
        self._in_line(self.record, part, places, now, steps)

        before = [self.arithmetic.zero(node) for node in states]
        # Where all operations have them, the values of a row are numbers, else arrays of shape (..., 1).
        on_numbers = self.arithmetic.on_numbers
        in_numbers = all(np.ndim(self.known[node]) == 1 for node in outer)
        in_numbers &= all(
            function is None or node.operation in on_numbers for function, _, _, node in steps
        )
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
