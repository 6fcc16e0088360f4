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
from erclutch.export.step_recording import StepRecord, StepRecording, parted
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
    made = described_step(model, options)
    step_record(made)
    return made


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
    made = StepRecording(step, remember=False, rest=True)
    e = step.elements
    inputs = [made.record.input(f"u{i}") for i in range(e, step.model_inputs)]
    outside, _, held = made.signals([], slips_of(step.device, inputs[:e]), inputs[e:])
    for x in held:
        made.record.give(x)
    made.record.give(outside)
    return made.record


def settled_record(step: ExportedStep) -> Record:
    """The record of the effort at rest from a signed field, and from slips and further inputs that are held."""
    made = StepRecording(step, remember=False, rest=True)
    record, count = made.record, step.elements + len(step.extras)
    signed, rest = record.input("field"), [record.input(f"w{i}") for i in range(count)]
    record.give(made.behind(parted(step, signed), rest[: step.elements], rest[step.elements :]))
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
    open_, seen = [record.outputs[0]], set[Node]()
    while open_:
        node = open_.pop()
        if node.operation == "input" and node.value == "field":
            return True
        seen.add(node)
        first_row_only = node.operation == "choose" and node.arguments[0] is going
        open_ += [a for a in (node.arguments[:2] if first_row_only else node.arguments) if a not in seen]
    return False
