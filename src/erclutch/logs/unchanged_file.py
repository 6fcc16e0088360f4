"""A file that is written while it is read would be half of the old log and half of the new: a log that nobody took."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogSource, Windows
from erclutch.logs.table import Table

State = tuple[int, int, int] | None


def state_of(path: Path) -> State:
    """What changes when a file is written or replaced; None where there is none."""
    try:
        state = path.stat()
    except OSError:
        return None
    return state.st_ino, state.st_size, state.st_mtime_ns


@contextmanager
def unchanged(path: Path, before: State = None) -> Generator[None]:
    """What is read of a file inside is of one file, and so is what is wrong with it.

    Args:
        path: of the file.
        before: its state at an earlier look; None: the look is taken here.

    Raises:
        LogError: the file was written, replaced or taken away meanwhile.
    """
    before = before or state_of(path)
    written = LogError(
        "the file was written while it was read",
        remedy="Wait until it is whole, or give a copy of it",
    )
    try:
        yield
    except LogError as error:
        if state_of(path) != before:
            raise written from error
        raise
    if state_of(path) != before:
        raise written


def unchanged_windows(windows: Windows, before: State) -> Windows:
    """The same windows, as long as the file has its state of an earlier look."""

    def checked(
        source: LogSource, rows: int, margin: int, first: int, last: int | None
    ) -> Iterator[tuple[int, int, Table]]:
        with unchanged(source.path, before):
            each = iter(windows(source, rows, margin, first, last))
        while True:
            with unchanged(source.path, before):
                window = next(each, None)
            if window is None:
                return
            yield window

    return checked
