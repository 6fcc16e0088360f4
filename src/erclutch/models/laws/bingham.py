"""Bingham: T = T_y y(E) sgn(w) + eta w. Equation (1) of Huang and Ishikawa; Bingham 1922."""

from __future__ import annotations

from typing import Any

from erclutch.laws.law import VISCOSITY, YIELD, Law
from erclutch.laws.smooth import TRANSITION_SLIP, direction
from erclutch.laws.yield_stress import YieldForm


def bingham(yield_form: YieldForm) -> Law:
    """Bingham's law with the given yield stress against field."""

    def columns(E: Any, w: Any, w_s: Any, *field: Any) -> tuple[Any, ...]:
        return yield_form.factor(E, *field) * direction(w, w_s), w

    return Law(
        name="bingham",
        title="Bingham",
        source="Huang and Ishikawa, eq. (1)",
        columns=columns,
        shape=(TRANSITION_SLIP, *yield_form.shape),
        gains=(YIELD, VISCOSITY),
    )
