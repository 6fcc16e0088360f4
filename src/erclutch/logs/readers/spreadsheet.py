"""Excel tables, old and new, and OpenDocument tables are read by python-calamine: a sheet is a recording.

It is read on like a text log.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

from erclutch.errors import LogError, SeveralRecordingsError
from erclutch.logs.log_reader import HEAD, LogReader, LogSource, reader_of
from erclutch.logs.readers import first_bytes, found_recordings, reader_in_child
from erclutch.logs.readers.budget import Budget, budget_of, take_zip
from erclutch.logs.readers.names_on_a_sheet import named_by
from erclutch.logs.readers.units_on_a_sheet import with_units_of_sheets
from erclutch.logs.table import Table

_PARTS = (
    b"[Content_Types].xml",
    b"_rels/",
    b"docProps/",
    b"xl/",
    b"application/vnd.oasis.opendocument.spreadsheet",
)
_OLD_OFFICE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"  # .xls, and documents of other programs that old
_WIDEST_GAP = 2  # empty columns; behind more of them stands another table
_COMMA = re.compile(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?")
#: Tabs and line ends in a cell would cut the row, and a quote would join cells.
_PLAIN = str.maketrans({"\t": " ", "\n": " ", "\r": " ", '"': "'"})


def find(path: str, variable: str | None) -> Table:
    """The child's work. Beside a sheet with rows of numbers, sheets without are no recordings."""
    recordings: dict[str, Table] = {}
    problems: list[LogError] = []
    for sheet in _sheets(path, variable):
        if isinstance(sheet, LogError):
            problems.append(sheet)
            continue
        for name, source in sheet.parts.items():
            wanted = variable in (None, name, sheet.sheet, found_recordings.ALL)
            if not wanted and recordings:
                continue
            try:
                recordings[name] = _table(source, sheet)
            except LogError as error:
                problems.append(_of_sheet(sheet.sheet, error))
                break
    if problems and not recordings:
        raise problems[0]
    if variable not in (None, found_recordings.ALL, *recordings):
        # The error names all sheets that there are.
        for name, each in find_each(path).items():
            if isinstance(each, Table):
                recordings[name] = each
        joint = found_recordings.joint_table(recordings, str(variable), "sheet")
        if joint is not None:
            return joint
    try:
        _, table = found_recordings.choose(recordings, variable, "sheet", "the file has no sheet")
    except SeveralRecordingsError as error:
        if variable is None:
            raise found_recordings.SeveralTables(error, recordings) from error
        raise
    return table


def find_each(path: str) -> dict[str, Table | LogError]:
    """The child's work for all recordings at once: the workbook is opened once."""
    recordings: dict[str, Table | LogError] = {}
    for sheet in _sheets(path, None):
        if isinstance(sheet, LogError):
            continue
        for name, source in sheet.parts.items():
            try:
                recordings[name] = _table(source, sheet)
            except LogError as error:
                recordings[name] = _of_sheet(sheet.sheet, error)
    return recordings


@dataclass(frozen=True)
class _Sheet:
    """A sheet, the texts of its recordings by their names, what was left out beside them, and its workbook."""

    sheet: str
    parts: dict[str, LogSource]
    note: str = ""
    book: Any = None


def _sheets(path: str, variable: str | None) -> Iterator[_Sheet | LogError]:
    """The sheets of a workbook, or the sheet that a name is of; what stands against one in its place."""
    from python_calamine import CalamineWorkbook

    budget = budget_of(Path(path))
    with Path(path).open("rb") as file:
        head = file.read(HEAD)
    is_packed = not head.startswith(_OLD_OFFICE)
    text_in_disguise = first_bytes.named_text(head.decode("utf-8", "replace"))
    if is_packed and text_in_disguise:
        kind, remedy = text_in_disguise
        raise LogError(f"the file is {kind} under the name of a workbook", remedy=remedy)
    if is_packed:
        take_zip(Path(path), budget)
    try:
        book = CalamineWorkbook.from_path(path)
    except Exception as error:  # the library's own kinds have no types
        if is_packed:
            raise  # the child tells the damage of a new file
        problem = f"the file holds an old Office file without a table that can be read ({error})"
        raise LogError(problem, remedy="Save it as .xlsx") from error
    with book:
        # A name that is no sheet may be that of a part of a sheet: of the sheet that it begins with, or of any.
        named = [name for name in book.sheet_names if variable in (None, name)]
        if not named:
            named = [name for name in book.sheet_names if str(variable).startswith(f"{name}, ")]
        for sheet in named or book.sheet_names:
            try:
                parts, note = _parts(path, book.get_sheet_by_name(sheet), budget)
            except LogError as error:
                yield _of_sheet(sheet, error)
                continue
            by_name: dict[str, LogSource] = {}
            for part, source in parts.items():
                # A recording is called after its sheet, its part, or both where there are several sheets.
                several = len(book.sheet_names) > 1
                name = f"{sheet}, {part}" if part and several else part or sheet
                by_name[name] = source
            yield _Sheet(sheet, by_name, note, book)


def _of_sheet(sheet: str, error: LogError) -> LogError:
    return LogError(f"sheet {sheet}: {error.problem}", remedy=error.remedy)


def _parts(path: str, sheet: Any, budget: Budget) -> tuple[dict[str, LogSource], str]:
    """The rows of a sheet as a text log, or as several where an instrument's export stands in the sheet; by name.

    The second is a note on columns that were left out, see `_without_numbers_beside`.

    Lines in messages are rows of the sheet. Its empty first columns are left out.
    """
    budget.take_cells(sheet.total_height * sheet.total_width)
    rows: list[list[str]] = []
    worded: set[int] = set()  # columns that hold a text
    with_thousands: set[int] = set()  # columns that hold a whole number of 1000 or more
    #: By column, the rows of texts that are numbers with a decimal comma.
    with_commas: dict[int, list[int]] = {}
    for place, row in enumerate(sheet.iter_rows()):
        for column, value in enumerate(row):
            if isinstance(value, str) and value.strip():
                worded.add(column)
            if isinstance(value, float) and value >= 1000.0 and value.is_integer():
                with_thousands.add(column)
            elif isinstance(value, str) and "," in value and _COMMA.fullmatch(value.strip()):
                with_commas.setdefault(column, []).append(place)
        rows.append([_cell(value) for value in row])
    for column, places in with_commas.items():
        texts = [rows[place][column] for place in places]
        # In a column of thousands and of texts the program has read 1,017 as 1017 and left 0,933 a text: nobody
        # knows what each number was, so the texts stay texts.
        is_mixed = column in with_thousands
        if not is_mixed and all(re.fullmatch(r"[-+]?[1-9]\d{0,2},\d{3}", text) for text in texts):
            continue  # thousands, perhaps: the text reader weighs all that the sheet holds
        for place, text in zip(places, texts, strict=True):
            # A workbook's own numbers have points.
            rows[place][column] = f"{text} (a text)" if is_mixed else text.replace(",", ".")
    note = _without_numbers_beside(rows, worded)
    lines = ["\t".join(cells) if any(cells) else "" for cells in rows]
    source = LogSource(Path(path), "\n".join(lines).encode("utf-8", "replace"), "")

    plugin, _ = reader_of(source.data[:HEAD], "")
    names_in = plugin.of_type(LogReader).recordings
    names = list[str]() if names_in is None else list(names_in(source))
    if len(names) < 2:
        return {"": source}, note
    return {name: replace(source, variable=name) for name in names}, note


def _without_numbers_beside(rows: list[list[str]], worded: set[int]) -> str:
    """Cut off the last columns where they are numbers without a text behind a gap, beside a table with names; a note.

    Somebody copied columns there, to draw them or to reckon with them.

    Args:
        rows: cells of the sheet.
        worded: columns that hold a text.
    """
    width = max(map(len, rows), default=0)
    filled = [0] * width  # cells of each column
    for cells in rows:
        for column, cell in enumerate(cells):
            filled[column] += bool(cell)
    first = width  # of the last columns without a gap among them
    while first and filled[first - 1]:
        first -= 1
    gap = 0
    while gap < first and not filled[first - 1 - gap]:
        gap += 1
    beside = range(first, width)
    of_a_table = [
        column
        for column in worded
        if column < first and 2 * filled[column] > max(filled[first:], default=0)
    ]
    if gap < _WIDEST_GAP or not beside or not worded.isdisjoint(beside) or len(of_a_table) < 2:
        return ""
    for cells in rows:
        del cells[first - gap :]
    count = len(beside)
    return f"numbers without a name beside the table ({count} column{'s' if count > 1 else ''}): left out"


def _cell(value: Any) -> str:
    """A cell as the reader of text logs knows it; dates with their fraction of a second, durations in s."""
    if isinstance(value, str):
        return value.translate(_PLAIN).strip().lstrip("#")  # a mark of a comment would hide its row
    if isinstance(value, datetime):
        return f"{value:%Y-%m-%d %H:%M:%S.%f}"
    if isinstance(value, time):
        return f"{value:%H:%M:%S.%f}"
    if isinstance(value, date):
        return value.isoformat()
    if isinstance(value, timedelta):
        return repr(value.total_seconds())
    return repr(value * 1)  # True is written as 1


def _table(source: LogSource, found: _Sheet) -> Table:
    plugin, _ = reader_of(source.data[:HEAD], "")
    table = named_by(plugin.of_type(LogReader).read(source), found.book, found.sheet)
    table = with_units_of_sheets(table, found.book, found.sheet)
    notes = [f"recording read from sheet {found.sheet}", *table.notes]
    if found.note:
        notes.append(found.note)
    if table.clock_name:
        notes.append(f"the dates of column {table.clock_name} are read to 1 ms")
    return replace(table, notes=tuple(notes))


READER = LogReader(
    suffixes=(".xlsx", ".xlsm", ".ods"),
    # New formats are archives of parts; the old one has a mark of its own.
    claims=lambda head: (
        (head.startswith(b"PK\x03\x04") and any(part in head for part in _PARTS))
        or head.startswith(_OLD_OFFICE)
    ),
    **reader_in_child.in_child("spreadsheet", "python_calamine", reads_all=True),
    tells_damage="seen: the parts of the file have checksums; an .xls has none",
)
