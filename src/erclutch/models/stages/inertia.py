"""Inertia between the fluid and the load cell adds a gain times the acceleration, the backward difference of the slip.

::

    a_k = (w_k - w_{k-1}) / dt,   column a
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.arithmetic.recursion import starts_of
from erclutch.models.laws.law import Dimension, Gain, ShapeParameter
from erclutch.models.stages.stage import Memory, Place, SlipAndStrength, StageFamily
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class Inertia:
    """The inertia as a stage on the slip."""

    name: str = "inertia"
    title: str = "inertia, with the acceleration from the slip"
    source: str = "Newton's second law"
    equation: str = "a = w'"
    place: Place = "slip"
    switches: bool = False
    outputs: tuple[str, ...] = ("a",)
    gains: tuple[Gain, ...] = (
        Gain(
            "m",
            "inertia between fluid and load cell",
            Dimension(
                effort=1,
                slip=-1,
                time=1,
            ),
            nonnegative=False,
            negative="No mass is negative: this one stands for an effort that comes later than the slip (a filter, a "
            "delay or a soft mount on the sensor's side), or a mass whose push the sensor sees with the other sign. "
            "Compare the filters and the signs of both channels.",
        ),
    )

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """There are none: the inertia is a gain."""
        return ()

    def settled(self, signal: SlipAndStrength, q: Mapping[str, float]) -> tuple[Any, ...]:
        """No acceleration."""
        return (0.0 * signal.slip,)

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """The acceleration."""
        return tuple(outputs)

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The acceleration over all rows; see `Stage`."""
        slip: Any = signal.slip
        before: Any = slip.copy()
        before[1:] = slip[:-1]
        starts = starts_of(clock)
        before[starts] = slip[starts]
        return [((slip - before) / clock.steps)[rows]]

    def initial(self, signal: SlipAndStrength, q: Mapping[str, float]) -> Mapping[str, Any]:
        """Before the first row the slip was as in the first row."""
        return {"slip": signal.slip}

    def step(
        self,
        memory: Memory,
        signal: SlipAndStrength,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row."""
        before = memory.before("slip")
        memory.keep("slip", signal.slip)
        return ((signal.slip - before) / memory.number(period),)


STAGE = StageFamily(lambda count, forms: Inertia(), ladder=("inertia",))
