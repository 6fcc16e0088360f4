"""Seo-Seo (SS): T = T_sy y(E) (1 - (1 - exp(-a |w|)) / (1 + (a |w|)**b)) sgn(w) + eta w, doi 10.1021/la204515q.

The yield effort falls from its static value T_sy while chains break, and comes back as they form again. How sure we are
of this form: docs/decisions/0003-sources-of-ss-and-ccj.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.models.laws.law import (
    EFFORT,
    PER_SLIP,
    VISCOSITY,
    Gain,
    Law,
    LawFamily,
    ShapeParameter,
)
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction, power
from erclutch.models.laws.yield_stress import YieldForm

_TIME = ShapeParameter(
    "a",
    "time of the structure: the yield effort falls at slips above 1 / a",
    1e-3,
    1e3,
    PER_SLIP,
    "log",
)
_INDEX = ShapeParameter(
    "b", "exponent (alpha in the source) with which the structure re-forms", 0.05, 6.0, scale="log"
)
_STATIC = Gain("T_sy", "static yield effort at the reference field", EFFORT, part="yield")


def seo_seo(yield_form: YieldForm) -> Law:
    """Seo and Seo's law with the given yield stress against field."""

    def columns(E: Any, w: Any, w_s: Any, a: Any, b: Any, *field: Any) -> tuple[Any, ...]:
        broken = -np.expm1(-a * np.abs(w)) / (1.0 + power(a * w, b))
        return yield_form.factor(E, *field) * (1.0 - broken) * direction(w, w_s), w

    return Law(
        name="seo-seo",
        title="Seo-Seo (SS)",
        source="doi 10.1021/la204515q; [16] of Huang and Ishikawa",
        columns=columns,
        shape=(TRANSITION_SLIP, _TIME, _INDEX, *yield_form.shape),
        gains=(_STATIC, VISCOSITY),
    )


LAW = LawFamily(
    law=seo_seo,
    formula="T_sy y(E) (1 - (1 - e^(-a|w|)) / (1 + (a|w|)^b)) sgn w + eta w",
    about="""Chains break under shear and form again: the yield effort dips below its static value and comes back. In
this form the dip is at least 31.6 %, whatever the parameters ([computed, not
cited](decisions/measurements/0003-sources-of-ss-and-ccj.md)). As far as we can tell this is the paper's SS; the
original article could not be seen.""",
    curves="w_s=0.02 a=3 b=1.2 n=2 T_sy=1 eta=0.1",
    ladder={"seo-seo": 70},
    aliases=("ss",),
)
