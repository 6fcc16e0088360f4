"""A device that slips under field warms, and its effort fades: the power of the slip behind a first-order lag.

::

    h' = (y(E) |w| - h) / tau_h,   f = min(h, 2),   column y(E) f tanh(w / 0.05);   /viscous has a column f w beside it

The power is that of the yield effort, over its value at the reference field and the reference slip. So a log needs no
temperature. A device begins cold in each log, and in a steady state that is asked for by itself. A fade of the power
itself needs no feedback: it is a little shorter a time constant.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.recursion import recur
from erclutch.models.laws.law import EFFORT, Dimension, Gain, ShapeParameter
from erclutch.models.laws.smooth import direction
from erclutch.models.stages.stage import Memory, Place, SlipAndStrength, StageFamily
from erclutch.signals.clock import Clock

#: Slip over which the fade turns its sign, as a share of the reference slip. What heats is far from rest, so no log
#: tells this number.
_TURN = 0.05
#: Of the reference power: beyond it the fade grows no more, so that a model does not turn its effort round in a heat
#: that no log had.
_HOTTEST = 2.0


@dataclass(frozen=True)
class SelfHeating:
    """The fade as a stage.

    Attributes:
        viscous: whether the viscous effort fades by a gain of its own.
    """

    viscous: bool = False
    source: str = "Newton's law of cooling"
    place: Place = "slip"
    switches: bool = False
    #: The heat is counted from the start of a log: within a window cut out of it, the device would begin cold.
    from_the_start: str = (
        "counts the heat from the start of each log: the effort of a log that starts warm fades earlier. Log the "
        "temperature and give it with --temperature"
    )

    @property
    def name(self) -> str:
        """Identifier."""
        return "self-heating/viscous" if self.viscous else "self-heating"

    @property
    def title(self) -> str:
        """Name for people."""
        which = "yield and viscous effort" if self.viscous else "yield effort"
        return f"{which} that fades with the heat of the slip"

    @property
    def equation(self) -> str:
        """See `Stage`."""
        viscous = ", g = min(h, 2) w" if self.viscous else ""
        return f"h' = (y(E) |w| - h) / tau_h, f = min(h, 2) tanh(w / 0.05){viscous}"

    @property
    def outputs(self) -> tuple[str, ...]:
        """Heat in the direction of the slip, and times the slip."""
        return ("f", "g") if self.viscous else ("f",)

    @property
    def gains(self) -> tuple[Gain, ...]:
        """Below zero where the effort fades."""
        of_yield = "yield effort at the reference field, hot by the reference power beyond cold"
        of_viscous = "viscous effort per slip, hot by the reference power beyond cold"
        gains = [Gain("T_h", of_yield, EFFORT, nonnegative=False, part="yield")]
        if self.viscous:
            per_slip = Dimension(effort=1, slip=-1)
            gains.append(Gain("eta_h", of_viscous, per_slip, nonnegative=False, part="viscous"))
        return tuple(gains)

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The time constant of the lag."""
        usual = (100.0 * period, 1e5 * period)
        meaning = "time constant with which the device warms"
        return (
            ShapeParameter(
                "tau_h", meaning, 10.0 * period, 1e7 * period, Dimension(time=1), "log", usual
            ),
        )

    def settled(self, signal: SlipAndStrength, q: Mapping[str, float]) -> tuple[Any, ...]:
        """A cold device: what a steady slip under a steady field would heat it to, no log may have shown."""
        return (0.0 * signal.slip,) * len(self.outputs)

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """That of the yield effort with the strength of the field, the viscous one as it is."""
        of_yield, *of_viscous = outputs
        return (strength * of_yield, *of_viscous)

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The heat over all rows; see `Stage`."""
        share = clock.steps / q[0]
        power = signal.strength * np.abs(signal.slip)
        heat = recur(np.exp(-share), power * share, 0.0, clock)
        return [pick(output, rows) for output in self._outputs(heat, signal.slip, _TURN, _HOTTEST)]

    def initial(self, signal: SlipAndStrength, q: Mapping[str, float]) -> Mapping[str, Any]:
        """The device starts cold."""
        return {"heat": 0.0 * signal.slip}

    def step(
        self,
        memory: Memory,
        signal: SlipAndStrength,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row."""
        share = period / q["tau_h"]
        keep = memory.number(float(np.exp(-share)))
        power = signal.strength * np.abs(signal.slip)
        heat = memory.keep("heat", keep * memory.before("heat") + power * memory.number(share))
        return self._outputs(heat, signal.slip, memory.number(_TURN), memory.number(_HOTTEST))

    def _outputs(self, heat: Any, slip: Any, turn: Any, hottest: Any) -> tuple[Any, ...]:
        """The fade of a heat."""
        fade = less_select(heat, hottest, heat, hottest)
        of_yield = fade * direction(slip, turn)
        return (of_yield, fade * slip) if self.viscous else (of_yield,)


STAGE = StageFamily(
    lambda count, forms: SelfHeating("viscous" in forms),
    forms=("viscous",),
    ladder=("self-heating", "self-heating/viscous"),
)
