"""A stage on the temperature is a factor on a part of the fluid's effort, with one number and no state."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.arithmetic.dual import pick
from erclutch.models.laws.law import Part, ShapeParameter
from erclutch.models.stages.stage import Memory, Place
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class TemperatureFactor:
    """The factor as a stage.

    Attributes:
        name, title, source, equation: see `Stage`.
        part: which effort of the fluid the factor multiplies.
        shape: the number.
        factor: ``factor(t, number)`` for a temperature over that of reference, 1 at t = 1; elementwise on any operand.
    """

    name: str
    title: str
    source: str
    equation: str
    part: Part
    shape: ShapeParameter
    factor: Callable[[Any, Any], Any]
    place: Place = "temperature"
    switches: bool = False

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The number of the factor."""
        return (self.shape,)

    def respond(
        self,
        signal: Any,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> Any:
        """The factor over all rows; see `Stage`."""
        return pick(self.factor(signal, q[0]), rows)

    def initial(self, signal: Any, q: Mapping[str, float]) -> Mapping[str, Any]:
        """There is no state."""
        return {}

    def step(
        self,
        memory: Memory,
        signal: Any,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row."""
        return (self.factor(signal, *q.values()),)
