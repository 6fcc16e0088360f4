"""Robertson-Stiff: T = A (|w| + C)**B sgn(w), doi 10.2118/5333-PA, with a yield effort that the field sets.

Written T = T_y y(E) (1 + |w| / C)**B sgn(w) + eta w, with T_y = A C**B: the gains are linear, and eta is the viscosity
that is left without a field.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.models.laws.law import SLIP, VISCOSITY, YIELD, Law, LawFamily, ShapeParameter
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction, power
from erclutch.models.laws.yield_stress import YieldForm

_OFFSET = ShapeParameter(
    "C",
    "slip that is added before the power is taken",
    1e-2,
    1e2,
    SLIP,
    scale="log",
    usual=(0.1, 10.0),
)
_EXPONENT = ShapeParameter(
    "B", "exponent: 0 is a constant yield effort, 1 a straight line", 0.01, 1.5
)


def robertson_stiff(yield_form: YieldForm) -> Law:
    """The law with the given yield stress against field."""

    def columns(E: Any, w: Any, w_s: Any, C: Any, B: Any, *field: Any) -> tuple[Any, ...]:
        grown = power(1.0 + np.abs(w) / C, B)
        return yield_form.factor(E, *field) * grown * direction(w, w_s), w

    return Law(
        name="robertson-stiff",
        title="Robertson-Stiff",
        source="doi 10.2118/5333-PA",
        columns=columns,
        shape=(TRANSITION_SLIP, _OFFSET, _EXPONENT, *yield_form.shape),
        gains=(YIELD, VISCOSITY),
    )


LAW = LawFamily(
    law=robertson_stiff,
    formula="T_y y(E) (1 + |w|/C)^B sgn w + eta w",
    about="""The yield effort itself grows with the slip, as for drilling muds. With B = 1 and one field this is
Bingham's law. C and B trade off unless the log covers slips well below and above C.""",
    curves="w_s=0.05 C=1 B=0.5 n=2 T_y=1 eta=0.1",
    ladder={"robertson-stiff": 65},
    aliases=("rs",),
)
