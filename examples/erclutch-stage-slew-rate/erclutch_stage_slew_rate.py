"""A limit to how fast the field changes: a current driver whose voltage is limited, before an inductance.

::

    x_k = x_{k-1} + clip(u_k - x_{k-1}, -R dt, R dt)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.recursion import follow
from erclutch.models.laws.law import Dimension, ShapeParameter
from erclutch.models.stages.stage import Memory, Place
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class SlewRate:
    """The stage."""

    name: str = "slew-rate"
    title: str = "limited rate of the command"
    source: str = "a current driver of limited voltage; any book on power electronics"
    equation: str = "E' = (u - E) / dt within -rate and rate"
    place: Place = "command"
    switches: bool = True

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """What a fit looks for: the rate, in units of the largest field a second."""
        return (
            ShapeParameter(
                "rate",
                "largest rate of the field",
                lower=1e-4 / period,
                upper=2.0 / period,
                dimension=Dimension(field=1, time=-1),
                scale="log",
                usual=(0.002 / period, 0.5 / period),
            ),
        )

    def initial(self, signal: Any, q: Mapping[str, float]) -> Mapping[str, Any]:
        """The field has settled at the first command."""
        return {"x": signal}

    def step(
        self, memory: Memory, signal: Any, q: Mapping[str, float], period: float
    ) -> tuple[Any]:
        """One row. The exported C is made from these lines."""
        most = memory.number(q["rate"]) * memory.number(period)
        (x,) = advance((memory.before("x"),), (signal, most))
        return (memory.keep("x", x),)

    def respond(self, signal: Any, clock: Clock, q: Sequence[Any], rows: slice) -> Any:
        """All rows at once, with derivatives, for fits."""
        (x,) = follow(advance, (signal,), (signal, q[0] * clock.steps), clock)
        return pick(x, rows)


def advance(before: tuple[Any, ...], given: tuple[Any, ...]) -> tuple[Any, ...]:
    """The field after a row, from the field before, the command and the largest change in a row."""
    x, most = before[0], given[1]
    change = given[0] - x
    change = less_select(change, most, change, most)
    return (x + less_select(-most, change, change, -most),)


STAGE = SlewRate()
