"""Files that somebody gives are read here: as plain files, since a pipe has no end, all of whose bytes were written."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import stat
import tomllib
from contextlib import suppress
from io import BufferedReader
from json import JSONDecodeError
from pathlib import Path
from typing import Any, cast

#: Bytes of a file that may never have been written. Such holes take no room on the disk, and are read as zeros.
MOST_UNWRITTEN = 256 << 20
#: Of a file that is read whole though it is no log.
MOST_BYTES = 64 << 20
#: Bytes that a file of rows in a run may have: a run keeps some 10^6 rows at most.
MOST_OF_ROWS = 4 << 30


class UnfitFileError(OSError):
    """A file that is none to be read.

    Args:
        problem: what is wrong with it.
        remedy: what to do about it.
        file: its path.
    """

    def __init__(self, problem: str, remedy: str, file: Path) -> None:
        super().__init__(errno.EINVAL, problem, str(file))
        self.problem = problem
        self.remedy = remedy


def opened_plainly(file: Path) -> BufferedReader:
    """A plain file, opened; what became a pipe after the look at it is refused: its opening may have no end.

    Raises:
        UnfitFileError: it is no plain file any more, or has holes of more than `MOST_UNWRITTEN`.
        OSError: it cannot be opened.
    """
    opened = _opened(file)
    if has_large_holes(opened.fileno()):
        opened.close()
        problem = f"more than {MOST_UNWRITTEN >> 20} MiB of the file were never written"
        remedy = "Copy the file again, or cut it where its rows end"
        raise UnfitFileError(problem, remedy, file)
    return opened


def _opened(file: Path) -> BufferedReader:
    """A plain file of any holes, opened without a wait.

    Raises:
        UnfitFileError: it is no plain file any more. OSError: it cannot be opened.
    """
    opened = open(  # noqa: SIM115  the caller closes it
        file, "rb", opener=lambda path, flags: os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
    )
    if not stat.S_ISREG(os.fstat(opened.fileno()).st_mode):
        opened.close()
        raise UnfitFileError("the file was replaced while it was read", "Give a plain file", file)
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


def plain_words(error: Exception) -> str:
    """What is wrong with a file that cannot be read, without the words of Python."""
    if isinstance(error, UnicodeDecodeError):
        return "it is no UTF-8 text"
    if isinstance(error, JSONDecodeError):
        return f"it is no JSON from line {error.lineno} on"
    if isinstance(error, RecursionError):
        return "it is nested too deep"
    if "integer string conversion" in str(error):  # what Python says of thousands of digits
        return "a whole number in it has too many digits"
    missing = isinstance(error, FileNotFoundError)
    return "there is no such file" if missing else getattr(error, "strerror", None) or str(error)


_LONG_KEY = re.compile(
    rb"""(?<![\w.-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){100}"""
)


def small_file(path: Path) -> bytes:
    """The bytes of a file that is never large: a rig, a mapping, a model, what a run or an export says of itself.

    Raises:
        OSError: there is no such file, or it has more than `MOST_BYTES`; or it is a pipe, which may never be filled, or
            a device, which may never end.
    """
    _require_plain(path)
    with opened_plainly(path) as file:
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise OSError(errno.EFBIG, f"it has more than {MOST_BYTES >> 20} MiB", str(path))
    return content


def small_text(path: Path) -> str:
    """The text of such a file, which is UTF-8.

    Raises:
        OSError, UnicodeDecodeError: see `small_file`; `plain_words` says why.
    """
    return small_file(path).decode()


def small_json(path: Path) -> Any:
    """What such a file of JSON holds.

    Raises:
        OSError, ValueError: it cannot be read, or is no JSON; `plain_words` says why.
    """
    try:
        return json.loads(small_text(path), object_pairs_hook=with_different_names)
    except RecursionError as error:
        raise ValueError("it is nested too deep") from error


class NameTwiceError(ValueError):
    """Two values of one name in an object of JSON, of which the last would be taken in silence."""


def with_different_names(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON, for `json.loads`.

    Raises:
        NameTwiceError: two of its entries have one name.
    """
    entries = dict(pairs)
    if len(entries) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in entries if names.count(name) > 1)
        raise NameTwiceError(f"{twice!r:.60} stands in it twice")
    return entries


def _require_plain(path: Path) -> None:
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):  # of a folder the system tells itself
        raise OSError(errno.EINVAL, "it is a pipe or a device and no plain file", str(path))


def toml_of(content: bytes) -> dict[str, Any]:
    """What a TOML file holds; its whole numbers have 64 bits at most, so that each can be a float and be printed.

    Raises:
        ValueError, RecursionError: it is no such file; `plain_words` says why.
    """
    if _LONG_KEY.search(content):  # the library takes the square of the time for it
        raise ValueError("a name in it has more than 100 parts with points between them")
    body = tomllib.loads(content.decode("utf-8-sig"))
    if not _fits(body):
        raise ValueError("a whole number in it has more than 64 bits")
    return body


def _fits(value: object) -> bool:
    if isinstance(value, dict):
        return all(map(_fits, cast(dict[str, object], value).values()))
    if isinstance(value, list):
        return all(map(_fits, cast(list[object], value)))
    return not isinstance(value, int) or -(2**63) <= value < 2**63


def file_digest(path: Path, most: int = MOST_OF_ROWS) -> str:
    """SHA-256 of a file's bytes, hexadecimal.

    Args:
        path: of the file.
        most: bytes that it may have; a sparse file of terabytes costs nothing to make, and days to read.

    Raises:
        OSError: the file cannot be read, or has more bytes; or it is a pipe or a device.
    """
    _require_plain(path)
    with _opened(path) as file:
        if os.fstat(file.fileno()).st_size > most:
            raise OSError(errno.EFBIG, f"it has more than {most >> 20} MiB", str(path))
        return hashlib.file_digest(file, "sha256").hexdigest()
