"""A noisy acceleration is smoothed at the price of a delay; a smoother speed has no need of that delay."""

from __future__ import annotations

import numpy as np

from erclutch.fit.checks.finding import Finding

#: Rows of a window of speeds for each row of the low-pass: of windows tried, this one left the least error.
_ROWS_OF_A_WINDOW = 4.0


def noisy_acceleration(tau: float, period: float) -> Finding:
    """What to do about an inertia whose acceleration passes a low-pass.

    Args:
        tau: time constant of the low-pass in s.
        period: sampling period in s.
    """
    half = int(np.ceil(_ROWS_OF_A_WINDOW * tau / (2.0 * period)))
    window = 2 * max(half, 3) + 1  # odd, and wider than the usual 5
    seen = f"the speed is too noisy for its acceleration, which a low-pass of {1e3 * tau:.3g} ms smooths and delays"
    remedy = f"Where the speed is made of a position, try --window {window}"
    return Finding("note", "noisy acceleration", seen, remedy)
