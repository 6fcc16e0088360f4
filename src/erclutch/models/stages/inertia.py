"""Inertia between the fluid and the load cell adds a gain times the acceleration, the backward difference of the slip.

::

    inertia:         a_k = (w_k - w_{k-1}) / dt,   column a
    inertia/smooth:  tau_a b' + b = a,             column b

A speed made of an encoder's positions is noisy, and its difference is noise alone. The smooth form passes the
difference through a first-order low-pass: the fit weighs the noise that goes against the delay that comes. A step is
exact for an acceleration that is held over the sample.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.recursion import recur, starts_of
from erclutch.models.laws.law import Dimension, Gain, ShapeParameter
from erclutch.models.stages.stage import Memory, Place, SlipAndStrength, StageFamily
from erclutch.signals.clock import Clock

_SMOOTH = "smooth"
#: The stage with the low-pass, by its name.
SMOOTH_INERTIA = f"inertia/{_SMOOTH}"


@dataclass(frozen=True)
class Inertia:
    """The inertia as a stage on the slip.

    Attributes:
        smooth: the acceleration passes a low-pass.
    """

    name: str
    title: str
    equation: str
    smooth: bool
    outputs: tuple[str, ...]
    source: str = "Newton's second law"
    place: Place = "slip"
    switches: bool = False
    gains: tuple[Gain, ...] = (
        Gain(
            "m_a",
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
        """The time constant of the low-pass; without it none, since the inertia is a gain."""
        if not self.smooth:
            return ()
        tau = ShapeParameter(
            "tau_a",
            "time constant of the low-pass of the acceleration",
            lower=0.2 * period,
            upper=100.0 * period,
            dimension=Dimension(time=1),
            scale="log",
            usual=(0.5 * period, 20.0 * period),
        )
        return (tau,)

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
        acceleration = (slip - before) / clock.steps
        if self.smooth:
            share = -np.expm1(-clock.steps / q[0])
            acceleration = recur(1.0 - share, share * acceleration, 0.0, clock)
        return [pick(acceleration, rows)]

    def initial(self, signal: SlipAndStrength, q: Mapping[str, float]) -> Mapping[str, Any]:
        """Before the first row the slip was as in the first row."""
        if self.smooth:
            return {"slip": signal.slip, "acceleration": 0.0 * signal.slip}
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
        acceleration = (signal.slip - before) / memory.number(period)
        if not self.smooth:
            return (acceleration,)
        share = memory.number(-float(np.expm1(-period / q["tau_a"])))
        smoothed = (1.0 - share) * memory.before("acceleration") + share * acceleration
        return (memory.keep("acceleration", smoothed),)


def _inertia(_: int, forms: tuple[str, ...]) -> Inertia:
    if _SMOOTH not in forms:
        return Inertia(
            name="inertia",
            title="inertia, with the acceleration from the slip",
            equation="a = w'",
            smooth=False,
            outputs=("a",),
        )
    return Inertia(
        name=SMOOTH_INERTIA,
        title="inertia, with the acceleration from the slip behind a low-pass",
        equation="tau_a b' + b = w'",
        smooth=True,
        outputs=("b",),
    )


STAGE = StageFamily(
    _inertia,
    forms=(_SMOOTH,),
    ladder=("inertia", SMOOTH_INERTIA),
)
