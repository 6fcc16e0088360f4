"""A log file is opened, its format is found, and its table is read: nothing of it is called a signal yet."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.errors import LogError, placed
from erclutch.logs.columns.row_groups import EACH, group_of, groups_in, rows_of
from erclutch.logs.log_reader import (
    ROWS_WANTED,
    LogReader,
    LogSource,
    ReadableLog,
    log_at,
    readable,
)
from erclutch.logs.readers.budget import Budget, size_of, within
from erclutch.logs.table import Table
from erclutch.logs.tidying import tidied
from erclutch.registry import Plugin
from erclutch.signals.array import Array

if TYPE_CHECKING:
    from pandas import DataFrame

_LARGEST = 4 << 30  # bytes


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
    group = group_of(variable)
    log = log_at(path)
    source = replace(_source_of(log), variable=variable, told=told, decimal=decimal)
    if group is None or variable in _names_in(log.plugin, source):
        table = read_by(log.plugin, source)
    else:
        with placed(log.path.name):
            whole = read_by(log.plugin, replace(source, variable=group.recording))
            table = rows_of(whole, group)
    return _finished(table, log, path)


def tables_in(
    path: str | Path, names: Sequence[str], decimal: str | None = None
) -> dict[str, Table | LogError]:
    """The tables of recordings of a file, by name, or what stands against one: the file is read once where it can be.

    Args:
        path: see `read`.
        names: of recordings.
        decimal: see `read_table`.
    """
    log = log_at(path)
    reader = log.plugin.of_type(LogReader)
    at_once: Mapping[str, Table | LogError] = {}
    if reader.each is not None and len(names) > 1:
        with suppress(LogError):  # such as too much for one reading
            at_once = _at_once(log.path, _source_of(log).digest)
    tables: dict[str, Table | LogError] = {}
    for name in names:
        try:
            table = at_once.get(name)
            if table is None:
                tables[name] = read_table(path, variable=name or None, decimal=decimal)
            elif isinstance(table, LogError):
                tables[name] = table
            else:
                tables[name] = _finished(replace(table, damage=reader.tells_damage), log, path)
        except LogError as error:
            tables[name] = error
    return tables


def readable_tables(
    path: str | Path, names: Sequence[str], decimal: str | None = None
) -> dict[str, Table]:
    """The tables of recordings of a file, by name; a recording that is none has no table. See `tables_in`."""
    tables = tables_in(path, names, decimal)
    return {name: table for name, table in tables.items() if not isinstance(table, LogError)}


def recordings_in(path: str | Path, variable: str | None = None) -> list[str]:
    """Names of the recordings that a file holds beside each other; none where it is a recording itself.

    Args:
        path: of the file.
        variable: ``COLUMN=all`` for the rows of each word of a column; anything else: what the file holds.

    Raises:
        LogError: the file cannot be read, or has no such column.
    """
    group = group_of(variable)
    if group is not None and group.word == EACH:
        with placed(Path(path).name):
            parted = groups_in(read_table(path, variable=group.recording), group.column)
        return [f"{group.recording}; {name}" if group.recording else name for name in parted]
    return recordings_of_file(path)


def recordings_of_file(path: str | Path) -> list[str]:
    """Names of the recordings that the format of a file tells apart; none where it is a recording itself.

    Raises:
        LogError: the file cannot be read.
    """
    log = log_at(path)
    if log.plugin.of_type(LogReader).recordings is None:
        return []
    return list(_names_at_once(log.path, _source_of(log).digest))


@lru_cache(maxsize=1)
def _at_once(file: Path, digest: str) -> Mapping[str, Table | LogError]:
    """The tables of all recordings of a file; of the last file they are kept, since a look at it asks several times."""
    log = log_at(file)
    each = log.plugin.of_type(LogReader).each
    assert each is not None
    with log.plugin.working(f"failed on {file.name}"):
        return each(replace(_source_of(log), digest=digest))


@lru_cache(maxsize=1)
def _names_at_once(file: Path, digest: str) -> tuple[str, ...]:
    """The names of these recordings."""
    log = log_at(file)
    return tuple(_names_in(log.plugin, replace(_source_of(log), digest=digest)))


def _source_of(log: ReadableLog) -> LogSource:
    """The bytes of a log and their digest.

    Raises:
        LogError: no permission; the file is empty or too large.
    """
    file = log.path
    data = b""
    with placed(file.name):
        if not log.is_file:
            # Names and digests of the files of a log, by name.
            of_files = hashlib.sha256()
            with readable(file):
                parts = log.plugin.of_type(LogReader).parts
                files = file.iterdir() if file.is_dir() else parts(file)
                inside = sorted(path for path in files if path.is_file())
                if sum(path.stat().st_size for path in inside) > _LARGEST:
                    problem = "the files of the folder are larger than 4 GiB"
                    raise LogError(problem, remedy="Split the log")
                for path in inside:
                    with path.open("rb") as content:
                        own = hashlib.file_digest(content, "sha256").hexdigest()
                    of_files.update(f"{path.name}\0{own}\0".encode())
            return LogSource(file, data, of_files.hexdigest())
        with readable(file):
            if file.stat().st_size > _LARGEST:
                raise LogError("the file is larger than 4 GiB", remedy="Split the log")
            data = file.read_bytes()
        if not data:
            raise LogError("the file is empty", remedy=ROWS_WANTED)
        return LogSource(file, data, hashlib.sha256(data).hexdigest())


def _finished(table: Table, log: ReadableLog, path: str | Path) -> Table:
    """What a reader gave, with rows of numbers, whole stamps, and woven rows apart.

    Raises:
        LogError: there are no rows of numbers.
    """
    if not table.columns or not table.rows:
        raise LogError("the file has no rows of numbers", remedy=ROWS_WANTED, where=table.name)
    table = tidied(table)
    return replace(table, notes=(*table.notes, *log.notes), path=str(path))


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
        budget = Budget(len(source.data) or size_of(source.path))
        with placed(source.name), within(budget.seconds):
            table: Any = reader.read(source)
        if not plugin.own:  # a package of somebody else may return anything
            if not isinstance(table, Table):
                returned = f"returns a {type(table).__name__}"
                raise plugin.fault(f"{returned}, it must be a Table of erclutch.logs.table")
            columns: dict[str, Array] = {}
            for name, values in table.columns.items():
                columns[name] = np.asarray(values, np.float64)
            shapes = {values.shape for values in columns.values()}
            if len(shapes) > 1 or any(len(shape) != 1 for shape in shapes):
                listed = ", ".join(f"{name} {values.shape}" for name, values in columns.items())
                raise plugin.fault(f"returns columns that are no vectors of one length: {listed}")
            notes = (*table.notes, f"read by {plugin.name!r} of {plugin.label}")
            table = replace(table, columns=columns, notes=notes)
        return replace(table, damage=reader.tells_damage)


def _names_in(plugin: Plugin, source: LogSource) -> list[str]:
    """The names of the recordings that a reader sees in a file; none where its format has one recording only."""
    names_of = plugin.of_type(LogReader).recordings
    if names_of is None:
        return []
    with placed(source.path.name), plugin.working(f"failed on {source.path.name}"):
        return list(names_of(source))
