"""Places that take no file: a folder that is read-only for its owner too, and disks that are full after 60 kB."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from erclutch.registry import names
from tests.support.races import words_of

#: A superuser writes where nobody may, unless this capability is taken away.
_AS_OTHERS = ("setpriv", "--bounding-set", "-dac_override,-dac_read_search", "--inh-caps", "-all")
FULL = 60  # kB
_EXPORT = "export to "


def exports() -> tuple[str, ...]:
    """Names of commands beside those of `races`: an export to each target."""
    return tuple(f"{_EXPORT}{target}" for target in names("erclutch.targets"))


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
    *words, place = _words(command)
    said = subprocess.run(
        [*(_AS_OTHERS if os.geteuid() == 0 else ()), *_program(words), f"closed/{place}"],
        cwd=folder, capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    return Ended(said.returncode, said.stderr, tuple(path.name for path in closed.rglob("*")))


def full_disk(command: str, folder: Path) -> Ended:
    """A command whose place is on a disk of 60 kB, a file system of this process alone."""
    return _on_a_small_disk(command, folder, "")


def full_disks(command: str, folder: Path) -> Ended:
    """The same, and temporary files go there, too."""
    return _on_a_small_disk(command, folder, "TMPDIR=small ")


def _on_a_small_disk(command: str, folder: Path, variables: str) -> Ended:
    small = folder / "small"
    small.mkdir(exist_ok=True)
    *words, place = _words(command)
    mount = f"mount -t tmpfs -o size={FULL}k none small"
    run = variables + shlex.join([*_program(words), f"small/{place}"])
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


def _words(command: str) -> tuple[str, ...]:
    if not command.startswith(_EXPORT):
        return words_of(command, 0)
    target = command.removeprefix(_EXPORT)
    run = "pair" if target.startswith("controller") else "run"
    return "export", run, "--to", target, "--out", "made"


def _program(words: list[str]) -> list[str]:
    return [sys.executable, "-m", "erclutch", *words]
