"""Stiffness beside the fluid adds a gain times the travel, the slip summed up since the start of the stretch.

::

    x_k = c x_{k-1} + w_k dt,   c = exp(-dt / tau_x),   column x

A leak with the time constant tau_x forgets what a sensor's zero would pile up; where the position is logged, take the
position itself as a further input.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.recursion import recur
from erclutch.models.laws.law import Dimension, Gain, ShapeParameter
from erclutch.models.stages.inertia import SMOOTH_INERTIA
from erclutch.models.stages.stage import Memory, Place, SlipAndStrength, StageFamily
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class Stiffness:
    """The stiffness as a stage on the slip."""

    name: str = "stiffness"
    title: str = "stiffness, with the travel from the slip"
    source: str = "Hooke's law"
    equation: str = "x' = w - x / tau_x"
    place: Place = "slip"
    switches: bool = False
    #: The travel is counted from the start of a stretch: within a window cut out of it, it would begin elsewhere.
    from_the_start: str = (
        "counts the travel from the start of each log: a log that starts at another position is off by the stiffness "
        "times the distance. Give the column of the position with --input, or log it where there is none"
    )
    unsettled: str = (
        "the spring: a slip that lasts has no travel that is known. Measured rows have one"
    )
    outputs: tuple[str, ...] = ("x",)
    gains: tuple[Gain, ...] = (
        Gain(
            "k",
            "stiffness beside the fluid",
            Dimension(
                effort=1,
                slip=-1,
                time=-1,
            ),
            nonnegative=False,
            negative="No spring pushes along with the travel. Where tau_x is at its lower end, it stands in for an "
            "inertia whose acceleration is too noisy: try a wider --window for speeds from positions.",
        ),
    )

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The time constant of the leak."""
        usual = (100.0 * period, 3e5 * period)
        meaning = "time after which the travel is forgotten"
        return (
            ShapeParameter(
                "tau_x", meaning, 10.0 * period, 1e7 * period, Dimension(time=1), "log", usual
            ),
        )

    def settled(self, signal: SlipAndStrength, q: Mapping[str, float]) -> tuple[Any, ...]:
        """The travel is counted from zero: a slip that lasts has none that is known."""
        return (0.0 * signal.slip,)

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """The travel."""
        return tuple(outputs)

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The travel over all rows; see `Stage`."""
        steps = clock.steps
        keep = np.exp(-steps / q[0])
        travel = recur(keep, signal.slip * steps, 0.0, clock)
        return [pick(travel, rows)]

    def initial(self, signal: SlipAndStrength, q: Mapping[str, float]) -> Mapping[str, Any]:
        """The travel starts at zero."""
        return {"travel": 0.0 * signal.slip}

    def step(
        self,
        memory: Memory,
        signal: SlipAndStrength,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row."""
        keep = memory.number(float(np.exp(-period / q["tau_x"])))
        travel = keep * memory.before("travel") + signal.slip * memory.number(period)
        return (memory.keep("travel", travel),)


STAGE = StageFamily(
    lambda count, forms: Stiffness(),
    ladder=("stiffness",),
    forgets="tau_x",
    instead=SMOOTH_INERTIA,
    of_travel=True,
)
