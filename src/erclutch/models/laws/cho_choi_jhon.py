"""Cho-Choi-Jhon (CCJ): T = T_y y(E) / (1 + (t_1 |w|)**a) sgn(w) + eta (1 + (t_2 |w|)**-b) w.

Source: doi 10.1016/j.polymer.2005.10.029. How sure we are of this form: docs/decisions/0003-sources-of-ss-and-ccj.md.
"""

from __future__ import annotations

from typing import Any

from erclutch.models.laws.law import PER_SLIP, VISCOSITY, YIELD, Law, LawFamily, ShapeParameter
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction, power, signed_power
from erclutch.models.laws.yield_stress import YieldForm

_T1 = ShapeParameter("t_1", "time after which the yield effort falls", 1e-3, 1e3, PER_SLIP, "log")
_A = ShapeParameter("a", "exponent (alpha in the source) of the fall", 0.05, 6.0, scale="log")
_T2 = ShapeParameter(
    "t_2", "time of the viscosity's rise toward low slip", 1e-3, 1e3, PER_SLIP, "log"
)
_B = ShapeParameter("b", "exponent (beta in the source) of that rise", 0.02, 1.0)


def cho_choi_jhon(yield_form: YieldForm) -> Law:
    """Cho, Choi and Jhon's law with the given yield stress against field."""

    def columns(
        E: Any, w: Any, w_s: Any, t_1: Any, a: Any, t_2: Any, b: Any, *field: Any
    ) -> tuple[Any, ...]:
        standing = yield_form.factor(E, *field) / (1.0 + power(t_1 * w, a))
        return standing * direction(w, w_s), w + signed_power(w, 1.0 - b) * t_2**-b

    return Law(
        name="cho-choi-jhon",
        title="Cho-Choi-Jhon (CCJ)",
        source="doi 10.1016/j.polymer.2005.10.029; [15] of Huang and Ishikawa",
        columns=columns,
        shape=(TRANSITION_SLIP, _T1, _A, _T2, _B, *yield_form.shape),
        gains=(YIELD, VISCOSITY),
    )


LAW = LawFamily(
    law=cho_choi_jhon,
    formula="T_y y(E) / (1 + (t_1|w|)^a) sgn w + eta (1 + (t_2|w|)^-b) w",
    about="""The yield effort falls with slip, and the viscosity rises toward low slip. The six parameters trade off
unless the log covers several decades of slip. [The original article](decisions/0003-sources-of-ss-and-ccj.md) could
not be seen.""",
    curves="w_s=0.02 t_1=2 a=0.8 t_2=2 b=0.6 n=2 T_y=1 eta=0.3",
    ladder={"cho-choi-jhon": 80},
    aliases=("ccj",),
)
