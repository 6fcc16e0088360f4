"""LuGre friction has bristles that bend with the slip, yield over a travel, and slip at a falling effort.

::

    s' = (w - |w| s / g(w)) / r,   g(w) = 1 + (h - 1) exp(-(w / w_l)**2)
    lugre:        columns s, y(E) s, d and y(E) d with d = w - |w| s / g(w)
    lugre/field:  s' = (y(E) w - |w| s / g(w)) / r and d = y(E) w - |w| s / g(w), columns s and d
    lugre/sides, lugre/field/sides:  the same with g(w) (1 + a sgn w) in place of g(w)

The published form has a deflection z, a stiffness sigma_0, a damping sigma_1, and efforts F_C (Coulomb) and F_S
(static): s = sigma_0 z / F_C, r = F_C / sigma_0, h = F_S / F_C; the gain of s is F_C, and the gain of d is
sigma_1. Its viscous part sigma_2 w is the law's. A step is exact for a slip that is held over the sample.

With h = 1 and no damping this is one Dahl state. It is dissipative at a constant field while the damping is small:
sigma_1 below 4 F_C times the least of g(w) / |w|, with which s w = (r s**2 / 2)' + |w| s**2 / g pays for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.elementary import sign_of
from erclutch.arithmetic.recursion import recur
from erclutch.models.laws.law import SLIP, ShapeParameter
from erclutch.models.stages.slip_memory import SlipMemory, travel
from erclutch.models.stages.stage import Memory, SlipAndStrength, StageFamily
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class LuGre(SlipMemory):
    """LuGre friction as a stage.

    Attributes:
        sided: whether bristles hold more one way than the other.
    """

    takes_places: bool = True  # see `CommandLag`
    sided: bool = False

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The travel of the bristles, the static effort, the slip at which it has fallen, and how the ways differ."""
        of_both_ways = (
            travel("r_l", "travel over which the bristles yield", period),
            ShapeParameter(
                "h_l",
                "static effort over that at high slip",
                0.2,
                5.0,
                scale="log",
                usual=(0.7, 2.0),
            ),
            ShapeParameter(
                "w_l",
                "slip over which the static effort fades",
                1e-3,
                3.0,
                SLIP,
                "log",
                (0.01, 1.0),
            ),
        )
        if not self.sided:
            return of_both_ways
        share = "share by which the bristles hold more forward, and less backward"
        ways = ShapeParameter("a_l", share, -0.8, 0.8, usual=(-0.15, 0.15))
        return (*of_both_ways, ways)

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice | NDArray[np.intp],
    ) -> list[Any]:
        """Deflection and its rate over all rows; see `Stage`."""
        aim, most, gone = self._row(signal, clock.steps, *q)
        end = aim * most
        s = pick(recur(1.0 - gone, end * gone, end, clock), rows)
        moved = SlipAndStrength(pick(signal.slip, rows), signal.strength)
        return [s, self._rate(moved, pick(aim, rows), s, pick(most, rows))]

    def _row(
        self,
        signal: SlipAndStrength,
        step: Any,
        r: Any,
        h: Any,
        w_l: Any,
        a: Any = 0.0,
    ) -> tuple[Any, Any, Any]:
        """The way of the slip with the field's strength, g, and the share of the way that a row goes."""
        way = sign_of(signal.slip)
        ratio = signal.slip / w_l
        most = (h - 1.0) * np.exp(-(ratio * ratio)) + 1.0
        if self.sided:
            most = most * (1.0 + a * way)
        aim = way * signal.strength if self.ahead else way
        travelled = (np.abs(signal.slip) * step) / (r * most)
        gone = -np.expm1(-travelled)
        return aim, most, gone

    @staticmethod
    def _rate(signal: SlipAndStrength, aim: Any, s: Any, most: Any) -> Any:
        """The rate d of the deflection times the travel r: a slip."""
        return np.abs(signal.slip) * (aim - s / most)

    def settled(self, signal: SlipAndStrength, q: Mapping[str, float]) -> tuple[Any, ...]:
        """The bristles have yielded in the way of the slip, and bend no further."""
        aim, most, _ = self._row(signal, 0.0, *q.values())
        s = aim * most
        return s, self._rate(signal, aim, s, most)

    def initial(self, signal: SlipAndStrength, q: Mapping[str, float]) -> Mapping[str, Any]:
        """The settled deflection."""
        return {"s": self.settled(signal, q)[0]}

    def step(
        self,
        memory: Memory,
        signal: SlipAndStrength,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row."""
        aim, most, gone = self._row(signal, memory.number(period), *map(memory.number, q.values()))
        deflection = (1.0 - gone) * memory.before("s") + (aim * most) * gone
        s = memory.keep("s", deflection)
        return s, self._rate(signal, aim, s, most)


def _lugre(_: int, forms: tuple[str, ...]) -> LuGre:
    ahead = "field" in forms
    sided = "sides" in forms
    name, title, level = "lugre", "LuGre friction", "(1 + (h_l - 1) exp(-(w / w_l)^2))"
    if ahead:
        name += "/field"
        title += ", the field ahead of the memory"
    if sided:
        name += "/sides"
        title += ", forward and backward apart"
        level = f"({level} (1 + a_l sgn w))"
    pull = "y(E) w" if ahead else "w"
    return LuGre(
        name=name,
        title=title,
        source="Canudas de Wit, Olsson, Astrom and Lischinsky 1995, doi 10.1109/9.376053",
        outputs=("l", "ld"),
        meanings=("effort of the bristles", "effort of the bristles' damping"),
        equation=f"r_l l' = ld, ld = {pull} - |w| l / {level}",
        ahead=ahead,
        damping=("ld",),
        sided=sided,
    )


STAGE = StageFamily(
    _lugre,
    forms=("field", "sides"),
    ladder=("lugre/field", "lugre/field/sides"),
    behind=("lugre", "lugre/sides"),
    apart={"lugre/field/sides": 0.02},
)
