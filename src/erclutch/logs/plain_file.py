"""The files of a log are plain files, all of whose bytes were written."""

from __future__ import annotations

import os
import stat
from collections.abc import Generator
from contextlib import contextmanager, suppress
from io import BufferedReader
from pathlib import Path

from erclutch.errors import LogError

#: Bytes of a log that may never have been written. Such holes take no room on the disk, and are read as zeros.
MOST_UNWRITTEN = 256 << 20


@contextmanager
def readable(file: Path) -> Generator[None]:
    """What the system says against reading a file is a LogError."""
    try:
        yield
    except OSError as error:
        problem = f"the file cannot be read ({error.strerror})"
        raise LogError(problem, remedy="Check its permissions", where=str(file)) from error


def opened_plainly(file: Path) -> BufferedReader:
    """A plain file, opened; what became a pipe after the look at it is refused: its opening may have no end.

    Raises:
        LogError: it is no plain file any more, or has holes of more than `MOST_UNWRITTEN`.
        OSError: it cannot be opened.
    """
    opened = open(  # noqa: SIM115  the caller closes it
        file, "rb", opener=lambda path, flags: os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
    )
    if not stat.S_ISREG(os.fstat(opened.fileno()).st_mode):
        opened.close()
        raise LogError("the file was replaced while it was read", remedy="Give a plain file")
    if has_large_holes(opened.fileno()):
        opened.close()
        problem = f"more than {MOST_UNWRITTEN >> 20} MiB of the file were never written"
        remedy = "Copy the file again, or cut it where its rows end"
        raise LogError(problem, remedy=remedy)
    return opened


def has_large_holes(file: int) -> bool:
    """Whether more than `MOST_UNWRITTEN` of an open file are holes; False where the system does not tell.

    A file of gigabytes costs nothing to make where nothing is written, and minutes to read.

    Args:
        file: its descriptor, which stands at the beginning afterwards.
    """
    size = os.fstat(file).st_size
    unwritten = 0  # bytes
    place = 0  # where bytes are written, or begin to be
    if size <= MOST_UNWRITTEN or not hasattr(os, "SEEK_HOLE"):
        return False
    with suppress(OSError):  # nothing is written behind the last hole, or the disk tells of none
        while unwritten <= MOST_UNWRITTEN:
            hole = os.lseek(file, place, os.SEEK_HOLE)
            unwritten += size - hole  # as if it went to the end
            place = os.lseek(file, hole, os.SEEK_DATA)
            unwritten -= size - place
    os.lseek(file, 0, os.SEEK_SET)
    return unwritten > MOST_UNWRITTEN
