"""Dahl's memory has N states that follow the slip and saturate at its sign.

::

    s_i' = (w - |w| s_i) / r_i            dahl-N:        columns s_i and y(E) s_i
    z_i' = (y(E) w - |w| z_i) / r_i       dahl-N/field:  columns z_i, the field enters ahead of the memory

r_i is the travel that it takes to yield. A step is exact for a slip that is held over the sample, and costs one
exponential a state: with g = 1 - exp(-|w| dt / r), s_k = (1 - g) s_{k-1} + g sgn w.

With gains that are not negative the effort never gives back more than it stored while the field is constant, because
s w = (r s**2 / 2)' + |w| s**2. A field that changes while a state is stretched may add energy, which the supply pays
for: y(E) s when the field grows, z when the field falls, as it stores r z**2 / (2 y).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.recursion import recur, step_of
from erclutch.models.laws.law import EFFORT, Gain, ShapeParameter
from erclutch.models.stages.slip_memory import SlipMemory, travels
from erclutch.models.stages.stage import Memory, SlipAndStrength, StageFamily, numbered
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class Dahl(SlipMemory):
    """Dahl states as a stage."""

    @property
    def gains(self) -> tuple[Gain, ...]:
        """Effort of each state, without field and with it."""
        gains: list[Gain] = []
        places = range(1, len(self.outputs) + 1)
        if not self.ahead:
            for i in places:
                gains.append(Gain(f"T_s{i}", f"effort of memory {i} without field", EFFORT))
        for i in places:
            gains.append(
                Gain(
                    f"T_z{i}", f"effort of memory {i} at the reference field", EFFORT, part="yield"
                )
            )
        return tuple(gains)

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The travel of each state; a scan looks for them in neighbouring parts of the usual range."""
        return travels("r_{}", "travel over which memory {} yields", period, len(self.outputs))

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The states over all rows; see `Stage`."""
        aim = self.aim(signal)
        moved = np.abs(signal.slip) * step_of(clock)
        states: list[Any] = []
        for r in q:
            gone = -np.expm1(-(moved / r))
            state = recur(1.0 - gone, aim * gone, aim, clock)
            states.append(pick(state, rows))
        return states

    def step(
        self,
        memory: Memory,
        signal: SlipAndStrength,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row of each state."""
        aim = self.aim(signal)
        moved = np.abs(signal.slip) * memory.number(period)
        gone = [-np.expm1(-(moved / memory.number(r))) for r in q.values()]
        states: list[Any] = []
        for name, share in zip(self.outputs, gone, strict=True):
            state = (1.0 - share) * memory.before(name) + aim * share
            states.append(memory.keep(name, state))
        return tuple(states)


def _dahl(count: int, forms: tuple[str, ...]) -> Dahl:
    ahead = "field" in forms
    title = f"memory of the slip with {count} Dahl state{'s' if count > 1 else ''}"
    letter = "s"
    pull = "w"
    if ahead:
        title += ", the field ahead of the memory"
        letter = "z"
        pull = "y(E) w"
    places = range(1, count + 1)
    equations = [f"r_{i} {letter}{i}' = {pull} - |w| {letter}{i}" for i in places]
    return Dahl(
        name=numbered("dahl", count, ahead=ahead),
        title=title,
        source="Dahl 1968, a solid friction model; with N states Al-Bender et al. 2005, doi 10.1109/TAC.2005.858676",
        outputs=tuple(f"{letter}{i}" for i in places),
        meanings=tuple(f"effort of memory {i}" for i in places),
        equation=", ".join(equations),
        ahead=ahead,
    )


STAGE = StageFamily(
    _dahl,
    count=1,
    forms=("field",),
    ladder=("dahl/field", "dahl-2/field"),
    behind=("dahl", "dahl-2"),
)
