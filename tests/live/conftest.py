from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.live.c_build import build
from erclutch.live.layout import FRAME, HEADER
from erclutch.live.ring import RingReader

HERE = Path(__file__).parent


class RingWriter(RingReader):
    """Writes frames as the loop does. One a ring."""

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        size = HEADER.itemsize
        self._header = np.memmap(path, HEADER, "r+", shape=1)
        self._head = self._header["head"]
        self._frames = np.memmap(path, FRAME, "r+", size, self.info.capacity)

    def write(self, frame: Any) -> None:
        """Append one frame (a record or 0-d array of dtype `FRAME`); its number is set here."""
        head = self.head
        slot = head % self.info.capacity
        self._frames[slot] = frame
        self._frames["seq"][slot] = head
        self._head[0] = head + 1
        events = int(self._frames["events"][slot])
        for bit in range(events.bit_length()):
            if events >> bit & 1:
                self._header["counts"][0][bit] += 1

    def put(self, **values: Any) -> None:
        """Set entries of the header that are the loop's: state, pid, mode, program, realtime, trip_reason."""
        for name, value in values.items():
            self._header[name][0] = value.encode() if isinstance(value, str) else value


@pytest.fixture(scope="session")
def ring_writer() -> type[RingWriter]:
    """The writer's side of a ring, for tests without a loop."""
    return RingWriter


@pytest.fixture(scope="session")
def bingham() -> Path:
    """The hand-written model, compiled."""
    return build("bingham.so", [HERE / "bingham.c"], shared=True)


@pytest.fixture(scope="session")
def brake() -> Path:
    """The hand-written model of a single device, compiled."""
    return build("brake.so", [HERE / "bingham.c"], shared=True, flags=("-DSINGLE",))
