"""The effort passes a first-order lag: load cell, filter, or the structure between the fluid and the load cell.

::

    tau_e F' + F = F_fluid

The lag is linear and the same for all parts of the effort, so a fit puts it over each column. A step is exact for an
effort of the fluid that is held over the sample.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.recursion import recur, step_of
from erclutch.models.laws.law import Dimension, ShapeParameter
from erclutch.models.stages.stage import Memory, Place, StageFamily, longest_lag
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class EffortLag:
    """The lag as a stage."""

    name: str = "effort-lag"
    title: str = "first-order lag of the effort"
    source: str = "first-order model of a load cell and its filter; no publication of its own"
    equation: str = "tau_e T' + T = T_fluid"
    place: Place = "effort"
    switches: bool = False

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The time constant."""
        tau = ShapeParameter(
            "tau_e",
            "time constant of the effort's lag",
            lower=0.05 * period,
            upper=longest_lag(period),
            dimension=Dimension(time=1),
            scale="log",
            usual=(0.5 * period, 50.0 * period),
        )
        return (tau,)

    def respond(
        self,
        signal: Any,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> Any:
        """The lagged effort at some of the rows; see `Stage`."""
        share = -np.expm1(-step_of(clock) / q[0])
        return pick(recur(1.0 - share, share * signal, signal, clock), rows)

    def initial(self, signal: Any, q: Mapping[str, float]) -> Mapping[str, Any]:
        """The effort has settled."""
        return {"effort": signal}

    def step(
        self,
        memory: Memory,
        signal: Any,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any]:
        """One row."""
        share = memory.number(-float(np.expm1(-period / q["tau_e"])))
        lagged = (1.0 - share) * memory.before("effort") + share * signal
        return (memory.keep("effort", lagged),)


STAGE = StageFamily(lambda count, forms: EffortLag(), ladder=("effort-lag",))
