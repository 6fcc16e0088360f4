"""A recorded step is a value: its arithmetic, and which of its nodes are the inputs, the effort and the flags."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from erclutch.arithmetic.record import Node, Record


@dataclass(frozen=True)
class StepRecord:
    """One step, or the effort at rest.

    Attributes:
        record: its arithmetic; ``network`` nodes stand for the forward pass.
        inputs: the record's names of the step's inputs.
        effort: the result.
        flags: by bit, whether it is raised.
        value: the effort ahead of its limits.
        fields, slips, extras: signals within their windows, of each element.
        started: whether a good row has come, this one included.
    """

    record: Record
    inputs: tuple[str, ...]
    effort: Node
    flags: Mapping[int, Node]
    value: Node
    fields: tuple[Node, ...]
    slips: tuple[Node, ...]
    extras: tuple[Node, ...]
    started: Node

    @property
    def size(self) -> int:
        """Numbers of the state."""
        return len(self.record.after) + sum(self.record.registers().values())
