"""The targets by name. A target is a module of this package.

    TITLE                              one phrase
    write(program, folder)             writes all its files
    verify(program, folder)            runs what it wrote on the test vectors and yields a `check.Check` each

It needs a line in TARGETS. export.json and model.json are written for it.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Protocol, cast

from erclutch.errors import ExportError
from erclutch.export.check import Check
from erclutch.export.program import Program

#: Name of a target -> its module in `erclutch.export`.
TARGETS: Mapping[str, str] = {
    "c": "c",
    "python": "python",
    "onnx": "onnx",
    "fmu2": "fmu2",
    "fmu3": "fmu3",
    "cpp": "cpp",
    "simulink": "simulink",
    "mujoco": "mujoco",
}


class Target(Protocol):
    """What a target's module offers."""

    TITLE: str

    def write(self, program: Program, folder: Path) -> None:
        """Write all files of the target."""
        ...

    def verify(self, program: Program, folder: Path) -> Iterator[Check]:
        """Run what was written on the test vectors."""
        ...


def target(name: str) -> Target:
    """A target by name.

    Raises:
        ExportError: there is none of this name.
    """
    if name not in TARGETS:
        near = difflib.get_close_matches(name, TARGETS, n=1)
        hint = f"Did you mean {near[0]}? " if near else ""
        raise ExportError(f"unknown target {name!r}", where="--to", remedy=f"{hint}Known are {', '.join(TARGETS)}")
    return cast(Target, import_module(f"erclutch.export.{TARGETS[name]}"))
