"""The command passes two first-order lags in parallel: one part of the field follows quickly, the rest later.

::

    x_1' = (u - x_1) / tau_1,   x_2' = (u - x_2) / (m_1 tau_1),   field = p_1 x_1 + (1 - p_1) x_2

Eddy currents beside a coil, or chains that form after the particles have turned, answer in this way. A step is exact
for a command that is held over the sample.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.recursion import recur, step_of
from erclutch.models.laws.law import Dimension, ShapeParameter
from erclutch.models.stages.stage import Memory, Place, longest_lag
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class TwoLags:
    """The two lags as a stage."""

    name: str = "two-lags"
    title: str = "two first-order lags of the command in parallel"
    source: str = "first-order models of a coil and of its eddy currents; no publication of its own"
    equation: str = "tau_1 x_1' + x_1 = u, m_1 tau_1 x_2' + x_2 = u, E = p_1 x_1 + (1 - p_1) x_2"
    place: Place = "command"
    switches: bool = False

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The quick lag's time constant, how many times longer the slow lag takes, and the quick lag's share."""
        usual = (0.5 * period, 100.0 * period)
        return (
            ShapeParameter(
                "tau_1",
                "time constant of the quick lag",
                0.2 * period,
                longest_lag(period),
                Dimension(time=1),
                "log",
                usual,
            ),
            ShapeParameter(
                "m_1",
                "time constant of the slow lag over that of the quick lag",
                1.2,
                300.0,
                scale="log",
            ),
            ShapeParameter("p_1", "share of the quick lag", 0.0, 1.0),
        )

    def respond(
        self,
        signal: Any,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> Any:
        """The field in the fluid at some of the rows; see `Stage`."""
        tau, times, part = q
        step = step_of(clock)
        lagged: list[Any] = []
        for constant in (tau, times * tau):
            share = -np.expm1(-step / constant)
            lagged.append(recur(1.0 - share, share * signal, signal, clock))
        quick, slow = lagged
        return pick(part * quick + (1.0 - part) * slow, rows)

    def initial(self, signal: Any, q: Mapping[str, float]) -> Mapping[str, Any]:
        """Both have settled."""
        return {"quick": signal, "slow": signal}

    def step(
        self,
        memory: Memory,
        signal: Any,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any]:
        """One row."""
        tau, times, part = q.values()
        lagged: list[Any] = []
        for name, constant in (("quick", tau), ("slow", times * tau)):
            share = memory.number(-float(np.expm1(-period / constant)))
            state = (1.0 - share) * memory.before(name) + share * signal
            lagged.append(memory.keep(name, state))
        quick, slow = lagged
        return (memory.number(part) * quick + memory.number(1.0 - part) * slow,)


STAGE = TwoLags()
