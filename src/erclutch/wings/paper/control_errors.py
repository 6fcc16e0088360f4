"""How well a torque follows its reference: errors as shares, frequencies that are reached, standing still."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array

AMPLITUDE = 0.08  # N m, of a reference
SETTLING = 1000  # rows: the motor runs up
LOCK = 1000  # rows between two steps


def share_of_range(off: Array) -> float:
    """RMS of errors in N m, as a share of the range of all references."""
    if not off.size:
        return math.nan
    return math.sqrt(float(np.mean(off * off))) / (2.0 * AMPLITUDE)


def error_share(frames: Any) -> float:
    """RMS of torque less reference, as a share of the range of all references; the first second does not count."""
    off = frames["torque"] - frames["reference"]
    return share_of_range(off[SETTLING:])


def reaches(frames: Any, phase: Array, omega: Array) -> tuple[float, float]:
    """Frequencies in Hz up to which a chirp's torque keeps its amplitude (-3 dB), and is off by less than 10 % of it.

    Args:
        frames: of a chirp.
        phase: of the chirp in rad, shape (n,).
        omega: its rate in rad/s, shape (n,).

    Returns:
        Both; the chirp's highest frequency where the torque never leaves the limit.
    """
    cycles = 4  # of a span, over which an amplitude is taken
    turning = np.exp(-1j * phase)
    edges = np.searchsorted(phase, np.arange(0.0, phase[-1], 2.0 * math.pi * cycles))
    spans = [slice(start, stop) for start, stop in pairwise(edges.tolist()) if start >= SETTLING]

    def amplitude(name: str) -> NDArray[np.complex128]:
        signal: Array = frames[name]
        turned = signal * turning
        return np.array([complex(np.mean(turned[span])) for span in spans])

    reached = amplitude("torque")
    wanted = amplitude("reference")
    hertz = np.array([omega[span.start] for span in spans]) / (2.0 * math.pi)

    def first(beyond: NDArray[np.bool_]) -> float:
        if beyond.any():
            return float(hertz[np.argmax(beyond)])
        return float(omega[-1] / (2.0 * math.pi))

    too_small = abs(reached) < abs(wanted) * math.sqrt(0.5)
    too_far_off = abs(reached - wanted) > 0.1 * abs(wanted)
    return first(too_small), first(too_far_off)


def stands_still(frames: Any) -> bool:
    """Whether a stalled motor is held without chatter.

    The clutches change as often as the reference does, and neither field nor torque swings in the second half of each
    step.
    """
    field = frames["field1"] - frames["field2"]
    sides = field[field != 0.0]
    changes = int(np.count_nonzero(np.diff(np.sign(sides))))
    starts = range(0, len(frames), LOCK)
    steps = [slice(start + LOCK // 2, start + LOCK) for start in starts]
    field_swing = max(float(np.std(field[step])) for step in steps)
    torque_swing = max(float(np.std(frames["torque"][step])) for step in steps)
    calm = field_swing < 0.01 * 0.5 and torque_swing < 0.02 * 2.0 * AMPLITUDE
    return calm and changes <= len(steps) - 1
