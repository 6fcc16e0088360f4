"""Lines above the rows of a text name the columns and give their units, in the ways that loggers write them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from erclutch.logs.columns.labels import EASTERN, split_label
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.readers.cells import Marks, is_comment
from erclutch.logs.readers.channel_lines import (
    channel_units,
    keyed_channels,
    labels_and_units,
    said_below_names,
    with_channel_labels,
    with_groups,
)
from erclutch.logs.readers.numbered_channels import numbered_channels
from erclutch.logs.readers.rows_of_units import (
    are_borne_out,
    are_units,
    bare_units,
    is_written_unit,
    repeat_a_unit,
    units_of_row,
)
from erclutch.signals import units

#: What the line of units is called that some loggers write above the names.
_UNIT_LINE = frozenset(
    ("unit units einheit einheiten unite unité unités unidad unidade 単位 单位 單位").split()
)
_COLUMN = r"(?:col(?:umn)?|ch(?:annel)?|field|var(?:iable)?|spalte|colonne|columna)?"
_TYPE = re.compile(
    r"[fiu]\d{1,2}|(?:real|u?int|float)\d{1,2}|l?real|d?int|float|double|integer", re.IGNORECASE
)
_FEWEST_TOLD = 2  # columns of a legend
#: Between the heading of a table and the name of a column, where tables stand side by side.
HEADED = ": "
#: A comment that names one column by its number: ``# column 1: time [s]``.
_NUMBER_ALONE = re.compile(r"[-+]?\d+(?:[.,]\d+)?")
_NUMBERED = re.compile(rf"[#%/]+\s*{_COLUMN}[\s.#]*(\d{{1,3}})\s*[:=.)-]\s*(\S.*)", re.I)


@dataclass(frozen=True)
class RowsBelow:
    """What the rows of the sample say of the header above them.

    Attributes:
        width: cells of a row.
        trailing: whether each row ends in a delimiter with nothing behind it.
        are_named: whether the first cells name their rows.
    """

    width: int
    trailing: bool
    are_named: bool


@dataclass(frozen=True)
class Header:
    """The lines right above the data that name the columns.

    Attributes:
        labels: as they stand in a line.
        units: of the labels, where a line of its own gives them.
        lines: how many they are.
        pairs: ``Key: value`` lines among them, which say the same of all channels.
    """

    labels: list[str]
    units: list[str | None] | None
    lines: int
    pairs: tuple[str, ...] = ()


def header_of(above: Sequence[str], marks: Marks, rows: RowsBelow) -> Header | None:
    """Labels and units of the one, two or three header lines right above the data.

    Args:
        above: lines above the first row, without empty lines.
        marks: delimiter and decimal mark.
        rows: below.
    """
    if said_of_each := _said_of_each_column(above, marks, rows):
        return said_of_each
    for below in (0, 1):  # lines below that of the types, such as f8, REAL64
        types = marks.cells(above[-1 - below]) if len(above) > 1 + below else []
        if len(types) == rows.width > 1 and all(map(_TYPE.fullmatch, types)):
            typed = header_of([*above[: -1 - below], *above[len(above) - below :]], marks, rows)
            return None if typed is None else replace(typed, lines=typed.lines + 1)
    last = _labels(above[-1], marks, rows) if above else None
    if last is None:
        return None
    # A row of samples over every second column, below names and units: the names are those above.
    if len(above) > 2 and 2 * _filled(last) <= len(last) > 1:
        names = _labels(above[-3], marks, rows)
        units_below = _labels(above[-2], marks, rows)
        has_more_names = names is not None and _filled(names) > _filled(last)
        if names and has_more_names and units_below and are_units(bare_units(units_below)):
            return Header(names, units_of_row(units_below), 3)
    if len(above) < 2:
        return Header(last, None, 1)
    if labels := _labels_of_pairs(marks.cells(above[-2]), last):
        return Header(labels, None, 2)
    if labels := _names_over_an_index(last, above[-2], marks, rows):
        return Header(labels, None, 2)
    # A line of units above the names begins with the word for them, in a cell of its own or in front of the first.
    upper = marks.cells(above[-2].lstrip("#%/ "))
    word, colon, first_unit = upper[0].partition("=" if "=" in upper[0] else ":")
    own_units = [first_unit if colon else "", *upper[1:]]
    is_called_units = word.lower().strip("[]() ") in _UNIT_LINE and len(upper) == len(last)
    if is_called_units and all(map(is_written_unit, filter(None, bare_units(own_units)))):
        return Header(last, units_of_row(own_units), 2)

    names = _names_over(last, above[-2], marks, rows)
    if names is not None and len(names) == len(last):
        # Names are words: a second line of units, or of what is called like a unit, names nothing.
        names_are_units = are_units(bare_units(names))
        last_are_units = are_units(bare_units(last))
        if not names_are_units and (
            last_are_units or repeat_a_unit(last, names) or are_borne_out(last, names)
        ):
            return Header(names, units_of_row(last), 2)
        are_distinct = all(last) and len({*last}) == len(last)
        if names_are_units and are_distinct and not last_are_units:
            return Header(last, units_of_row(names), 2)
        # A line under the names may say them again in Chinese or Japanese, half of them or more with a unit.
        are_eastern = all(map(EASTERN.search, last))
        eastern_units = [split_label(cell)[1] for cell in last] if are_eastern else []
        if are_eastern and all(names) and 2 * eastern_units.count(None) <= len(last):
            return Header(names, eastern_units, 2)
    return Header(last, None, 1)


def _names_over_an_index(
    last: Sequence[str], line: str, marks: Marks, rows: RowsBelow
) -> list[str]:
    """Names above a line of one name, as pandas writes the name of its index below names of two levels; else none."""
    if len(last) < 3 or not last[0] or any(last[1:]):
        return []
    first, *names = _labels(line, marks, rows) or [""]
    # Such a cell may also be the unit of the first column; t is a tonne, but not there.
    is_a_unit = bool(first) and is_written_unit(last[0]) and not spoken_name(last[0]).is_time
    return [last[0], *names] if names and all(names) and not is_a_unit else []


def _names_over(last: Sequence[str], line: str, marks: Marks, rows: RowsBelow) -> list[str] | None:
    """Names in the line above the last one of the header; some may be numbers where the last one tells units."""
    names = _labels(line, marks, rows)
    if names is None and not last[0]:
        # Bluehill writes the number of the specimen over an empty column.
        names = _labels(line, marks, rows, is_numbered=True)
    if names is None and are_units(bare_units(last)):
        # Sensors may be called by their serial numbers.
        names = _labels(line, marks, rows, may_be_serial=True)
    return names


def _said_of_each_column(above: Sequence[str], marks: Marks, rows: RowsBelow) -> Header | None:
    """The header of lines that say one thing each of all columns, by a number or a key; None for other lines."""
    names: dict[int, str] = {}  # by the number of their column, which is counted from 0 or from 1
    for line in above:
        match = _NUMBERED.fullmatch(line.strip()) if is_comment(line) else None
        if match:
            names.setdefault(int(match.group(1)), match.group(2))
    first = min(names, default=0)
    numbers = [*range(first, first + rows.width)]
    if rows.width > 1 and first in (0, 1) and sorted(names) == numbers:
        return Header([names[number] for number in numbers], None, 1)
    own_units, count = said_below_names(above, marks, rows.width)
    if 0 < count < len(above):
        named = _labels(above[-1 - count], marks, rows)
        if named is not None:
            return Header(named, own_units or None, count + 1)
    cells_of_key, lines = keyed_channels(above, marks, rows.width)
    if not cells_of_key:
        numbered = numbered_channels(above, rows.width - rows.trailing)
        if numbered is None:
            return None
        names_below = _labels(above[-1], marks, rows)
        says_more = 2 * _filled([unit or "" for unit in numbered[1]]) >= rows.width
        return Header(*numbered, 0) if names_below is None or says_more else None
    alike = (f"{key}: {cells[0]}" for key, cells in cells_of_key.items() if len({*cells}) == 1)
    return Header(*labels_and_units(cells_of_key), lines, tuple(alike))


def with_headings(header: Header, above: Sequence[str], marks: Marks) -> Header:
    """The header with the heading of its table before each name, where tables of the same columns stand side by side.

    A heading stands over the first column of its table, and perhaps over the others again; columns without a name may
    stand between the tables. In front of them may stand columns that they share, such as a time; then the headings are
    levels, and over a shared column may stand what they are: ``Current [A]``. Without such a line the header is as it
    was.
    """
    if not 0 < header.lines < len(above):
        return header
    names = header.labels
    bare = [split_label(label)[0] for label in names]
    counts_of_names = Counter(name for name in bare if name)
    first = next((place for place, name in enumerate(bare) if counts_of_names[name] > 1), 0)
    starts = [place for place, name in enumerate(bare) if name and name == bare[first]]
    tables: list[Sequence[str]] = []  # labels of each
    columns: list[list[str]] = []  # names of each
    for start, stop in pairwise([*starts, len(names)]):
        tables.append(names[start:stop])
        columns.append([name for name in bare[start:stop] if name])
    if len(tables) < 2 or (len(columns[0]) < 2 and first == 0):
        return header
    if any(of_table != columns[0] for of_table in columns):
        return header

    over = marks.cells(above[-header.lines - 1])
    over += [""] * (len(names) - len(over))
    levels = _as_levels([over[start] for start in starts], over[:first])
    if first > 0 and levels is None:
        return header
    headings: list[str] = [""] * first
    counts = Counter[str]()  # specimens of a second material may have the numbers of the first
    for number, (start, table) in enumerate(zip(starts, tables, strict=True)):
        heading = over[start]
        cells = over[start : start + len(table)]
        if not heading or not {*cells} <= {"", heading}:
            return header
        heading = heading if levels is None else levels[number]
        counts[heading] += 1
        told_apart = f"{heading} ({counts[heading]})" if counts[heading] > 1 else heading
        headings += [told_apart] * len(table)
    if len(counts) < 2:
        return header
    # People write the units once, with the names of the first table.
    own = {name: label for name, label in zip(bare[first:], tables[0], strict=False) if name}
    width = len(tables[0])
    says_no_unit = [label == name for label, name in zip(names, bare, strict=True)]
    if len({*bare[first : first + width]}) == width and all(says_no_unit[first + width :]):
        names = [*names[:first], *(own.get(name, "") for name in bare[first:])]
    labels: list[str] = []
    for heading, name in zip(headings, names, strict=True):
        labels.append(f"{heading}{HEADED}{name}" if heading and name else name)
    return Header(labels, header.units, header.lines + 1)


def _as_levels(headings: Sequence[str], over_shared: Sequence[str]) -> list[str] | None:
    """Headings as levels with what stands over shared columns before them, unit or name; None where some are none."""
    if not all(any(map(str.isdigit, heading)) for heading in headings):
        return None
    said = next((cell for cell in over_shared if cell), "")
    if not said or not all(_NUMBER_ALONE.fullmatch(heading) for heading in headings):
        return [*headings]
    name, unit = split_label(said)
    return [f"{heading} {unit}" if unit else f"{name} {heading}" for heading in headings]


def with_lines_above(header: Header, above: Sequence[str], marks: Marks) -> Header:
    """The header with what lines above its names call their channels, or the groups that they are of."""
    before = above[: len(above) - header.lines]
    if not header.lines or not before:
        return header
    if header.units is None:
        header = replace(header, units=channel_units(header.labels, before, marks))
    labels = with_channel_labels(header.labels, before, marks)
    if labels == header.labels:
        labels = with_groups(labels, marks.cells(before[-1]))
    return replace(header, labels=labels)


def with_legend(
    names: Sequence[str],
    own_units: Sequence[str | None],
    said: Mapping[str, str],
) -> tuple[list[str], list[str | None], list[str]]:
    """Names and units with what lines above say of the columns: ``Ch1: displacement [mm]``, or ``F: N``; and a note.

    One such line may be a setting of the test that is called like a column.

    Args:
        names: of the columns.
        own_units: of the columns, by the header.
        said: ``Key: value`` lines above the header.
    """
    told: dict[str, tuple[str, str]] = {}  # what a column is, and its unit
    for name in names:
        text = said.get(name, "")
        if re.match(r"[\s+.-]*\d", text):
            continue  # a setting: Speed: 100 rpm
        meaning, unit = split_label(text)
        if unit is None and meaning and units.is_unit(meaning):
            meaning, unit = "", meaning
        if unit:
            told[name] = meaning, unit
    if len(told) < _FEWEST_TOLD:
        return [*names], [*own_units], []
    new_names: list[str] = []
    new_units: list[str | None] = []
    for name, own in zip(names, own_units, strict=True):
        meaning, unit = told.get(name, ("", None))
        is_repeated = meaning.lower() == name.lower()
        new_names.append(f"{name} {meaning}" if meaning and not is_repeated else name)
        new_units.append(own or unit)
    return new_names, new_units, [f"lines above the table say what columns {', '.join(told)} are"]


def _labels_of_pairs(upper: Sequence[str], names: Sequence[str]) -> list[str]:
    """Labels that stand over pairs of columns called x and y, as tools that read curves off a picture write them.

    Drives record their channels so too: x is the time there, and the label that of y.

    Returns: for each pair a label and none, or a time and the label; nothing where the lines are others.
    """
    pairs, odd = divmod(len(names), 2)
    if not pairs or odd or [name.lower() for name in names] != ["x", "y"] * pairs:
        return []
    labels = [*upper, *[""] * (len(names) - len(upper))]
    over_x = labels[::2]
    over_y = labels[1::2]
    if not all(over_x) or any(over_y):
        return []
    said = [spoken_name(split_label(label)[0]).may_be for label in over_x]
    has_a_motion = any(not may_be.isdisjoint(("slip", "position")) for may_be in said)
    has_an_effort = any("effort" in may_be for may_be in said)
    if has_a_motion and has_an_effort:
        return [cell for label in over_x for cell in ("time", label)]
    return labels


def _filled(cells: Sequence[str]) -> int:
    return sum(map(bool, cells))


def _with_whole_brackets(cells: Sequence[str], delimiter: str | None) -> list[str]:
    """Cells of a line, where a bracket that a delimiter parts is one again: ``Torque (filtered``, ``mNm)``."""
    whole: list[str] = []
    for cell in cells:
        last = whole[-1] if whole else ""
        is_open = any(last.count(left) > last.count(right) for left, right in ("()", "[]"))
        if is_open and delimiter is not None and re.match(r"[^(\[]*[)\]]", cell):
            whole[-1] = f"{last}{delimiter} {cell}"
        else:
            whole.append(cell)
    return whole


def _labels(
    line: str,
    marks: Marks,
    rows: RowsBelow,
    *,
    is_numbered: bool = False,
    may_be_serial: bool = False,
) -> list[str] | None:
    """Cells of a header line, or None if their number or kind is not that of a header.

    Args:
        line: as it stands in the file.
        marks: delimiter and decimal mark.
        rows: below.
        is_numbered: whether a whole number may stand in place of the first name, which is left out.
        may_be_serial: whether some of the names, half of them at most, may be whole numbers.
    """
    was_comment = is_comment(line)
    if was_comment:
        line = line.lstrip("#%/ \t")
    splits: list[list[str]] = []
    if was_comment and marks.delimiter is None:  # names between commas above numbers between blanks
        for mark in ",;|\t":
            splits.append([cell.strip() for cell in line.split(mark)])
    cells_of_line = marks.cells(line)
    whole = _with_whole_brackets(cells_of_line, marks.delimiter)
    if len(whole) < len(cells_of_line) and len(whole) in (rows.width, rows.width - rows.trailing):
        splits.append(whole)
    splits.append(cells_of_line)
    if marks.delimiter is None:
        # Names may hold blanks: brackets stay with their name, or wide gaps part the names.
        splits.append(re.findall(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?", line))
        splits.append(re.split(r"\t|\s{2,}", line.strip()))

    width = rows.width
    fitting = {width}
    if rows.trailing:
        fitting.add(width - 1)
    if marks.delimiter is not None:
        # A name more than the cells is that of a column with cells in its first rows only (events).
        fitting.add(width + 1)
    for cells in splits:
        if marks.delimiter is not None and len(cells) > width + 1 > 2:
            *own, gap = cells[: width + 1]
            if all(own) and not gap:  # remarks stand in the same line, behind a gap
                cells = own
        lacks_one = len(cells) == width - 1 > 1 and not rows.trailing
        if lacks_one and marks.delimiter is not None and rows.are_named:
            # R names no column of row names. A line that begins with an empty cell lacks its last cell.
            cells = ["", *cells] if cells[0] else [*cells, ""]
        if is_numbered and cells[0].isdecimal():
            cells = ["", *cells[1:]]
        words = [cell for cell in cells if not (may_be_serial and cell.isdecimal())]
        are_enough = any(cells) and 2 * len(words) >= len(cells)
        if len(cells) in fitting and are_enough and not any(map(marks.is_number, words)):
            return cells
    return None
