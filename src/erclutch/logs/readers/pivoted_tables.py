"""A table may be pivoted: one quantity runs down, another across, and a third fills the cells.

Spreadsheets write stresses so, over shear rates (down) and fields (across). The numbers across are no row: they become
names of columns with what they are of, ``Shear stress 0.2 T [Pa]``. Rates across are turned down first.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

from erclutch.errors import UnitError
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.rheometer_names import said_by_name
from erclutch.logs.readers.cells import DELIMITERS, WORDS, cells_of, is_full, is_numeric, sums_up
from erclutch.logs.readers.dialect import lines_of
from erclutch.logs.readers.numerals import BLANKS, ungrouped
from erclutch.signals import units
from erclutch.signals.recording import SI_UNITS_OF_FIELDS

_HEAD = 1 << 14  # characters in which the numbers across stand
_MOST_ABOVE = 40  # lines
_FEWEST_ACROSS = 2
_LONGEST_CORNER = 200  # characters
_FEWEST_DOWN = 3
_LARGEST_TURNED = 1 << 20  # characters of a table that is turned
_CORNER = re.compile(r"(.+?[\])]|.+?\s)\s*[\\/]\s*(\S.*)")
_BRACKETS = re.compile(r"[\[(]([^\[\]()]+)[\])]")
#: What a spreadsheet calls the column behind the others of a pivot.
_TOTALS = frozenset(
    (
        "grand total",
        "total",
        "gesamtergebnis",
        "total general",
        "total général",
        "totale",
        "общий итог",
        "总计",
        "総計",
    )
)


@dataclass(frozen=True)
class _Pivot:
    """Where the numbers across stand, and what is said of them.

    Attributes:
        line: of the numbers, among all lines.
        said_in: lines that tell what the numbers are of; they are no prose.
        delimiter: between the cells.
        down: label of the quantity that runs down.
        across: the numbers, as written with a decimal point.
        value: label of what fills the cells; "" where nobody says.
        set_to: name and unit of the quantity that runs across.
        is_turned: whether shear rates run across.
        has_total: whether a column of sums or means stands behind the others.
    """

    line: int
    said_in: tuple[int, ...]
    delimiter: str
    down: str
    across: tuple[str, ...]
    value: str
    set_to: tuple[str, str]
    is_turned: bool = False
    has_total: bool = False


def with_pivoted_heads(text: str) -> tuple[str, str]:
    """The text with a line of names for the numbers across, and a note; the text and "" where it is not pivoted."""
    head = lines_of(text[:_HEAD])
    if len(text) > _HEAD:
        head.pop()
    filled = [place for place, line in enumerate(head) if is_full(line)][:_MOST_ABOVE]
    for delimiter in DELIMITERS:
        if not any(delimiter in head[place] for place in filled):
            continue
        pivot = _pivot_in(head, filled, delimiter)
        if pivot is None:
            continue
        lines = lines_of(text)
        for line in pivot.said_in:
            lines[line] = ""
        if pivot.has_total:
            width = len(pivot.across) + 2
            for place in range(pivot.line, len(lines)):
                cells = lines[place].split(delimiter)
                if len(cells) == width:
                    lines[place] = delimiter.join(cells[:-1])
        if not pivot.is_turned:
            lines[pivot.line] = delimiter.join([pivot.down, *_names(pivot, pivot.across)])
            first_numbers = ", ".join(pivot.across[:4])
            note = f"the numbers {first_numbers}, ... above the columns are in their names"
            return "\n".join(lines), note
        if len(text) > _LARGEST_TURNED:
            return text, ""
        rows = [cells_of(line, delimiter) for line in lines[pivot.line + 1 :] if line.strip()]
        count = len(pivot.across)
        numbers = [_number(row[0]) for row in rows]
        if None in numbers:  # a remark below the rows
            return text, ""
        levels = [f"{number:g}" for number in numbers]
        turned = [delimiter.join([pivot.down, *_names(pivot, levels)])]
        _, *rates = cells_of(lines[pivot.line], delimiter)
        for column, rate in enumerate(rates[:count], start=1):
            cells = [row[column] if column < len(row) else "" for row in rows]
            turned.append(delimiter.join([rate, *cells]))
        return "\n".join(turned) + "\n", "the shear rates stand across: rows are taken as columns"
    return text, ""


def _pivot_in(lines: Sequence[str], filled: Sequence[int], delimiter: str) -> _Pivot | None:
    """The line of numbers across under a delimiter, by the first lines that are filled; None where there is none."""
    rows = {place: cells_of(lines[place].rstrip(delimiter), delimiter) for place in filled}
    for order, place in enumerate(filled):
        cells = rows[place]
        below = filled[order + 1 :]
        above = [rows[each] for each in filled[max(order - 1, 0) : order]]
        # A row whose first number is missing is no line of numbers across: above it stand rows, or names.
        is_a_row = (
            is_numeric(cells[0], delimiter)
            or (cells[0].lower() in WORDS and cells[0] != "")
            or sums_up(cells[0])
        )
        is_below_a_row = bool(above) and is_numeric(above[0][0], delimiter)
        if is_a_row or is_below_a_row:
            continue
        has_total = cells[-1].lower() in _TOTALS
        numbers = _rising_numbers(cells[1 : len(cells) - has_total], delimiter)
        if not numbers:
            continue
        corner = cells[0]
        down = corner
        own: list[str] = []  # what the line itself says of the numbers across
        said_in: list[int] = []
        if corner and below:
            next_cells = rows[below[0]]
            is_a_name_alone = sum(map(bool, next_cells)) == 1 and not is_numeric(
                next_cells[0], delimiter
            )
            if is_a_name_alone:  # pandas writes the name of what runs down into a line of its own
                said_in.append(below[0])
                down = next_cells[0]
                own = [corner]
                below = below[1:]
        first_rows = [rows[each] for each in below[:_FEWEST_DOWN]]
        width = len(numbers) + 1 + has_total
        begin_filled = all(2 <= len(row) <= width and row[0] != "" for row in first_rows)
        cells_below = [cell for row in first_rows for cell in row if cell]
        are_numbers = all(is_numeric(cell, delimiter) for cell in cells_below)
        is_one_full = any(len(row) == width for row in first_rows)
        if len(first_rows) < 2 or not begin_filled or not are_numbers or not is_one_full:
            continue

        # The line above may name what fills the cells and what runs across; above an empty corner, what runs down too.
        over = [cell for cell in above[0] if cell] if above else []
        are_words = not any(is_numeric(cell, delimiter) for cell in over)
        if not corner:
            names_what_runs_down = 2 <= len(over) <= 3 and above[0][0] != ""
            if not names_what_runs_down or not are_words or len(over) > len(numbers):
                continue
            down, *over = over
            said_in.append(filled[order - 1])
        elif 0 < len(over) <= 2 and are_words and len(over) < len(cells) - 1:
            said_in.append(filled[order - 1])
        else:
            over = []

        is_turned = False
        parts = _CORNER.fullmatch(corner) if len(corner) <= _LONGEST_CORNER else None
        if parts and not own:  # such as rate [1/s] / T [°C]
            first, second = (part.strip() for part in parts.groups())
            name, _ = split_label(second)
            is_turned = said_by_name(name) == "rate"
            down = second if is_turned else first
            own = [first if is_turned else second]
        value, set_to = _said(over, own)
        return _Pivot(
            place,
            tuple(said_in),
            delimiter,
            down,
            tuple(numbers),
            value,
            set_to,
            is_turned=is_turned,
            has_total=has_total,
        )
    return None


def _rising_numbers(cells: Sequence[str], delimiter: str) -> list[str]:
    """Numbers that rise or fall over all cells, as short as they can be written; none where a cell is another."""
    if len(cells) < _FEWEST_ACROSS or not all(is_numeric(cell, delimiter) for cell in cells):
        return []
    numbers: list[float] = []
    for cell in cells:
        number = _number(cell)
        if number is None:
            return []
        numbers.append(number)
    steps = [later - earlier for earlier, later in pairwise(numbers)]
    if not all(step > 0 for step in steps) and not all(step < 0 for step in steps):
        return []
    return [f"{number:g}" for number in numbers]


def _number(cell: str) -> float | None:
    """The number of a cell with either decimal mark; None for words, and for digits in groups, whose mark is open."""
    is_grouped = cell.count(",") + cell.count(".") > 1 or any(blank in cell for blank in BLANKS)
    if is_grouped or not is_numeric(cell):
        return None
    return float(ungrouped(cell, "," if "," in cell else "."))


def _said(over: Sequence[str], own: Sequence[str]) -> tuple[str, tuple[str, str]]:
    """Label of what fills the cells, and name and unit of what runs across, as the words above and beside them say."""
    words = [*over, *own]
    if len(words) > 1:
        name, unit = split_label(words[1])
        return words[0], (name, unit or "")
    if not words:
        return "", ("", "")
    units_in_brackets = _BRACKETS.findall(words[0])
    if len(units_in_brackets) > 1:  # Shear stress [Pa] at flux density [T]
        first = words[0].index(units_in_brackets[0]) + len(units_in_brackets[0]) + 1
        behind = _BRACKETS.sub("", words[0][first:]).strip()
        return words[0][:first], (behind, units_in_brackets[-1])
    name, unit = split_label(words[0])
    runs_across = bool(own)
    if unit and not own:
        with suppress(UnitError):
            runs_across = (
                units.is_temperature(unit) or units.fits(unit, SI_UNITS_OF_FIELDS) is not None
            )
    return ("", (name, unit or "")) if runs_across else (words[0], ("", ""))


def _names(pivot: _Pivot, levels: Sequence[str]) -> list[str]:
    """A label for each column: the quantity in its cells, and what the column is set to."""
    name, unit = split_label(pivot.value)
    set_name, set_unit = pivot.set_to
    labels: list[str] = []
    for level in levels:
        words = [name, f"{level} {set_unit}" if set_unit else f"{set_name or 'at'} {level}"]
        label = " ".join(word for word in words if word)
        labels.append(f"{label} [{unit}]" if unit else label)
    return labels
