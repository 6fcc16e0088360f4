"""Tables that pandas or R printed have a column of row names without a name, and names right above the ends of cells.

``df.to_string()`` and ``print(ts)`` write so. A csv of a DataFrame without names has 0, 1, 2 in their place.
"""

from __future__ import annotations

import re

from erclutch.logs.readers.cells import cells_of, is_number, line_of
from erclutch.logs.readers.dialect import lines_of

_HEAD = 1 << 13  # characters that hold all lines above the rows, and some rows
_MOST_ABOVE = 20  # lines
_FEWEST_ROWS = 3
_DURATION = r"-?\d+ days? [+]?\d\d:\d\d:\d\d(?:\.\d+)?"
_CELL = re.compile(rf"{_DURATION}|\S+")
_SIZE = re.compile(r"\[\d+ rows x \d+ columns\]")
_OF_R = "time series:"
_JUMP = 3.0  # steps from row to row, by which a row is no neighbour of the next


def with_names_of_printed_frame(text: str) -> tuple[str, str]:
    """The text as a csv, where it is such a print, and a note; the text and "" where it is none."""
    head = lines_of(text[:_HEAD])[: _MOST_ABOVE + _FEWEST_ROWS]
    for place, line in enumerate(head[:_MOST_ABOVE]):
        if not line.startswith(" ") or "\t" in line or not line.strip():
            continue
        name = ""
        first = place + 1
        if first < len(head) and head[first].strip().isidentifier():
            name = head[first].strip()  # of the index, in a line of its own
            first += 1
        names = _names_above(line, head[first : first + _FEWEST_ROWS])
        if not names:
            continue
        lines = lines_of(text)
        above = lines[:place]
        is_of_r = any(_OF_R in each.lower() for each in above)
        name = name or ("time" if is_of_r else "index")
        rows: list[str] = []
        for row in lines[first:]:
            if row.strip() and not _SIZE.fullmatch(row.strip()):
                rows.append(",".join(_CELL.findall(row)))
        note = f"laid out as a print of a table: its first column is called {name}"
        return "\n".join([*above, line_of([name, *names], ","), *rows]), note
    return text, ""


def _names_above(line: str, rows: list[str]) -> list[str]:
    """The names in a line, each right above the end of a cell but for the first of each row; none in another line."""
    cells = [list(_CELL.finditer(row)) for row in rows]
    widths = {len(of_row) for of_row in cells}
    if len(rows) < _FEWEST_ROWS or len(widths) != 1 or widths.pop() < 3:
        return []
    if not all(is_number(cell[0], ".") for of_row in cells for cell in (of_row[0], of_row[-1])):
        return []
    first, *others = cells[0]
    names: list[str] = []
    start = 0
    for cell in others:
        end = cell.end()
        is_apart = line[end : end + 1] in ("", " ") and line[end - 1 : end].strip() != ""
        names.append(line[start:end].strip())
        if not is_apart or not names[-1] or is_number(names[-1], "."):
            return []
        start = end
    is_whole = not line[start:].strip() and not line[: first.end()].strip()
    return names if is_whole else []


def with_names_for_places(text: str) -> tuple[str, str]:
    """The text without a first line of 0, 1, 2, which pandas writes for names; a note; the text and "" for others."""
    first, *others = lines_of(text[:_HEAD])
    if not re.fullmatch(r"[;,\t]?0[;,\t]1(?:[;,\t]\d+)*\s*", first):
        return text, ""
    delimiter = next(mark for mark in first if mark in ";,\t")
    places = cells_of(first, delimiter)
    has_index = places[0] == ""
    numbers = [int(cell) for cell in places if cell]
    rows = [cells_of(row, delimiter) for row in others[:_FEWEST_ROWS]]
    if numbers != [*range(len(numbers))] or len(rows) < _FEWEST_ROWS:
        return text, ""
    if any(len(row) != len(places) for row in rows):
        return text, ""
    if not has_index and len(numbers) < 3 and not _is_apart(rows, numbers):
        return text, ""
    names = [f"c{number + 1}" for number in numbers]
    line = line_of(["index", *names] if has_index else names, delimiter)
    note = f"the first line counts the columns: they are called {names[0]} .. {names[-1]}"
    return f"{line}\n{text.partition(chr(10))[2]}", note


def _is_apart(rows: list[list[str]], numbers: list[int]) -> bool:
    """Whether a line of numbers lies far from the first row, by the steps between the rows."""
    try:
        first, second, *_ = ([float(cell.replace(",", ".")) for cell in row] for row in rows)
    except ValueError:
        return False
    for number, one, other in zip(numbers, first, second, strict=True):
        if abs(one - number) > _JUMP * abs(other - one) > 0.0:
            return True
    return False
