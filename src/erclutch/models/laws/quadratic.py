"""Quadratic: T = T_y E**2 sgn(w) + eta w, a baseline of practice: [9] and [10] of Huang and Ishikawa.

The square is the law's stimulus: it comes ahead of the lag, so that the effort itself follows the command with one time
constant.
"""

from __future__ import annotations

from typing import Any

from erclutch.models.laws.law import VISCOSITY, YIELD, Law, LawFamily
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction


def stimulus(E: Any) -> Any:
    """The square of the command."""
    return E * E


def columns(squared: Any, w: Any, w_s: Any) -> tuple[Any, ...]:
    """Columns of T_y and eta; ``squared`` is the stimulus."""
    return squared * direction(w, w_s), w


LAW = LawFamily(
    law=Law(
        name="quadratic",
        title="Quadratic in E",
        source="practice, [9] and [10] of Huang and Ishikawa",
        columns=columns,
        shape=(TRANSITION_SLIP,),
        gains=(YIELD, VISCOSITY),
        stimulus=stimulus,
    ),
    formula="T_y E^2 sgn w + eta w",
    about="""The practice that the paper argues against, as a baseline: the yield effort follows the square of the
command. The command is squared ahead of the [lag](lag.md).""",
    curves="w_s=0.05 T_y=1 eta=0.3",
    ladder={"quadratic": 20},
)
