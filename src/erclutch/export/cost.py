"""What a step costs, counted from its record: operations, and bytes of state."""

from __future__ import annotations

from collections import Counter

from erclutch.arithmetic.record import FUNCTIONS, Record, traced
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_record import step_record
from erclutch.models.networks.network_model import NetworkModel

_GROUPS = {
    "add": "additions",
    "subtract": "additions",
    "negate": "additions",
    "multiply": "multiplications",
    "divide": "divisions",
    "choose": "selections",
    "less": "comparisons",
    "finite": "comparisons",
    "table": "look-ups",
}
_FROM_BITS = ("real_of_bits", "real_from_bits")


def operations(record: Record, step: ExportedStep) -> Counter[str]:
    """Operations of a record, those inside functions and calls too."""
    total: Counter[str] = Counter()
    for node in record.needed():
        if node.operation in FUNCTIONS:
            total += operations(traced(node.operation, step.precision), step)
        elif node.operation == "call":
            total += operations(record.calls[node.value], step)
        elif node.operation == "network" and step.network is not None:
            total += _of_network(step.network, step)
        elif node.operation in _GROUPS:
            total[_GROUPS[node.operation]] += 1
        elif node.kind == "bits" or node.operation in _FROM_BITS:
            total["shifts and the like"] += 1
    return total


def _of_network(model: NetworkModel, step: ExportedStep) -> Counter[str]:
    """Operations of a network's forward pass: of its inputs, of each layer, and of the four sums at its end."""
    total: Counter[str] = Counter()
    inputs = len(model.structure.inputs)
    hidden = model.structure.hidden
    radial = model.structure.kind == "rbfn"
    total["additions"] += inputs + hidden[-1] + 4
    total["multiplications"] += hidden[-1]
    activation = operations(traced("exp" if radial else "tanh", step.precision), step)
    for before, after in zip((inputs, *hidden), hidden, strict=False):
        weights = before * after
        total["additions"] += weights * (2 if radial else 1)
        total["multiplications"] += weights
        for group, count in activation.items():
            total[group] += count * after
    if radial:
        total["multiplications"] += hidden[0]
        total["divisions"] += inputs + hidden[0]
    return total


def state_bytes(step: ExportedStep) -> int:
    """Size of the state, without what the compiler pads."""
    record = step_record(step).record
    registers = record.registers()
    truths = sum(node.kind == "truth" for node in record.after.values())
    reals = len(record.after) - truths + sum(registers.values())
    lengths = len(set(registers.values()))
    words = truths + lengths + 1  # the last one says whether the arithmetic is exact
    return reals * step.precision.width // 8 + 4 * words


def cost_text(step: ExportedStep) -> list[str]:
    """Lines of the header."""
    counts = operations(step_record(step).record.flat(), step)
    counted = ", ".join(f"{count} {group}" for group, count in sorted(counts.items()))
    return [f"A step is about: {counted}.", f"State: {state_bytes(step)} bytes and padding."]
