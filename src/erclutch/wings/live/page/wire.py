"""A browser gets frames as a short header and rows of 4-byte words, little-endian, for typed arrays.

The page is told the columns of a row once, in the server's first message.
"""

from __future__ import annotations

import json
import math
import struct
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from erclutch.wings.live.ring import RingInfo

_HEAD = struct.Struct("<IIdd")


def row_of(info: RingInfo) -> np.dtype[Any]:
    """One row: time in s after the first of the message, by deadline; the channels; times in us; words of bits."""
    channels = [channel.name for channel in info.channels]
    numbers = [(name, "<f4") for name in ("time", *channels, "lateness", "step")]
    words = [("flags", "<u4"), ("events", "<u4")]
    return np.dtype([*numbers, *words])


def wire_of(info: RingInfo) -> dict[str, Any]:
    """What the page needs to read a message: bytes before the rows, and the columns of a row, 4 bytes each."""
    return {"head": _HEAD.size, "columns": list(row_of(info).names or ())}


def as_text(body: object) -> str:
    """JSON that each browser reads, whatever a folder is called and whatever a number is.

    Bytes of a name that are no text stay as they came (half a pair of UTF-16), and what is no finite number is null.
    """
    return json.dumps(_finite(body), separators=(",", ":"), allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        entries = cast("dict[str, Any]", value)
        return {name: _finite(entry) for name, entry in entries.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(entry) for entry in cast("list[Any]", value)]
    return value


def pack(frames: NDArray[Any], info: RingInfo, skipped: int) -> bytes:
    """A message: zero, frames skipped before it, time of the first in s since the start, its number; then the rows.

    Args:
        frames: at least one, shape (n,), as a reader of the ring gives them.
        info: of the session.
        skipped: frames that this client did not get, so far.
    """
    due = frames["time_ns"].astype(np.int64) - frames["lateness_ns"]
    out = np.zeros(frames.size, row_of(info))
    out["time"] = (due - due[0]) * 1e-9
    with np.errstate(over="ignore"):  # a number beyond single precision shows as infinite
        for channel in info.channels:
            # A motor that has turned for an hour needs more digits than a float has.
            values = frames[channel.name]
            turns = channel.slot == "theta" and channel.unit == "rad"
            out[channel.name] = np.mod(values, 2 * np.pi) if turns else values
    out["lateness"] = frames["lateness_ns"] * 1e-3
    out["step"] = frames["step_ns"] * 1e-3
    out["flags"] = frames["flags"]
    out["events"] = frames["events"]
    first_time = (int(due[0]) - info.start_ns) * 1e-9
    first_number = float(frames["seq"][0])
    head = _HEAD.pack(0, min(skipped, 0xFFFFFFFF), first_time, first_number)
    return head + out.tobytes()
