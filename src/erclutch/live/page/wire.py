"""A browser gets frames as a short header and rows of 4-byte words, little-endian, for typed arrays.

The page is told the columns of a row once, in the server's first message.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.live.layout import FRAME
from erclutch.live.ring import RingInfo

_HEAD = struct.Struct("<IIdd")
_SAME = tuple(name for name in FRAME.names or () if FRAME[name] == np.float64)
#: One row: time in s after the first of the message, by deadline; a frame's numbers; times in us; words of bits.
_ROW = np.dtype(
    [
        *((name, "<f4") for name in ("time", *_SAME, "lateness", "step")),
        *((name, "<u4") for name in ("flags", "events")),
    ]
)
#: What the page needs to read a message: bytes before the rows, and the columns of a row, 4 bytes each.
WIRE: dict[str, Any] = {"head": _HEAD.size, "columns": list(_ROW.names or ())}


def pack(frames: NDArray[Any], info: RingInfo, skipped: int) -> bytes:
    """A message: zero, frames skipped before it, time of the first in s since the start, its number; then the rows.

    Args:
        frames: at least one, shape (n,), as in the ring.
        info: of the session.
        skipped: frames that this client did not get, so far.
    """
    due = frames["time_ns"].astype(np.int64) - frames["lateness_ns"]
    out = np.zeros(frames.size, _ROW)
    out["time"] = (due - due[0]) * 1e-9
    with np.errstate(over="ignore"):  # a number beyond single precision shows as infinite
        for name in _SAME:
            out[name] = frames[name]
    # A motor that has turned for an hour needs more digits than a float has.
    out["theta"] = np.mod(frames["theta"], 2 * np.pi)
    out["lateness"], out["step"] = frames["lateness_ns"] * 1e-3, frames["step_ns"] * 1e-3
    out["flags"], out["events"] = frames["flags"], frames["events"]
    first = (int(due[0]) - info.start_ns) * 1e-9
    return _HEAD.pack(0, min(skipped, 0xFFFFFFFF), first, float(frames["seq"][0])) + out.tobytes()
