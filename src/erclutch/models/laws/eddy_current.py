"""Eddy-current drag: T = 2 T_d y(E) r / (1 + r**2) sgn(w) + eta w with r = |w| / w_c. Smythe 1942, Wouterse 1991.

Below the critical slip w_c the drag grows with the slip, at w_c it is largest, beyond it falls: the currents weaken the
field that makes them. The drag follows the square of the field until the iron saturates.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.models.laws.law import (
    EFFORT,
    SLIP,
    VISCOSITY,
    Gain,
    Law,
    LawFamily,
    ShapeParameter,
)
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction
from erclutch.models.laws.yield_stress import YieldForm

_CRITICAL = ShapeParameter(
    "w_c", "critical slip, at which the drag is largest", 1e-2, 1e2, SLIP, "log", (0.1, 10.0)
)
# The temperature changes the critical slip and leaves the largest drag as it is: no part of a fluid's effort does so.
_DRAG = Gain("T_d", "largest drag at the reference field", EFFORT)


def eddy_current(yield_form: YieldForm) -> Law:
    """The drag of eddy currents, whose largest value follows the field as the yield effort of a fluid would."""

    def columns(E: Any, w: Any, w_s: Any, w_c: Any, *field: Any) -> tuple[Any, ...]:
        ratio = w / w_c
        drag = 2.0 * np.abs(ratio) / (1.0 + ratio * ratio)
        return yield_form.factor(E, *field) * drag * direction(w, w_s), w

    return Law(
        name="eddy-current",
        title="Eddy-current drag",
        source="Smythe 1942, Trans. AIEE 61, 681; Wouterse 1991, IEE Proc. B 138, 153",
        columns=columns,
        shape=(TRANSITION_SLIP, _CRITICAL, *yield_form.shape),
        gains=(_DRAG, VISCOSITY),
    )


LAW = LawFamily(
    law=eddy_current,
    formula="2 T_d y(E) |w| / w_c / (1 + (w / w_c)^2) sgn w + eta w",
    about="""A conductor that moves through a field is braked by its own currents, without a fluid. The drag grows with
the slip up to the critical slip $w_c$ and falls beyond it. `--models all` tries this law where the field's effort
vanishes towards rest or falls at high slips.""",
    curves="w_s=0.05 w_c=0.5 n=2 T_d=1 eta=0.1",
    ladder={"eddy-current": 45},
    without_yield=True,
)
