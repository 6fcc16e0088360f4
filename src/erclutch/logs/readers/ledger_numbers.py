"""Negative numbers get their sign in front, where ledgers and spreadsheets write ``(408.1)``, ``408.1-``, ``- 408.1``.

Excel's format for accounts writes them so, SAP's lists do, and both are exported as they are shown.
"""

from __future__ import annotations

import re

from erclutch.logs.readers.cells import DELIMITERS, cells_of, line_of
from erclutch.logs.readers.dialect import lines_of

_LOOKED_AT = 1 << 17  # characters at either end
_NUMBER = (
    r"(?:\d+(?:[.,]\d*)?|\d{1,3}(?:[., '\u00a0\u202f]\d{3})+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?"
)
_LEDGER = re.compile(rf"\(({_NUMBER})\)|({_NUMBER})-|-\s+({_NUMBER})")
_PLAIN = re.compile(rf"[+-]?{_NUMBER}")
#: Such a number in a text, between marks; in quotes it may hold the mark.
_IN_A_TEXT = re.compile(
    rf'(?:^|[\t;,|])"?[ ]*(?:{_LEDGER.pattern})[ ]*"?(?=[\t;,|]|$)', re.MULTILINE
)


def with_leading_minus(text: str) -> tuple[str, str]:
    """The text with such numbers as ``-408.1``, and what is said of it; "" where there are none.

    A column that holds no other numbers keeps them: in (1), (2) or (0.1) the brackets may be of a remark.
    """
    ends = text[:_LOOKED_AT] + "\n" + text[-_LOOKED_AT:]
    written = _IN_A_TEXT.search(ends)
    if written is None:
        return text, ""
    line = ends[ends.rfind("\n", 0, written.end()) + 1 :].partition("\n")[0]
    delimiter = next((mark for mark in DELIMITERS if mark in line), None)
    if delimiter is None:
        return text, ""
    lines = lines_of(text)
    rows = [cells_of(line, delimiter) for line in lines]
    plain = [{k for k, cell in enumerate(cells) if _PLAIN.fullmatch(cell)} for cells in rows]
    with_numbers = set[int]().union(*plain)  # columns with a number as everybody writes it
    first = ""
    for place, cells in enumerate(rows):
        if not plain[place]:
            continue  # a line of (1), (2), (3) numbers its columns
        signed = [*cells]
        for column, cell in enumerate(cells):
            number = _LEDGER.fullmatch(cell) if column in with_numbers else None
            if number:
                signed[column] = f"-{number[number.lastindex or 1]}"
                first = first or cell
        if signed != cells:
            lines[place] = line_of(signed, delimiter)
    if not first:
        return text, ""
    return "\n".join(lines), f"numbers with their sign behind or in brackets are negative: {first}"
