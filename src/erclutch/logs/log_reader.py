"""This module says what a reader of log files is, which reader a file gets, and how the reader is called.

A reader is a file of ``logs/readers`` that assigns ``READER``, or comes from another package (entry point
``erclutch.readers``).
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Container, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from erclutch import registry
from erclutch.errors import LogError, PluginError, placed, printable
from erclutch.files.given_files import UnfitFileError, opened_plainly
from erclutch.logs.readers.budget import Budget, size_of, within_seconds
from erclutch.logs.table import Table
from erclutch.registry import Plugin

if TYPE_CHECKING:
    from pandas import DataFrame

GROUP = "erclutch.readers"
#: What to give in place of a file without rows of numbers.
ROWS_WANTED = "Give a log with one row a sample"
_LARGEST = 4 << 30  # bytes of a log
HEAD = 1024  # bytes that a reader may look at to claim a file
#: What `live --program learn` writes beside its logs: what each round taught. It is no log.
LEARN_REPORT = "learn.json"


State = tuple[int, int, int] | None
#: What each file of a log was like when it was looked at.
States = Mapping[Path, State]


@dataclass(frozen=True)
class LogSource:
    """A log as a reader gets it: a file, a folder, or an object in memory.

    Attributes:
        path: of the file; of an object in memory, the name of its class.
        data: all of its bytes; none where the log is a folder.
        digest: SHA-256 of these, for the table; of a folder, of the digests of its files by name.
        variable: which of several recordings in the file the user wants; None: there is to be one only.
        decimal: the decimal mark of a text, where the user named it.
        told: may be called with how many bytes were read, and of how many.
        memory: the log itself, where it is an object in memory; None for a file.
        states: what its files were like before their bytes were read; a file that changes meanwhile is refused.
    """

    path: Path
    data: bytes
    digest: str
    variable: str | None = None
    told: Callable[[int, int], None] = field(default=lambda done, total: None, compare=False)
    decimal: str | None = None
    memory: object = field(default=None, compare=False)
    states: States = field(default_factory=dict[Path, State], compare=False)

    @property
    def name(self) -> str:
        """The file's name, for the table and for messages."""
        return printable(self.path.name)  # a name may hold bytes that are no text

    @property
    def size(self) -> int:
        """Bytes of the log, on the disk or in memory."""
        if self.memory is not None:
            return sys.getsizeof(self.memory)
        return len(self.data) or size_of(self.path)


#: How an address begins, once it is taken for a path.
_ADDRESSES = ("http:/", "https:/", "ftp:/", "s3:/", "gs:/")
#: ``windows(source, rows, margin, first, last)`` yields (start, stop, table) from row ``first`` of a file to row
#: ``last``, or to its end: the rows that a window stands for, and its table, which holds up to ``margin`` rows more on
#: either side; `Table.first_row` says where that begins. The source has no data.
Windows = Callable[[LogSource, int, int, int, int | None], Iterator[tuple[int, int, Table]]]


@dataclass(frozen=True)
class LogReader:
    """What a reader's file or package brings under the name ``READER``.

    Attributes:
        suffixes: of files that it reads, small letters with the dot.
        claims: whether a file is of its format, by its first `HEAD` bytes; it goes before the suffix.
        read: the file as a table; raises LogError where it is damaged, with the line or place.
        windows: for files larger than memory: see `Windows`. None: such a file is read whole.
        extent: rows and columns of a file that has windows, rows that hold no numbers included; it reads as little of
            the file as it can.
        recordings: names of the recordings that a file holds, each of which is a `LogSource.variable`. None: one only.
        each: the tables of all recordings of a file by name, read at once, or what stands against one; of a file that
            joins recordings those whose names ``variable`` has, one a line. None: they are read one by one.
        takes: whether an object in memory, such as a DataFrame, is a log of this format. None: the reader has files.
        tells_damage: whether damaged bytes are seen in such a file (by checksums, say), as the rest of a sentence.
        folder: name of the file by which a folder is one log of this format; "": a log is a file.
        joins: whether a folder, or a path that names several files, is one log of this format. None: neither is.
        parts: the files that such a path names.
    """

    suffixes: tuple[str, ...]
    claims: Callable[[bytes], bool]
    read: Callable[[LogSource], Table]
    windows: Windows | None = None
    extent: Callable[[Path], tuple[int, int]] | None = None
    recordings: Callable[[LogSource], Sequence[str]] | None = None
    each: Callable[[LogSource], Mapping[str, Table | LogError]] | None = None
    takes: Callable[[object], bool] | None = None
    tells_damage: str = "seen or not: the reader does not say"
    folder: str = ""
    joins: Callable[[Path], bool] | None = None
    parts: Callable[[Path], Sequence[Path]] = lambda path: ()

    def of_others(self, plugin: Plugin) -> LogReader:
        """The same reader, of another package: what it is and what it gives is looked at. See `Plugin.of_type`."""
        from erclutch.logs.outside_reader import looked_at

        return looked_at(self, plugin)


def claims_nothing(head: bytes) -> bool:
    """For formats without a mark: the suffix decides."""
    return False


def log_suffixes() -> tuple[str, ...]:
    """Suffixes of all logs that can be read."""
    suffixes: set[str] = set()
    for _, reader in _readers([]):
        suffixes.update(reader.suffixes)
    return tuple(sorted(suffixes))


def may_be_log(file: Path, suffixes: Container[str]) -> bool:
    """Whether a file of a folder may be a log, by its name: packed (``.csv.gz``) too, hidden or a workbook's lock not.

    Args:
        file: in the folder.
        suffixes: `log_suffixes`.
    """
    if file.name.startswith((".", "~$")):  # as macOS and Excel leave them beside the logs
        return False
    suffix = file.suffix.lower()
    if suffix == ".gz":
        suffix = Path(file.stem).suffix.lower()
    return suffix in suffixes and file.is_file()


@dataclass(frozen=True)
class ReadableLog:
    """A log that is there, and its reader.

    Attributes:
        path: of the file, or of the folder that is one log; of an object in memory, the name of its class.
        plugin: the reader.
        is_file: whether the log is one file; else it is a folder, or several files.
        notes: a sentence on each reader that could not be asked.
        memory: the log itself, where it is an object in memory.
        head: the first bytes of the file, by which the reader was found.
        size: bytes of the file as it was found.
    """

    path: Path
    plugin: Plugin
    is_file: bool
    notes: list[str]
    memory: object = None
    head: bytes = b""
    size: int = 0


def log_at(path: str | Path | DataFrame) -> ReadableLog:
    """The log at a path, and its reader; no more than the head of a file is read. An object in memory is its own place.

    Raises:
        LogError: no such file, no log, or no permission.
    """
    if isinstance(path, str | Path):
        with placed(str(path)):
            try:
                return _log_on_the_disk(Path(path))
            except (OSError, ValueError) as error:
                problem = f"the file cannot be read ({error})"
                raise LogError(problem, remedy="Check the path and its permissions") from error

    name = type(path).__name__
    notes: list[str] = []
    for plugin, reader in _readers(notes):
        if reader.takes is not None and _says(plugin, reader.takes, path, notes):
            return ReadableLog(Path(name), plugin, is_file=False, notes=notes, memory=path)
    remedy = "Give the path of a file, or a pandas DataFrame"
    raise LogError(f"a log cannot be a {name}", remedy=remedy)


def _log_on_the_disk(file: Path) -> ReadableLog:
    """A file, a folder or several files that are a log, and the reader."""
    require_no_run(file)
    if file.is_file():
        # The system's own files, such as /proc/kmsg, are regular and of no size, and a look into them may never end.
        size = file.stat().st_size
        if not size:
            raise LogError("the file is empty", remedy=ROWS_WANTED, where=file.name)
        with readable(file), opened_plainly(file) as content:
            head = content.read(HEAD)
        plugin, notes = reader_of(head, file.suffix)
        return ReadableLog(file, plugin, is_file=True, notes=notes, head=head, size=size)

    of_folder = folder_reader(file)
    if of_folder is not None:
        return ReadableLog(file, of_folder, is_file=False, notes=[])
    if file.is_dir():
        raise LogError("this is a folder, not a file", remedy="Give one log file")
    if not file.exists():
        is_address = str(file).startswith(_ADDRESSES)
        remedy = "Download it first: erclutch reads files alone" if is_address else "Check the path"
        raise LogError("there is no such file", remedy=remedy)
    raise LogError("this is not a regular file", remedy="Give a log file")


def require_no_run(path: Path) -> None:
    """Refuse the folder of a run, whose files look like logs.

    Raises:
        LogError: it is one.
    """
    if (path / "run.json").is_file():
        raise LogError(
            "this is the folder of a run",
            where=str(path),
            remedy="Give a log; erclutch report shows a run",
        )


def reader_of(head: bytes, suffix: str) -> tuple[Plugin, list[str]]:
    """The reader of a file, and a note on each reader that could not be asked.

    Content goes before suffix, ours before others; what nobody claims is read as text.

    Args:
        head: the file's first bytes.
        suffix: of its name.
    """
    notes: list[str] = []
    readers = _readers(notes)
    named = [plugin for plugin, reader in readers if suffix.lower() in reader.suffixes]
    by_name = {plugin.name: plugin for plugin, _ in readers}
    by_suffix = named[0] if named else by_name["text"]
    for plugin, reader in readers:
        if _says(plugin, reader.claims, head, notes):
            return plugin, notes
    return by_suffix, notes


def folder_reader(path: Path) -> Plugin | None:
    """The reader for which a folder, or a path of several files, is one log, or None: then a folder holds logs."""
    if path.is_file():
        return None
    readers = _readers([])
    for plugin, reader in readers:
        if reader.folder and (path / reader.folder).is_file():
            return plugin
    for plugin, reader in readers:
        if reader.joins is not None and _says(plugin, reader.joins, path, []):
            return plugin
    return None


def _says(plugin: Plugin, question: Callable[[Any], bool], of: object, notes: list[str]) -> bool:
    """What a reader answers; one that fails has no file, with a note."""
    try:
        with plugin.working("failed to look at a file"):
            return bool(question(of))
    except PluginError as error:
        notes.append(f"a reader was left out: {error}")
        return False


def _readers(notes: list[str]) -> list[tuple[Plugin, LogReader]]:
    """All readers, ours first; one that cannot be loaded or used is left out, with a note."""
    readers, failures = registry.sound(GROUP, LogReader)
    notes += [f"a reader was left out: {error}" for error in failures]
    return readers


@contextmanager
def readable(file: Path) -> Generator[None]:
    """What the system says against reading a file is a LogError."""
    try:
        yield
    except UnfitFileError as error:
        raise LogError(error.problem, remedy=error.remedy) from error
    except OSError as error:
        problem = f"the file cannot be read ({error.strerror})"
        raise LogError(problem, remedy="Check its permissions", where=str(file)) from error


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
    # Half of the old log and half of the new are a log that nobody took.
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


def source_of(log: ReadableLog) -> LogSource:
    """The bytes of a log and their digest; an object in memory has none.

    Raises:
        LogError: no permission; the file is empty or too large.
    """
    file = log.path
    data = b""
    if log.memory is not None:
        return LogSource(file, data, "", memory=log.memory)
    with placed(file.name):
        if not log.is_file:
            # Names and digests of the files of a log, by name.
            of_files = hashlib.sha256()
            with readable(file):
                reader: LogReader = log.plugin.of_type(LogReader)
                with log.plugin.working(f"failed on {file.name}"):
                    files = list(file.iterdir() if file.is_dir() else reader.parts(file))
                inside: list[Path] = sorted(path for path in files if path.is_file())
                if sum(path.stat().st_size for path in inside) > _LARGEST:
                    problem = "the files of the folder are larger than 4 GiB"
                    raise LogError(problem, remedy="Split the log")
                states = states_of(inside)
                with unchanged(states):
                    for path in inside:
                        with opened_plainly(path) as content:
                            own = hashlib.file_digest(content, "sha256").hexdigest()
                        of_files.update(f"{path.name}\0{own}\0".encode())
            return LogSource(file, data, of_files.hexdigest(), states=states)
        states = states_of([file])
        with readable(file), opened_plainly(file) as content:
            if file.stat().st_size > _LARGEST:
                raise LogError("the file is larger than 4 GiB", remedy="Split the log")
            data = content.read()
            # A log that a recorder makes longer has the same beginning.
            if states_of([file]) != states:
                content.seek(0)
                if content.read(len(data)) != data:
                    raise changed()
        # The reader was found by the beginning of the file, and is the reader of no other file.
        if len(data) < log.size or not data.startswith(log.head):
            raise changed()
        return LogSource(file, data, hashlib.sha256(data).hexdigest(), states=states)


def source_with(log: ReadableLog, digest: str) -> LogSource:
    """The bytes of a log that was read before.

    Raises:
        LogError: it is another log by now; see also `source_of`.
    """
    source = source_of(log)
    if source.digest != digest:
        with placed(log.path.name):
            raise changed()
    return source


def names_in(plugin: Plugin, source: LogSource) -> list[str]:
    """The names of the recordings that a reader sees in a file; none where its format has one recording only."""
    names_of = plugin.of_type(LogReader).recordings
    if names_of is None:
        return []
    with (
        placed(source.path.name),
        plugin.working(f"failed on {source.path.name}"),
        unchanged(source.states),
    ):
        return list(names_of(source))


def read_by(plugin: Plugin, source: LogSource) -> Table:
    """The file as a table by a reader; that of another package is named in its notes, and looked at.

    Raises:
        LogError: the file is damaged. PluginError: the reader is.
    """
    reader: LogReader = plugin.of_type(LogReader)
    if source.variable and reader.recordings is None:
        problem = (
            f"a log of this format is one recording: it has no {source.variable!r} for --variable"
        )
        remedy = "Leave it out, or give --variable '' where a run or mapping has it"
        raise LogError(problem, where=source.name, remedy=remedy)
    with plugin.working(f"failed on {source.name}"):
        budget = Budget(source.size)
        # Ours read what they were given, or look themselves whether the file that they open is the same.
        opened_again: States = {} if plugin.own else source.states
        with placed(source.name), unchanged(opened_again), within_seconds(budget.seconds):
            table = reader.read(source)
        if not plugin.own:
            notes = (*table.notes, f"read by {plugin.name!r} of {plugin.label}")
            table = replace(table, notes=notes)
        return replace(table, damage=reader.tells_damage)


@lru_cache(maxsize=1)
def read_once(file: Path, digest: str, recording: str | None, decimal: str | None) -> Table:
    """A recording whose rows are parted by the words of a column: it is kept, for each word asks for it."""
    log = log_at(file)
    source = replace(source_with(log, digest), variable=recording, decimal=decimal)
    return read_by(log.plugin, source)
