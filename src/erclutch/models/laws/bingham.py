"""Bingham: T = T_y y(E) sgn(w) + eta w. Equation (1) of Huang and Ishikawa; Bingham 1922."""

from __future__ import annotations

from typing import Any

from erclutch.models.laws.law import VISCOSITY, YIELD, Law, LawFamily
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction
from erclutch.models.laws.yield_stress import YieldForm


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


LAW = LawFamily(
    law=bingham,
    formula="T_y y(E) sgn w + eta w",
    about="""Bingham's law adds a yield effort that the field sets and a constant viscosity. It has two gains. Few
data suffice to fit it, so judge every other model by how far it beats it. `bingham/critical` has Choi's yield stress.
Where all data lie on one side of $E_c$, the data do not identify $E_c$, and its interval says so.""",
    curves="w_s=0.05 n=2 T_y=1 eta=0.3",
    ladder={"bingham": 30, "bingham/critical": 40},
    quick=True,
)
