"""A ring that something writes at 1 kHz, as the loop would."""

from __future__ import annotations

import os
import tempfile
import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.wings.live.layout import FRAME
from erclutch.wings.live.ring import RingInfo, State, make_ring, ring_folder


def make_frames(count: int) -> Any:
    """Frames of a pair that follows a sine of 1 Hz, shape (count,): plausible numbers, quick to make."""
    rng = np.random.default_rng(0)
    frames = np.zeros(count, FRAME)
    frames["seq"] = np.arange(count)
    wave = np.sin(2 * np.pi * frames["seq"] / 1000)
    frames["theta_dot"], frames["alpha_dot"] = 40 + 3 * wave, 30 * np.roll(wave, -250)
    frames["theta"], frames["alpha"] = np.cumsum(frames["theta_dot"]) / 1000, 5 * wave
    frames["field1"], frames["field2"] = np.maximum(0.4 * wave, 0), np.maximum(-0.4 * wave, 0)
    frames["motor_torque"], frames["reference"] = 0.1, 5 * np.roll(wave, -20)
    frames["estimate"] = 0.9 * wave * np.abs(wave) + 0.01 * wave
    frames["torque"] = frames["estimate"] + rng.normal(size=count) * 1e-3
    frames["time_ns"] = 10**12 + frames["seq"] * 1_000_000 + 30_000
    frames["lateness_ns"], frames["step_ns"] = 30_000, 9_000
    return frames


class Loop:
    """Writes frames at 1 kHz into a ring, from a thread.

    Attributes:
        path: the ring.
        events: bits that the next frame gets.
        flags: of every frame.
    """

    def __init__(self, folder: Path, frames: Any, ring_writer: Any, **info: Any) -> None:
        self.path = folder / "ring"
        self.info = RingInfo(
            model="fnn-16",
            digest="ab" * 32,
            start_ns=time.monotonic_ns(),
            start_unix_ns=time.time_ns(),
            **info,
        )
        make_ring(self.path, self.info)
        self.writer = ring_writer(self.path)
        self.events = 0
        self.flags = 0
        self._frames = frames.copy()
        self._ended = threading.Event()
        self.writer.put(state=State.RUNNING, pid=os.getpid(), realtime="a thread of the tests")
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def head(self) -> int:
        return self.writer.head

    def _run(self) -> None:
        step = 0
        while not self._ended.is_set():
            # In bursts, so that a thread of Python keeps the pace on a busy machine.
            due = int((time.monotonic_ns() - self.info.start_ns) // self.info.period_ns)
            while step < due:
                frame = self._frames[step % len(self._frames)]
                frame["time_ns"] = self.info.start_ns + (step + 1) * self.info.period_ns + 30_000
                frame["events"], self.events = self.events, 0
                frame["flags"] = self.flags
                self.writer.write(frame)
                step += 1
            time.sleep(0.002)

    def stop(self) -> None:
        self._ended.set()
        self._thread.join()


@pytest.fixture(scope="session")
def frames() -> Any:
    """Four seconds."""
    return make_frames(4000)


@contextmanager
def _starter(frames: Any, ring_writer: Any) -> Generator[Callable[..., Loop]]:
    with tempfile.TemporaryDirectory(dir=ring_folder(), prefix="erclutch-test-") as folder:
        loops: list[Loop] = []

        def start(**info: Any) -> Loop:
            place = Path(folder) / str(len(loops))
            place.mkdir()
            loops.append(Loop(place, frames, ring_writer, **info))
            return loops[-1]

        yield start
        for loop in loops:
            loop.stop()
            loop.writer.close()


@pytest.fixture
def start_loop(frames: Any, ring_writer: Any) -> Generator[Callable[..., Loop]]:
    """Starts a `Loop`; it ends with the test."""
    with _starter(frames, ring_writer) as start:
        yield start


@pytest.fixture(scope="module")
def shared_loop(frames: Any, ring_writer: Any) -> Generator[Loop]:
    """A `Loop` for tests that leave it as it is."""
    with _starter(frames, ring_writer) as start:
        yield start()
