"""Excel and OpenDocument tables are read by python-calamine: a sheet is a recording, read on like a text log."""

from __future__ import annotations

from dataclasses import replace
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import found_recordings, text
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


def _sheet(path: str, sheet: Any, budget: Budget) -> Table:
    """The rows of a sheet as a table; lines in messages are rows of the sheet. Its empty first columns are left out."""
    budget.take_cells(sheet.total_height * sheet.total_width)
    rows = ([_cell(each) for each in row] for row in sheet.iter_rows())
    lines = ["\t".join(cells) if any(cells) else "" for cells in rows]
    table = text.read_text(LogSource(Path(path), "\n".join(lines).encode("utf-8", "replace"), ""))
    note = (f"the dates of column {table.clock_name} are read to 1 ms",) if table.clock_name else ()
    return replace(table, notes=(f"recording read from sheet {sheet.name}", *table.notes, *note))


def find(path: str, variable: str | None) -> Table:
    """The child's work. Beside a sheet with rows of numbers, sheets without are no recordings."""
    from python_calamine import CalamineWorkbook

    budget = budget_of(Path(path))
    take_zip(Path(path), budget)
    found: dict[str, Table] = {}
    problems: list[LogError] = []
    with CalamineWorkbook.from_path(path) as book:
        for name in [each for each in book.sheet_names if variable in (None, each)] or book.sheet_names:
            try:
                found[name] = _sheet(path, book.get_sheet_by_name(name), budget)
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
