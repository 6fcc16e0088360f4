"""What a command calls may end the whole program: a command that is not done never has the exit code 0."""

from __future__ import annotations

import os
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import PurePath
from typing import NoReturn

from erclutch.registry import others_at_work

_NOT_DONE = 2  # as after bad input


@contextmanager
def no_early_end() -> Generator[None]:
    """Tell of `os._exit` within this block: of a plug-in at work as an error of it, else on standard error.

    What the system ends without Python (C's ``exit``, ``exec`` of another program) is out of reach.
    """
    at_once = os._exit
    program = os.getpid()

    def end(status: int) -> NoReturn:
        if os.getpid() != program:  # a child that somebody forked ends as it likes
            at_once(status)
        caller = sys._getframe(1)  # pyright: ignore[reportPrivateUsage]
        place = f"{PurePath(caller.f_code.co_filename).name}, line {caller.f_lineno}"
        ends = f"os._exit({status}) in {place} ends the command before it is done"
        if others_at_work():
            raise RuntimeError(ends)
        if sys.stderr is not None:
            sys.stderr.write(f"error: {ends}\n")
            sys.stderr.flush()
        at_once(status or _NOT_DONE)

    os._exit = end
    try:
        yield
    finally:
        os._exit = at_once
