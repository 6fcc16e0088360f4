"""Commands of the command line, run inside this process, which spares a start of Python for each."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import NamedTuple

import pytest

from erclutch.cli import main


class Done(NamedTuple):
    """What a command has left: its exit code, and what it said on both streams."""

    code: int
    out: str
    error: str


def run(*words: object, cwd: Path | None = None) -> Done:
    """Run ``erclutch WORDS`` in a folder."""
    out, error = io.StringIO(), io.StringIO()
    with (
        pytest.MonkeyPatch.context() as patch,
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(error),
    ):
        if cwd is not None:
            patch.chdir(cwd)
        code = main([str(word) for word in words])
    return Done(code, out.getvalue(), error.getvalue())


def good(*words: object, cwd: Path | None = None, code: int = 0) -> str:
    """What a command prints; it must end with the code and say nothing on standard error."""
    done = run(*words, cwd=cwd)
    assert done.code == code, done.error
    assert done.error == ""
    return done.out


def refused(*words: object, cwd: Path, code: int = 2) -> str:
    """The error line of a command that must fail and leave the folder as it was."""
    before = sorted(str(path) for path in cwd.rglob("*"))
    done = run(*words, cwd=cwd)
    assert done.code == code, done.error
    assert done.out == ""
    assert sorted(str(path) for path in cwd.rglob("*")) == before
    if code == 2:
        assert done.error.startswith("error: ")
        assert done.error.count("\n") == 1, done.error
        assert done.error.endswith(".\n")
    return done.error
