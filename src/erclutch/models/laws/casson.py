"""Casson: sqrt(T) = sqrt(T_y y(E)) + sqrt(eta |w|), squared and signed. Casson 1959.

Written T = T_y (y + r |w| + 2 sqrt(y r |w|)) sgn(w) with r = eta / T_y, so that one gain is linear and the others few.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.models.laws.law import PER_SLIP, YIELD, Law, LawFamily, ShapeParameter
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction, power
from erclutch.models.laws.yield_stress import YieldForm

_RATIO = ShapeParameter(
    "r",
    "viscous over yield effort, per slip",
    1e-5,
    1e5,
    PER_SLIP,
    scale="log",
    viscous_over_yield=True,
)


def casson(yield_form: YieldForm) -> Law:
    """Casson's law with the given yield stress against field."""

    def columns(E: Any, w: Any, w_s: Any, r: Any, *field: Any) -> tuple[Any, ...]:
        strength = yield_form.factor(E, *field)
        mixed = 2.0 * power(strength, 0.5) * r**0.5 * power(w, 0.5)
        return ((strength + r * np.abs(w) + mixed) * direction(w, w_s),)

    return Law(
        name="casson",
        title="Casson",
        source="Casson 1959, in Mill (ed.), Rheology of Disperse Systems",
        columns=columns,
        shape=(TRANSITION_SLIP, _RATIO, *yield_form.shape),
        gains=(YIELD,),
        paper_form=lambda shape, gains, field: {
            "tau_y": gains["T_y"],
            "eta": gains["T_y"] * shape["r"],
        },
    )


LAW = LawFamily(
    law=casson,
    formula="(sqrt(T_y y(E)) + sqrt(eta |w|))^2 sgn w",
    about=r"""The square roots of yield effort and viscous effort add up, so the curve bends into the viscous range
instead of breaking. $r$ is the viscous effort over the yield effort: $\eta = r\,T_y$ is printed beside it.""",
    curves="w_s=0.05 r=0.3 n=2 T_y=1",
    ladder={"casson": 50},
    quick=True,
)
