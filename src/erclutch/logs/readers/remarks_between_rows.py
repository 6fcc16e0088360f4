"""A logger's remarks among its rows, such as ``motor on`` or ``pause``, are left out and told."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise

from erclutch.errors import listed
from erclutch.logs.readers.dialect import lines_of

_FIRST_CELL = re.compile(r"\s*([+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?)\s*[,;\t ]")
_NUMBER = re.compile(r"[+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?")
_DIGIT = re.compile(r"\d")
#: Rows that tell a table, and how many rows there are for a remark at least: more remarks are no remarks.
_ROWS = 10
_ROWS_A_REMARK = 5
_MOST_TOLD = 5
_LONGEST_TOLD = 40  # characters


def without_remarks(text: str) -> tuple[str, str] | None:
    """The text without lines that hold no digit and stand right between two rows; a note. None where there are none.

    Only where a column counts on past them, as a time or a number of the row does: else a line of text may part two
    recordings, and nothing would tell.
    """
    lines = lines_of(text)
    rows = {place for place, line in enumerate(lines) if _FIRST_CELL.match(line)}
    if len(rows) < _ROWS:
        return None

    # Between two rows: a line of names or settings stands above the first, and a result below the last.
    remarks: list[int] = []
    for place in range(min(rows), max(rows)):
        if place in rows or not lines[place].strip():
            continue
        between_rows = place - 1 in rows and place + 1 in rows
        if not between_rows or _DIGIT.search(lines[place]):
            return None
        remarks.append(place)
    if not remarks or _ROWS_A_REMARK * len(remarks) > len(rows):
        return None
    if not _count_on({place: lines[place] for place in sorted(rows)}, remarks):
        return None

    left_out = {*remarks}
    kept = [line for place, line in enumerate(lines) if place not in left_out]
    told = [f"'{lines[place].strip()[:_LONGEST_TOLD]}' (line {place + 1})" for place in remarks]
    one_or_more = "a line" if len(remarks) == 1 else f"{len(remarks)} lines"
    note = f"{one_or_more} among the rows without a number left out: {listed(told, _MOST_TOLD)}"
    return "\n".join(kept), note


def _count_on(rows: Mapping[int, str], remarks: Sequence[int]) -> bool:
    """Whether a column of the rows never falls, grows in most of them, and grows past each remark.

    Args:
        rows: by the place of the line.
        remarks: places between two rows.
    """
    first_row = next(iter(rows.values()))
    delimiter = next((mark for mark in "\t;," if mark in first_row), None)
    cells = {place: row.split(delimiter) for place, row in rows.items()}
    for column in range(min(map(len, cells.values()))):
        counts: dict[int, float] = {}
        for place, row in cells.items():
            number = _NUMBER.fullmatch(row[column].strip())
            if number is None:
                break
            counts[place] = float(number.group().replace(",", "."))
        if len(counts) < len(rows):
            continue
        steps = [later - earlier for earlier, later in pairwise(counts.values())]
        counts_on = min(steps) >= 0.0 and 2 * sum(step > 0.0 for step in steps) > len(steps)
        if counts_on and all(counts[place + 1] > counts[place - 1] for place in remarks):
            return True
    return False
