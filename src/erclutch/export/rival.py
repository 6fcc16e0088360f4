"""Checks of targets that compute with the functions of somebody else, and so not to the bit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.export.check import Check, ulps
from erclutch.export.program import Program
from erclutch.export.rounding import bound
from erclutch.export.vectors import Vectors
from erclutch.precision import FLOAT64


def near(program: Program, vectors: Vectors, where: str, effort: NDArray[Any], flags: NDArray[Any]) -> Check:
    """Steps against NumPy in float64, and flags against those expected."""
    other = int(np.count_nonzero(np.asarray(flags, np.uint32) != vectors.flags))
    difference = float(np.max(np.abs(np.asarray(effort, np.float64) - vectors.numpy)))
    largest = ulps(program, difference) if np.isfinite(difference) else float("inf")
    return Check(where, len(vectors.flags), other or None, largest, allowed(program, vectors))


#: What the functions of other libraries may be worse by than ours.
_SLACK = 8.0


def allowed(program: Program, vectors: Vectors) -> float:
    """Largest difference from NumPy that rounding may make, in units of the last place at the largest effort."""
    limit = bound(program, vectors.rows) + bound(program, vectors.rows, FLOAT64)
    return _SLACK + ulps(program, float(np.max(limit)))
