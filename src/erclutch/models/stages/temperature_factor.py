"""A stage on the temperature is a factor on a part of the fluid's effort, with one number and no state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from erclutch.models.laws.law import Part, ShapeParameter
from erclutch.models.stages.stage import Place, RowByRow


@dataclass(frozen=True)
class TemperatureFactor(RowByRow):
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

    def outputs_at(self, signal: Any, *numbers: Any) -> tuple[Any, ...]:
        """The factor."""
        return (self.factor(signal, *numbers),)
