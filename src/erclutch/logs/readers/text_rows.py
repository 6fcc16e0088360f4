"""The rows of a text are cut out of it: comments among them, remarks and sums below them go, with a word on each."""

from __future__ import annotations

import re
from itertools import takewhile
from operator import le, lt
from typing import NamedTuple

from erclutch.logs.readers.cells import WORDS, cells_of, is_comment, is_number, sums_up
from erclutch.logs.readers.dialect import LINE_END, Dialect, lines_of
from erclutch.logs.readers.numerals import ungrouped
from erclutch.logs.readers.text_cells import BLANK

_BLANK_LINE = re.compile(r"(?:\r\n|\n|\r)[ \t,;]*(?=\r|\n)")
_BELOW = 1 << 14  # characters at the end of a text in which a summary of the rows is looked for
_ABOVE = 1 << 14  # characters at the start of a text in which such a summary is looked for
_NEAR = 1 << 12  # characters above the last row that show how its numbers are written
_FEWEST_BELOW = 12  # rows
_FEWEST_SUMMED = 3  # columns
_ROUNDED = 1e-3  # of a number that sums up
_MOST_SUMS = 6  # lines below the rows
_LEAST_BLOCK = 10  # rows between blank lines that are a stretch of a log
_MOST_BLOCKS = 100


class CutRows(NamedTuple):
    """The rows of a text.

    Attributes:
        body: the text from the first row on, without comment lines and last lines that are no rows.
        notes: on what was left out.
        below: last lines without a number, which may tell units.
    """

    body: str
    notes: list[str]
    below: list[str]


def rows_of_body(text: str, dialect: Dialect) -> CutRows:
    """The text from the first row on without what is no row."""
    start = 0
    for _ in range(dialect.first):
        line_end = LINE_END.search(text, start)
        start = line_end.end() if line_end else start
    body = text[start:]
    below: list[str] = []
    if any(mark in body for mark in ("#", "%", "//")):
        # Comments become blank: line numbers stay right.
        lines = lines_of(body)
        body = "\n".join("" if is_comment(line) else line for line in lines)
        comments = takewhile(lambda line: is_comment(line) or not line.strip(BLANK), lines[::-1])
        below += [line for line in comments if line.strip(BLANK)]

    body, notes = _without_sums_above(body, dialect)

    # Behind a blank line below the rows, text none of whose lines is a row is a remark.
    remark = ""
    near_the_end = max(len(body) - _BELOW, 0)
    gaps = [*_BLANK_LINE.finditer(body, near_the_end)]
    for gap in reversed(gaps):
        lines = [line for line in lines_of(body[gap.end() :]) if line.strip(BLANK)]
        if any(map(dialect.is_row, lines)):
            break
        body = body[: gap.start()]
        below += lines
        remark = lines[0] if lines else remark
    if remark:
        shown = " ".join(remark.split())[:60]
        notes.append(f"text below the table left out: {shown!r}")

    # The last lines may hold no number, or sum up the rows.
    first_row = lines_of(body[:_ABOVE].lstrip(BLANK))[0]
    # Such as a row for Max, and the next for Min.
    rows_have_such_words = any(map(sums_up, cells_of(first_row, dialect.delimiter)))
    rows_begin_with_numbers = bool(dialect.numeric) and dialect.numeric[0]
    without: list[str] = []  # last lines that hold no number, from the last on
    sums = 0  # last lines that sum up the rows
    while last := _last_line(body):
        first_cell, *others = cells_of(body[last:], dialect.delimiter) or [""]
        cells = [cell for cell in (first_cell, *others) if cell]
        is_row = any(is_number(cell, dialect.decimal) or cell.lower() in WORDS for cell in cells)
        is_sum = any(map(sums_up, cells)) and not rows_have_such_words
        if is_row and others and rows_begin_with_numbers and sums < _MOST_SUMS:
            # A word stands where the rows have a number: ``x mean`` below 1, 2, 3.
            is_sum |= first_cell[:1].isalpha() and first_cell.lower() not in WORDS
        if not cells or (is_row and not is_sum):
            break
        shown = " ".join(body[last:].split())[:60]
        if is_sum:
            sums += 1
            notes.append(f"the last line sums up the rows ({shown!r}): left out")
        else:
            without.append(shown)
            below.append(body[last:])
        body = body[:last]
    if without:
        count = len(without)
        begin = "the last line holds" if count == 1 else f"the last {count} lines hold"
        notes.append(f"{begin} no number ({without[-1]!r}): left out")

    # A logger that was stopped leaves half a row, without an end of its line.
    last = max(body.rfind("\n"), body.rfind("\r")) + 1
    rest = body[last:]
    if not last or not rest.strip(BLANK):
        return CutRows(body, notes, below)
    usual_columns = enumerate(dialect.numeric[: dialect.usual or None])
    needed = max((column for column, is_numeric in usual_columns if is_numeric), default=0)
    if len(cells_of(rest, dialect.delimiter)) <= needed:
        notes.append("the last row was cut off in the middle: left out")
    elif _ends_within_a_number(body[:last], rest, dialect):
        notes.append(
            f"the last row seems to end within a number ({rest.strip()[-20:]!r}): left out"
        )
    else:
        return CutRows(body, notes, below)
    return CutRows(body[:last], notes, below)


def _ends_within_a_number(above: str, row: str, dialect: Dialect) -> bool:
    """Whether the last number of a row has fewer decimals than all numbers above, which have as many each.

    Where numbers are written with as many digits as they need, a last one may well be round.
    """

    def decimals(cell: str) -> int:
        return len(cell.partition(dialect.decimal)[2])

    *others, last = cells_of(row, dialect.delimiter)
    near = lines_of(above[-_NEAR:])[1:]  # the first of them may be a part of a line
    rows = [cells_of(line, dialect.delimiter) for line in near if dialect.is_row(line)]
    above_it = [decimals(cells[-1]) for cells in rows if len(cells) == len(others) + 1]
    have_as_many = len(above_it) >= _FEWEST_BELOW and len({*above_it}) == 1
    return have_as_many and decimals(last) < above_it[0]


def _without_sums_above(body: str, dialect: Dialect) -> tuple[str, list[str]]:
    """The text with blanks in place of first rows that sum up those below, and a note on them.

    Such a row has the word for it in its first cell, or the first two rows are the smallest and the largest number of
    each column, as DIAdem writes them: the time rises behind both.
    """
    lines = lines_of(body[:_ABOVE])
    places = [place for place, line in enumerate(lines) if line.strip(BLANK)]
    sums: list[int] = []  # places of their lines
    for place in places[:_MOST_SUMS]:
        first_cell = "".join(cells_of(lines[place], dialect.delimiter)[:1])
        if not sums_up(first_cell):
            break
        sums.append(place)
    next_line = lines[places[len(sums)]] if len(sums) < len(places) else ""
    next_cell = "".join(cells_of(next_line, dialect.delimiter)[:1])
    if next_cell and not is_number(next_cell, dialect.decimal):
        sums = []  # the rows themselves have such words
    if not sums and len(places) > _FEWEST_BELOW:
        filled = [lines[place] for place in places]
        sums = places[:2] if _are_extremes(body, filled, dialect) else []
    if not sums:
        return body, []

    whole = lines_of(body)
    shown = " ".join(whole[sums[0]].split())[:60]
    for place in sums:
        whole[place] = ""  # line numbers stay right
    count = "the first row sums" if len(sums) == 1 else f"the first {len(sums)} rows sum"
    return "\n".join(whole), [f"{count} up those below ({shown!r}): left out"]


def _are_extremes(body: str, lines: list[str], dialect: Dialect) -> bool:
    """Whether the first two lines hold the ends of each column's range, and a column that rises is among them.

    Args:
        body: all rows.
        lines: the first of them.
        dialect: of the text.
    """
    low, high, third = (_numbers(line, dialect) for line in lines[:3])
    # Of most logs the first two rows are near the third: these few cells tell it without a look at all rows.
    if len(low) < _FEWEST_SUMMED or len(low) != len(high) or len(low) != len(third):
        return False
    third_is_between = all(map(le, low, third)) and all(map(le, third, high))
    if not third_is_between:
        return False
    last_row = body[_last_line(body) :]
    ends_at = _numbers(last_row, dialect)
    if len(ends_at) != len(low) or not low[0] < high[0]:
        return False
    first_column_rises = _close(low[0], third[0]) and _close(high[0], ends_at[0])
    another_varies = any(map(lt, low[1:], high[1:]))
    if not first_column_rises or not another_varies:
        return False

    smallest = [*third]
    largest = [*third]
    for line in lines_of(body):
        if not line.strip(BLANK) or line in lines[:2]:
            continue
        numbers = _numbers(line, dialect)
        if len(numbers) == len(third):
            smallest = [*map(min, smallest, numbers)]
            largest = [*map(max, largest, numbers)]
    return all(map(_close, low, smallest)) and all(map(_close, high, largest))


def _numbers(line: str, dialect: Dialect) -> list[float]:
    """The numbers of a row; none where a cell is no number."""
    cells = cells_of(line, dialect.delimiter)
    if not all(is_number(cell, dialect.decimal) for cell in cells):
        return []
    return [float(ungrouped(cell, dialect.decimal)) for cell in cells]


def _close(summed: float, of_rows: float) -> bool:
    """Whether a number of a summary is that of the rows, up to the digits that it is written with."""
    return abs(summed - of_rows) <= _ROUNDED * max(abs(summed), abs(of_rows))


def _last_line(body: str) -> int:
    """Where the last line that is not blank begins."""
    end = len(body.rstrip(BLANK))
    return max(body.rfind("\n", 0, end), body.rfind("\r", 0, end)) + 1


def blocks_in(body: str) -> tuple[int, ...]:
    """Rows above which a blank line parts the rows into blocks; none where blocks are short: then lines are spaced."""
    with_returns = "\r" in body  # a search for one character is fast
    if "\n\n" not in body and not (with_returns and ("\r\n\r\n" in body or "\r\r" in body)):
        return ()
    breaks: list[int] = []
    rows = 0
    below_blank = False
    for line in lines_of(body):
        if not line.strip(BLANK):
            below_blank = rows > 0
            continue
        if below_blank:
            block = rows - (breaks[-1] if breaks else 0)
            if block < _LEAST_BLOCK or len(breaks) == _MOST_BLOCKS:
                return ()
            breaks.append(rows)
        rows += 1
        below_blank = False
    if breaks and rows - breaks[-1] < _LEAST_BLOCK:
        return ()
    return tuple(breaks)
