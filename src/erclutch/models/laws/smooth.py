"""Powers and signs stay finite here, with finite derivatives, where field or slip is zero.

Normalised arguments are of order one; ``TINY`` lies far below what any sensor resolves, so the published equations are
met wherever there is something to measure, and the limits at zero are exact.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.models.laws.law import SLIP, ShapeParameter

TINY = 1e-12
#: Keeps a rate off zero where it stands in a quotient that has a limit there.
OFF_ZERO = 1e-10

#: Slip over which the sign turns. A stiff sign (far below the data's slips) is its lower bound.
TRANSITION_SLIP = ShapeParameter(
    "w_s", "slip over which the sign of the yield effort turns", 1e-3, 3.0, SLIP, scale="log"
)


#: In place of w_s: the slip has one sign, whatever the sensors say.
FORWARD: float = float("inf")


def direction(w: Any, w_s: Any) -> Any:
    """Sign of the slip, turning smoothly over w_s: tanh(w / w_s). With `FORWARD` it is always 1."""
    return 1.0 if w_s is FORWARD else np.tanh(w / w_s)


def power(x: Any, n: Any) -> Any:
    """|x|**n for n > 0: zero at x = 0, with finite derivatives in x and n there."""
    square = x * x
    return square * (square + TINY) ** (0.5 * n - 1.0)


def signed_power(x: Any, n: Any) -> Any:
    """sign(x) |x|**n for n >= 0: zero at x = 0, with finite derivatives in x and n there."""
    return x * (x * x + TINY) ** (0.5 * n - 0.5)
