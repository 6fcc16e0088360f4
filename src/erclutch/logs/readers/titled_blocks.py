"""Tests may stand under each other below one line of names, each under a title: ``Test 2: current 0.5 A``.

Titles are lines between rows that are the same but for their numbers, and tell a field or count the tests. A title may
be a comment. Without this rule the tests would be one log, and what their titles tell would be lost.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from typing import NamedTuple

from erclutch.logs.columns.levels_in_names import stated_in
from erclutch.logs.columns.vocabulary import set_of

_FEWEST = 2  # titles
_MOST = 1000  # lines that may be titles: with more they are rows that begin with words
_FEWEST_ROWS = 3  # below each title, on average
_MAY_BE_TITLE = re.compile(
    rb"^[#%/;,=*\" \t-]*[A-Za-z\x80-\xff]|^[#%=*]+[^\r\n]*\d ?[A-Za-z]", re.M
)
#: Marks of a comment and of an underlined head, stripped in one pass: a pattern takes the square of their length.
_BEFORE_A_TITLE = '#%/=*"- \t\r\n\f\v'
_BEHIND_A_TITLE = ',;"=*- \t\r\n\f\v'
_NUMBER = re.compile(r"\d+(?:[.,]\d+)?")
_COUNTED = re.compile(r"([^\W\d_]+)[ _#.:-]*\d+\b")
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
        title = _title(line)
        if not title:
            rows += is_row(line)
            continue
        title_of_line[place] = title
        shapes[_NUMBER.sub("#", title)] += 1
    counts = [count for count in shapes.values() if count >= _FEWEST]
    if not counts or rows < _FEWEST_ROWS * max(counts):
        return []
    shape = next(shape for shape, count in shapes.items() if count == max(counts))

    blocks: list[TitledBlock] = []
    above: list[str] = []
    title = ""
    for place, line in enumerate(lines):
        own = title_of_line.get(place, "")
        if own and _NUMBER.sub("#", own) == shape:
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
    return blocks if len(blocks) > 1 else []


def _title(line: str) -> str:
    """The words of a line that may be the title of a test; "" for another line."""
    title = line.lstrip(_BEFORE_A_TITLE).rstrip(_BEHIND_A_TITLE)
    if not title or len(title) > 100 or not re.search(r"\d", title):
        return ""
    if not re.match(r"[^\W\d_]|[-+]?\d+(?:[.,]\d+)? ?[^\W\d_]+$", title):
        return ""
    counted = _COUNTED.match(title)
    counts_a_test = counted is not None and counted[1].lower() in _TESTS
    return title if counts_a_test or stated_in(title) is not None else ""
