"""Some loggers write a unit into a cell of its own behind each number: ``-0.17,N, 23.86,V``.

Number and unit become one cell, ``-0.17 N``, which `unit_cells` reads. A column of words is none of units where it has
a name of its own, such as the flag of a satellite's fix or the phase of a motor.
"""

from __future__ import annotations

from erclutch.logs.readers.cells import DELIMITERS, cells_of, is_full, is_numeric, line_of
from erclutch.logs.readers.dialect import lines_of
from erclutch.logs.readers.unit_cells import (
    LOOKED_AT,
    is_called_unit,
    is_of_one_quantity,
    unit_in,
    whole_rows,
)

_FEWEST_PAIRS = 2  # of a number and its unit, where no names stand above


def with_units_in_cells(text: str) -> tuple[str, str]:
    """The text with such pairs of cells as one cell each, and what is said of it; the text and "" for other texts."""
    tail = lines_of(text[-LOOKED_AT:])[len(text) > LOOKED_AT :]
    rows_of_tail = [line for line in tail if is_full(line)]
    below_the_names = rows_of_tail[len(rows_of_tail) // 2 :]
    for delimiter in (*DELIMITERS, None):
        if delimiter is not None and not any(delimiter in line for line in below_the_names):
            continue  # a number and its unit are two cells
        whole = whole_rows([cells_of(line, delimiter) for line in below_the_names])
        width = len(whole[0]) if whole else 0
        # The cells of a row that are units of one quantity, behind a number, in all rows.
        places: list[int] = []
        for place in range(1, width):
            unit = whole[-1][place]
            if not unit_in(f"1 {unit}") or place - 1 in places:
                continue
            are_behind_numbers = all(is_numeric(cells[place - 1], delimiter) for cells in whole)
            own_units = [unit_in(f"1 {cells[place]}") for cells in whole]
            if are_behind_numbers and all(is_of_one_quantity(own, unit) for own in own_units):
                places.append(place)
        if not places:
            continue
        lines = lines_of(text)
        rows = (cells_of(line, delimiter) for line in lines)
        have_units = (
            len(cells) == width and all(unit_in(f"1 {cells[place]}") for place in places)
            for cells in rows
        )
        first = next(place for place, has_units in enumerate(have_units) if has_units)
        names = cells_of(lines[first - 1], delimiter) if first else []
        header: list[str] = []
        names_of_units = [names[place] for place in places] if len(names) == width else []
        if names_of_units and all(not name or is_called_unit(name) for name in names_of_units):
            header = [name for place, name in enumerate(names) if place not in places]
        elif len(names) == width - len(places) and delimiter is None:
            header = names  # a name for a number and its unit
        elif len(names) > 1 or len(places) < _FEWEST_PAIRS:
            continue
        mark = delimiter or "\t"
        joined = lines[: first - bool(header)]
        if header:
            joined.append(line_of(header, mark))
        for line in lines[first:]:
            cells = cells_of(line, delimiter)
            if len(cells) != width:
                joined.append(line)
                continue
            for place in reversed(places):
                cells[place - 1 : place + 1] = [f"{cells[place - 1]} {cells[place]}".strip()]
            joined.append(line_of(cells, mark))
        return "\n".join(joined), f"{len(places)} columns hold the unit of the number before them"
    return text, ""
