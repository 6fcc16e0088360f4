"""Some loggers write the unit into each cell (``0.5 A``): it belongs to the column, and the cells are numbers.

A meter that changes its range changes the unit too (``950 mV``, ``1.2 V``): all cells come in the unit of the last.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from erclutch.logs.columns.labels import split_label
from erclutch.logs.readers.cells import DELIMITERS, is_full
from erclutch.logs.readers.dialect import lines_of
from erclutch.signals import units

if TYPE_CHECKING:
    import pandas as pd

LOOKED_AT = 1 << 13  # last characters
_FEWEST = 3  # rows
_LONGEST_UNIT = 12  # characters
# A word may stand in front, behind which a sign says that a number follows: ``Reading: 2.1 lbs``, ``F=2 N``.
_MEASURED = re.compile(
    r"(?P<word>\s*[^\W\d][^\d:=,;\t]{0,30}[:=])?\s*(?P<number>[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?)\s*"
    rf"(?P<unit>(?:[^\W\d_]|[%°µ]|(?<=\s)1/[^\W\d_])[^\s\d,;]{{0,{_LONGEST_UNIT}}}"
    r"(?:[ ·*.][^\W\d_]{1,3}(?:\^-?|-)[1-4]|(?<=\^)-?[1-4])?)\s*"
)
_CALLED_UNIT = re.compile(
    r"(?:units?|einheit|unit[eé]s?|unidad(?:es)?|单位|単位|ед)\b.*", re.IGNORECASE
)


def without_units_in_cells(text: str) -> tuple[str, str]:
    """The text with the units of such columns behind their names, and what is said of it; "" where there are none."""
    tail = lines_of(text[-LOOKED_AT:])[1:]
    rows_of_tail = [line for line in tail if is_full(line)]
    below_the_names = rows_of_tail[len(rows_of_tail) // 2 :]  # the first ones may name columns
    delimiter, unit_of = _units_by_column(below_the_names)
    if not unit_of:
        return text, ""

    rows = [line.split(delimiter) for line in lines_of(text)]
    # The names above the rows have no units of these quantities in their cells.
    have_units = (
        all(
            column < len(cells) and is_of_one_quantity(unit_in(cells[column]), unit)
            for column, unit in unit_of.items()
        )
        for cells in rows
    )
    first = next(place for place, has_units in enumerate(have_units) if has_units)
    words = {column: _word_before(rows[first][column]) for column in unit_of}
    for column, unit in [*unit_of.items()]:
        own = [cells[column] if column < len(cells) else "" for cells in rows[first:]]
        units_in_cells = {unit_in(cell) for cell in {*own} if cell.strip(' "0.,')}
        if None in units_in_cells and len(units_in_cells) > 2:
            del unit_of[column]  # nobody knows in which of the units a bare number is
            continue
        for cells in rows[first:]:
            own_unit = unit_in(cells[column]) if column < len(cells) else None
            if own_unit is None or (own_unit != unit and not is_of_one_quantity(own_unit, unit)):
                continue
            if _word_before(cells[column]) != words[column]:
                continue  # another quantity
            number = _MEASURED.sub(r"\g<number>", cells[column])
            if own_unit != unit:
                in_si = float(number.replace(",", ".")) * units.parse(own_unit).factor
                converted = f"{in_si / units.parse(unit).factor:.15g}"
                number = converted.replace(".", ",") if "," in number else converted
            cells[column] = number
    if not unit_of:
        return text, ""
    if first and len(rows[first - 1]) >= len(rows[first]):
        header = rows[first - 1]
        for column, unit in unit_of.items():
            name, own_unit = split_label(header[column])
            is_unread = not own_unit and name.endswith(("]", ")"))
            if own_unit != unit and not is_unread:  # the cells know better
                header[column] = f"{name} [{unit}]"
    elif not first:  # no line of names, so the units make the first
        labels = [f"c{place}" for place in range(1, len(rows[0]) + 1)]
        for column, unit in unit_of.items():
            labels[column] += f" [{unit}]"
        rows.insert(0, labels)
    plain = "\n".join(delimiter.join(cells) for cells in rows)
    listed_units = ", ".join(dict.fromkeys(unit_of.values()))
    return plain, f"cells hold their units ({listed_units}): read as numbers in them"


def units_beside(names: Sequence[str], texts: Mapping[str, pd.Series[Any]]) -> dict[str, str]:
    """Units that stand in a column of their own behind the column of their numbers, by the name of the latter.

    Args:
        names: of all columns, in the order of the file.
        texts: cells of the columns that hold no numbers, by name.
    """
    beside: dict[str, str] = {}
    for name, behind in pairwise(names):
        if name in texts or behind not in texts or not is_called_unit(behind):
            continue
        words = [str(word).strip("[]() ") for word in texts[behind].dropna().unique()]
        if len(words) == 1 and units.is_unit(words[0]):
            beside[name] = words[0]
    return beside


def is_called_unit(name: str) -> bool:
    """Whether a column is called one of units, in one of several languages."""
    return _CALLED_UNIT.fullmatch(name) is not None


def unit_in(cell: str) -> str | None:
    """The unit behind the number of a cell; None for any other cell, a plain number too."""
    match = _MEASURED.fullmatch(cell)
    if not match:
        return None
    unit = match["unit"]
    return unit if _is_unit(unit) else None


def _word_before(cell: str) -> str:
    """The word in front of the number of a cell, behind which a sign stands; "" for none."""
    match = _MEASURED.fullmatch(cell)
    return (match["word"] or "").strip() if match else ""


#: Whether a text is a unit; a cell of many rows is looked at once.
_is_unit = lru_cache(maxsize=1024)(units.is_unit)


def is_of_one_quantity(unit: str | None, other: str) -> bool:
    """Whether a unit is one of the quantity that another unit is of; None is a unit of none."""
    return unit is not None and units.parse(unit).dimension == units.parse(other).dimension


def whole_rows(rows: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """The rows, which have one width but perhaps for the last, which may be cut off; none where they have several."""
    if not rows:
        return []
    ((width, count),) = Counter(map(len, rows)).most_common(1)
    if width < 2 or count < _FEWEST or count < len(rows) - 1:
        return []
    return [cells for cells in rows if len(cells) == width]


def _units_by_column(lines: Sequence[str]) -> tuple[str, dict[int, str]]:
    """The delimiter, and for each column whose cells all have a unit of one quantity the unit of the last."""
    best: tuple[str, dict[int, str]] = (",", {})
    for delimiter in DELIMITERS:
        if not any(delimiter in line for line in lines):
            continue  # `whole_rows` have two columns and more
        whole = whole_rows([line.split(delimiter) for line in lines])
        width = len(whole[0]) if whole else 0
        unit_of: dict[int, str] = {}
        for column in range(width):
            unit = unit_in(whole[-1][column])
            if not unit:  # as in most logs
                continue
            have_one_word = len({_word_before(cells[column]) for cells in whole}) == 1
            are_alike = (is_of_one_quantity(unit_in(cells[column]), unit) for cells in whole)
            if have_one_word and all(are_alike):
                unit_of[column] = unit
        if len(unit_of) > len(best[1]):
            best = delimiter, unit_of
    return best
