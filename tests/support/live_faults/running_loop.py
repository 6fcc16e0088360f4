"""The whole live loop in its own process, against a rig in another thread that notes what it is told."""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from erclutch.wings.live.c_build import loop_program
from erclutch.wings.live.orders import Order, order_bytes
from erclutch.wings.live.ring import RingInfo, RingReader, State, make_ring, ring_folder
from erclutch.wings.live.settings import config_of
from erclutch.wings.rig.interface import Measurement, RigCommand
from erclutch.wings.rig.rig_server import RigServer
from tests.support.live_faults.finding import (
    DIGEST,
    MODEL,
    chosen,
    compiled_model,
)


@dataclass
class Spy:
    """A rig that runs well and keeps what it was told, with times.

    Attributes:
        told: (monotonic time, field on, step of the rig) whenever a command was applied.
    """

    period: float = 1e-3
    told: list[tuple[float, bool, int]] = field(default_factory=list)
    rows: int = 0

    def sense(self) -> Measurement:
        """Sensors of a motor at 40 rad/s."""
        t = self.rows * self.period
        return Measurement(t, 40.0 * t, 0.0, 0.0, 0.0)

    def command(self, command: RigCommand) -> None:
        """Keep it."""
        self.told.append((time.monotonic(), command.E1 > 0.0 or command.E2 > 0.0, self.rows))

    def step(self) -> None:
        """Time passes."""
        self.rows += 1

    def close(self) -> None:
        """Nothing."""

    def __enter__(self) -> Spy:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def zero_since(self, moment: float) -> float:
        """Seconds from a moment until the field was zero for good; inf if it still is on."""
        return max(0.0, self._end()[0] - moment)

    def steps_with_field(self) -> float:
        """Steps of the rig's own clock from the last command with a field to zero; inf if it still is on."""
        last = max((k for k, (_, on, _) in enumerate(self.told) if on), default=-1)
        return self._end()[1] - (self.told[last][2] if last >= 0 else 0)

    def commands_of_zero(self) -> int:
        """Since the last one with a field; the watchdog's are among them."""
        last = max((k for k, (_, on, _) in enumerate(self.told) if on), default=-1)
        return len(self.told) - 1 - last

    def _end(self) -> tuple[float, float]:
        """When the field went to zero for good: time and step."""
        last = max((k for k, (_, on, _) in enumerate(self.told) if on), default=-1)
        return (
            (self.told[last + 1][0], self.told[last + 1][2])
            if last + 1 < len(self.told)
            else (math.inf, math.inf)
        )


@dataclass
class Running:
    """A loop in its own process, its rig in a thread of this one."""

    ring: Path
    loop: subprocess.Popen[bytes]
    spy: Spy
    server: RigServer
    reader: RingReader

    def ready(self, steps: int = 30, reset: bool = False) -> None:
        """Wait until the field is on; a trip before it ends the wait, or is reset (with ``--orders 0``)."""

        def over() -> bool:
            tripped = self.reader.state is State.TRIPPED
            if reset and tripped and self.loop.stdin is not None:
                os.write(
                    self.loop.stdin.fileno(), order_bytes(Order.RESET) + order_bytes(Order.PROGRAM)
                )
            return self._steady(steps) or (tripped and not reset)

        until(over, 30.0)
        if self._steady(steps):
            return
        said = self.loop.stderr.read() if self.loop.poll() is not None and self.loop.stderr else b""
        raise NeverReadyError(
            f"the loop does not run: {said!r}, {self.reader.trip_reason or 'not tripped'}"
        )

    def _steady(self, steps: int) -> bool:
        frames = self.reader.latest(steps)
        return len(frames) == steps and bool((frames["field1"] > 0).all())

    def zero(self) -> bool:
        """Wait until the rig's field is zero; whether it came to that."""
        return until(lambda: not self.spy.told[-1][1], 5.0)

    def held_up(self) -> bool:
        """Whether the loop tripped for a delay that it recorded itself: its own, or 20 periods without a sample."""
        frames = self.reader.latest(self.reader.info.capacity)
        late = bool((frames["lateness_ns"] > 1e7).any())
        deadlines = frames["time_ns"].astype(np.int64) - frames["lateness_ns"]
        missed = int(np.rint(np.diff(deadlines) / self.reader.info.period_ns).sum()) - (
            len(frames) - 1
        )
        return self.reader.state is State.TRIPPED and (
            late or self.reader.counts["sample-lost"] + missed >= 20
        )


class NeverReadyError(RuntimeError):
    """The loop did not come to run, so nothing could be injected."""


def until(true: Callable[[], bool], seconds: float) -> bool:
    """Wait for something; whether it came."""
    limit = time.monotonic() + seconds
    while not true():
        if time.monotonic() > limit:
            return False
        time.sleep(0.002)
    return True


@contextlib.contextmanager
def running(
    model: Path = MODEL, *words: str, wrapper: tuple[str, ...] = (), port: int | None = None
) -> Iterator[Running]:
    """Start the loop and its rig: a thread's, or one that listens at a port already."""
    with tempfile.TemporaryDirectory(dir=ring_folder()) as name:
        folder = Path(name)
        (folder / "config").write_bytes(config_of(chosen())[0])
        ring = make_ring(folder / "ring", RingInfo(capacity=8192))
        library = compiled_model(model)
        spy = Spy()
        server = RigServer(spy, session=42, lead=0.01, device=chosen().device)
        stop = threading.Event()
        thread = threading.Thread(target=serve, args=(server, stop), daemon=True)
        thread.start()
        loop = subprocess.Popen(
            [
                *wrapper,
                *(str(loop_program()), "--config", str(folder / "config"), "--ring", str(ring)),
                *(
                    "--udp",
                    "127.0.0.1",
                    str(port or server.port),
                    "0",
                    "42",
                    "--model",
                    str(library),
                    DIGEST,
                    *words,
                ),
            ],
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        reader = RingReader(ring)
        try:
            yield Running(ring, loop, spy, server, reader)
        finally:
            loop.kill()
            loop.communicate()
            stop.set()
            thread.join()
            reader.close()


def serve(server: RigServer, stop: threading.Event) -> None:
    """The rig's thread, ahead of ordinary work where that is permitted."""
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(70))
    server.run(stop.is_set)
