"""Stop operators after Prandtl and Ishlinskii are N springs, each in series with a slider of dry friction.

::

    s_k = clip(s_{k-1} + w dt / r_i, -1, 1)             stops-N:        columns s_i and y(E) s_i
    z_k = clip(z_{k-1} + y(E) w dt / r_i, -y(E), y(E))  stops-N/field:  columns z_i, the field in spring and slider

r_i is the travel from rest to yield. A step is exact for a slip that is held over the sample, and costs no exponential.
With gains that are not negative the effort never gives back more than it stored while the field is constant.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.recursion import follow
from erclutch.models.laws.law import ShapeParameter
from erclutch.models.stages.slip_memory import SlipMemory, travels
from erclutch.models.stages.stage import Memory, SlipAndStrength, StageFamily, numbered
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class Stops(SlipMemory):
    """Stop operators as a stage."""

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The travel of each stop; a scan looks for them in neighbouring parts of the usual range."""
        return travels("r_p{}", "travel over which stop {} yields", period, len(self.outputs))

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The states over all rows; see `Stage`."""
        moved, edge = self._given(signal, clock.steps)
        settled = (self.aim(signal),)
        states: list[Any] = []
        for r in q:
            (state,) = follow(_advance, settled, (moved / r, edge), clock)
            states.append(pick(state, rows))
        return states

    def _given(self, signal: SlipAndStrength, step: Any) -> tuple[Any, Any]:
        """Travel of a row, and where the states stop."""
        moved = signal.slip * step
        if self.ahead:
            return moved * signal.strength, signal.strength
        return moved, 1.0

    def step(
        self,
        memory: Memory,
        signal: SlipAndStrength,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row of each state."""
        moved, edge = self._given(signal, memory.number(period))
        states: list[Any] = []
        for name, r in zip(self.outputs, q.values(), strict=True):
            before = memory.before(name)
            (state,) = _advance((before,), (moved / memory.number(r), edge))
            states.append(memory.keep(name, state))
        return tuple(states)


def _advance(before: tuple[Any, ...], given: tuple[Any, ...]) -> tuple[Any, ...]:
    """The state after a row: it goes along with the slip until it stops at an edge."""
    moved = before[0] + given[0]
    edge = given[1]
    held = less_select(moved, edge, moved, edge)
    return (less_select(-edge, held, held, -edge),)


def _stops(count: int, forms: tuple[str, ...]) -> Stops:
    ahead = "field" in forms
    title = f"memory of the slip with {count} stop operator{'s' if count > 1 else ''}"
    letter = "p"
    pull = "w"
    edge = "-1 and 1"
    if ahead:
        title += ", the field ahead of the memory"
        letter = "q"
        pull = "y(E) w"
        edge = "-y(E) and y(E)"
    places = range(1, count + 1)
    equations = [f"r_p{i} {letter}{i}' = {pull}, {letter}{i} within {edge}" for i in places]
    return Stops(
        name=numbered("stops", count, ahead=ahead),
        title=title,
        source="Prandtl 1928 and Ishlinskii 1944; stop operators after Brokate and Sprekels 1996, "
        "doi 10.1007/978-1-4612-4048-8",
        outputs=tuple(f"{letter}{i}" for i in places),
        meanings=tuple(f"effort of stop {i}" for i in places),
        equation="; ".join(equations),
        ahead=ahead,
    )


STAGE = StageFamily(_stops, count=1, forms=("field",))
