"""Companions of a session only look on: the page, the recordings, and the way of the page's commands."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from erclutch.errors import ErclutchError
from erclutch.wings.live.page.page_process import PageProcess
from erclutch.wings.live.page_commands import CommandLimits, PageCommand
from erclutch.wings.live.recording.recordings import Recordings

_PERIOD = 0.05  # s
_NOTES = 50  # the page is sent


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
    ) -> None:
        self._carry_out = carry_out
        self._notes: list[tuple[int, int, str, str]] = []
        self._ended = threading.Event()
        self._lock = threading.RLock()
        self.recordings = Recordings(ring, folder, self.say)
        self.page: PageProcess | None = None
        if page:
            limits = CommandLimits(tuple(name for name, *_ in programs), motor_limit)
            texts = [
                {"name": name, "text": text, "reference": unit} for name, text, unit in programs
            ]
            shown = {"programs": texts, "stroke": stroke, "lead": lead}
            self.page = PageProcess(str(ring), limits, port=port, shown=shown)
        self._thread = threading.Thread(target=self._look_after, daemon=True)
        self._thread.start()

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
        self._notes.append((len(self._notes), time.monotonic_ns(), text, level))

    def record(self, on: bool, *, whole: bool = False) -> None:
        """Start a recording, `whole` with the frames so far, or end it; a failure is said, and raised for a script."""
        with self._lock:
            try:
                if on:
                    self.recordings.start(whole=whole)
                else:
                    self.recordings.stop()
            except ErclutchError as error:
                self.say(str(error), "alarm")
                raise

    def _command(self, command: PageCommand) -> None:
        if command.kind != "record":
            self._carry_out(command)
            return
        with contextlib.suppress(ErclutchError):  # it was said
            self.record(bool(command.value))

    def _look_after(self) -> None:
        while not self._ended.wait(_PERIOD):
            with self._lock:
                self.recordings.poll()
            if self.page is not None:
                restarts = self.page.restarts
                self.page.poll(self._command)
                if self.page.restarts != restarts:
                    self.say("the page's server was gone and was started again", "warning")
                self.page.tell(self._state())

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
        self._thread.join()
        with self._lock:
            self.recordings.stop()
        if self.page is not None:
            self.page.close()

    def __exit__(self, *_: object) -> None:
        self.close()
