"""tanh for training: off by some units of rounding near zero, and quicker than NumPy's."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[Any]


def tanh_in_place(z: Floats) -> Floats:
    """Hyperbolic tangent of an array of floats, in its own memory: 1 - 2 / (exp(2 z) + 1)."""
    z += z
    with np.errstate(over="ignore"):  # of a large z, for which 1 comes out
        np.exp(z, out=z)
    z += 1.0
    np.divide(-2.0, z, out=z)
    z += 1.0
    return z
