"""A session starts recorders, names their files, and goes on recording where a recorder was killed."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from erclutch.errors import ErclutchError
from erclutch.files import unwritable
from erclutch.wings.live.companion_process import CompanionProcess, end_process
from erclutch.wings.live.recording.mcap_file import RecordingError, finish_torn, partial_of
from erclutch.wings.live.recording.recorder import Progress
from erclutch.wings.live.ring import RingReader

_BEGIN = 30.0  # s that a recorder may take to begin on a busy machine; the ring holds frames for twice as long
_END = 10.0  # s that it may take to end its file
_DISK = 3  # exit code of a recorder whose disk ended it


@dataclass(frozen=True)
class Started:
    """A recorder that runs: its process, its file, the frame after which it began, the first file of the recording."""

    process: CompanionProcess
    path: Path
    after: int
    first: Path


class Recordings:
    """At most one recording at a time.

    Args:
        ring: path of the ring.
        folder: where recordings go; made if it is missing.
        say: called with a sentence for people, and note, warning or alarm, whenever a recording starts, ends, fails or
            goes on.

    Attributes:
        progress: state of the recording that runs, or of the last one; None before the first.
        files: finished files, oldest first.
        faults: what was said of each recording that is lost or lacks frames.
    """

    def __init__(
        self,
        ring: str | Path,
        folder: str | Path,
        say: Callable[[str, str], None] = lambda text, level: None,
    ) -> None:
        self.ring = Path(ring)
        self.folder = Path(folder)
        self.progress: Progress | None = None
        self.files: list[Path] = []
        self.faults: list[str] = []
        self._say = say
        self._running: Started | None = None

    @property
    def running(self) -> bool:
        """Whether a recording runs."""
        return self._running is not None

    @property
    def pid(self) -> int | None:
        """Process of the recorder."""
        return self._running.process.pid if self._running else None

    def start(self, name: str | None = None, *, whole: bool = False) -> Path:
        """Start a recording; does nothing if one runs.

        Args:
            name: of the file, without a folder; None: the date and time.
            whole: with the frames that the ring still holds, of the session's first seconds those from the start.

        Raises:
            RecordingError: the folder cannot be made or written. RingError: the session is over.
        """
        if self._running is not None:
            return self._running.path
        stem = name or datetime.now(UTC).strftime("%Y-%m-%dT%H-%M-%SZ")
        with contextlib.closing(RingReader(self.ring)) as reader:
            path = self._reserved(self.folder / f"{stem}.mcap")
            self._start(path, 0 if whole else reader.head - 1, path)
        self._say(f"recording to {path}", "note")
        return path

    def stop(self) -> None:
        """End the recording and wait until its file is whole."""
        started = self._running
        if started is None:
            return
        limit = time.monotonic() + _BEGIN
        while (
            not self._begun(started) and started.process.poll() is None and time.monotonic() < limit
        ):
            # On a busy machine it may not be there yet; the ring still holds its frames.
            time.sleep(0.01)
        with contextlib.suppress(OSError):
            started.process.terminate()
        end_process(started.process, _END)
        self.poll(go_on=False)

    def poll(self, *, go_on: bool = True) -> None:
        """Look after the recorder: read what it says, and start another where it was killed."""
        started = self._running
        if started is None:
            return
        self._listen(started)
        code = started.process.poll()
        if code is None:
            return
        self._listen(started)
        self._running = None
        if code in (0, _DISK):
            self._finished(started, full=code == _DISK)
        elif code < 0:
            self._killed(started, go_on)
        else:
            left = partial_of(started.path)
            if left.exists() and left.stat().st_size == 0:
                left.unlink()
            self._fault(f"the recording to {started.path.name} failed", "alarm")

    def _fault(self, text: str, level: str) -> None:
        self.faults.append(text)
        self._say(text, level)

    def _reserved(self, path: Path) -> Path:
        """A name that is not taken, and from now on is: another session may look for one at the same moment."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            problem, remedy = (
                "the folder of recordings cannot be made",
                "Give another with --folder",
            )
            raise unwritable(self.folder, error, problem, remedy, RecordingError) from error
        if not os.access(self.folder, os.W_OK):
            raise RecordingError(
                "the folder cannot be written", where=str(self.folder), remedy="Give another folder"
            )
        number, free = 2, path
        while True:
            with contextlib.suppress(FileExistsError):
                partial_of(free).touch(exist_ok=False)
                if not free.exists():
                    return free
                partial_of(free).unlink()
            free = path.with_name(f"{path.stem}-{number}.mcap")
            number += 1

    def _start(self, path: Path, after: int, first: Path) -> None:
        words = (str(self.ring), str(path), "--reserved", "--after", str(after))
        process = CompanionProcess("erclutch.wings.live.recording.recorder", *words)
        self._running = Started(process, path, after, first)

    def _begun(self, started: Started) -> bool:
        """Whether the recorder has said something."""
        self._listen(started)
        return self.progress is not None and self.progress.path == str(started.path)

    def _listen(self, started: Started) -> None:
        """What the recorder said of itself; a recorder that was killed may leave a piece of a line."""
        for line in started.process.lines():
            with contextlib.suppress(ValueError, TypeError):
                self.progress = Progress(**json.loads(line))

    def _finished(self, started: Started, *, full: bool) -> None:
        why = self.progress.ended if self.progress and full else ""
        path = started.path
        if self.progress and Path(self.progress.path).name.startswith(f"{path.stem}-"):
            path = Path(self.progress.path)  # its name was taken when it was done
        if path.exists():
            self.files.append(path)
        lost = self.progress.lost if self.progress else 0
        if full:
            self._fault(f"recording {path.name} was ended by the disk: {why}", "alarm")
        elif lost:
            self._fault(
                f"recording {path.name} lacks {lost} frames, which the recorder came too late for",
                "warning",
            )
        else:
            self._say(f"recording {path.name} is complete", "note")

    def _killed(self, started: Started, go_on: bool) -> None:
        """Make a whole file of what a killed recorder left, and go on after its last frame in a further one."""
        after = started.after
        try:
            kept, after = finish_torn(partial_of(started.path), started.path)
            self.files.append(kept)
        except ErclutchError:  # it was killed before a frame was on the disk
            pass
        partial_of(started.path).unlink(missing_ok=True)
        if not go_on:
            self._fault(
                f"the recorder of {started.path.name} was killed; what it wrote was kept", "warning"
            )
            return
        again = self._reserved(started.first)
        self._start(again, after, started.first)
        self._say(f"the recorder was killed; another goes on in {again.name}", "warning")

    def wait_for_frames(self, seconds: float = 5.0) -> bool:
        """Wait until the file of the recorder that runs has frames; whether it has. For scripts and tests."""
        limit = time.monotonic() + seconds
        while time.monotonic() < limit and self._running is not None:
            self.poll()
            if (
                self._running
                and self._begun(self._running)
                and self.progress
                and self.progress.frames
            ):
                return True
            time.sleep(0.01)
        return False
