"""What a step costs, counted from what it does: operations, and bytes of state and tables."""

from __future__ import annotations

from collections import Counter

from erclutch.export.graph import FUNCTIONS, Graph, traced
from erclutch.export.program import Program
from erclutch.networks.model import NetworkModel
from erclutch.precision import Precision

_GROUPS = {
    "add": "additions",
    "subtract": "additions",
    "negate": "additions",
    "multiply": "multiplications",
    "divide": "divisions",
    "less_select": "selections",
}


def operations(graph: Graph, precision: Precision) -> Counter[str]:
    """Operations of a record, those inside functions too."""
    total: Counter[str] = Counter()
    for node in graph.needed():
        if node.operation in FUNCTIONS:
            total += operations(traced(node.operation, precision), precision)
        elif node.operation in _GROUPS:
            total[_GROUPS[node.operation]] += 1
        elif node.operation not in ("input", "constant"):
            total["shifts and the like"] += 1
    return total


def cost(program: Program) -> Counter[str]:
    """Operations of the command and the effort of one step."""
    total: Counter[str] = Counter()
    for _ in range(program.elements):
        total += operations(program.command, program.precision)
    if program.law is not None:
        return total + operations(program.law, program.precision)
    model = program.model
    assert isinstance(model, NetworkModel)
    inputs, hidden = len(model.structure.inputs), model.structure.hidden
    total["additions"] += inputs + hidden[-1] + 5
    total["divisions"] += inputs
    total["multiplications"] += hidden[-1] + 1
    name = "exp" if model.structure.kind == "rbfn" else "tanh"
    each = operations(traced(name, program.precision), program.precision)
    for before, after in zip((inputs, *hidden), hidden, strict=False):
        total["additions"] += before * after * (2 if name == "exp" else 1)
        total["multiplications"] += before * after
        for group, count in each.items():
            total[group] += count * after
    if name == "exp":
        total["multiplications"] += hidden[0]
        total["divisions"] += hidden[0]
    return total


def state_bytes(program: Program) -> int:
    """Size of the state, without what the compiler pads."""
    e = program.elements
    numbers, words = len(program.inputs) + 1, 1
    if program.filter:
        numbers += 2 * e
    if program.lag:
        numbers, words = numbers + e * (1 + 2 * program.lag.rows), words + 1
    if program.past:
        numbers, words = numbers + program.rows_back * len(program.base), words + 1
    words += 1 if program.lag or program.past else 0
    return numbers * program.precision.width // 8 + 4 * words


def cost_text(program: Program) -> list[str]:
    """Lines of the header."""
    counted = ", ".join(f"{count} {group}" for group, count in sorted(cost(program).items()))
    return [f"A step is about: {counted}.", f"State: {state_bytes(program)} bytes and padding."]
