"""A file that is written while it is read would be half of the old log and half of the new: a log that nobody took."""

from __future__ import annotations

import os
import stat
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path
from typing import TYPE_CHECKING

from erclutch.errors import LogError

if TYPE_CHECKING:
    from erclutch.logs.log_reader import LogSource, Windows
    from erclutch.logs.table import Table

State = tuple[int, int, int] | None
#: What each file of a log was like when it was looked at.
States = Mapping[Path, State]


def states_of(files: Iterable[Path]) -> States:
    """What changes when a file is written or replaced; None where there is none."""
    states: dict[Path, State] = {}
    for file in files:
        try:
            state = file.stat()
            states[file] = (state.st_ino, state.st_size, state.st_mtime_ns)
        except OSError:
            states[file] = None
    return states


def changed() -> LogError:
    """The error of a log that is not the log of an earlier look."""
    problem = "the file was written while it was read"
    return LogError(problem, remedy="Wait until it is whole, or give a copy of it")


@contextmanager
def unchanged(before: States) -> Generator[None]:
    """What is read of files inside is of the files of an earlier look, and so is what is wrong with them.

    Raises:
        LogError: a file was written, replaced or taken away meanwhile.
    """
    try:
        yield
    except LogError as error:
        if states_of(before) != before:
            raise changed() from error
        raise
    if states_of(before) != before:
        raise changed()


def opened_plainly(file: Path) -> BufferedReader:
    """A plain file, opened; what became a pipe after the look at it is refused: its opening may have no end.

    Raises:
        LogError: it is no plain file any more.
        OSError: it cannot be opened.
    """
    opened = open(  # noqa: SIM115  the caller closes it
        file, "rb", opener=lambda path, flags: os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
    )
    if stat.S_ISREG(os.fstat(opened.fileno()).st_mode):
        return opened
    opened.close()
    raise LogError("the file was replaced while it was read", remedy="Give a plain file")


def unchanged_windows(windows: Windows, before: States) -> Windows:
    """The same windows, as long as the file has its state of an earlier look."""

    def checked(
        source: LogSource, rows: int, margin: int, first: int, last: int | None
    ) -> Iterator[tuple[int, int, Table]]:
        with unchanged(before):
            each = iter(windows(source, rows, margin, first, last))
        while True:
            with unchanged(before):
                window = next(each, None)
            if window is None:
                return
            yield window

    return checked
