"""Friction falls from its static level to its sliding level as the slip grows: Stribeck's hump; it remembers nothing.

::

    h = exp(-|w / w_st|**p_st),   columns d h and y(E) d h  with d = tanh(w / w_s), the law's own sign of the slip
    stribeck:       p_st = 2;  stribeck-1: p_st = 1;  stribeck/free: p_st is fitted

The published form is F = sgn(v) (F_C + (F_S - F_C) exp(-|v / v_S|**p)) + F_v v. Its Coulomb level F_C is the friction
or the yield effort of the law, F_v the viscosity of the law, v_S is w_st, and the gains here are F_S - F_C: how far the
static level lies above. With a spring under the hump, before it breaks away, take `lugre`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.models.laws.law import EFFORT, SLIP, Gain, ShapeParameter
from erclutch.models.laws.smooth import power
from erclutch.models.stages.stage import Place, RowByRow, SlipAndStrength, StageFamily

_FREE = 0
_USUAL = 2


@dataclass(frozen=True)
class Stribeck(RowByRow):
    """Stribeck's hump as a stage.

    Attributes:
        exponent: of the slip; `_FREE`: it is fitted.
        turns_as_friction: the structure gives its columns the sign of the slip, which turns as that of friction does.
    """

    name: str
    title: str
    exponent: int
    equation: str
    source: str = "Stribeck 1902; Armstrong-Helouvry, Dupont and Canudas de Wit 1994, doi 10.1016/0005-1098(94)90209-7"
    place: Place = "slip"
    switches: bool = False
    turns_as_friction: bool = True
    outputs: tuple[str, ...] = ("h",)
    gains: tuple[Gain, ...] = (
        Gain("T_st", "static effort above that of sliding, without field", EFFORT),
        Gain(
            "T_sty",
            "static effort above that of sliding, that of the reference field",
            EFFORT,
            part="yield",
        ),
    )

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The slip over which the hump fades, over the root mean square of the slip, and the exponent if it is free."""
        fades = ShapeParameter(
            "w_st",
            "slip over which static friction fades (Stribeck)",
            1e-3,
            3.0,
            SLIP,
            "log",
            (0.01, 1.0),
        )
        if self.exponent != _FREE:
            return (fades,)
        steepness = ShapeParameter("p_st", "exponent of the slip in the fading", 0.3, 4.0)
        return fades, steepness

    def outputs_at(self, signal: SlipAndStrength, *numbers: Any) -> tuple[Any, ...]:
        """How much of the hump is left at a slip: 1 at rest, 0 where all slides."""
        ratio = signal.slip / numbers[0]
        if self.exponent == _FREE:
            faded = power(ratio, numbers[1])
        elif self.exponent == 1:
            faded = np.abs(ratio)
        elif self.exponent == _USUAL:
            faded = ratio * ratio
        else:
            faded = power(ratio, float(self.exponent))
        return (np.exp(-faded),)

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """The hump without field, and that which the field scales; their sign is the structure's to give."""
        (left,) = outputs
        return left, strength * left


def _stribeck(number: int, forms: tuple[str, ...]) -> Stribeck:
    free = "free" in forms
    exponent = _FREE if free else number
    title = "Stribeck's hump of the friction"
    if free:
        title += ", exponent fitted"
    elif exponent != _USUAL:
        title += f", exponent {exponent}"
    written = "p_st" if free else f"{exponent}"
    stem = "stribeck" if free or exponent == _USUAL else f"stribeck-{exponent}"
    return Stribeck(
        name=f"{stem}/free" if free else stem,
        title=title,
        exponent=exponent,
        equation=f"h = exp(-|w / w_st|^{written}), of the sign tanh(w / w_s)",
    )


STAGE = StageFamily(
    _stribeck,
    count=_USUAL,
    forms=("free",),
    ladder=("stribeck", "stribeck-1"),
    fades="w_st",
    striking=0.02,
)
