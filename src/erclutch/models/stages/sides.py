"""The two ways of the slip differ: a damper is softer in compression than in rebound, a disc drags more one way round.

::

    a = |w|,  d = |tanh(w / w_a)|,   columns a, d and y(E) d

Both are even in the slip, where a law is odd: their gains are half the difference between forward and backward, of the
viscous effort, of the friction and of the yield effort. Where the slip has one sign they say nothing that the law does
not say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.models.laws.law import EFFORT, SLIP, Dimension, Gain, ShapeParameter
from erclutch.models.laws.smooth import direction
from erclutch.models.stages.stage import Place, RowByRow, SlipAndStrength, StageFamily


@dataclass(frozen=True)
class Sides(RowByRow):
    """The difference between forward and backward as a stage."""

    name: str = "sides"
    title: str = "forward and backward slip apart"
    source: str = "rebound and compression of a damper; no publication of its own"
    equation: str = "a = |w|, d = |tanh(w / w_a)|"
    place: Place = "slip"
    switches: bool = False
    outputs: tuple[str, ...] = ("a", "d")
    gains: tuple[Gain, ...] = (
        Gain(
            "eta_a",
            "viscous effort per slip, forward beyond backward, halved",
            Dimension(effort=1, slip=-1),
            nonnegative=False,
            part="viscous",
        ),
        Gain(
            "T_a",
            "friction effort at zero field, forward beyond backward, halved",
            EFFORT,
            nonnegative=False,
        ),
        Gain(
            "T_ay",
            "yield effort at the reference field, forward beyond backward, halved",
            EFFORT,
            nonnegative=False,
            part="yield",
        ),
    )

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The slip over which the ways part."""
        return (
            ShapeParameter(
                "w_a", "slip over which forward and backward part", 1e-3, 3.0, SLIP, "log"
            ),
        )

    def outputs_at(self, signal: SlipAndStrength, *numbers: Any) -> tuple[Any, ...]:
        """The size of the slip, and how far it has left rest either way."""
        (turn,) = numbers
        return np.abs(signal.slip), np.abs(direction(signal.slip, turn))

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """The viscous one and that of the friction as they are, that of the yield effort with the field's strength."""
        size, way = outputs
        return size, way, strength * way


STAGE = StageFamily(lambda count, forms: Sides(), ladder=("sides",), two_ways=True)
