"""A table may lie on its side, a signal a row: its rows are made columns before it is read on."""

from __future__ import annotations

from erclutch.logs.readers.cells import DELIMITERS, cells_of, is_full, is_number
from erclutch.logs.readers.dialect import lines_of
from erclutch.logs.table import WIDEST

_MOST_SIGNALS = 64
_FEWEST_SAMPLES = 10
_LONGEST = 50_000_000  # characters
LYING = "the table has a signal a row: its rows are taken as columns"


def upright(text: str) -> tuple[str, str]:
    """The text with its rows as columns, and a note; the text and "" where it does not lie.

    Each row begins with a name, and perhaps a unit behind it; all else in it is numbers, many more than there are rows.
    Rows of numbers alone lie where they are wider than any log.
    """
    if len(text) > _LONGEST or text.count("\n") > 2 * _MOST_SIGNALS:
        return text, ""
    lines = [line for line in lines_of(text) if is_full(line)]
    if not 2 <= len(lines) <= _MOST_SIGNALS:
        return text, ""
    for delimiter in (*DELIMITERS, " "):
        if delimiter == " ":
            rows = [line.split() for line in lines]
        else:
            rows = [cells_of(line.rstrip(delimiter), delimiter) for line in lines]
        width = len(rows[0])
        if width < max(_FEWEST_SAMPLES, 3 * len(rows)) or any(len(row) != width for row in rows):
            continue
        first_cells = {row[0].lower() for row in rows}
        for decimal in (".", ","):
            if decimal == delimiter:
                continue
            heads = {_names_before_numbers(row, decimal) for row in rows}
            has_names = heads in ({1}, {2}) and len(first_cells) == len(rows)
            lies = has_names and delimiter != " "
            if not lies and width > WIDEST:
                lies = all(is_number(cell, decimal) for row in rows for cell in row)
            if lies:
                columns = zip(*rows, strict=True)
                return "\n".join(delimiter.join(cells) for cells in columns), LYING
    return text, ""


def _names_before_numbers(row: list[str], decimal: str) -> int:
    """How many cells stand before the numbers of a row; 0 where others are no numbers, or none is a name."""
    for count in (1, 2):
        names = row[:count]
        cells = row[count:]
        are_names = all(names) and not any(is_number(name, decimal) for name in names)
        if are_names and all(not cell or is_number(cell, decimal) for cell in cells):
            return count
    return 0
