"""The first lines of a text log decide its delimiter, decimal mark, header, units and first row of data."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import chain, pairwise

from erclutch.errors import LogError
from erclutch.logs.columns.labels import name_columns
from erclutch.logs.readers.cells import WORDS, Marks, cells_of, is_comment, is_full, is_number
from erclutch.logs.readers.header_lines import (
    Header,
    RowsBelow,
    header_of,
    with_headings,
    with_legend,
    with_lines_above,
)
from erclutch.logs.readers.header_pairs import header_pairs
from erclutch.logs.readers.names_and_cells import (
    FIRST_NAMES,
    keep_empty_cells,
    width_of_names,
    without_a_header,
)
from erclutch.logs.readers.numerals import is_grouped
from erclutch.logs.readers.stated_units import units_of_a_comment, units_of_a_list

#: Three digits behind a blank that are no number of their own.
_GROUP_OF_THREE = re.compile(r"\d(?: 0\d\d|[\u00a0\u202f]\d{3})(?!\d)")
#: Characters looked at: they hold any header block seen so far, and cost a few milliseconds.
SAMPLE = 1 << 18
# Lines at the end of the sample, where data is purest; few, for short tables under long prose.
_TAILS = (60, 10, 1)
_FILLED = 0.2  # share of the rows
_SETTINGS = 30  # lines of settings of a test, at most, above the names
#: A line that a program draws below the names, in one run.
_RULE = re.compile(r"([-=_*~+.–—])\1{2,}")
_LONGEST_COUNT = 16  # digits of a row's number
_BEGINS_A_NUMBER = re.compile(r"(?:^|[\s,;|\"])[-+.]{0,2}\d")
LINE_END = re.compile(r"\r\n|\n|\r")


def lines_of(text: str) -> list[str]:
    """The lines of a text, whatever ends them.

    Some twenty looks at a text begin so, and a split by `LINE_END` takes ten times as long.
    """
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.split("\n")


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
        usual: cells of most rows, where the header names more columns, which few rows fill; 0 elsewhere.
        unsure_names: see `Table`.
        cells_below: cells of the sample's rows, where the names above them are one more; 0 elsewhere.
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
    usual: int = 0
    unsure_names: str = ""
    cells_below: int = 0

    def is_row(self, line: str) -> bool:
        """Whether a line has numbers where the rows have numbers."""
        marks = Marks(self.delimiter, self.decimal)
        return _is_data(marks.cells(line), marks, self.numeric)


def sniff(text: str, asked: str | None = None) -> Dialect:
    """Find the dialect of a text log from its first 256 K characters.

    Args:
        text: of the log.
        asked: its decimal mark, where that is known.

    Raises:
        LogError: no line reads as a row of numbers under any dialect.
    """
    sample = text[:SAMPLE]
    goes_on = len(text) > SAMPLE
    try:
        dialect = _sniffed(sample, goes_on, asked)
    except LogError:
        # The last rows may read as whole numbers in thousands, 700,000; the others, 0,123, then tell the decimal comma.
        with_comma: Dialect | None = None
        if asked is None and "," in sample:
            with suppress(LogError):  # the error of the text as it is says more
                with_comma = _sniffed(sample, goes_on, ",")
        if with_comma is None:
            raise
        dialect = with_comma
    return replace(dialect, metadata={**dialect.metadata})


# A text is sniffed by each who wants to know its columns: tables beside each other, one table, its marks weighed.
@lru_cache(maxsize=4)
def _sniffed(sample: str, goes_on: bool, asked: str | None) -> Dialect:
    """The dialect of a text by its sample, and by whether the text goes on below it."""
    lines = lines_of(sample)
    if goes_on and len(lines) > 1:
        lines.pop()  # the sample ends inside of it
    # A spreadsheet fills one word down below the last row.
    last = len(lines)
    for place in reversed(range(len(lines))):
        if _BEGINS_A_NUMBER.search(lines[place]):
            last = place
            break
    places = [place for place, line in enumerate(lines[: last + 1]) if is_full(line)]
    full = [lines[place] for place in places]

    for size in _TAILS:
        tail = full[-size:]
        marks = _marks(tail, asked, full)
        rows = [marks.cells(line) for line in tail]
        # A spreadsheet fills all lines up to the longest, which may stand above the table.
        width = max((len(row) for row in rows), default=0)
        while width > 1:
            filled = sum(len(row) >= width and row[width - 1] != "" for row in rows)
            if filled >= _FILLED * len(rows):
                break
            width -= 1
        numeric = _numeric_columns(rows, marks)[:width]

        names_stand_above = False
        for first, line in enumerate(lines):
            if not is_full(line):
                continue
            cells = marks.cells(line)
            if not _is_data(cells, marks, numeric):
                names_stand_above |= _are_names(cells, marks, numeric)
                continue
            if _is_above_names(lines[first:], marks, numeric, is_first=not names_stand_above):
                continue
            below = full[bisect_left(places, first) :]
            ending_rows = [marks.cells(row) for row in below[-size:]]
            data = [row for row in ending_rows if _is_data(row, marks, numeric)]
            return _with_header(lines, first, marks, data, below)

    count = len(lines)
    if not lines[-1]:
        count -= 1  # a line end closes the last line and begins no other
    problem = f"no row of numbers in {count} line{'' if count == 1 else 's'}"
    if full:
        problem += f" (it begins with {full[0].strip()[:60]!r})"
    raise LogError(
        problem, remedy="Give a table of numbers with one row a sample, or check the file's format"
    )


def _marks(tail: Sequence[str], asked: str | None, full: Sequence[str]) -> Marks:
    """The delimiter and decimal mark under which most cells are numbers, then the most numbers a row."""
    best = (0.0, 0.0)
    best_marks = Marks(",", asked or ".")
    decimals = (asked,) if asked else (".", ",")
    # Delimiters that no line has leave the same cells: the first of them stands for all.
    delimiters = ("\t", ";", "|", ",")
    absent = [mark for mark in delimiters if not any(mark in line for line in tail)]
    for delimiter in (*delimiters, None):
        if delimiter in absent[1:]:
            continue
        cells: list[str] = []
        for line in tail:
            cells += cells_of(line, delimiter)
        filled = sum(1 for cell in cells if cell)
        for decimal in decimals:
            numbers = sum(1 for cell in cells if is_number(cell, decimal))
            share = round(numbers / max(filled, 1), 2)
            numbers_a_row = numbers / max(len(tail), 1)
            if (share, numbers_a_row) > best:
                best = (share, numbers_a_row)
                best_marks = Marks(delimiter, decimal)
    # Of a short table the first lines name columns, perhaps with blanks in the names.
    rows = tail[len(tail) // 2 :]
    if best_marks.delimiter is None and _are_cut_at_tabs(rows, best_marks, full):
        return Marks("\t", best_marks.decimal)
    return best_marks


def _are_cut_at_tabs(rows: Sequence[str], blanks: Marks, full: Sequence[str]) -> bool:
    """Whether rows that blanks cut into more numbers are cut at tabs: a blank is in words only, as in "step 2"."""
    cells = [cells_of(row, "\t") for row in rows]
    if all(row == line.split() for row, line in zip(cells, rows, strict=True)):
        return True
    widths = {len(row) for row in cells}
    if len(widths) != 1 or widths == {1}:
        return False
    # Blanks between thousands leave rows of unequal widths (1 008,5 below 804,2), or numbers that begin with a 0.
    alike = [line for line in full if "\t" in line and _BEGINS_A_NUMBER.match(line)]
    at_blanks = {len(row.split()) for row in alike}
    has_groups = len(at_blanks) > 1 or any(map(_GROUP_OF_THREE.search, alike))
    for cell in chain(*cells):
        first, *others = cell.split() or [""]
        is_one_number = has_groups and is_grouped(cell, blanks.decimal)
        if others and blanks.is_number(first) and not is_one_number:
            return False
    return True


def _numeric_columns(rows: Sequence[Sequence[str]], marks: Marks) -> list[bool]:
    """Which columns are numbers in most rows of the sample."""
    width = max((len(row) for row in rows), default=0)
    numeric: list[bool] = []
    for column in range(width):
        cells = [row[column] for row in rows if len(row) > column]
        others = [cell for cell in cells if not marks.is_number(cell)]
        texts = sum(cell.lower() not in WORDS for cell in others)
        numbers = len(cells) - len(others)
        numeric.append(2 * numbers > numbers + texts)
    return numeric


def _is_data(row: Sequence[str], marks: Marks, numeric: Sequence[bool]) -> bool:
    """Whether most number columns hold a number (or nan) here and at least one a number, or all say nan."""
    cells = [cell for cell, is_numeric in zip(row, numeric, strict=False) if is_numeric]
    numbers = sum(marks.is_number(cell) for cell in cells)
    if numbers and 2 * numbers > sum(numeric):
        return True  # most rows: no words need be looked up
    if {cell.lower() for cell in row if cell} == {"nan"}:
        return True  # a logger's first row, before its first sample; no names
    words = sum(cell.lower() in WORDS for cell in cells)
    return numbers > 0 and 2 * (numbers + words) > sum(numeric)


def _is_above_names(
    lines: Sequence[str], marks: Marks, numeric: Sequence[bool], *, is_first: bool
) -> bool:
    """Whether a line is no row, since names follow: a setting of the test, or a number that labels columns.

    A setting has a word in a column of numbers, and so may the lines between it and the names. A line of numbers alone
    labels columns where it has gaps, and no names stand above it.

    Args:
        lines: the line and those below it.
        marks: delimiter and decimal mark.
        numeric: which columns hold numbers.
        is_first: whether no names stand above the line.
    """
    filled = [line for line in lines[:_SETTINGS] if line.strip()]
    for place, line in enumerate(filled):
        cells = marks.cells(line)
        if place and _are_names(cells, marks, numeric):
            return True
        number_cells = [
            cell for cell, is_numeric in zip(cells, numeric, strict=False) if is_numeric
        ]
        if not all(marks.is_filled_in(cell) for cell in number_cells):
            continue
        labels_columns = place == 0 and is_first and "" in number_cells
        if not labels_columns or len(filled) < 2:
            return False
        next_cells = marks.cells(filled[1])
        return _are_names(next_cells, marks, numeric)
    return False


def _are_names(cells: Sequence[str], marks: Marks, numeric: Sequence[bool]) -> bool:
    """Whether more than half of the columns have a cell, and no cell is a number."""
    names = [cell for cell in cells if cell]
    return 2 * len(names) > len(numeric) and not any(marks.is_number(cell) for cell in names)


def _with_header(
    lines: Sequence[str],
    first: int,
    marks: Marks,
    data: Sequence[Sequence[str]],
    below: Sequence[str],
) -> Dialect:
    """Complete the dialect with names, units and header block from the lines above the first row.

    Args:
        lines: of the sample.
        first: index of the first row.
        marks: delimiter and decimal mark.
        data: cells of rows at the end of the sample.
        below: all rows of the sample.
    """
    first_row = marks.cells(lines[first])
    usual_width = Counter(map(len, data)).most_common(1)[0][0]
    width = max(len(first_row), usual_width)
    usual = 0
    named = width_of_names(lines[:first], marks)
    if named > width + 1 and any(len(marks.cells(line)) == named for line in below):
        # Columns at the end are filled in few rows, and the other rows are short.
        usual = width
        width = named
    trailing = False
    if marks.delimiter is not None and width > 1:
        trailing = all(len(row) < width or not row[-1] for row in (first_row, *data))

    # R names its rows by words or by whole numbers that rise.
    first_cells = [row[0] for row in data if row]
    are_words = not any(marks.is_number(cell) for cell in first_cells)
    are_counts = all(cell.isdecimal() and len(cell) < _LONGEST_COUNT for cell in first_cells)
    rise = are_counts and all(
        int(cell) < int(next_cell) for cell, next_cell in pairwise(first_cells)
    )
    rows = RowsBelow(width, trailing, are_named=are_words or rise)

    # An empty comment is no line, and neither is a page break of a printer, nor an empty row of a spreadsheet.
    nothing = f'#%/ \t\f\v"{marks.delimiter or ""}'
    places = [
        index
        for index in range(first)
        if lines[index].strip(nothing) and not _RULE.fullmatch(lines[index].strip("#%/ \t"))
    ]
    above = [lines[index] for index in places]
    above = _with_remarks_first(above, marks, rows)
    header, notes = _header_above(above, marks, rows, below)
    if header is None:
        if above:
            _refuse_bad_first_row(above[-1], places[-1], marks, width)
        header, said = without_a_header(above, marks, rows)
        notes.append(said)
    headed = with_headings(header, above, marks)
    header = with_lines_above(header, above, marks) if headed is header else headed
    names, own_units, renamed = name_columns(header.labels, header.units)

    # What stands above the names: keys with values, and prose.
    before_header = above[: len(above) - header.lines]
    bare = [line.lstrip("#%/ ") for line in before_header]
    metadata = {**header_pairs(bare), **header_pairs(header.pairs)}
    if not any(own_units):
        metadata |= units_of_a_comment(bare, names) or units_of_a_list(bare)
    names, own_units, by_legend = with_legend(names, own_units, metadata)
    prose = [line for line in before_header if not is_comment(line) and not header_pairs([line])]
    if prose:
        first_words = " ".join(prose[0].split())[:60]
        more = f" and {len(prose) - 1} more" if len(prose) > 1 else ""
        notes.append(f"text above the table skipped: {first_words!r}{more}")

    # Names for fewer cells than there are names may have lost their cells anywhere.
    unsure_names = notes[-1] if notes and notes[-1].endswith(FIRST_NAMES) else ""

    # A name may stand over an empty column.
    numeric = [*_numeric_columns(data, marks), *[False] * len(names)]
    return Dialect(
        delimiter=marks.delimiter,
        decimal=marks.decimal,
        names=tuple(names),
        units=tuple(own_units),
        first=first,
        trailing=rows.trailing and len(names) == width - 1,
        numeric=tuple(numeric[: len(names)]),
        metadata=metadata,
        notes=(*notes, *renamed, *by_legend),
        usual=usual,
        unsure_names=unsure_names,
        cells_below=width if len(names) == width + 1 else 0,
    )


def _with_remarks_first(above: Sequence[str], marks: Marks, rows: RowsBelow) -> Sequence[str]:
    """The lines above the first row, where remarks stand between the names and the row with the remarks first."""
    if not above or header_of(above, marks, rows) is not None:
        return above
    for below in range(1, len(above)):  # remarks, as far as they reach up
        names = above[:-below]
        remarks = above[-below:]
        if not is_comment(remarks[0]):
            break
        if header_of(names, marks, rows) is not None:
            return [*remarks, *names]
    return above


def _header_above(
    above: Sequence[str], marks: Marks, rows: RowsBelow, below: Sequence[str]
) -> tuple[Header | None, list[str]]:
    """The names above the rows, one for each of their cells, and what to say of names left out; None without names."""
    cells = rows.width - rows.trailing
    header = header_of(above, marks, rows)
    if header is not None:
        count = len(header.labels)
        is_one_too_many = count > 1 and not header.labels[-1]
        if is_one_too_many and (rows.trailing or count > rows.width):
            units = header.units and header.units[:-1]
            header = replace(header, labels=header.labels[:-1], units=units)
        return header, []
    if not above or not keep_empty_cells(below, marks, rows.width):
        return None, []
    # The line above may have more names than the rows have cells.
    labels = marks.cells(above[-1])[:cells]
    more = width_of_names(above, marks) - cells
    if more <= 0 or not all(labels):
        return None, []
    note = f"the last {more} names above the rows stand over no cells: left out"
    return Header(labels, None, 1), [note]


def _refuse_bad_first_row(line: str, index: int, marks: Marks, width: int) -> None:
    """Right above the data, a line of half as many names or of numbers and text is a fault, not a comment."""
    if is_comment(line):
        return
    cells = marks.cells(line)
    counts = f"line {index + 1} names {len(cells)} columns but the rows have {width} cells"
    if marks.delimiter == "," and 2 * len(cells) == width and all(cells):
        remedy = "Export it with a decimal point, or with a semicolon between the columns"
        raise LogError(f"{counts} (commas in the numbers?)", remedy=remedy)
    are_words = all(cells) and not any(marks.is_number(cell) for cell in cells)
    if marks.delimiter is not None and are_words and len(cells) == width - 1 > 2:
        raise LogError(counts, remedy="Name each column in that line")

    bad = [place for place, cell in enumerate(cells) if cell and not marks.is_number(cell)]
    if len(cells) == width > 1 and 0 < len(bad) < len(cells):
        place = bad[0]
        problem = (
            f"line {index + 1}, column {place + 1} is '{cells[place]}' where a number is expected"
        )
        raise LogError(
            problem,
            remedy="Correct or delete that line, or put a complete header row above the data",
        )
