"""A logger's remarks among its rows, such as ``motor on`` or ``pause``, are left out and told."""

from __future__ import annotations

import re
from itertools import pairwise

from erclutch.errors import listed
from erclutch.logs.readers.dialect import lines_of

_FIRST_CELL = re.compile(r"\s*([+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?)\s*[,;\t ]")
_DIGIT = re.compile(r"\d")
#: Rows that tell a table, and how many rows there are for a remark at least: more remarks are no remarks.
_ROWS = 10
_ROWS_A_REMARK = 5
_MOST_TOLD = 5
_LONGEST_TOLD = 40  # characters


def without_remarks(text: str) -> tuple[str, str] | None:
    """The text without lines that hold no digit and stand right between two rows; a note. None where there are none.

    Only where the first column counts on past them, as a time or a number of the row does: else a line of text may part
    two recordings, and nothing would tell.
    """
    lines = lines_of(text)
    counts: dict[int, float] = {}  # the first cell of each row, by the row's line
    for place, line in enumerate(lines):
        first = _FIRST_CELL.match(line)
        if first is not None:
            counts[place] = float(first.group(1).replace(",", "."))
    if len(counts) < _ROWS:
        return None
    if any(later < earlier for earlier, later in pairwise(counts.values())):
        return None

    # Between two rows: a line of names or settings stands above the first, and a result below the last.
    remarks: list[int] = []
    for place in range(min(counts), max(counts)):
        if place in counts or not lines[place].strip():
            continue
        between_rows = place - 1 in counts and place + 1 in counts
        if not between_rows or _DIGIT.search(lines[place]):
            return None
        remarks.append(place)
    if not remarks or _ROWS_A_REMARK * len(remarks) > len(counts):
        return None
    if any(counts[place + 1] <= counts[place - 1] for place in remarks):
        return None

    left_out = {*remarks}
    kept = [line for place, line in enumerate(lines) if place not in left_out]
    told = [f"'{lines[place].strip()[:_LONGEST_TOLD]}' (line {place + 1})" for place in remarks]
    one_or_more = "a line" if len(remarks) == 1 else f"{len(remarks)} lines"
    note = f"{one_or_more} among the rows without a number left out: {listed(told, _MOST_TOLD)}"
    return "\n".join(kept), note
