"""Viscous effort is a power of the slip, without field and with it; it remembers nothing.

::

    v = sgn(w) |w|**p,   columns v and y(E) v

A law's own viscosity is constant in most cases. This stage lets it thin (p < 1) or thicken, and grow with the field.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.arithmetic.dual import pick
from erclutch.models.laws.law import EFFORT, Gain, ShapeParameter
from erclutch.models.laws.smooth import signed_power
from erclutch.models.stages.stage import Memory, Place, SlipAndStrength, StageFamily
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class Viscous:
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

    def settled(self, signal: SlipAndStrength, q: Mapping[str, float]) -> tuple[Any, ...]:
        """The power of the slip: nothing is remembered."""
        return (signed_power(signal.slip, q["p"]),)

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """The power of the slip, and that times the strength of the field."""
        with_field = [strength * output for output in outputs]
        return (*outputs, *with_field)

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The power of the slip; see `Stage`."""
        return [pick(signed_power(signal.slip, q[0]), rows)]

    def initial(self, signal: SlipAndStrength, q: Mapping[str, float]) -> Mapping[str, Any]:
        """There is no state."""
        return {}

    def step(
        self,
        memory: Memory,
        signal: SlipAndStrength,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row."""
        return (signed_power(signal.slip, q["p"]),)


STAGE = StageFamily(lambda count, forms: Viscous(), ladder=("viscous",))
