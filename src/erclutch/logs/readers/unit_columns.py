"""Some loggers write a unit into a cell of its own behind each number: ``-0.17,N, 23.86,V``.

Number and unit become one cell, ``-0.17 N``, which `unit_cells` reads. A column of words is none of units where it has
a name of its own, such as the flag of a satellite's fix or the phase of a motor.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from erclutch.logs.readers.cells import DELIMITERS, cells_of, is_comment, is_numeric
from erclutch.logs.readers.dialect import LINE_END
from erclutch.logs.readers.unit_cells import LOOKED_AT, is_called_unit, is_of_one_quantity, unit_in

_FEWEST = 3  # rows
_FEWEST_PAIRS = 2  # of a number and its unit, where no names stand above


def with_units_in_cells(text: str) -> tuple[str, str]:
    """The text with such pairs of cells as one cell each, and what is said of it; the text and "" for other texts."""
    tail = LINE_END.split(text[-LOOKED_AT:])
    rows_of_tail = [
        line for line in tail[len(text) > LOOKED_AT :] if line.strip() and not is_comment(line)
    ]
    below_the_names = rows_of_tail[len(rows_of_tail) // 2 :]
    for delimiter in (*DELIMITERS, None):
        width, places = _columns_of_units(below_the_names, delimiter)
        if not places:
            continue
        lines = LINE_END.split(text)
        first = next(
            place
            for place, line in enumerate(lines)
            if _is_row(cells_of(line, delimiter), width, places)
        )
        names = cells_of(lines[first - 1], delimiter) if first else []
        mark = delimiter or "\t"
        header: list[str] = []
        if len(names) == width and all(
            not names[place] or is_called_unit(names[place]) for place in places
        ):
            header = [name for place, name in enumerate(names) if place not in places]
        elif len(names) == width - len(places) and delimiter is None:
            header = names  # a name for a number and its unit
        elif len(names) > 1 or len(places) < _FEWEST_PAIRS:
            continue
        joined = lines[: first - bool(header)]
        if header:
            joined.append(_line(header, mark))
        for line in lines[first:]:
            cells = cells_of(line, delimiter)
            joined.append(_line(_joined(cells, places), mark) if len(cells) == width else line)
        return "\n".join(joined), f"{len(places)} columns hold the unit of the number before them"
    return text, ""


def _columns_of_units(lines: Sequence[str], delimiter: str | None) -> tuple[int, list[int]]:
    """Cells of a row, and which of them are units of one quantity behind a number, in all rows."""
    rows = [cells_of(line, delimiter) for line in lines]
    if not rows:
        return 0, []
    ((width, count),) = Counter(map(len, rows)).most_common(1)
    if width < 2 or count < _FEWEST or count < len(rows) - 1:  # the last one may be cut off
        return 0, []
    whole = [cells for cells in rows if len(cells) == width]
    places: list[int] = []
    for place in range(1, width):
        unit = whole[-1][place]
        if not unit_in(f"1 {unit}") or place - 1 in places:
            continue
        if all(_is_pair(cells, place, unit, delimiter) for cells in whole):
            places.append(place)
    return width, places


def _is_pair(cells: Sequence[str], place: int, unit: str, delimiter: str | None) -> bool:
    """Whether a number stands in front of a cell that is a unit, of the same quantity as another."""
    own = unit_in(f"1 {cells[place]}")
    return is_numeric(cells[place - 1], delimiter) and is_of_one_quantity(own, unit)


def _is_row(cells: Sequence[str], width: int, places: Sequence[int]) -> bool:
    """Whether a line has units where the rows have them."""
    return len(cells) == width and all(unit_in(f"1 {cells[place]}") for place in places)


def _joined(cells: Sequence[str], places: Sequence[int]) -> list[str]:
    """The cells, each unit behind its number."""
    joined: list[str] = []
    for place, cell in enumerate(cells):
        if place in places:
            joined[-1] = f"{joined[-1]} {cell}".strip()
        else:
            joined.append(cell)
    return joined


def _line(cells: Sequence[str], mark: str) -> str:
    """Cells as a line; in quotes where they hold what stands between them."""
    return mark.join(f'"{cell}"' if mark in cell else cell for cell in cells)
