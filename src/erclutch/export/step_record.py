"""The whole step, recorded once; every target, the test vectors, the error bound and the cost come from this record.

Beside it stand the records of the effort at rest, of the inverse and of the next step.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from erclutch.arithmetic.record import Node, Record
from erclutch.export.exported_step import (
    ExportedStep,
    ExportOptions,
    described_step,
)
from erclutch.export.recording.recorded_step import StepRecord
from erclutch.export.recording.step_recording import StepRecording, parted
from erclutch.signals.device import slips_of


def has_memory(step: ExportedStep) -> bool:
    """Whether the effort depends on earlier rows (other than in place of a bad one)."""
    return bool(step.stages or step.model.past or step.filter)


def feels_state(step: ExportedStep) -> bool:
    """Whether the effort of the next step depends on the state: on earlier rows, or on the switch of a network."""
    return has_memory(step) or step.model.correction is not None


def step_of(model: Any, options: ExportOptions | None = None) -> ExportedStep:
    """The step of a model for export; its arithmetic can be recorded.

    Raises:
        ExportError: no model of erclutch, numbers that are not finite, an option or an equation that does not fit.
    """
    step = described_step(model, options)
    step_record(step)  # an equation that has no C is refused here
    return step


@lru_cache(maxsize=16)
def step_record(step: ExportedStep, *, remember: bool = True) -> StepRecord:
    """The record of a step.

    Args:
        step: what to record.
        remember: keep the last good row to stand in for a bad one; without it, and only for a model without memory,
            there is no state, and the effort of a bad row is 0.
    """
    return StepRecording(step, remember or has_memory(step)).whole()


def rest_record(step: ExportedStep) -> StepRecord:
    """The record of the effort at rest: no state, speeds come in."""
    return StepRecording(step, remember=False, rest=True).whole()


def search_record(step: ExportedStep) -> Record:
    """The record that the inverse begins with: from speeds and further inputs to their held values and a truth.

    The inputs are u0, u1, ... of the step without the fields; the outputs are slips, further inputs, and whether one
    of them lies outside.
    """
    recording = StepRecording(step, remember=False, rest=True)
    record = recording.record
    elements = step.elements
    inputs = [record.input(f"u{i}") for i in range(elements, step.model_inputs)]
    speeds = inputs[:elements]
    extras = inputs[elements:]
    outside, _, held = recording.signals([], slips_of(step.device, speeds), extras)
    for signal in held:
        # It is finite. A proof of the C must see that where the signal says a place in a table.
        finite = step.model.gives_way is None or record.finite(signal)
        record.give(record.choose(finite, signal, 0.0))
    record.give(outside)
    return record


def settled_record(step: ExportedStep) -> Record:
    """The record of the effort at rest from a signed field, and from slips and further inputs that are held."""
    recording = StepRecording(step, remember=False, rest=True)
    record = recording.record
    elements = step.elements
    signed = record.input("field")
    held = [record.input(f"w{i}") for i in range(elements + len(step.extras))]
    slips = held[:elements]
    extras = held[elements:]
    record.give(recording.behind(parted(step, signed), slips, extras))
    return record


def next_record(step: ExportedStep) -> Record:
    """The record of the next step's effort ahead of its limits, with the state as it is: nothing is kept.

    The inputs are a signed field and u0, u1, ... of the step without its fields; all of them are finite.
    """
    return StepRecording(step, remember=True, ahead=True).next_effort()


def feels_next_field(step: ExportedStep) -> bool:
    """Whether the effort of a step depends on the field of the same step; a dead time of a row or more cuts it off."""
    if not feels_state(step):
        return True
    record = next_record(step)
    going = record.state("started", kind="truth").node
    pending = [record.outputs[0]]
    seen: set[Node] = set()
    while pending:
        node = pending.pop()
        if node.operation == "input" and node.value == "field":
            return True
        seen.add(node)
        needs = node.arguments
        if node.operation == "choose" and needs[0] is going:
            needs = needs[:2]  # the third stands in the first row only
        pending += [argument for argument in needs if argument not in seen]
    return False
