"""The practice that the paper argues against, as baselines: [8] to [10] of Huang and Ishikawa.

On-off: the field is either on or off, T = T_on 1(E > E_on) sgn(w) + eta w. Quadratic: T = T_y E**2 sgn(w) + eta w.
The viscosity is constant. In both the response to the command is first-order: their stimulus (the step, the square)
comes ahead of the lag, so that the effort itself follows with one time constant.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.laws.law import EFFORT, FIELD, VISCOSITY, Gain, Law, Shape
from erclutch.laws.smooth import TRANSITION_SLIP, direction

_THRESHOLD = Shape("E_on", "field from which the device counts as on", 0.05, 0.95, FIELD)
#: Width of the step, normalised: sharp against any command, smooth enough to have a derivative.
_STEP_WIDTH = 0.02


def _step(E: Any, E_on: Any) -> Any:
    return 0.5 + 0.5 * np.tanh((np.abs(E) - E_on) / _STEP_WIDTH)


def on_off() -> Law:
    """A device that is either on or off, with a constant viscosity."""

    def columns(on: Any, w: Any, w_s: Any) -> tuple[Any, ...]:
        return on * direction(w, w_s), w

    return Law(
        name="on-off",
        title="On-off step",
        source="practice, [8] of Huang and Ishikawa",
        columns=columns,
        shape=(TRANSITION_SLIP,),
        gains=(Gain("T_on", "yield effort when on", EFFORT), VISCOSITY),
        stimulus=_step,
        stimulus_shape=(_THRESHOLD,),
    )


def _square(E: Any) -> Any:
    return E * E


def quadratic() -> Law:
    """Yield effort in proportion to the square of the field, with a constant viscosity."""

    def columns(squared: Any, w: Any, w_s: Any) -> tuple[Any, ...]:
        return squared * direction(w, w_s), w

    return Law(
        name="quadratic",
        title="Quadratic in E",
        source="practice, [9] and [10] of Huang and Ishikawa",
        columns=columns,
        shape=(TRANSITION_SLIP,),
        gains=(Gain("T_y", "yield effort at the reference field", EFFORT), VISCOSITY),
        stimulus=_square,
    )
