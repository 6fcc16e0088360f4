"""The names above the rows are counted against the cells of the rows: they may be more or fewer."""

from __future__ import annotations

import re
from collections.abc import Sequence

from erclutch.logs.readers.cells import Marks, is_comment
from erclutch.logs.readers.header_lines import Header, RowsBelow

#: How a note on more names than cells ends.
FIRST_NAMES = ": the columns are called by the first of these names, which may be those of others"
#: How a note on fewer names than cells ends, where the first columns are called by them.
FIRST_COLUMNS = ": the first columns are called by these names, which may be those of others"

#: A last column that loggers name and seldom fill.
_REMARKS = re.compile(
    r"comments?|remarks?|notes?|events?|markers?|messages?|bemerkung(?:en)?|kommentare?|commentaires?|remarques?|"
    r"comentarios?|observaciones|备注|備考|コメント",
    re.IGNORECASE,
)


def without_a_header(above: Sequence[str], marks: Marks, rows: RowsBelow) -> tuple[Header, str]:
    """The names of rows that no line has as many names for as they have cells, and what is said of them.

    Of more names than cells the first are taken, and each is asked about: the other cells may have been left out at the
    end of the rows, or a name may have fallen apart at a delimiter.
    """
    cells = rows.width - rows.trailing
    called = f"the columns are called c1 .. c{cells}"
    nameless = Header([""] * cells, None, 0)
    named = width_of_names(above, marks)
    are_too_few = named < rows.width < 2 * named
    are_too_many = cells < named < 2 * rows.width
    if named <= 2 or not (are_too_few or are_too_many):
        return nameless, f"no header row: {called}"
    counts = _counts(named, cells)
    if are_too_few:
        return nameless, f"{counts}: {called}"
    return Header(marks.cells(above[-1])[:cells], None, 1), f"{counts}{FIRST_NAMES}"


def last_name_without_a_cell(names: Sequence[str], cells: int, hollow: Sequence[str]) -> str:
    """What is said of a last name that no row has a cell for; "" elsewhere, and of a column of remarks.

    Rows that lack their last cell and rows that lack another cell look the same: the names may be those of others.

    Args:
        names: of the columns.
        cells: of a row, where the names are one more, else 0.
        hollow: names of the columns without a cell that holds something.
    """
    if not cells or names[-1] not in hollow or _REMARKS.fullmatch(names[-1]):
        return ""
    return f"{_counts(len(names), cells)}{FIRST_NAMES}"


def _counts(names: int, cells: int) -> str:
    return f"the line above the rows names {names} columns, the rows have {cells} cells"


def width_of_names(above: Sequence[str], marks: Marks) -> int:
    """Cells of the line right above the rows, where each is a name but perhaps the last; 0 for another line."""
    line = next((line for line in reversed(above) if line.strip()), "")
    if marks.delimiter is None or is_comment(line):
        return 0
    cells = marks.cells(line)
    if len(cells) < 2 or not all(cells[:-1]):
        return 0
    return 0 if any(map(marks.is_number, cells)) else len(cells)


def keep_empty_cells(rows: Sequence[str], marks: Marks, width: int) -> bool:
    """Whether all rows have as many cells, and one inside of them is empty throughout: none is passed over."""
    if marks.delimiter is None or width < 3:
        return False
    cells = [marks.cells(row) for row in rows]
    if any(len(row) != width for row in cells):
        return False
    inside = range(1, width - 2)
    return any(all(not row[place] for row in cells) for place in inside)
