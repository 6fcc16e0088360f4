"""A record is cut into its strongly connected parts: nodes outside every cycle through the state, and the cycles."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from erclutch.arithmetic.record import Node, Record


def parts_of(
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
