"""A page holds 290,000 rows: rounded, packed as differences, with as much detail as fits; it says what it left out.

Each signal comes in layers. A layer holds rows [start, stop) either each on its own or as the smallest and largest
value of every ``bucket`` rows. Coarse layers of everything always fit; whole rows are added, the most wanted first,
until the budget of bytes is spent. The page takes the finest layer that covers what is looked at.

A layer is differences of rounded values, modulo 2^16, zigzag, low bytes then high bytes, raw DEFLATE, base64.
"""

from __future__ import annotations

import base64
import zlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array

#: Bytes of base64 for all layers of a page; the page's limit is 2 MB.
BUDGET = 1_300_000
_MOST = 32000  # rounded values reach this far from zero


@dataclass(frozen=True)
class Layer:
    """Some rows of a signal, packed.

    Attributes:
        start, stop: rows.
        bucket: rows a pair of smallest and largest value stands for; 1: each row.
        data: base64.
    """

    start: int
    stop: int
    bucket: int
    data: str


@dataclass
class Channel:
    """A signal of the page.

    Attributes:
        step: shown value = step * integer + middle.
        middle: see step.
        layers: coarse ones first.
    """

    step: float
    middle: float
    layers: list[Layer] = field(default_factory=list[Layer])

    def to_dict(self) -> dict[str, Any]:
        """As JSON values."""
        layers = [[x.start, x.stop, x.bucket, x.data] for x in self.layers]
        return {"step": self.step, "middle": self.middle, "layers": layers}


def channel(values: Array, resolution: float) -> Channel:
    """A channel whose rounding is the resolution, or coarser where the values' range asks for it."""
    low = float(values.min())
    high = float(values.max())
    coarsest = (high - low) / (2 * _MOST)
    return Channel(step=max(resolution, coarsest, 1e-300), middle=0.5 * (low + high))


def rounded(values: Array, made: Channel) -> NDArray[np.int64]:
    """Integers of a channel's values."""
    return np.rint((values - made.middle) / made.step).astype(np.int64)


def coarse(
    values: NDArray[np.int64],
    start: int,
    stop: int,
    bucket: int,
) -> NDArray[np.int64]:
    """Smallest and largest of each bucket of rows, interleaved, shape (2 * buckets,)."""
    first_rows = np.arange(start, stop, bucket)
    smallest = np.minimum.reduceat(values[:stop], first_rows)
    largest = np.maximum.reduceat(values[:stop], first_rows)
    return np.column_stack([smallest, largest]).ravel()


def packed(values: NDArray[np.int64]) -> str:
    """Integers as base64 of deflated bytes."""
    short_steps = np.diff(values, prepend=0).astype(np.int16)
    step = short_steps.astype(np.int32)
    # Zigzag: 0, -1, 1, -2 become 0, 1, 2, 3, so that small steps of both signs have a high byte of zero.
    zigzag = ((step << 1) ^ (step >> 31)).astype("<u2")
    halves = zigzag.view(np.uint8).reshape(-1, 2)
    planes = halves.T.tobytes()  # all low bytes, then all high ones
    squeeze = zlib.compressobj(6, zlib.DEFLATED, -15)
    deflated = squeeze.compress(planes) + squeeze.flush()
    return base64.b64encode(deflated).decode()


def unpacked(data: str) -> NDArray[np.int64]:
    """What `packed` packed; the page does the same."""
    planes = zlib.decompress(base64.b64decode(data), -15)
    planes_of_bytes = np.frombuffer(planes, np.uint8).reshape(2, -1)
    pairs = planes_of_bytes.T.copy()  # low and high byte of each value
    zigzag = pairs.view("<u2").ravel().astype(np.int32)
    step = (zigzag >> 1) ^ -(zigzag & 1)
    whole = np.cumsum(step, dtype=np.int64)
    return ((whole + 32768) % 65536) - 32768


class Packer:
    """Adds layers while they fit."""

    def __init__(self, rows: int, budget: int = BUDGET) -> None:
        self.rows = rows
        self.left = budget
        self.channels: dict[str, Channel] = {}
        self._rounded: dict[str, NDArray[np.int64]] = {}

    def add(
        self,
        name: str,
        values: Array,
        resolution: float,
        buckets: int,
    ) -> None:
        """A channel with its coarse layer over all rows: whole rows where there are few."""
        made = channel(values, resolution)
        integers = rounded(values, made)
        bucket = max(1, -(-self.rows // buckets))
        body = integers if bucket == 1 else coarse(integers, 0, self.rows, bucket)
        data = packed(body)
        made.layers.append(Layer(0, self.rows, bucket, data))
        self.left -= len(data)
        self.channels[name] = made
        self._rounded[name] = integers

    def whole(self, name: str, start: int, stop: int) -> bool:
        """Each of rows [start, stop) of a channel, if they fit; whether they are there."""
        if self.has(name, start, stop):
            return True
        # Nothing packs to less than a sixteenth: do not try what cannot fit.
        if (stop - start) // 12 > self.left:
            return False
        data = packed(self._rounded[name][start:stop])
        if len(data) > self.left:
            return False

        kept: list[Layer] = []
        for layer in self.channels[name].layers:
            held_by_new = layer.bucket == 1 and start <= layer.start and layer.stop <= stop
            if held_by_new:  # its rows are not needed twice
                self.left += len(layer.data)
            else:
                kept.append(layer)
        self.left -= len(data)
        whole = Layer(start, stop, 1, data)  # every row
        self.channels[name].layers = [*kept, whole]
        return True

    def has(self, name: str, start: int, stop: int) -> bool:
        """Whether each of rows [start, stop) of a channel is there."""
        return any(
            layer.bucket == 1 and layer.start <= start and layer.stop >= stop
            for layer in self.channels[name].layers
        )
