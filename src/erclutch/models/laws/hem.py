"""Heuristic explicit model (HEM): T = k_1 E**2 sgn(w) + k_2 (beta_1 + exp(beta_2 E)) w, equations (8) - (11).

As printed, k_2 and beta_1 trade off and can hardly be told apart. The same family written as

    eta(E) = eta_0 (1 + kappa (exp(beta E) - 1) / (exp(beta) - 1)),   E normalised

has the constraints of (11) as plain bounds, eta_0 > 0, Bingham at kappa = 0, and a smooth way through beta = 0
(viscosity linear in the field), where the printed form runs off to infinity on both sides. `paper_form` gives the
printed symbols.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.models.laws.law import PER_FIELD, VISCOUS, YIELD, Gain, Law, LawFamily, ShapeParameter
from erclutch.models.laws.smooth import OFF_ZERO, TRANSITION_SLIP, direction
from erclutch.models.laws.yield_stress import YieldForm

_KAPPA = ShapeParameter(
    "kappa",
    "rise of the viscosity up to the reference field, as a share",
    -20.0,
    20.0,
    usual=(-1.5, 4.0),
)
_BETA = ShapeParameter(
    "beta",
    "rate at which the viscosity follows the field",
    -20.0,
    20.0,
    PER_FIELD,
    usual=(-6.0, 6.0),
)
_ETA_0 = Gain("eta_0", "viscous effort per slip without field", VISCOUS, part="viscous")


def hem(yield_form: YieldForm) -> Law:
    """The heuristic explicit model; with the square yield form it is the paper's."""

    def columns(E: Any, w: Any, w_s: Any, kappa: Any, beta: Any, *field: Any) -> tuple[Any, ...]:
        rate = beta + OFF_ZERO
        thick = 1.0 + kappa * np.expm1(rate * E) / np.expm1(rate)
        return yield_form.factor(E, *field) * direction(w, w_s), w * thick

    def paper_form(
        shape: dict[str, float], gains: dict[str, float], field: float
    ) -> dict[str, float]:
        rho = shape["kappa"] / np.expm1(shape["beta"] * field)
        return {
            "k_2": gains["eta_0"] * rho,
            "beta_1": (1.0 - rho) / rho if rho else float("inf"),
            "beta_2": shape["beta"],
        }

    return Law(
        name="hem",
        title="HEM",
        source="Huang and Ishikawa, eq. (8)-(11)",
        columns=columns,
        shape=(TRANSITION_SLIP, _KAPPA, _BETA, *yield_form.shape),
        gains=(YIELD, _ETA_0),
        paper_form=paper_form,
    )


LAW = LawFamily(
    law=hem,
    formula="T_y y(E) sgn w + eta_0 (1 + kappa (e^(beta E) - 1) / (e^beta - 1)) w",
    about=r"""In the paper's heuristic explicit model the viscosity grows (or falls) exponentially with the field. As
printed, two of its parameters can hardly be told apart. The form below is the same family, with $\kappa$ as the rise
up to the largest field. `fit` prints the paper's $k_2$, $\beta_1$, $\beta_2$ too.""",
    curves="w_s=0.05 kappa=2 beta=3 n=2 T_y=1 eta_0=0.2",
    ladder={"hem": 90},
)
