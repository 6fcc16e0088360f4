"""Herschel-Bulkley: T = T_y y(E) sgn(w) + K |w|**m sgn(w), doi 10.1007/BF01432034."""

from __future__ import annotations

from typing import Any

from erclutch.models.laws.law import EFFORT, YIELD, Gain, Law, LawFamily, ShapeParameter
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction, signed_power
from erclutch.models.laws.yield_stress import YieldForm

_FLOW_INDEX = ShapeParameter("m", "flow index: below 1 thins, above 1 thickens with slip", 0.1, 3.0)
_CONSISTENCY = Gain("K", "viscous effort at the reference slip", EFFORT, part="viscous")


def herschel_bulkley(yield_form: YieldForm) -> Law:
    """Herschel and Bulkley's law with the given yield stress against field."""

    def columns(E: Any, w: Any, w_s: Any, m: Any, *field: Any) -> tuple[Any, ...]:
        return yield_form.factor(E, *field) * direction(w, w_s), signed_power(w, m)

    return Law(
        name="herschel-bulkley",
        title="Herschel-Bulkley",
        source="doi 10.1007/BF01432034",
        columns=columns,
        shape=(TRANSITION_SLIP, _FLOW_INDEX, *yield_form.shape),
        gains=(YIELD, _CONSISTENCY),
    )


LAW = LawFamily(
    law=herschel_bulkley,
    formula="T_y y(E) sgn w + K |w|^m sgn w",
    about="The viscous effort thins ($m < 1$) or thickens ($m > 1$) with slip.",
    curves="w_s=0.05 m=0.6 n=2 T_y=1 K=0.3",
    ladder={"herschel-bulkley": 60},
    aliases=("hb",),
)
