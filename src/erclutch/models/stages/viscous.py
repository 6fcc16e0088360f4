"""Viscous effort is a power of the slip, without field and with it; it remembers nothing.

::

    v = sgn(w) |w|**p,   columns v and y(E) v

A law's own viscosity is constant in most cases. This stage lets it thin (p < 1) or thicken, and grow with the field.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.models.laws.law import EFFORT, Gain, ShapeParameter
from erclutch.models.laws.smooth import signed_power
from erclutch.models.stages.stage import Place, RowByRow, SlipAndStrength, StageFamily


@dataclass(frozen=True)
class Viscous(RowByRow):
    """The power of the slip as a stage."""

    name: str = "viscous"
    title: str = "viscous effort as a power of the slip"
    source: str = "Ostwald 1925 and de Waele 1923, the power law of a fluid"
    equation: str = "v = sgn(w) |w|^p"
    place: Place = "slip"
    switches: bool = False
    outputs: tuple[str, ...] = ("v",)
    gains: tuple[Gain, ...] = (
        Gain("T_v", "viscous effort at the reference slip without field", EFFORT, part="viscous"),
        Gain(
            "T_vy",
            "viscous effort at the reference slip and field, that of the field",
            EFFORT,
            part="viscous",
        ),
    )

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The exponent."""
        return (ShapeParameter("p", "exponent of the slip in the viscous effort", 0.1, 2.5),)

    def outputs_at(self, signal: SlipAndStrength, *numbers: Any) -> tuple[Any, ...]:
        """The power of the slip."""
        (exponent,) = numbers
        return (signed_power(signal.slip, exponent),)

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """The power of the slip, and that times the strength of the field."""
        with_field = [strength * output for output in outputs]
        return (*outputs, *with_field)


STAGE = StageFamily(lambda count, forms: Viscous(), ladder=("viscous",))
