"""A scan of the nonlinear parameters on few rows says where the local solver starts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array

_GOLDEN = 0.5 * (5.0**0.5 - 1.0)
_SECONDS = 0.3  # least time of a stretch


def scan_points(lower: Array, upper: Array, count: int) -> Array:
    """Points that fill a box evenly: the additive recurrence of Roberts (2018), shape (count, k). Deterministic.

    Its k-th direction is a power of the root of x**(k+1) = x + 1, the golden ratio for k = 1.
    """
    k = lower.size
    root = 2.0
    for _ in range(40):
        root = (1.0 + root) ** (1.0 / (k + 1))
    steps = root ** -np.arange(1.0, k + 1)
    unit = (0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0
    return lower + unit * (upper - lower)


def thinned(rows: int, most: int) -> slice:
    """Every so-many-th row, so that at most ``most`` are left."""
    return slice(None, None, max(1, -(-rows // most)))


def windows(
    rows: int,
    most: int,
    period: float,
    count: int = 12,
) -> NDArray[np.bool_]:
    """Mask of ``count`` stretches of neighbouring rows: ``most`` together, and more where these are too short a time.

    A command must move within them, and what follows it must be seen, however fast it was sampled. One stretch begins
    in each of ``count`` parts of the log, at another place in each: a command of any period moves in some of them.
    """
    length = max(1, most // count, round(_SECONDS / period))
    part = rows / count
    if length >= part:
        return np.ones(rows, np.bool_)
    mask = np.zeros(rows, np.bool_)
    for i in range(count):
        start = min(int((i + i * _GOLDEN % 1.0) * part), rows - length)
        mask[start : start + length] = True
    return mask
