"""The first lines of a text log decide its delimiter, decimal mark, header, units and first row of data."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from erclutch.errors import LogError
from erclutch.logs.labels import EASTERN, header_pairs, name_columns, split_label
from erclutch.logs.readers.numerals import is_grouped
from erclutch.signals import units

SAMPLE = 1 << 18  # characters looked at: holds any header block seen so far, costs a few milliseconds
# Lines at the end of the sample, where data is purest; few, for short tables under long prose.
_TAILS = (60, 10, 1)
_COMMENT = ("#", "%", "//")
_SIGNED = {sign + word for sign in ("", "-", "+") for word in ("nan", "inf")}
#: What a C library of Windows writes for no number, cut to the digits that a format has.
_MARKED = ("QNAN", "QNB", "QO", "IND", "IO", "R", "INF", "J", "F")
NO_NUMBERS = tuple(f"{sign}1.#{mark}" for sign in ("", "-") for mark in _MARKED)
_LOWER = {word.lower() for word in NO_NUMBERS}
WORDS = {*_SIGNED, *_LOWER, "", "na", "n/a", "null", "infinity", "-infinity"}
_CLEAR_UNITS = {"s", "ms", "us", "µs", "min", "Nm", "kN", "rpm", "mm", "kV", "deg", "rad"}  # t, V, F may be names
_NO_FACTOR = re.compile(r"(?:°|deg) ?[CF]|[℃℉]|dB\w*|bits?|counts?", re.I)  # units, but no plain factor to the SI
_NUMBER = {
    ".": re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eEdD][+-]?\d+)?"),
    ",": re.compile(r"[+-]?(?:\d+(?:,\d+)?|,\d+)(?:[eEdD][+-]?\d+)?"),
}
_LONGEST_COUNT = 16  # digits of a row's number
LINE_END = re.compile(r"\r\n|\n|\r")


@dataclass(frozen=True)
class Dialect:
    """How to read the rows of a text log.

    Attributes:
        delimiter: one character, or None for runs of white space.
        decimal: "." or ",".
        thousands: the other mark where it groups digits, else "".
        names: column names, one a cell of a full row.
        units: units in the order of the names.
        first: index of the first data line, counted from 0.
        trailing: whether each row ends in a delimiter with nothing behind it.
        numeric: which columns hold numbers in the sample.
        metadata: the ``Key: value`` lines above the header.
        notes: sentences on names and headers.
    """

    delimiter: str | None
    decimal: str
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    first: int
    trailing: bool
    numeric: tuple[bool, ...]
    metadata: dict[str, str] = field(default_factory=dict[str, str])
    notes: tuple[str, ...] = ()
    thousands: str = ""


def is_comment(line: str) -> bool:
    """Whether the line starts with ``#``, ``%`` or ``//``."""
    return line.lstrip().startswith(_COMMENT)


def cells_of(line: str, delimiter: str | None) -> list[str]:
    """Cells of one line, stripped; quotes are honoured."""
    if '"' in line:
        plain = line.strip().replace("\t", " ") if delimiter is None else line
        try:
            rows = list(csv.reader([plain], delimiter=delimiter or " ", skipinitialspace=True))
            return [cell.strip() for cell in rows[0]] if rows else []
        except csv.Error:
            pass  # an unfinished quote: the plain split below shows the row as it is
    return line.split() if delimiter is None else [cell.strip() for cell in line.split(delimiter)]


def is_number(cell: str, decimal: str) -> bool:
    """Whether the cell is a finite decimal number with that decimal mark, perhaps in groups of three digits."""
    return _NUMBER[decimal].fullmatch(cell) is not None or is_grouped(cell, decimal)


def sniff(text: str, asked: str | None = None) -> Dialect:
    """Find the dialect of a text log from its first 256 K characters.

    Args:
        text: of the log.
        asked: its decimal mark, where that is known.

    Raises:
        LogError: no line reads as a row of numbers under any dialect.
    """
    lines = LINE_END.split(text[:SAMPLE])
    if len(text) > SAMPLE and len(lines) > 1:
        lines.pop()
    full = [line for line in lines if line.strip() and not is_comment(line)]
    for size in _TAILS:
        delimiter, decimal = _separators(full[-size:], asked)
        rows = [cells_of(line, delimiter) for line in full[-size:]]
        kinds = _kinds(rows, decimal)
        for first, line in enumerate(lines):
            if line.strip() and not is_comment(line) and _is_data(cells_of(line, delimiter), decimal, kinds):
                if _is_above_names(lines[first:], delimiter, decimal, kinds):
                    continue
                rows = [row for row in rows if _is_data(row, decimal, kinds)]
                return _with_header(lines, first, delimiter, decimal, rows)
    shown = f" (it begins with {full[0].strip()[:60]!r})" if full else ""
    remedy = "Give a table of numbers with one row a sample, or check the file's format"
    many = len(lines) - (not lines[-1])  # a line end closes the last line and begins no other
    raise LogError(f"no row of numbers in {many} line{'' if many == 1 else 's'}{shown}", remedy=remedy)


def _is_above_names(lines: Sequence[str], delimiter: str | None, decimal: str, kinds: Sequence[bool]) -> bool:
    """Whether a line with a word in a column of numbers stands right above names: settings of the test, and no row."""
    cells = cells_of(lines[0], delimiter)
    number_cells = [cell for cell, kind in zip(cells, kinds, strict=False) if kind]
    if all(is_number(cell, decimal) or cell.lower() in WORDS for cell in number_cells):
        return False
    below = cells_of(next((line for line in lines[1:] if line.strip()), ""), delimiter)
    named = [cell for cell in below if cell]
    return 2 * len(named) > len(kinds) and not any(is_number(cell, decimal) for cell in named)


def _separators(tail: Sequence[str], asked: str | None = None) -> tuple[str | None, str]:
    """The delimiter and decimal mark under which most cells are numbers, then the most numbers a row."""
    best, found = (0.0, 0.0), (",", asked or ".")
    for delimiter in ("\t", ";", "|", ",", None):
        rows = [cells_of(line, delimiter) for line in tail]
        filled = sum(1 for row in rows for cell in row if cell)
        for decimal in (asked,) if asked else (".", ","):
            count = sum(1 for row in rows for cell in row if is_number(cell, decimal))
            score = (round(count / max(filled, 1), 2), count / max(len(rows), 1))
            if score > best:
                best, found = score, (delimiter, decimal)
    return found


def _kinds(rows: Sequence[Sequence[str]], decimal: str) -> list[bool]:
    """Which columns are numbers in most rows of the sample."""
    width = max((len(row) for row in rows), default=0)
    kinds: list[bool] = []
    for column in range(width):
        filled = [row[column] for row in rows if len(row) > column and row[column].lower() not in WORDS]
        kinds.append(2 * sum(is_number(cell, decimal) for cell in filled) > len(filled))
    return kinds


def _is_data(row: Sequence[str], decimal: str, kinds: Sequence[bool]) -> bool:
    """Whether more than half of the number columns hold a number (or nan) here and at least one does."""
    cells = [cell for cell, kind in zip(row, kinds, strict=False) if kind]
    numbers = sum(is_number(cell, decimal) for cell in cells)
    words = sum(cell.lower() in WORDS for cell in cells)
    return numbers > 0 and 2 * (numbers + words) > sum(kinds)


def _with_header(
    lines: Sequence[str], first: int, delimiter: str | None, decimal: str, rows: Sequence[Sequence[str]]
) -> Dialect:
    """Complete the dialect with names, units and header block from the lines above the first row."""
    begin = cells_of(lines[first], delimiter)
    width = max(len(begin), Counter(map(len, rows)).most_common(1)[0][0])
    trailing = delimiter is not None and width > 1 and all(len(row) < width or not row[-1] for row in (begin, *rows))
    above = [index for index in range(first) if lines[index].strip()]
    named = _name_rows(rows, decimal)
    header, used = _header(lines, above, delimiter, decimal, width, trailing, named) if above else (None, 0)
    notes: list[str] = []
    labels, own = header or ([""] * (width - trailing), None)
    if header is None:
        if above:
            _refuse_bad_first_row(lines[above[-1]], above[-1], delimiter, decimal, width)
        notes.append(f"no header row: the columns are called c1 .. c{len(labels)}")
    elif len(labels) > 1 and not labels[-1] and (trailing or len(labels) > width):
        labels, own = labels[:-1], own and own[:-1]
    trailing = trailing and len(labels) == width - 1
    names, found, renamed = name_columns(labels, own)
    numeric = _kinds(rows, decimal) + [False] * len(names)
    skipped = [lines[index] for index in above[: len(above) - used]]
    metadata = header_pairs(line.lstrip("#%/ ") for line in skipped)
    prose = [line for line in skipped if not is_comment(line) and not header_pairs([line])]
    if prose:
        more = f" and {len(prose) - 1} more" if len(prose) > 1 else ""
        notes.append(f"text above the table skipped: {' '.join(prose[0].split())[:60]!r}{more}")
    notes += renamed
    kinds = tuple(numeric[: len(names)])
    return Dialect(delimiter, decimal, tuple(names), tuple(found), first, trailing, kinds, metadata, tuple(notes))


def _name_rows(rows: Sequence[Sequence[str]], decimal: str) -> bool:
    """Whether the first cells name their rows, as R writes them: words, or whole numbers that rise."""
    first = [row[0] for row in rows if row]
    if not any(is_number(cell, decimal) for cell in first):
        return True
    return all(cell.isdecimal() and len(cell) < _LONGEST_COUNT for cell in first) and all(
        int(a) < int(b) for a, b in pairwise(first)
    )


def _header(
    lines: Sequence[str],
    above: Sequence[int],
    delimiter: str | None,
    decimal: str,
    width: int,
    trailing: bool,
    rows_are_named: bool,
) -> tuple[tuple[list[str], list[str | None] | None] | None, int]:
    """Labels and units of the one or two header lines right above the data, and how many lines they take."""
    last = _labels(lines[above[-1]], delimiter, decimal, width, trailing, rows_are_named)
    if last is None:
        return None, 0
    # A row of samples over every second column, below names and units: the names are those above.
    if len(above) > 2 and 2 * sum(map(bool, last)) <= len(last) > 1:
        names, below = (_labels(lines[at], delimiter, decimal, width, trailing, rows_are_named) for at in above[-3:-1])
        inner = [cell.strip("[]() ") for cell in below or []]
        if names and below and sum(map(bool, names)) > sum(map(bool, last)) and _are_units(inner):
            return (names, [unit or None for unit in inner]), 3
    inner = [cell.strip("[]() ") for cell in last]
    if len(above) > 1 and _are_units(inner):
        names = _labels(lines[above[-2]], delimiter, decimal, width, trailing, rows_are_named)
        # Names are words: a second line of units, or of what is called like a unit, names nothing.
        if names is not None and len(names) == len(last) and not _are_units([name.strip("[]() ") for name in names]):
            return (names, [unit or None for unit in inner]), 2
    if len(above) > 1 and _are_translated(last):
        names = _labels(lines[above[-2]], delimiter, decimal, width, trailing, rows_are_named)
        if names is not None and len(names) == len(last) and all(names):
            return (names, [split_label(cell)[1] for cell in last]), 2
    return (last, None), 1


def _are_translated(cells: Sequence[str]) -> bool:
    """Whether a line under the names says them again in Chinese or Japanese, half of them or more with a unit."""
    eastern = [cell for cell in cells if EASTERN.search(cell)]
    return len(eastern) == len(cells) and 2 * sum(split_label(cell)[1] is not None for cell in eastern) >= len(cells)


def _are_units(cells: Sequence[str]) -> bool:
    """Whether the cells of a line are units: a clear one among them, and at most one in four that is none we know."""
    filled = [cell for cell in cells if cell]
    # Names alone are common, and whether a name is a unit takes long to say: no clear unit, no such question.
    if not any(_is_known(cell) for cell in filled if cell in _CLEAR_UNITS or re.search(r"[/^°%*.]", cell)):
        return False
    return sum(not _is_known(cell) for cell in filled) <= len(filled) / 4


def _is_known(cell: str) -> bool:
    return bool(_NO_FACTOR.fullmatch(cell)) or units.is_unit(cell)


def _labels(
    line: str, delimiter: str | None, decimal: str, width: int, trailing: bool, rows_are_named: bool
) -> list[str] | None:
    """Cells of a header line, or None if their number or kind is not that of a header."""
    if is_comment(line):
        line = line.lstrip("#%/ \t")
    splits = [cells_of(line, delimiter)]
    if delimiter is None:  # names with blanks in them: keep brackets with their name, or split at wide gaps
        splits.append(re.findall(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?", line))
        splits.append(re.split(r"\t|\s{2,}", line.strip()))
    for cells in splits:
        # One name more than cells is a column filled in its first rows only (events); one fewer, a trailing delimiter.
        fitting = {width, width - 1 if trailing else width, width + 1 if delimiter is not None else width}
        if len(cells) == width - 1 and not trailing and delimiter is not None and width > 2 and rows_are_named:
            # R names no column of row names. A line that begins with an empty cell lacks its last cell.
            cells, fitting = ["", *cells] if cells[0] else [*cells, ""], {width}
        if len(cells) in fitting and any(cells) and not any(is_number(cell, decimal) for cell in cells):
            return cells
    return None


def _refuse_bad_first_row(line: str, index: int, delimiter: str | None, decimal: str, width: int) -> None:
    """Right above the data, a line of half as many names or of numbers and text is a fault, not a comment."""
    cells = cells_of(line, delimiter)
    if is_comment(line):
        return
    if delimiter == "," and 2 * len(cells) == width and all(cells):
        raise LogError(
            f"line {index + 1} names {len(cells)} columns but the rows have {width} cells (commas in the numbers?)",
            remedy="Export it with a decimal point, or with a semicolon between the columns",
        )
    words = all(cells) and not any(is_number(cell, decimal) for cell in cells)
    if delimiter is not None and words and len(cells) == width - 1 > 2:
        raise LogError(
            f"line {index + 1} names {len(cells)} columns but the rows have {width} cells",
            remedy="Name each column in that line",
        )
    bad = [(number, cell) for number, cell in enumerate(cells, start=1) if cell and not is_number(cell, decimal)]
    if len(cells) == width > 1 and 0 < len(bad) < len(cells):
        raise LogError(
            f"line {index + 1}, column {bad[0][0]} is '{bad[0][1]}' where a number is expected",
            remedy="Correct or delete that line, or put a complete header row above the data",
        )
