"""A scan of the nonlinear parameters on few rows says where the local solver starts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array


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


def windows(rows: int, most: int, count: int = 12) -> NDArray[np.bool_]:
    """Mask of ``count`` stretches of neighbouring rows, evenly spread, of at most ``most`` rows together."""
    mask = np.zeros(rows, np.bool_)
    starts, length = window_starts(rows, most, count)
    for start in starts:
        mask[start : start + length] = True
    return mask


def window_starts(rows: int, most: int, count: int = 12) -> tuple[list[int], int]:
    """First rows of such stretches, and the rows of each."""
    length = max(1, most // count)
    return np.linspace(0, max(rows - length, 0), count).round().astype(int).tolist(), length
