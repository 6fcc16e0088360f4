"""The names above the rows are counted against the cells of the rows: they may be more or fewer."""

from __future__ import annotations

from collections.abc import Sequence

from erclutch.logs.readers.cells import Marks, is_comment
from erclutch.logs.readers.header_lines import Header, RowsBelow

#: How a note on more names than cells ends.
FIRST_NAMES = ": the columns are called by the first of these names, which may be those of others"
#: How a note on fewer names than cells ends, where the first columns are called by them.
FIRST_COLUMNS = ": the first columns are called by these names, which may be those of others"


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
    counts = f"the line above the rows names {named} columns, the rows have {cells} cells"
    if are_too_few:
        return nameless, f"{counts}: {called}"
    return Header(marks.cells(above[-1])[:cells], None, 1), f"{counts}{FIRST_NAMES}"


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
