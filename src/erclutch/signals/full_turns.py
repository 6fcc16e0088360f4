"""A sensor of an angle may start again after a full turn; its jump from one end to the other is no motion."""

from __future__ import annotations

import numpy as np

from erclutch.signals.array import Array

#: A full turn in the units that an angle may have: rad, deg, turns.
FULL_TURNS = (2.0 * np.pi, 360.0, 1.0)
#: Share by which rounded angles may go beyond a full turn.
ROUNDED = 1e-6


def starts_again(angle: Array, turn: float) -> int:
    """How often an angle jumps by more than half a turn though all of it lies within one; 0 where it goes beyond.

    Args:
        angle: shape (rows,).
        turn: a full turn in the unit of the angle.
    """
    if angle.size == 0 or np.ptp(angle) > turn * (1.0 + ROUNDED):
        return 0
    return int(np.count_nonzero(np.abs(np.diff(angle)) > turn / 2.0))


def between_samples(at: Array, times: Array, angle: Array, turn: float) -> Array:
    """An angle that starts again after a full turn, by straight lines between its samples along the shorter way.

    Args:
        at: times that are asked for, in s, shape (rows,).
        times: of the samples, in s, shape (samples,), increasing.
        angle: the samples, within one turn, shape (samples,).
        turn: a full turn in the unit of the angle.

    Returns:
        Angles within a turn from the smallest sample on, shape (rows,).
    """
    drawn = np.unwrap(angle, period=turn)
    joined = np.interp(at, times, drawn)
    smallest = float(angle.min())
    return np.asarray(smallest + np.mod(joined - smallest, turn), np.float64)
