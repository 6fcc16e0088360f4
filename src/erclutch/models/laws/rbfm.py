"""Radial basis function model (RBFM): T = k_0 E**2 sgn(w) + w sum_i k_i exp(-(E - mu_i)**2 / (2 sigma_i**2)).

Equations (12) - (16). The constraint of (16), sum_i k_i phi_i(0) > 0, is the viscosity without field. Taking that
viscosity as the first gain, k_1 = eta_0 - sum_{i>1} k_i phi_i(0) because phi_1(0) = 1, turns the constraint into a
bound.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.errors import SettingError
from erclutch.models.laws.law import VISCOUS, YIELD, Gain, Law, LawFamily
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction
from erclutch.models.laws.yield_stress import YieldForm

# Equations (13), (14): sigma_1 = 0.01 and sigma_2 = 1 over fields up to 0.5, here over normalised fields up to 1.
_NARROWEST, _WIDEST = 0.01 / 0.5, 1.0 / 0.5
_LARGEST = 100  # kernels


def rbfm(yield_form: YieldForm, kernels: int) -> Law:
    """The radial basis function model; with the square yield form it is the paper's.

    Raises:
        SettingError: fewer than 2 kernels (equation 13 divides by n - 1) or more than 100.
    """
    if not 2 <= kernels <= _LARGEST:
        raise SettingError(
            f"{kernels} kernels for the RBFM, allowed are 2 to {_LARGEST}",
            remedy="Write for example rbfm-5 or rbfm-10",
        )
    share = np.arange(kernels) / (kernels - 1)
    centres = share
    spreads = _NARROWEST + share * (_WIDEST - _NARROWEST)
    at_zero = np.exp(-(centres**2) / (2.0 * spreads**2))

    def kernel(E: Any, i: int) -> Any:
        distance = (E - float(centres[i])) / float(spreads[i])
        return np.exp(-0.5 * distance * distance)

    def columns(E: Any, w: Any, w_s: Any, *field: Any) -> tuple[Any, ...]:
        first = kernel(E, 0)
        others = (w * (kernel(E, i) - float(at_zero[i]) * first) for i in range(1, kernels))
        return yield_form.factor(E, *field) * direction(w, w_s), w * first, *others

    def paper_form(
        shape: dict[str, float], gains: dict[str, float], field: float
    ) -> dict[str, float]:
        weights = [gains[f"k_{i + 1}"] for i in range(1, kernels)]
        above_zero = float(np.dot(weights, at_zero[1:]))
        return {"k_1": gains["eta_0"] - above_zero}

    free = tuple(
        Gain(f"k_{i + 1}", f"weight of kernel {i + 1}", VISCOUS, False, part="viscous")
        for i in range(1, kernels)
    )
    return Law(
        name=f"rbfm-{kernels}",
        title=f"RBFM ({kernels} kernels)",
        source="Huang and Ishikawa, eq. (12)-(16)",
        columns=columns,
        shape=(TRANSITION_SLIP, *yield_form.shape),
        gains=(
            YIELD,
            Gain("eta_0", "viscous effort per slip without field", VISCOUS, part="viscous"),
            *free,
        ),
        paper_form=paper_form,
    )


LAW = LawFamily(
    law=rbfm,
    formula="T_y y(E) sgn w + w sum k_i exp(-(E - mu_i)^2 / 2 sigma_i^2)",
    about="""The viscosity is any smooth function of the field: a sum of $N$ Gaussian kernels at fixed centres
(`rbfm-5`, `rbfm-10`; equations 12 to 16). The equation is shown for $N = 2$. The weights trade off: together they
predict, one by one they mean nothing.""",
    curves="w_s=0.05 n=2 T_y=1 eta_0=0.2 k_2=0.6",
    ladder={"rbfm-5": 100, "rbfm-10": 110},
    count=5,
)
