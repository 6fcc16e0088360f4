"""An oil damper has a knee in either direction: beyond it a blow-off valve is open, and the effort grows less steeply.

::

    f = max(w - w_f, 0),  b = min(w + w_b, 0),   columns f and b

Their gains are what the viscous effort per slip gains (or loses, where they are negative) beyond the forward knee w_f
and beyond the backward knee w_b. How steep the effort is below its knees, the law says, and `sides` where that differs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.arithmetic.elementary import less_select
from erclutch.models.laws.law import SLIP, Dimension, Gain, ShapeParameter
from erclutch.models.stages.stage import Place, RowByRow, SlipAndStrength, StageFamily

_STEEPNESS = Dimension(effort=1, slip=-1)


@dataclass(frozen=True)
class Knees(RowByRow):
    """The two knees as a stage."""

    name: str = "knees"
    title: str = "knees of the viscous effort, forward and backward"
    source: str = "Dixon 2007, The Shock Absorber Handbook, doi 10.1002/9780470516430"
    equation: str = "f = max(w - w_f, 0), b = min(w + w_b, 0)"
    place: Place = "slip"
    switches: bool = False
    outputs: tuple[str, ...] = ("f", "b")
    gains: tuple[Gain, ...] = (
        Gain(
            "eta_f",
            "viscous effort per slip, beyond the forward knee less below it",
            _STEEPNESS,
            nonnegative=False,
            part="viscous",
        ),
        Gain(
            "eta_b",
            "viscous effort per slip, beyond the backward knee less below it",
            _STEEPNESS,
            nonnegative=False,
            part="viscous",
        ),
    )

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The slips of the knees, over the root mean square of the slip: beyond thrice that there are few rows."""
        usual = (0.2, 2.0)
        return (
            ShapeParameter("w_f", "slip of the forward knee", 0.05, 3.0, SLIP, "log", usual),
            ShapeParameter("w_b", "slip of the backward knee", 0.05, 3.0, SLIP, "log", usual),
        )

    def outputs_at(self, signal: SlipAndStrength, *numbers: Any) -> tuple[Any, ...]:
        """How far the slip is beyond its forward knee, and beyond its backward knee; 0 on this side of it."""
        forward, backward = numbers
        past = signal.slip - forward
        short = signal.slip + backward
        return less_select(0.0, past, past, 0.0), less_select(short, 0.0, short, 0.0)

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """The slip beyond the knees, whatever the field."""
        return tuple(outputs)


STAGE = StageFamily(lambda count, forms: Knees(), ladder=("knees",), striking=0.05, two_ways=True)
