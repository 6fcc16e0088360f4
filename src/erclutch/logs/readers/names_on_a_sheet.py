"""Some workbooks hold numbers on one sheet and the names of their columns, in one row, on another."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from erclutch.logs.columns.labels import is_given_by_place, name_columns
from erclutch.logs.readers.names_and_cells import FIRST_COLUMNS
from erclutch.logs.table import Table

_MOST_OTHERS = 4  # sheets: each of them has to be read for its names
_HIGHEST = 50  # rows of a sheet that names the columns of another


def named_by(table: Table, book: Any, sheet: str) -> Table:
    """The table with the names that another sheet has for its columns; as it is where it has names of its own.

    One sheet alone may give them: it holds one row of as many texts as the table has columns, two or more, and nothing
    besides. Of fewer texts, as many as half of the columns at least, each is unsure: the last columns may have no name,
    or others.

    Args:
        table: of a sheet.
        book: its workbook, which is open.
        sheet: its name.
    """
    others = [name for name in book.sheet_names if name != sheet]
    has_names = not all(map(is_given_by_place, table.columns))
    if has_names or len(others) > _MOST_OTHERS:
        return table
    rows_of_names: list[tuple[str, list[str]]] = []
    for other in others:
        labels = _only_row_of_texts(book.get_sheet_by_name(other))
        # One text alone may be a remark.
        if len(labels) > 1 and len(labels) <= len(table.columns) <= 2 * len(labels):
            rows_of_names.append((other, labels))
    if len(rows_of_names) != 1:
        return table
    namer, labels = rows_of_names[0]
    told = f"names of the columns are those of sheet {namer}"
    unsure_names = ""
    without_names = [*table.columns][len(labels) :]
    if without_names:
        counts = (
            f"sheet {namer} names {len(labels)} columns, the rows have {len(table.columns)} cells"
        )
        told = unsure_names = f"{counts}{FIRST_COLUMNS}"
    names, units, notes = name_columns([*labels, *without_names])
    renamed = dict(zip(table.columns, names, strict=True))
    return replace(
        table,
        columns={renamed[old]: values for old, values in table.columns.items()},
        units=dict(zip(names, units, strict=True)),
        numbers={renamed.get(old, old): place for old, place in table.numbers.items()},
        notes=(*table.notes, told, *notes),
        unsure_names=unsure_names,
    )


def _only_row_of_texts(content: Any) -> list[str]:
    """The texts of a sheet that holds one row of distinct texts; none for another sheet."""
    if content.total_height > _HIGHEST:
        return []
    filled = [row for row in content.iter_rows() if any(cell not in ("", None) for cell in row)]
    if len(filled) != 1:
        return []
    cells = [cell.strip() if isinstance(cell, str) else "" for cell in filled[0]]
    while cells and not cells[-1]:
        cells.pop()
    while cells and not cells[0]:
        del cells[0]
    return cells if all(cells) and len({*cells}) == len(cells) else []
