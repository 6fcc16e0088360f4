"""The recorder is a process of its own that takes frames from the ring and puts them into a file.

It writes what is there every 40 ms, so a kill -9 costs less than 0.1 s, and not even that where the session starts
another recorder: the ring holds a minute, and the new one goes on after the last frame in the file of the old one.
A full disk ends the recording; the file stays whole and the loop never notices.

As a process (``python -m erclutch.wings.live.recording.recorder RING FILE --after SEQ``) it writes its state as JSON
lines to standard output, and ends with a whole file at SIGTERM, SIGINT, when its parent is gone, or when the loop is.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shlex
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from erclutch.errors import ErclutchError
from erclutch.wings.live.recording.mcap_file import FrameFile
from erclutch.wings.live.ring import RingReader, State

PERIOD = 0.04  # s between chunks
_SYNC = 1.0  # s between requests to put it on the disk
_REPORT = 0.25  # s
_GONE = 2.0  # s without a frame after which it looks whether the loop lives
#: Frames taken at once: what a recorder that comes late finds is written in pieces, of which a small disk takes some.
_MOST = 256
_STOPS = (signal.SIGTERM, signal.SIGINT)


@dataclass(frozen=True)
class Progress:
    """State of a recording.

    Attributes:
        path: the file.
        frames: how many are in it.
        size: its bytes.
        last: number of the last frame in it, -1 before the first.
        lost: frames that the ring no longer had when the recorder came to them.
        seconds: recorded time.
        ended: why it ended; empty while it runs.
    """

    path: str
    frames: int
    size: int
    last: int
    lost: int
    seconds: float
    ended: str = ""


class FrameRecorder:
    """Ring to file, a step at a time.

    Args:
        ring: path of the ring.
        path: file to write.
        after: number of the last frame that another file has; None: begin now.
        reserved: the name was taken for this recorder, by an empty unfinished file.

    Attributes:
        reader: of the ring.
        file: that it writes.
        ended: why it ended; empty while it runs.

    Raises:
        RingError: no ring; RecordingError: the file cannot be made.
    """

    def __init__(
        self,
        ring: str | Path,
        path: str | Path,
        after: int | None = None,
        *,
        reserved: bool = False,
    ) -> None:
        self.reader = RingReader(ring, "now" if after is None else "oldest")
        self._after = -1 if after is None else after
        self.file = FrameFile(path, self.reader.info, reserved=reserved)
        self._last = -1
        self._lost = 0
        self.ended = ""

    @property
    def progress(self) -> Progress:
        """How it is."""
        seconds = self.file.frames * self.reader.info.period_ns * 1e-9
        return Progress(
            str(self.file.path),
            self.file.frames,
            self.file.size,
            self._last,
            self._lost,
            seconds,
            self.ended,
        )

    def step(self) -> int:
        """Write the frames that came since the last call; returns how many. A failure to write ends the recording."""
        written = 0
        while not self.ended:
            frames = self.reader.read(_MOST)
            last = max(self._after, self._last)
            fresh = frames[frames["seq"].astype("i8") > last]
            if not fresh.size:
                break
            try:
                self.file.write(fresh)
            except OSError as error:
                self.ended = f"it could not be written: {error.strerror or error}"
                break
            before = self._last if self._last >= 0 else self._after
            first = int(fresh["seq"][0])
            self._lost += int(fresh["seq"][-1]) - first + 1 - fresh.size
            if before >= 0:
                self._lost += first - before - 1
            self._last = int(fresh["seq"][-1])
            written += int(fresh.size)
        return written

    def close(self) -> None:
        """Write what is left and end the file."""
        self.step()
        try:
            self.file.close()
        except OSError as error:
            remedy = (
                f"erclutch inspect {shlex.quote(f'{self.file.path}.partial')} reads what is there"
            )
            self.ended = f"{self.ended or 'it could not be closed: ' + (error.strerror or str(error))}; {remedy}"
        self.reader.close()


class _Process:
    """The recorder as a process: when to stop, and what to say."""

    def __init__(self, recorder: FrameRecorder) -> None:
        self.recorder = recorder
        self.parent = os.getppid()
        self.stopped = False
        self._fresh = time.monotonic()
        for number in _STOPS:
            signal.signal(number, self._stop)
        with contextlib.suppress(OSError):
            os.set_blocking(sys.stdout.fileno(), False)

    def _stop(self, *_: object) -> None:
        self.stopped = True

    def run(self) -> None:
        """Until told to stop, or until there is nobody to record for."""
        synced = said = time.monotonic()
        self.say()
        while not (self.stopped or self.recorder.ended):
            time.sleep(PERIOD)
            now = time.monotonic()
            if self.recorder.step():
                self._fresh = now
            elif self._over(now):
                break
            if now - synced >= _SYNC:
                self.recorder.file.sync()
                synced = time.monotonic()
            if now - said >= _REPORT:
                self.say()
                said = now
                if os.getppid() != self.parent:
                    break
        self.recorder.close()
        self.say(self.recorder.ended or "stopped")
        # Python gives signals back their default as it ends, and the session's request to stop may come only then: its
        # file is whole, so it ends as finished and not as killed. A signal that is ignored stays so.
        for number in _STOPS:
            signal.signal(number, signal.SIG_IGN)

    def _over(self, now: float) -> bool:
        """Whether the loop is gone, which is only worth a look when no frame came."""
        reader = self.recorder.reader
        if reader.state == State.STOPPED:
            return True
        if now - self._fresh <= _GONE or reader.pid <= 0:
            return False
        try:
            os.kill(reader.pid, 0)
        except ProcessLookupError:
            return True
        except OSError:
            pass  # it lives, and is another user's
        return False

    def say(self, ended: str = "") -> None:
        """A line of state; nobody has to read it."""
        body = {**asdict(self.recorder.progress), "ended": ended}
        with contextlib.suppress(OSError):
            line = json.dumps(body) + "\n"
            os.write(sys.stdout.fileno(), line.encode())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run as a process; returns the exit code: 0 a whole file, 2 bad input, 3 the disk ended it."""
    parser = argparse.ArgumentParser(
        prog="erclutch-recorder", description="Frames of a session into an MCAP file."
    )
    parser.add_argument("ring")
    parser.add_argument("file")
    parser.add_argument("--after", type=int, default=None)
    parser.add_argument("--reserved", action="store_true")
    given: Any = parser.parse_args(arguments)
    try:
        recorder = FrameRecorder(given.ring, given.file, given.after, reserved=given.reserved)
        process = _Process(recorder)
    except ErclutchError as error:
        sys.stderr.write(f"error: {error}\n")
        return error.exit_code
    process.run()
    return 3 if process.recorder.ended else 0


if __name__ == "__main__":
    sys.exit(main())
