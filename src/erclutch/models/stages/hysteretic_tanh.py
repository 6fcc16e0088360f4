"""In the hysteretic tanh the sign of the slip turns early or late by the travel.

::

    z = tanh((w + x / t_w) / w_t),   x_k = c x_{k-1} + w_k dt,   c = exp(-dt / tau_m),   columns z and y(E) z

Kwok and others write tanh(beta w + delta sgn(x)). The travel x itself, in place of its sign, is the form of Gavin,
Hoagg and Dobossy 2001: it has no jump where the position passes its middle. The leak tau_m stands for the middle
position, which a slip does not tell.

At a constant field and without leak the effort is a spring plus what resists the slip, so it is dissipative. The field
cannot enter ahead of the memory, as the memory is of the travel alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.recursion import recur
from erclutch.models.laws.law import SLIP, Dimension, ShapeParameter
from erclutch.models.stages.slip_memory import SlipMemory
from erclutch.models.stages.stage import Memory, SlipAndStrength
from erclutch.signals.clock import Clock

_TIME = Dimension(time=1)


@dataclass(frozen=True)
class HystereticTanh(SlipMemory):
    """The hysteretic tanh as a stage."""

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The slip of the transition, the time that weighs travel against slip, and the time of the leak."""
        turn = "slip over which the sign of the memory turns"
        weight = "travel over slip of equal weight"
        leak = "time after which the travel is forgotten"
        usual_weight = (3.0 * period, 1000.0 * period)
        usual_leak = (100.0 * period, 1e4 * period)
        return (
            ShapeParameter("w_t", turn, 1e-3, 3.0, SLIP, "log", (0.02, 1.0)),
            ShapeParameter("t_w", weight, 0.1 * period, 1e5 * period, _TIME, "log", usual_weight),
            ShapeParameter("tau_m", leak, 10.0 * period, 1e6 * period, _TIME, "log", usual_leak),
        )

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The output over all rows; see `Stage`."""
        w_t, t_w, tau_m = q
        steps = clock.steps
        keep = np.exp(-steps / tau_m)
        x = recur(keep, signal.slip * steps, 0.0, clock)
        turned = self._turned(signal.slip, x, w_t, t_w)
        return [pick(turned, rows)]

    @staticmethod
    def _turned(slip: Any, x: Any, w_t: Any, t_w: Any) -> Any:
        return np.tanh((slip + x / t_w) / w_t)

    def settled(self, signal: SlipAndStrength, q: Mapping[str, float]) -> tuple[Any, ...]:
        """The travel is counted from zero: a slip that lasts has none that is known."""
        return (np.tanh(signal.slip / q["w_t"]),)

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
        keep = memory.number(float(np.exp(-period / q["tau_m"])))
        travelled = keep * memory.before("travel") + signal.slip * memory.number(period)
        x = memory.keep("travel", travelled)
        w_t = memory.number(q["w_t"])
        t_w = memory.number(q["t_w"])
        return (self._turned(signal.slip, x, w_t, t_w),)


STAGE = HystereticTanh(
    name="hysteretic-tanh",
    title="hysteretic tanh",
    source="Kwok et al. 2006, doi 10.1016/j.sna.2006.03.015, with the travel as in Gavin et al. 2001",
    outputs=("t",),
    meanings=("effort of the hysteretic tanh",),
    equation="t = tanh((w + x / t_w) / w_t), x' = w - x / tau_m",
    switches=False,
)
