"""Companions of a session run as processes of their own, which say in JSON lines how they are."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Any

_LOOK = 0.05  # s


class CompanionProcess(subprocess.Popen[bytes]):
    """A module of this package as a process; Ctrl-C is the session's business and does not reach it.

    Args:
        module: its name.
        words: of its command line.
        listens: whether it reads its standard input.
    """

    def __init__(self, module: str, *words: str, listens: bool = False) -> None:
        stdin = subprocess.PIPE if listens else subprocess.DEVNULL
        command = [sys.executable, "-P", "-m", module, *words]
        super().__init__(
            command,
            stdin=stdin,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        self._lines: SimpleQueue[bytes] = SimpleQueue()
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()
        self._begun = b""  # the rest of a line of which the process has a part
        self._next = b""  # the newest line
        self._took = time.monotonic()  # when the process took something, or had nothing to take
        if self.stdin is not None:
            os.set_blocking(self.stdin.fileno(), False)

    def _listen(self) -> None:
        assert self.stdout is not None
        with contextlib.suppress(OSError, ValueError), self.stdout:
            for line in self.stdout:
                self._lines.put(line)
        self._lines.put(b"")

    def answer(
        self, timeout: float, while_waiting: Callable[[], None] = lambda: None
    ) -> dict[str, Any]:
        """What its next line says, once it was told all; nothing if none comes in this time [s], or ever.

        Meanwhile ``while_waiting`` is called again and again; what it raises ends the wait.
        """
        limit = time.monotonic() + timeout
        while time.monotonic() < limit:
            while_waiting()
            if self.stdin is not None:
                self.push()
            with contextlib.suppress(Empty):
                line = self._lines.get(timeout=_LOOK)
                with contextlib.suppress(ValueError):
                    return json.loads(line)
                return {}
        return {}

    def lines(self) -> list[bytes]:
        """The lines since the last call: all that it wrote, if it has ended."""
        if self.poll() is not None:
            self._listener.join(1.0)
        return [self._lines.get() for _ in range(self._lines.qsize())]

    def tell(self, body: dict[str, Any]) -> None:
        """Write a line to its standard input, which takes the place of one that waits there; `push` goes on with it."""
        self._next = json.dumps(body).encode() + b"\n"
        self.push()

    def push(self) -> None:
        """Write what its standard input takes now. Whoever reads nothing is not waited for."""
        assert self.stdin is not None
        with contextlib.suppress(OSError, ValueError):
            while self._begun or self._next:
                if not self._begun:
                    self._begun, self._next = self._next, b""
                written = os.write(self.stdin.fileno(), self._begun)
                self._begun = self._begun[written:]
                self._took = time.monotonic()
        if not self._begun:
            self._took = time.monotonic()

    @property
    def deaf(self) -> float:
        """For how many seconds it has not read what it was told."""
        return time.monotonic() - self._took


def end_process(process: subprocess.Popen[Any], seconds: float) -> None:
    """Close the standard input of a process, wait for its end, and kill it when it does not end in time."""
    if process.stdin is not None:
        with contextlib.suppress(OSError):
            process.stdin.close()
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
