from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.signals.speed import Derivative, live
from erclutch.wings.live.c_build import build
from erclutch.wings.live.layout import FRAME, HEADER
from erclutch.wings.live.ring import RingReader
from tests.support.exported_models import boards, law, models, need, network
from tests.wings.own_machine import own_machine

__all__ = ["boards", "law", "models", "need", "network", "own_machine"]


HERE = Path(__file__).parent


class RingWriter(RingReader):
    """Writes frames as the loop does. One a ring."""

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        size = HEADER.itemsize
        self._header = np.memmap(path, HEADER, "r+", shape=1)
        self._head = self._header["head"]
        self._frames = np.memmap(
            path, FRAME, "r+", size, self.info.capacity
        )  # as the loop calls its numbers

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


def _as_filtered(rate: Any) -> Any:
    follows = live(Derivative("kalman"), 1e-3)
    follows.position, follows.speed = 0.0, float(rate[0])
    way = np.cumsum(0.5e-3 * (rate[1:] + rate[:-1]))
    return np.append(rate[0], [follows.step(float(x)) for x in way])


def _asks(frame: Any, model: Any, wanted: float, near: float) -> bool:
    speeds = float(frame["theta_dot"]), float(frame["alpha_dot"])
    if (
        abs(model.steady((float(frame["field1"]), float(frame["field2"]), *speeds)) - wanted)
        <= near
    ):
        return True
    return (
        abs(float(frame["field1"] - frame["field2"]) - model.inverse((0.0, 0.0, *speeds), wanted))
        < 1e-9
    )


@pytest.fixture
def asks() -> Any:
    """Whether a frame's field is what a model of the pair needs for a torque, within a torque, or its inverse."""
    return _asks


@pytest.fixture
def as_filtered() -> Any:
    """Makes a reference's rate as late as the filter of the output's speed is."""
    return _as_filtered
