"""A sensor of an angle may start again after a full turn; its jump from one end to the other is no motion."""

from __future__ import annotations

import numpy as np

from erclutch.signals.array import Array
from erclutch.signals.device import SPEED_OF
from erclutch.signals.recording import Recording

#: A full turn in the units that an angle may have: rad, deg, turns.
FULL_TURNS = (2.0 * np.pi, 360.0, 1.0)
_ROUNDED = 1e-6  # share by which rounded angles may go beyond a full turn


def starts_again(angle: Array, turn: float) -> int:
    """How often an angle jumps by more than half a turn though all of it lies within one; 0 where it goes beyond.

    Args:
        angle: shape (rows,).
        turn: a full turn in the unit of the angle.
    """
    if angle.size == 0 or np.ptp(angle) > turn * (1.0 + _ROUNDED):
        return 0
    return int(np.count_nonzero(np.abs(np.diff(angle)) > turn / 2.0))


def drawn_out(log: Recording) -> tuple[dict[str, Array], list[str]]:
    """The signals of a log, its positions without the jumps of a sensor that starts again, and a note on each.

    A position in rad is drawn out where its speed is not logged.
    """
    turn, *_ = FULL_TURNS
    signals = dict(log.signals)
    notes: list[str] = []
    for position, speed in SPEED_OF.items():
        angle = signals.get(position)
        if angle is None or speed in signals or log.units.get(position) != "rad":
            continue
        if np.ptp(angle) > turn * (1.0 + _ROUNDED):
            continue
        parts = [angle[start:stop] for start, stop in log.segments]
        turns = sum(starts_again(part, turn) for part in parts)
        if turns:
            signals[position] = np.concatenate([np.unwrap(part) for part in parts])
            anew = f"{position} starts again after a full turn, {turns} times"
            notes.append(f"{anew}: drawn out without jumps")
    return signals, notes


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
    without_jumps = np.unwrap(angle, period=turn)
    joined = np.interp(at, times, without_jumps)
    smallest = float(angle.min())
    return np.asarray(smallest + np.mod(joined - smallest, turn), np.float64)
