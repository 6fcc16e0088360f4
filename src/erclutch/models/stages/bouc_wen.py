"""The Bouc-Wen stage remembers the slip by Bouc-Wen hysteresis with the exponent N.

::

    r z' = w - beta |w| |z|**(N-1) z - (1 - beta) w |z|**N,   columns z and y(E) z

The published form A w - beta |w| |z|**(N-1) z - gamma w |z|**N has scales that an effort cannot tell apart. Here z ends
at 1: beta and gamma add up to 1, and r is the published z_max / A with z_max = (A / (beta + gamma))**(1/N).
beta = 1/2 unloads along a straight line; with N = 1 and beta = 1 this is one Dahl state. There is no form with the
field ahead of the memory: z would end at the N-th root of the field's strength.

A step is linearly implicit and of second order in the travel, and z is held within -1 and 1. With beta of at least 1/2
and gains that are not negative the effort never gives back more than it stored while the field is constant.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.elementary import less_select, sign_of
from erclutch.arithmetic.recursion import Advance, follow
from erclutch.models.laws.law import ShapeParameter
from erclutch.models.stages.slip_memory import SlipMemory, travel
from erclutch.models.stages.stage import Memory, SlipAndStrength, StageFamily, numbered
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class BoucWen(SlipMemory):
    """The hysteresis as a stage.

    Attributes:
        exponent: N.
    """

    exponent: int = 1

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The travel, and the share of beta."""
        return (
            travel("r_b", "travel over which the hysteresis yields", period),
            ShapeParameter(
                "beta_b", "beta over beta + gamma", 0.5, 5.0, scale="log", usual=(0.55, 2.0)
            ),
        )

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The state over all rows; see `Stage`."""
        r, beta = q
        moved = (signal.slip * clock.steps) / r
        settled = (sign_of(signal.slip),)
        given = (moved, 2.0 * beta - 1.0)
        (z,) = follow(_advance(self.exponent), settled, given, clock)
        return [pick(z, rows)]

    def initial(self, signal: SlipAndStrength, q: Mapping[str, float]) -> Mapping[str, Any]:
        """The settled state."""
        return {"z": sign_of(signal.slip)}

    def step(
        self,
        memory: Memory,
        signal: SlipAndStrength,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row."""
        moved = (signal.slip * memory.number(period)) / memory.number(q["r_b"])
        given = (moved, memory.number(2.0 * q["beta_b"] - 1.0))
        before = (memory.before("z"),)
        (z,) = _advance(self.exponent)(before, given)
        return (memory.keep("z", z),)


@cache
def _advance(exponent: int) -> Advance:
    """The step for a travel over r, and for beta - gamma, which counts while the slip runs against the state."""

    def advance(before: tuple[Any, ...], given: tuple[Any, ...]) -> tuple[Any, ...]:
        z = before[0]
        moved = given[0]
        against = given[1]
        size = less_select(moved, 0.0, -moved, moved)
        pull = less_select(z * moved, 0.0, against, 1.0)
        for _ in range(exponent - 1):
            pull = pull * less_select(z, 0.0, -z, z)
        held_back = pull * size
        # Not z plus a change: so written each row takes from an error of z, also in a bound that adds magnitudes.
        kept = (0.5 * exponent - 1.0) * held_back + 1.0
        pulled = kept * z + moved
        after = pulled / ((0.5 * exponent) * held_back + 1.0)
        held = less_select(after, 1.0, after, 1.0)
        return (less_select(-1.0, held, held, -1.0),)

    return advance


def _bouc_wen(exponent: int, _: tuple[str, ...]) -> BoucWen:
    inner = {1: "", 2: "|b| "}.get(exponent, f"|b|^{exponent - 1} ")
    power = f"^{exponent}" if exponent > 1 else ""
    return BoucWen(
        name=numbered("bouc-wen", exponent),
        title=f"Bouc-Wen hysteresis with exponent {exponent}",
        source="Bouc 1967 and Wen 1976, doi 10.1061/JMCEA3.0002106",
        outputs=("b",),
        meanings=("effort of the hysteresis",),
        equation=f"r_b b' = w - beta_b |w| {inner}b - (1 - beta_b) w |b|{power}",
        exponent=exponent,
    )


STAGE = StageFamily(_bouc_wen, count=1)
