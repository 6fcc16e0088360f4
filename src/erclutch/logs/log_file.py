"""A log file is opened, its format is found, and its table is read: nothing of it is called a signal yet."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from erclutch.errors import LogError, placed
from erclutch.logs.log_reader import HEAD, LogReader, LogSource, folder_reader, read_by, reader_of, require_no_run
from erclutch.logs.row_groups import group_of, groups_in, rows_of, wants_each
from erclutch.logs.split_stamps import with_whole_stamps
from erclutch.logs.table import Table
from erclutch.logs.woven_rows import unwoven
from erclutch.registry import Plugin

if TYPE_CHECKING:
    from pandas import DataFrame

_LARGEST = 4 << 30  # bytes
_ROWS_WANTED = "Give a log with one row a sample"


def table_of(log: str | Path | DataFrame, variable: str | None = None) -> Table:
    """The table of a file, or that of a DataFrame.

    Raises:
        LogError: see `read`.
    """
    if isinstance(log, str | Path):
        return read_table(log, variable=variable)
    from erclutch.logs.data_frame import table_of_frame

    return table_of_frame(log)


def read_table(
    path: str | Path,
    *,
    variable: str | None = None,
    decimal: str | None = None,
    told: Callable[[int, int], None] = lambda done, total: None,
) -> Table:
    """Read a log as it is: raw columns and units, nothing converted.

    Args:
        path: see `read`.
        variable: which recording of a file that holds several: variable, group, sheet, topic; or ``COLUMN=WORD``, the
            rows in which a column has a word.
        decimal: "." or "," where the numbers of a text may be read in two ways.
        told: called with how many bytes of a long text were read, and of how many.

    Raises:
        LogError: no such file, no permission, not a log, damaged, or without a column of numbers.
    """
    file, plugin = _found(path)
    data = b""
    notes: list[str] = []
    with placed(file.name):
        if plugin is not None:
            digest = _digest_of_files(file, plugin.of_type(LogReader))
        else:
            with readable(file):
                if file.stat().st_size > _LARGEST:
                    raise LogError("the file is larger than 4 GiB", remedy="Split the log")
                data = file.read_bytes()
            if not data:
                raise LogError("the file is empty", remedy=_ROWS_WANTED)
            digest = hashlib.sha256(data).hexdigest()
    if plugin is None:
        plugin, notes = reader_of(data[:HEAD], file.suffix)
    source = LogSource(file, data, digest, variable, told, decimal)
    group = group_of(variable)
    if group is not None and variable not in _names_in(plugin, source):
        with placed(file.name):
            table = rows_of(read_by(plugin, replace(source, variable=group.recording)), group)
    else:
        table = read_by(plugin, source)
    if not table.columns or not table.rows:
        raise LogError("the file has no rows of numbers", remedy=_ROWS_WANTED, where=table.name)
    table = unwoven(with_whole_stamps(table))
    return replace(table, notes=(*table.notes, *notes), path=str(path))


def require_file(path: str | Path) -> Path:
    """The path of a log that is there.

    Raises:
        LogError: no such file, no log, or no permission.
    """
    file, _ = _found(path)
    return file


def found_reader(path: str | Path) -> tuple[Path, Plugin]:
    """The path of a log that is there, and its reader; no more than the head of the file is read.

    Raises:
        LogError: see `require_file`.
    """
    file, plugin = _found(path)
    if plugin is None:
        with readable(file), file.open("rb") as content:
            plugin, _ = reader_of(content.read(HEAD), file.suffix)
    return file, plugin


def _found(path: str | Path) -> tuple[Path, Plugin | None]:
    """The path of a log that is there, and the reader for which its folder, or several files, are one log.

    Raises:
        LogError: no such file, no log, or no permission.
    """
    file = Path(path)
    with placed(str(path)):
        try:
            require_no_run(file)
            whole = folder_reader(file)
            if file.is_dir() and whole is None:
                raise LogError("this is a folder, not a file", remedy="Give one log file")
            if not file.exists() and whole is None:
                raise LogError("there is no such file", remedy="Check the path")
            if whole is None and not file.is_file():
                raise LogError("this is not a regular file", remedy="Give a log file")
        except (OSError, ValueError) as error:
            problem = f"the file cannot be read ({error})"
            raise LogError(problem, remedy="Check the path and its permissions") from error
    return file, whole


def _digest_of_files(log: Path, reader: LogReader) -> str:
    """SHA-256 over names and SHA-256 of the files of a log, by name."""
    digest = hashlib.sha256()
    with readable(log):
        files = log.iterdir() if log.is_dir() else reader.parts(log)
        inside = sorted(path for path in files if path.is_file())
        if sum(path.stat().st_size for path in inside) > _LARGEST:
            raise LogError("the files of the folder are larger than 4 GiB", remedy="Split the log")
        for path in inside:
            with path.open("rb") as content:
                own = hashlib.file_digest(content, "sha256").hexdigest()
            digest.update(f"{path.name}\0{own}\0".encode())
    return digest.hexdigest()


def recordings_in(path: str | Path, variable: str | None = None) -> list[str]:
    """Names of the recordings that a file holds beside each other; none where it is a recording itself.

    Args:
        path: of the file.
        variable: ``COLUMN=all`` for the rows of each word of a column; anything else: what the file holds.

    Raises:
        LogError: the file cannot be read, or has no such column.
    """
    group = group_of(variable)
    if group is not None and wants_each(variable):
        with placed(Path(path).name):
            parted = groups_in(read_table(path, variable=group.recording), group.column)
        return [f"{group.recording}; {name}" if group.recording else name for name in parted]
    file, plugin = _found(path)
    data = b""
    if plugin is None:
        with readable(file):
            data = file.read_bytes()
        plugin, _ = reader_of(data[:HEAD], file.suffix)
    return _names_in(plugin, LogSource(file, data, ""))


def _names_in(plugin: Plugin, source: LogSource) -> list[str]:
    names_of = plugin.of_type(LogReader).recordings
    if names_of is None:
        return []
    with placed(source.path.name), plugin.working(f"failed on {source.path.name}"):
        return list(names_of(source))


@contextmanager
def readable(file: Path) -> Generator[None]:
    """What the system says against reading a file is a LogError."""
    try:
        yield
    except OSError as error:
        problem = f"the file cannot be read ({error.strerror})"
        raise LogError(problem, remedy="Check its permissions", where=str(file)) from error
