"""Tests may stand under each other below one line of names, each under a title: ``Test 2: current 0.5 A``.

Titles are lines between rows that are the same but for their numbers, and tell a field or count the tests. A title may
be a comment. Without this rule the tests would be one log, and what their titles tell would be lost. Other settings,
such as ``speed: 100 rpm``, are titles where the rows begin anew below each: a logger may note its temperature at times.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from typing import NamedTuple

from erclutch.logs.columns.levels_in_names import field_set_in, stated_in
from erclutch.logs.columns.names import without_numbers
from erclutch.logs.columns.vocabulary import set_of

_FEWEST = 2  # titles
_MOST = 1000  # lines that may be titles: with more they are rows that begin with words
_FEWEST_ROWS = 3  # below each title, on average
_MAY_BE_TITLE = re.compile(
    rb"^[#%/;,=*<>\[(\" \t-]*+[A-Za-z\x80-\xff]|^[#%=*<>\[(-]++[^\r\n]*\d ?[A-Za-z]|^[\d.]{1,9} ?[A-Za-z]{1,3}\r?$",
    re.M,
)
#: Marks of a comment and of an underlined head, stripped in one pass: a pattern takes the square of their length.
_BEFORE_A_TITLE = '#%/=*"-<>[( \t\r\n\f\v'
_BEHIND_A_TITLE = ',;"=*-<>]) \t\r\n\f\v'
#: Between the cells of a title: ``Strom;0,5;A``. A comma between digits is a decimal mark.
_BETWEEN_CELLS = re.compile(r"\s*[;\t]\s*|(?<!\d),\s*|,\s*(?!\d)")
_COUNTED = re.compile(r"([^\W\d_]+)[ _#.:-]*\d+\b")
#: A setting and its number: ``current = 0.5``, ``speed: 100 rpm``, ``I<tab>0.5``.
_SETTING = re.compile(r"[^\W\d_][^:=\t\d]{0,40}?\s*[:=\t]\s*[-+]?\d+(?:[.,]\d+)?\s*[^\s\d,;]{0,12}")
_FIRST_CELL = re.compile(r"\s*([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)")
#: What tests under each other are counted as.
_TESTS = set_of(
    "test run trial experiment measurement versuch messung lauf essai mesure ensayo medida prueba "
    "prova серия опыт 测试 试验 実験 試験"
)


class TitledBlock(NamedTuple):
    """Rows below a title.

    Attributes:
        title: without the marks of a comment; "" for rows above the first title.
        line: of the first row, counted from 1.
        above: lines between the rows before and these.
        rows: lines from the first row on.
    """

    title: str
    line: int
    above: list[str]
    rows: list[str]


def may_hold_titles(data: bytes) -> bool:
    """Whether some lines of a text, but not many, begin with a word: a quick look without a cell of a row."""
    count = 0
    for _ in _MAY_BE_TITLE.finditer(data):
        count += 1
        if count > _MOST:
            return False
    return count >= _FEWEST


def titled_blocks(lines: Sequence[str], is_row: Callable[[str], bool]) -> list[TitledBlock]:
    """The blocks of rows below titles; none where no lines are titles.

    Args:
        lines: of the text.
        is_row: whether a line is a row of numbers.
    """
    shapes: Counter[str] = Counter()
    rows = 0
    title_of_line: dict[int, str] = {}
    for place, line in enumerate(lines):
        if not line.strip():
            continue
        title = title_of(line)
        if not title:
            rows += is_row(line)
            continue
        title_of_line[place] = title
        shapes[without_numbers(title)] += 1
    if not shapes or rows < _FEWEST_ROWS * max(shapes.values()):
        return []
    shape, count = shapes.most_common(1)[0]
    # One title alone parts the rows where it tells that the field was changed: ``# from here on 0.5 A``.
    only_title = next(iter(title_of_line.values()))
    if count < _FEWEST and (len(shapes) > 1 or stated_in(only_title) is None):
        return []

    blocks: list[TitledBlock] = []
    above: list[str] = []
    title = ""
    for place, line in enumerate(lines):
        own = title_of_line.get(place, "")
        if own and without_numbers(own) == shape:
            title = own
            above.append(line)
        elif is_row(line):
            if title or not blocks:
                blocks.append(TitledBlock(title, place + 1, above, []))
                title = ""
                above = []
            blocks[-1].rows.append(line)
        elif title or not blocks:
            above.append(line)
        else:
            blocks[-1].rows.append(line)
    if len(blocks) < 2:
        return []
    of_each = [block.title for block in blocks if block.title]
    if all(map(_tells_a_test, of_each)):
        return blocks
    # A time begins anew: the first number of each block is below the last one of the block before.
    starts = [_first_number(block.rows[0]) for block in blocks]
    # Behind the last row of a block may stand empty lines and comments.
    ends = [
        next((number for row in reversed(block.rows) if (number := _first_number(row))), 0.0)
        for block in blocks
    ]
    begin_anew = all(start < end for start, end in zip(starts[1:], ends, strict=False))
    return blocks if begin_anew else []


def _first_number(row: str) -> float:
    first = _FIRST_CELL.match(row)
    return float(first[1].replace(",", ".")) if first else 0.0


def title_of(line: str) -> str:
    """The words of a line that may be the title of a test; "" for another line."""
    title = line.lstrip(_BEFORE_A_TITLE).rstrip(_BEHIND_A_TITLE)
    if not title or len(title) > 100 or not re.search(r"\d", title):
        return ""
    if not _SETTING.fullmatch(title):
        title = _BETWEEN_CELLS.sub(" ", title)
    if not re.match(r"[^\W\d_]|[-+]?\d+(?:[.,]\d+)? ?[^\W\d_]+$", title):
        return ""
    return title if _tells_a_test(title) or _SETTING.fullmatch(title) else ""


def _tells_a_test(title: str) -> bool:
    """Whether a title counts a test or tells a field, with its unit or by its name."""
    counted = _COUNTED.match(title)
    if counted is not None and counted[1].lower() in _TESTS:
        return True
    return stated_in(title) is not None or field_set_in(title) is not None
