"""Excel and OpenDocument tables are read by python-calamine: a sheet is a recording, read on like a text log."""

from __future__ import annotations

from dataclasses import replace
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

from erclutch.errors import LogError
from erclutch.logs.log_reader import HEAD, LogReader, LogSource, reader_of
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.budget import Budget, budget_of, take_zip
from erclutch.logs.table import Table

_PARTS = (b"[Content_Types].xml", b"_rels/", b"docProps/", b"xl/", b"application/vnd.oasis.opendocument.spreadsheet")


def _cell(value: Any) -> str:
    """A cell as the reader of text logs knows it; dates with their fraction of a second, durations in s."""
    if isinstance(value, str):  # a mark of a comment would hide its row
        return value.translate({9: " ", 10: " ", 13: " ", 34: "'"}).strip().lstrip("#")
    if isinstance(value, datetime):
        return f"{value:%Y-%m-%d %H:%M:%S.%f}"
    if isinstance(value, (date, time)):
        return f"{value:%H:%M:%S.%f}" if isinstance(value, time) else value.isoformat()
    return repr(value.total_seconds() if isinstance(value, timedelta) else value * 1)


def _sheet(path: str, sheet: Any, budget: Budget) -> dict[str, LogSource]:
    """The rows of a sheet as a text log, or as several where an instrument's export stands in the sheet; by name.

    Lines in messages are rows of the sheet. Its empty first columns are left out.
    """
    budget.take_cells(sheet.total_height * sheet.total_width)
    rows = ([_cell(each) for each in row] for row in sheet.iter_rows())
    lines = ["\t".join(cells) if any(cells) else "" for cells in rows]
    source = LogSource(Path(path), "\n".join(lines).encode("utf-8", "replace"), "")
    plugin, _ = reader_of(source.data[:HEAD], "")
    listed = plugin.of_type(LogReader).recordings
    names = list(listed(source)) if listed is not None else list[str]()
    return {name: replace(source, variable=name) for name in names} if len(names) > 1 else {"": source}


def _table(source: LogSource, sheet: str) -> Table:
    plugin, _ = reader_of(source.data[:HEAD], "")
    table = plugin.of_type(LogReader).read(source)
    note = (f"the dates of column {table.clock_name} are read to 1 ms",) if table.clock_name else ()
    return replace(table, notes=(f"recording read from sheet {sheet}", *table.notes, *note))


def find(path: str, variable: str | None) -> Table:
    """The child's work. Beside a sheet with rows of numbers, sheets without are no recordings."""
    from python_calamine import CalamineWorkbook

    budget = budget_of(Path(path))
    take_zip(Path(path), budget)
    found: dict[str, Table] = {}
    problems: list[LogError] = []
    with CalamineWorkbook.from_path(path) as book:
        whole = [each for each in book.sheet_names if variable in (None, each)]
        for name in whole or book.sheet_names:
            try:
                for part, source in _sheet(path, book.get_sheet_by_name(name), budget).items():
                    full = f"{name}, {part}" if part and len(book.sheet_names) > 1 else part or name
                    if variable in (None, full, name, found_recordings.ALL) or not found:
                        found[full] = _table(source, name)
            except LogError as error:
                problems.append(LogError(f"sheet {name}: {error.problem}", remedy=error.remedy))
    if problems and not found:
        raise problems[0]
    return found_recordings.choose(found, variable, "sheet", "the file has no sheet")[1]


def _claims(head: bytes) -> bool:
    return head.startswith(b"PK\x03\x04") and any(part in head for part in _PARTS)


_DAMAGE = "seen: the parts of the file have checksums"
READER = LogReader(
    (".xlsx", ".xlsm", ".ods"),
    _claims,
    **found_recordings.in_child("spreadsheet", "python_calamine"),
    tells_damage=_DAMAGE,
)
