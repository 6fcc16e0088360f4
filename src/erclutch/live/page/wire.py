"""Frames on their way to the browser: a short header, then 64 bytes a frame, little-endian, for typed arrays."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.live.frame import RingInfo

KIND = 1
_HEAD = struct.Struct("<IIdd")
#: One frame: thirteen floats, then words.
FRAME = np.dtype(
    [
        ("time", "<f4"),  # s after the first of the message, by deadline
        ("theta", "<f4"),  # rad, within one turn
        ("alpha", "<f4"),
        ("theta_dot", "<f4"),
        ("alpha_dot", "<f4"),
        ("field1", "<f4"),
        ("field2", "<f4"),
        ("motor_torque", "<f4"),
        ("torque", "<f4"),
        ("estimate", "<f4"),
        ("reference", "<f4"),
        ("lateness", "<f4"),  # us
        ("step", "<f4"),  # us
        ("flags", "<u4"),
        ("events", "<u4"),
        ("spare", "<u4"),
    ]
)
_SAME = ("alpha", "theta_dot", "alpha_dot", "field1", "field2", "motor_torque", "torque", "estimate", "reference")


def pack(frames: NDArray[Any], info: RingInfo, skipped: int) -> bytes:
    """A message: kind, frames skipped before it, time of the first in s since the start, its number; then the frames.

    Args:
        frames: at least one, shape (n,), as in the ring.
        info: of the session.
        skipped: frames that this client did not get, so far.
    """
    due = frames["time_ns"].astype(np.int64) - frames["lateness_ns"]
    out = np.zeros(frames.size, FRAME)
    out["time"] = (due - due[0]) * 1e-9
    # A motor that has turned for an hour needs more digits than a float has.
    out["theta"] = np.mod(frames["theta"], 2 * np.pi)
    with np.errstate(over="ignore"):  # a number beyond single precision shows as infinite
        for name in _SAME:
            out[name] = frames[name]
    out["lateness"], out["step"] = frames["lateness_ns"] * 1e-3, frames["step_ns"] * 1e-3
    out["flags"], out["events"] = frames["flags"], frames["events"]
    first = (int(due[0]) - info.start_ns) * 1e-9
    return _HEAD.pack(KIND, min(skipped, 0xFFFFFFFF), first, float(frames["seq"][0])) + out.tobytes()
