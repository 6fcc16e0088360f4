"""Seo-Seo (SS): T = T_sy y(E) (1 - (1 - exp(-a |w|)) / (1 + (a |w|)**b)) sgn(w) + eta w, doi 10.1021/la204515q.

The yield effort falls from its static value T_sy while chains break, and comes back as they form again. How sure we are
of this form: docs/decisions/0003-sources-of-ss-and-ccj.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.laws.law import EFFORT, PER_SLIP, VISCOSITY, Gain, Law, Shape
from erclutch.laws.smooth import TRANSITION_SLIP, direction, power
from erclutch.laws.yield_stress import YieldForm

_TIME = Shape("a", "time of the structure: the yield effort falls at slips above 1 / a", 1e-3, 1e3, PER_SLIP, "log")
_INDEX = Shape("b", "exponent (alpha in the source) with which the structure re-forms", 0.05, 6.0, scale="log")
_STATIC = Gain("T_sy", "static yield effort at the reference field", EFFORT)


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
