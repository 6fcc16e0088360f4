"""A job is one erclutch command as a process of its own, which ends with the page's server.

The process is this module, started with ``python -m``. It runs the command line, and interrupts it as Ctrl-C does when
its standard input ends: the server closes it to cancel a job, and the system closes it when the server dies.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

from erclutch.cli.terminal import PROGRESS
from erclutch.wings.app.workspace import WorkspaceError

_MOST_LINES = 2000  # of a job's output that are kept, the last ones
_MOST_RUNNING = 4  # jobs at once
_MOST_LOOKING = 4  # looks at a log at once
_MOST_KEPT = 200  # jobs that the page remembers
_MOST_LOOKS = 20  # looks at logs that are remembered
_PATIENCE = 10.0  # s that an interrupted command has to end


class Job:
    """One command.

    Args:
        number: of the job.
        title: what it does, for people.
        words: the command's words behind ``erclutch``.
        folder: where it runs.
        result: file or folder in it that the command writes.
        back: address of the page that asked for it.
        whole: whether its output is kept as it is in ``output``, to be shown on that page.

    Attributes:
        lines: what it printed, the last 2,000 lines.
        share: how much is done, 0 to 1; None where that is not known.
        doing: what it does at this moment.
        fitted: RMSE of the models that it has fitted on the training rows, as a share of the effort's standard
            deviation, by name; None where it is not known.
        cancelled: whether somebody cancelled it.
    """

    def __init__(
        self,
        number: int,
        title: str,
        words: Sequence[str],
        folder: Path,
        result: str | None = None,
        back: str = "/",
        whole: bool = False,
    ) -> None:
        self.number = number
        self.title = title
        self.words = tuple(words)
        self.result = result
        self.back = back
        self.whole = whole
        self.output = b""
        self.lines: deque[str] = deque(maxlen=_MOST_LINES)
        self.share: float | None = None
        self.doing = "starting"
        self.fitted: dict[str, float | None] = {}
        self.cancelled = False
        self._began = time.monotonic()
        self._ended = 0.0
        self._process = start(words, folder)
        pipes = self._process.stdout, self._process.stderr
        self._readers = [
            threading.Thread(
                target=self._read,
                args=(pipe,),
                daemon=True,
            )
            for pipe in pipes
        ]
        self._waiter = threading.Thread(target=self._wait, daemon=True)
        for thread in (*self._readers, self._waiter):
            thread.start()
        self.code: int | None = None

    @property
    def seconds(self) -> float:
        """How long it has run."""
        return (self._ended or time.monotonic()) - self._began

    @property
    def state(self) -> str:
        """running, done, cancelled or failed."""
        if self.code is None:
            return "running"
        # A log that is not understood has been looked at.
        if self.code == 0 or (self.whole and self.output):
            return "done"
        return "cancelled" if self.cancelled else "failed"

    def cancel(self) -> None:
        """Interrupt it as Ctrl-C does; it is killed if it does not end within 10 s."""
        self.cancelled = self.code is None
        close_input(self._process)
        timer = threading.Timer(_PATIENCE, self._process.kill)
        timer.daemon = True
        timer.start()

    def join(self, seconds: float) -> None:
        """Wait for its end, for so long at most."""
        self._waiter.join(seconds)

    def _read(self, pipe: IO[bytes]) -> None:
        with contextlib.suppress(OSError, ValueError), pipe:
            if self.whole and pipe is self._process.stdout:
                self.output = pipe.read()
            for raw in pipe:
                line = raw.decode("utf-8", "replace").rstrip()
                if line.startswith(PROGRESS):
                    self._take_progress(line.removeprefix(PROGRESS))
                else:
                    self.lines.append(line[:4000])

    def _take_progress(self, text: str) -> None:
        # A name of a log may stand where a line of ours is expected, so the line is believed only as a whole.
        with contextlib.suppress(ValueError, TypeError, KeyError):
            line = json.loads(text)
            done = float(line["done"])
            total = line["total"]
            doing = str(line["doing"])
            share = min(done / total, 1.0) if total else None
            model = str(line.get("fitted", ""))
            train_share = line.get("train_share")
            off = None if train_share is None else float(train_share)
            self.doing, self.share = doing, share
            if model:
                self.fitted[model] = off

    def _wait(self) -> None:
        code = self._process.wait()
        for reader in self._readers:
            reader.join()
        close_input(self._process)
        self._ended = time.monotonic()
        self.code = code


class Jobs:
    """The jobs of a server, the newest first.

    Args:
        folder: where they run.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._jobs: dict[int, Job] = {}
        self._looks: dict[object, Job] = {}
        self._number = 0

    def __iter__(self) -> Any:
        return reversed(tuple(self._jobs.values()))

    def get(self, number: int) -> Job | None:
        """A job, if there is one of this number."""
        return self._jobs.get(number)

    @property
    def full(self) -> bool:
        """Whether as many jobs run as may; looks at logs do not count."""
        return sum(job.code is None and not job.whole for job in self) >= _MOST_RUNNING

    def begin(self, title: str, words: Sequence[str], **others: Any) -> Job:
        """Start a command; the other arguments are those of `Job`."""
        self._number += 1
        job = self._jobs[self._number] = Job(self._number, title, words, self._folder, **others)
        ended = [number for number, each in self._jobs.items() if each.code is not None]
        for number in ended[: max(0, len(self._jobs) - _MOST_KEPT)]:
            del self._jobs[number]
        return job

    def look(
        self,
        title: str,
        words: Sequence[str],
        state: object,
        back: str,
    ) -> Job:
        """The job that looks at a log so: one that did while the files were in this state, or a new one.

        Raises:
            WorkspaceError: as many look already as may.
        """
        key = (tuple(words), state)
        job = self._looks.get(key)
        if job is None or job.state in ("cancelled", "failed"):
            if sum(each.code is None and each.whole for each in self) >= _MOST_LOOKING:
                raise WorkspaceError(
                    "four logs are being looked at", remedy="Wait for one of them, then reload"
                )
            job = self._looks[key] = self.begin(title, words, back=back, whole=True)
        for old in list(self._looks)[:-_MOST_LOOKS]:
            del self._looks[old]
        return job

    def close(self) -> None:
        """Cancel all, and wait for their end."""
        for job in self:
            if job.code is None:
                job.cancel()
        for job in self:
            job.join(_PATIENCE + 1.0)


def start(words: Sequence[str], folder: Path) -> subprocess.Popen[bytes]:
    """Start a command in a folder, with pipes to its output; it ends when its standard input is closed."""
    surroundings = {
        **os.environ,
        "NO_COLOR": "1",
        "COLUMNS": "120",
        "PYTHONUTF8": "1",
        "PYTHONUNBUFFERED": "1",
        "ERCLUTCH_PROGRESS": "lines",
    }
    # By -P no module is taken out of the folder.
    command = [sys.executable, "-P", "-m", "erclutch.wings.app.jobs", *words]
    pipe = subprocess.PIPE
    # A group of its own, so that Ctrl-C at the server reaches it through the server alone; not a session of its own, to
    # which Linux would give processor time beside that of all others.
    return subprocess.Popen(
        command,
        cwd=folder,
        env=surroundings,
        stdin=pipe,
        stdout=pipe,
        stderr=pipe,
        process_group=0,
    )


def close_input(process: subprocess.Popen[bytes]) -> None:
    """Say to a command that it shall end."""
    if process.stdin is not None:
        with contextlib.suppress(OSError):
            process.stdin.close()


# --- the command's side -----------------------------------------------------------------------------------------------


def main() -> int:
    """Run the command line until it ends or standard input does; returns the exit code."""
    from erclutch.cli import main as command_line

    def watch(descriptor: int) -> None:
        with contextlib.suppress(OSError):
            while os.read(descriptor, 4096):
                pass
        os.kill(os.getpid(), signal.SIGINT)

    signal.signal(signal.SIGINT, signal.default_int_handler)
    # What the command starts must not hold the pipe: it gets an empty standard input.
    pipe = os.dup(sys.stdin.fileno())
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), sys.stdin.fileno())
    threading.Thread(target=watch, args=(pipe,), daemon=True).start()
    code = command_line()
    # It is done: who cancels it only now does not make a cancelled command of it. A signal that is ignored stays so
    # while Python ends, and others get their default back.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return code


if __name__ == "__main__":
    sys.exit(main())
