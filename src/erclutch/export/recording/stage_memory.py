"""While a step is recorded, a stage's memory turns into numbers of the exported step's state."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from erclutch.arithmetic.record import Record
from erclutch.models.stages.stage import Stage


def suffix_of(stage: Stage, element: str) -> str:
    """What ends the names of a stage's numbers in the state: of an element, or "" of the device."""
    return "_" + re.sub(r"[^A-Za-z0-9_]", "_", f"{stage.name}{element}")


def _finite(value: Any) -> Any:
    """A number of the state; 0 where it is not finite, so that no input can leave the state without a number."""
    record = value.owner
    return record.choose(record.label(record.finite(value), "is_finite"), value, 0.0)


def kept(value: Any) -> Any:
    """A number as the state keeps it: 0 where it is not finite."""
    return value.owner.call("kept", _finite, value=value)


@dataclass
class StageMemory:
    """The memory of a stage while its step is recorded.

    Attributes:
        record: what is recorded into.
        going: whether there was a row before.
        suffix: of every name, that of the element.
        initial: the state in the first row.
        earlier: a signal some rows back, by its name.
    """

    record: Record
    going: Any
    suffix: str
    initial: Mapping[str, Any]
    earlier: Callable[[str, Any, int], Any]

    def before(self, name: str) -> Any:
        """The value of a number after the row before; in the first row the initial one."""
        state = self.record.state(name + self.suffix)
        return self.record.choose(self.going, state, self.initial[name])

    def keep(self, name: str, value: Any) -> Any:
        """Set a number for the next row, and give the value that is kept."""
        going_on = self.record.choose(self.going, value, self.initial[name])
        number = kept(going_on)
        self.record.keep(name + self.suffix, number)
        return self.record.label(number, name + self.suffix)

    def back(self, name: str, value: Any, rows: int) -> Any:
        """A signal so many rows back."""
        if rows == 0:
            return value
        return self.earlier(name + self.suffix, kept(value), rows)

    def number(self, value: float) -> Any:
        """A constant."""
        return self.record.operand("constant", value=float(value))
