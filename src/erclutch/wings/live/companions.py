"""Companions of a session only look on: the page, the recordings, and the way of the page's commands."""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from erclutch.errors import ErclutchError
from erclutch.wings.live.page.page_process import PageProcess
from erclutch.wings.live.page_commands import CommandLimits, PageCommand
from erclutch.wings.live.recording.mcap_file import RecordingError
from erclutch.wings.live.recording.recordings import Recordings

_PERIOD = 0.05  # s
_NOTES = 50  # the page is sent
_MOST_NOTES = 1000  # that are kept


class Observers(contextlib.AbstractContextManager["Observers"]):
    """The page and the recorder of a session, looked after by a thread. Use it as a context.

    Args:
        ring: path of the session's ring.
        carry_out: gets the page's commands to the loop (zero, reset, program, motor); called from a thread.
        programs: names of the session's programs, what they do, and what follows their reference: position, effort or
            nothing.
        motor_limit: largest motor torque in N m that the page may ask for.
        folder: where recordings go.
        page: show the page; without it only recordings are looked after.
        port: of the page; 0 lets the system choose.
        stroke: how far the output may go either way in rad, for the picture; 0 if unknown.
        lead: of the screw in m, for the picture; 0 if there is none.
        while_waiting: called again and again until the page is there; what it raises ends the page.

    Raises:
        PageError: the page cannot be shown.
    """

    def __init__(
        self,
        ring: str | Path,
        carry_out: Callable[[PageCommand], None],
        *,
        programs: Sequence[tuple[str, str, str]] = (),
        motor_limit: float = 0.0,
        folder: str | Path = "recordings",
        page: bool = True,
        port: int = 0,
        stroke: float = 0.0,
        lead: float = 0.0,
        while_waiting: Callable[[], None] = lambda: None,
    ) -> None:
        self._carry_out = carry_out
        self._notes: list[tuple[int, int, str, str]] = []
        self._said = 0
        self._ended = threading.Event()
        self._lock = threading.RLock()  # of the recordings
        self._asked: deque[bool] = deque()  # recordings that the page wants to start or end
        self._brief = threading.Lock()  # of the notes, and of what is asked for
        self.recordings = Recordings(ring, folder, self.say)
        self.page: PageProcess | None = None
        if page:
            limits = CommandLimits(tuple(name for name, *_ in programs), motor_limit)
            texts = [
                {"name": name, "text": text, "reference": unit} for name, text, unit in programs
            ]
            shown = {"programs": texts, "stroke": stroke, "lead": lead}
            self.page = PageProcess(
                str(ring), limits, port=port, shown=shown, while_waiting=while_waiting
            )
        # Each in a thread of its own: a recording takes seconds to begin and to end, and an order for the loop
        # (zero the fields!) waits for none of them.
        self._threads = [threading.Thread(target=self._look_after_recordings, daemon=True)]
        if self.page is not None:
            looks = partial(self._look_after_page, self.page)
            self._threads.append(threading.Thread(target=looks, daemon=True))
        for thread in self._threads:
            thread.start()

    @property
    def url(self) -> str:
        """Address of the page with its token; empty without a page."""
        return self.page.access.url if self.page else ""

    @property
    def notes(self) -> tuple[str, ...]:
        """What was said so far."""
        return tuple(text for _, _, text, _ in self._notes)

    def say(self, text: str, level: str = "note") -> None:
        """A line in the page's log of events; level is note, warning or alarm."""
        with self._brief:
            self._notes.append((self._said, time.monotonic_ns(), text, level))
            self._said += 1
            del self._notes[:-_MOST_NOTES]

    def record(self, on: bool, *, whole: bool = False) -> None:
        """Start a recording, `whole` with the frames so far, or end it; a failure is said, and raised for a script."""
        with self._lock:
            try:
                if on:
                    self.recordings.start(whole=whole)
                else:
                    self.recordings.stop()
            except OSError as error:
                self.say(f"no recording can be started: {error.strerror or error}", "alarm")
                raise RecordingError(
                    f"no recording can be started: {error.strerror or error}",
                    where=str(self.recordings.folder),
                    remedy="Free space, or give another place with --folder",
                ) from error
            except ErclutchError as error:
                self.say(str(error), "alarm")
                raise

    def _command(self, command: PageCommand) -> None:
        if command.kind != "record":
            self._carry_out(command)
            return
        # What is asked for twice is done once, and a third change undoes the second: no click has to wait for many.
        wanted = bool(command.value)
        with self._brief:
            if self._asked and self._asked[-1] == wanted:
                return
            if len(self._asked) < 2:
                self._asked.append(wanted)
            else:
                self._asked.pop()

    def _look_after_recordings(self) -> None:
        while not self._ended.wait(_PERIOD):
            with self._lock:
                self.recordings.poll()
            while self._asked and not self._ended.is_set():
                with contextlib.suppress(ErclutchError):  # it was said
                    self.record(self._asked[0])
                with self._brief:
                    self._asked.popleft()

    def _look_after_page(self, page: PageProcess) -> None:
        while not self._ended.wait(_PERIOD):
            restarts = page.restarts
            # Where no process can be started now, the next look tries again.
            with contextlib.suppress(OSError):
                page.poll(self._command)
            if page.restarts != restarts:
                self.say("the page's server was gone and was started again", "warning")
            page.tell(self._state())

    def _state(self) -> dict[str, Any]:
        recording: dict[str, Any] = {
            "on": self.recordings.running,
            "folder": str(self.recordings.folder),
            "files": [path.name for path in self.recordings.files[-20:]],
        }
        progress = self.recordings.progress
        if progress is not None:
            recording |= asdict(progress)
            recording["path"] = Path(progress.path).name
        return {"recording": recording, "notes": self._notes[-_NOTES:]}

    def close(self) -> None:
        """End the recording and the page."""
        self._ended.set()
        for thread in self._threads:
            thread.join()
        with self._lock:
            self.recordings.stop()
        if self.page is not None:
            self.page.close()

    def __exit__(self, *_: object) -> None:
        self.close()
