"""A small file may unpack to gigabytes: what it may unpack to is limited by its size, before memory is asked for.

A log that a bench wrote holds less than eight numbers a byte, and its text shrinks to a tenth. A file beyond that is
damaged or hostile, or its user knows better: the environment ``ERCLUTCH_READER_MEMORY`` raises all limits together.
"""

from __future__ import annotations

import _thread
import ctypes
import os
import threading
import time
import zlib
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo

from erclutch.errors import LogError

#: MiB of memory for a reader, where a user knows that the file is sound.
RAISED = "ERCLUTCH_READER_MEMORY"
#: Bytes of address space of a reader's process.
MEMORY, MEMORY_PER_BYTE, MOST_MEMORY = 1 << 30, 64, 4 << 30
CELLS, CELLS_PER_BYTE = 3 << 23, 8  # numbers of all columns together, 8 bytes each
TEXT, TEXT_PER_BYTE = 1 << 25, 32  # bytes of text
NAMES = 1 << 14  # columns, groups and fields
LONGEST_LIST = 500  # numbers of a list in a cell or a message: a picture has more
SECONDS, SECONDS_PER_MIB = 6.0, 5.0  # of processor time
_MIB = 1 << 20
_BLOCK = 1 << 20  # bytes
_GOES = 0.2  # s, in which a thread that watches ends; one that found no memory has never begun
#: What to do where a limit is met.
MORE = (
    f"The file may be damaged; if it is sound, allow more by the environment: {RAISED}=8192 (MiB)"
)

_DAMAGED = "Copy the file again, or export it as CSV"


class Budget:
    """What one file may unpack to, and how much of that is left.

    Attributes:
        memory: bytes of address space of a process that reads the file.
        seconds: of its processor time.
        cells, names, text: how many are left; see the constants of this module.
    """

    def __init__(self, size: int, more: str = MORE) -> None:
        """Limits of a file of ``size`` bytes; ``more``: what to do where they are met.

        Raises:
            LogError: the environment asks for no memory that can be given.
        """
        self._more = more
        given = os.environ.get(RAISED, "")
        if given and not (given.isdecimal() and len(given) < 8 and 256 <= int(given) < _MIB):
            problem = f"{given!r} MiB of memory for a reader"
            raise LogError(problem, where=RAISED, remedy="Give 256 to 1048575, a whole number")
        usual = min(MOST_MEMORY, MEMORY + MEMORY_PER_BYTE * size)
        self.memory = int(given) * _MIB if given else usual
        times = max(self.memory / usual, 1.0) if given else 1.0
        self.seconds = times * (SECONDS + SECONDS_PER_MIB * size / _MIB)
        self.cells = round(times * (CELLS + CELLS_PER_BYTE * size))
        self.text = round(times * (TEXT + TEXT_PER_BYTE * size))
        self.names = round(times * NAMES)
        self._allowed = {"cells": self.cells, "names": self.names, "text": self.text}

    def take_cells(self, count: int) -> None:
        """Numbers that the file wants to unpack to.

        Raises:
            LogError: there are too many, with the numbers before.
        """
        self.cells -= count
        if self.cells < 0:
            raise self._beyond("cells", "numbers")

    def take_names(self, count: int = 1) -> None:
        """Columns, groups or fields of the file. LogError: see `take_cells`."""
        self.names -= count
        if self.names < 0:
            raise self._beyond("names", "names of columns, groups or fields")

    def take_text(self, count: int) -> None:
        """Bytes of text. LogError: see `take_cells`."""
        self.text -= count
        if self.text < 0:
            raise self._beyond("text", "bytes of text")

    def _beyond(self, what: str, words: str) -> LogError:
        return LogError(
            f"the file unpacks to more than {self._allowed[what]:,} {words}", remedy=self._more
        )


class _OutOfTime(BaseException):
    """What a thread is interrupted by; no reader takes it for damage of its file."""


@contextmanager
def within_seconds(seconds: float) -> Generator[None]:
    """What this thread does takes so much processor time and no more, where the system counts a thread's time.

    A second thread watches. It interrupts between two steps of Python: a single call into native code comes to its end
    first.

    Args:
        seconds: of the processor.

    Raises:
        LogError: the time is over.
    """
    if not hasattr(time, "pthread_getcpuclockid"):
        yield  # Windows
        return
    thread = threading.get_ident()
    ended, gone = threading.Event(), threading.Event()
    one_of_both = threading.Lock()  # what ends first: the time, or what it is for
    clock = time.pthread_getcpuclockid(thread)
    until = time.clock_gettime(clock) + seconds

    def interrupt() -> None:
        while (left := until - time.clock_gettime(clock)) > 0.0:
            # No thread has more processor time than the clock on the wall has time.
            if ended.wait(left):
                return
        with one_of_both:
            if not ended.is_set():
                ctypes.pythonapi.PyThreadState_SetAsyncExc(
                    ctypes.c_ulong(thread), ctypes.py_object(_OutOfTime)
                )

    def watch() -> None:
        try:
            interrupt()
        finally:
            gone.set()

    # `Thread.start` waits until the thread runs: for ever, where the thread finds no memory to begin with.
    _thread.start_new_thread(watch, ())
    try:
        try:
            yield
        finally:
            with one_of_both:
                ended.set()
            gone.wait(_GOES)
    except _OutOfTime:
        problem = f"reading the file takes longer than the {seconds:.3g} s that its size allows"
        raise LogError(problem, remedy=MORE) from None


def budget_of(path: Path) -> Budget:
    """The budget of a file, or of the files in a folder together."""
    return Budget(size_of(path))


def size_of(path: Path) -> int:
    """Bytes of a file, or of the files in a folder; 0 where they cannot be asked, which their reader then says."""
    try:
        files = path.iterdir() if path.is_dir() else [path]
        return sum(file.stat().st_size for file in files)
    except OSError:
        return 0


def take_zip(path: Path, budget: Budget) -> None:
    """Unpack a ZIP archive and keep nothing, so that its real size counts and not the size that it states.

    Raises:
        LogError: it unpacks to more text than its size allows, or it is damaged.
    """
    try:
        with path.open("rb") as file:
            take_parts(file, budget)
    except OSError as error:
        raise LogError(f"the file is damaged ({error})", remedy=_DAMAGED) from error


def take_parts(file: BinaryIO, budget: Budget) -> None:
    """The same of an archive that is open. LogError: see `take_zip`."""
    try:
        with ZipFile(file) as archive:
            for part in archive.infolist():
                budget.take_names()
                if part.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
                    problem = f"part {part.filename[:60]!r} is packed in a way that is not read"
                    raise LogError(problem, remedy=_DAMAGED)
                _take_part(file, part, budget)
    except (BadZipFile, zlib.error, OSError, ValueError, EOFError) as error:
        raise LogError(f"the file is damaged ({error})", remedy=_DAMAGED) from error


def _take_part(file: BinaryIO, part: ZipInfo, budget: Budget) -> None:
    """One part of an archive, behind its own header of 30 bytes, name and extra field."""
    file.seek(part.header_offset)
    head = file.read(30)
    if len(head) < 30:
        raise EOFError("it is cut off")
    name_length = int.from_bytes(head[26:28], "little")
    extra_length = int.from_bytes(head[28:30], "little")
    file.seek(name_length + extra_length, 1)
    unpacking = zlib.decompressobj(-15)
    left = part.compress_size
    while left > 0 and (block := file.read(min(left, _BLOCK))):
        left -= len(block)
        if part.compress_type == ZIP_STORED:
            budget.take_text(len(block))
            continue
        while block:
            budget.take_text(len(unpacking.decompress(block, _BLOCK)))
            block = unpacking.unconsumed_tail
