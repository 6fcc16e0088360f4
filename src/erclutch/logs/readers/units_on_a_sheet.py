"""Some workbooks list the channels of a sheet on another one, with their units: name, unit, description."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from erclutch.logs.readers.cells import is_number
from erclutch.logs.readers.told_units import with_told_units
from erclutch.logs.table import Table
from erclutch.signals import units

_MOST_OTHERS = 4  # sheets: each of them has to be read for its units
_HIGHEST = 300  # rows of a sheet that lists channels
_WIDEST = 300  # columns of it


def with_units_of_sheets(table: Table, book: Any, sheet: str) -> Table:
    """The table with the units that other sheets list for its columns; its own units go first.

    Args:
        table: of a sheet.
        book: its workbook, which is open.
        sheet: its name.
    """
    others = [name for name in book.sheet_names if name != sheet]
    if len(others) > _MOST_OTHERS or all(table.units.get(name) for name in table.columns):
        return table
    texts: list[tuple[str, str]] = []
    for other in others:
        content = book.get_sheet_by_name(other)
        if content.total_height > _HIGHEST or content.total_width > _WIDEST:
            continue
        rows = [[str(cell).strip() for cell in row] for row in content.iter_rows()]
        texts += texts_of_sheet(rows, [*table.columns])
    return with_told_units(table, texts)


def texts_of_sheet(
    rows: Sequence[Sequence[str]], names: Sequence[str]
) -> Iterator[tuple[str, str]]:
    """What a sheet says of columns: in the row of a name, or below a row of all names."""
    for number, row in enumerate(rows):
        named = [cell for cell in row if cell in names]
        if len(named) > 1:
            for below in rows[number + 1 : number + 2]:
                for name, cell in zip(row, below, strict=False):
                    if name in names:
                        yield f"{name} unit", cell
            continue
        if not named:
            continue
        behind = [cell for cell in row[row.index(named[0]) + 1 :] if cell]
        if behind and is_number(behind[0], "."):
            continue  # a setting of the test: F, 2, kN
        others = [cell for cell in row if cell not in ("", named[0]) and not is_number(cell, ".")]
        alone = [cell for cell in others if units.is_known_unit(cell)]
        if len({*alone}) == 1:
            yield f"{named[0]} unit", alone[0]
        elif not alone:
            for cell in others:
                yield named[0], cell
