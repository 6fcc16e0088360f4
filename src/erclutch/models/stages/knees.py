"""An oil damper has a knee in either direction: beyond it a blow-off valve is open, and the effort grows less steeply.

::

    f = max(w - w_f, 0),  b = min(w + w_b, 0),   columns f and b

Their gains are what the viscous effort per slip gains (or loses, where they are negative) beyond the forward knee w_f
and beyond the backward knee w_b. How steep the effort is below its knees, the law says, and `sides` where that differs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.elementary import less_select
from erclutch.models.laws.law import SLIP, Dimension, Gain, ShapeParameter
from erclutch.models.stages.stage import Memory, Place, SlipAndStrength, StageFamily
from erclutch.signals.clock import Clock

_STEEPNESS = Dimension(effort=1, slip=-1)


@dataclass(frozen=True)
class Knees:
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

    def settled(self, signal: SlipAndStrength, q: Mapping[str, float]) -> tuple[Any, ...]:
        """The slip beyond the knees: nothing is remembered."""
        return _beyond(signal.slip, q["w_f"], q["w_b"])

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """The slip beyond the knees, whatever the field."""
        return tuple(outputs)

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The slip beyond the knees; see `Stage`."""
        return [pick(output, rows) for output in _beyond(signal.slip, *q)]

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
        return _beyond(signal.slip, memory.number(q["w_f"]), memory.number(q["w_b"]))


def _beyond(slip: Any, forward: Any, backward: Any) -> tuple[Any, Any]:
    """How far the slip is beyond its forward knee, and beyond its backward knee; 0 on this side of it."""
    past = slip - forward
    short = slip + backward
    return less_select(0.0, past, past, 0.0), less_select(short, 0.0, short, 0.0)


STAGE = StageFamily(lambda count, forms: Knees(), ladder=("knees",), striking=True)
