"""Folders that take no file: read-only for their owner too, and a disk that is full after 60 kB."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from tests.support.races import words_of

#: A superuser writes where nobody may, unless this capability is taken away.
_AS_OTHERS = ("setpriv", "--bounding-set", "-dac_override,-dac_read_search", "--inh-caps", "-all")
FULL = 60  # kB


class Ended(NamedTuple):
    """How a program of erclutch ended: code, what it said of errors, and what it left in the folder."""

    code: int
    said: str
    left: tuple[str, ...]

    @property
    def wrong(self) -> str:
        """What is wrong with that; "" for one error line and nothing half-written."""
        errors = [line for line in self.said.splitlines() if line.startswith("error: ")]
        if "Traceback" in self.said:
            return f"a traceback: {self.said[-300:]}"
        if self.code not in (0, 2, 3) or (self.code != 0 and len(errors) != 1):
            return f"code {self.code}: {self.said[-300:]}"
        half = [name for name in self.left if "partial" in name or "writing" in name]
        return f"left {half[0]}" if half else ""


def read_only(command: str, folder: Path) -> Ended:
    """A command whose place is in a folder that nobody may write to."""
    closed = folder / "closed"
    closed.mkdir(exist_ok=True)
    closed.chmod(0o555)
    *words, place = words_of(command, 0)
    said = subprocess.run(
        [*(_AS_OTHERS if os.geteuid() == 0 else ()), *_program(words), f"closed/{place}"],
        cwd=folder, capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    return Ended(said.returncode, said.stderr, tuple(path.name for path in closed.rglob("*")))


def full_disk(command: str, folder: Path) -> Ended:
    """A command whose place is on a disk of 60 kB, a file system of this process alone."""
    small = folder / "small"
    small.mkdir(exist_ok=True)
    *words, place = words_of(command, 0)
    mount = f"mount -t tmpfs -o size={FULL}k none small"
    run = shlex.join([*_program(words), f"small/{place}"])
    script = f"{mount} && {{ {run} >&2; code=$?; find small -mindepth 1; exit $code; }}"
    own = (
        ["unshare", "--mount"]
        if os.geteuid() == 0
        else ["unshare", "--mount", "--user", "--map-root-user"]
    )
    said = subprocess.run(
        [*own, "sh", "-c", script],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    return Ended(said.returncode, said.stderr, tuple(said.stdout.split()))


def _program(words: list[str]) -> list[str]:
    return [sys.executable, "-m", "erclutch", *words]
