"""On-off: T = T_on 1(E > E_on) sgn(w) + eta w, a baseline of practice: [8] of Huang and Ishikawa.

The step is the law's stimulus: it comes ahead of the lag, so that the effort itself follows the command with one time
constant.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.models.laws.law import EFFORT, FIELD, VISCOSITY, Gain, Law, LawFamily, ShapeParameter
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction

#: Width of the step, normalised: sharp against any command, smooth enough to have a derivative.
_STEP_WIDTH = 0.02


def stimulus(E: Any, E_on: Any) -> Any:
    """0 below the field E_on, and 1 above."""
    return 0.5 + 0.5 * np.tanh((np.abs(E) - E_on) / _STEP_WIDTH)


def columns(on: Any, w: Any, w_s: Any) -> tuple[Any, ...]:
    """Columns of T_on and eta; ``on`` is the stimulus."""
    return on * direction(w, w_s), w


LAW = LawFamily(
    law=Law(
        name="on-off",
        title="On-off step",
        source="practice, [8] of Huang and Ishikawa",
        columns=columns,
        shape=(TRANSITION_SLIP,),
        gains=(Gain("T_on", "yield effort when on", EFFORT, part="yield"), VISCOSITY),
        stimulus=stimulus,
        stimulus_shape=(
            ShapeParameter("E_on", "field from which the device counts as on", 0.05, 0.95, FIELD),
        ),
    ),
    formula="T_on sgn w + eta w where E > E_on, eta w below",
    about="""The practice that the paper argues against, as a baseline: the device is either on or off. The command is
switched ahead of the [lag](lag.md).""",
    curves="E_on=0.4 w_s=0.05 T_on=1 eta=0.3",
    ladder={"on-off": 10},
)
