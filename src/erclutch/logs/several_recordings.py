"""A file may hold several recordings: their names, and their tables, read at once where the format can be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from erclutch.errors import LogError, placed
from erclutch.logs.columns.row_groups import EACH, group_of, groups_in
from erclutch.logs.log_file import read_table
from erclutch.logs.log_reader import LogReader, log_at, names_in, source_of
from erclutch.logs.table import Table
from erclutch.logs.tidying import finished


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
            at_once = _at_once(log.path, source_of(log).digest)
    tables: dict[str, Table | LogError] = {}
    for name in names:
        try:
            table = at_once.get(name)
            if table is None:
                tables[name] = read_table(path, variable=name or None, decimal=decimal)
            elif isinstance(table, LogError):
                tables[name] = table
            else:
                table = replace(table, damage=reader.tells_damage)
                tables[name] = finished(table, log.notes, path)
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
    return list(_names_at_once(log.path, source_of(log).digest))


@lru_cache(maxsize=1)
def _at_once(file: Path, digest: str) -> Mapping[str, Table | LogError]:
    """The tables of all recordings of a file; of the last file they are kept, since a look at it asks several times."""
    log = log_at(file)
    each = log.plugin.of_type(LogReader).each
    assert each is not None
    with log.plugin.working(f"failed on {file.name}"):
        return each(replace(source_of(log), digest=digest))


@lru_cache(maxsize=1)
def _names_at_once(file: Path, digest: str) -> tuple[str, ...]:
    """The names of these recordings."""
    log = log_at(file)
    return tuple(names_in(log.plugin, replace(source_of(log), digest=digest)))
