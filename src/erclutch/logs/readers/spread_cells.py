"""Tables of papers write what a number scatters by into its cell: the number is what was measured.

It stands behind a sign (``12.3 ± 0.4``) or in brackets (``12.3 (0.4)``); what is no small part of its number is another
quantity.
"""

from __future__ import annotations

import re

from erclutch.logs.readers.dialect import lines_of

_FEWEST = 3  # rows: one such cell may be a remark
_LOOKED_AT = 1 << 13  # last characters
_NEARLY_ALL = 0.9  # of the cells: a faint one may scatter by more
_PLUS_MINUS = r"[ \t]*(?:±|\+/-|\+-)[ \t]*"
_EXPONENT = r"(?:[eE][+-]?\d+)?"
_IN_A_CELL = re.compile(rf"(?<=[\d.]){_PLUS_MINUS}\d+(?:\.\d+)?{_EXPONENT}(?![.\d])")
#: Where the comma is no delimiter, it is the decimal mark of both numbers.
_WITH_COMMAS = re.compile(rf"(?<=[\d,]){_PLUS_MINUS}\d+(?:[.,]\d+)?{_EXPONENT}(?![.,\d])")
_SMALL = 0.5  # of the number: what a number in brackets scatters by stays below
#: A whole cell, between blanks, delimiters and ends of the line.
_BRACKETED = re.compile(
    r"(?:^|(?<=[\t;,|]))( *\"?[+-]?(\d+(?:[.,]\d+)?)) *\((?:± *)?(\d+(?:[.,]\d+)?)\)"
    r"(?=\"? *(?:[\t;,|]|$))"
)
_IN_A_NAME = re.compile(
    rf"{_PLUS_MINUS}(?:s\.? ?d\.?|s\.? ?e\.?(?: ?m\.?)?|std\w*|stdev|error|Δ\w*)(?![^\W_])",
    re.IGNORECASE,
)


def without_spread_in_cells(text: str) -> tuple[str, str]:
    """The text with the numbers of such cells alone, and what is said of it; "" where there are none."""
    bracketed, note = _without_brackets(text)
    if note:
        return bracketed, note
    if not any(mark in text for mark in ("±", "+/-", "+-")):
        return text, ""
    lines = lines_of(text)
    rows = [line for line in lines if _IN_A_CELL.search(line) or _WITH_COMMAS.search(line)]
    if len(rows) < _FEWEST:
        return text, ""
    pattern = _WITH_COMMAS if all(";" in row or "\t" in row for row in rows) else _IN_A_CELL
    count = 0
    for place, line in enumerate(lines):
        bare, spreads = pattern.subn("", line)
        lines[place] = bare if spreads else _IN_A_NAME.sub("", line)
        count += spreads
    example = pattern.search(rows[0])
    shown = example.group().strip() if example else "±"
    return "\n".join(lines), f"{count} cells hold what their numbers scatter by ({shown}): left out"


def _without_brackets(text: str) -> tuple[str, str]:
    """The text without the numbers in brackets behind those of cells, if nearly all are a small part of these."""
    tail = text[-_LOOKED_AT:]
    if "(" not in tail or ")" not in tail:
        return text, ""
    cells = [_BRACKETED.findall(line) for line in lines_of(tail)]
    if sum(map(bool, cells)) < _FEWEST:
        return text, ""
    lines = lines_of(text)
    small = count = 0
    for place, line in enumerate(lines):
        if "(" not in line:
            continue
        for _, number, spread in _BRACKETED.findall(line):
            count += 1
            small += float(spread.replace(",", ".")) <= _SMALL * float(number.replace(",", "."))
        lines[place] = _BRACKETED.sub(r"\1", line)
    if small < _NEARLY_ALL * count:
        return text, ""
    note = f"{count} cells hold in brackets what their numbers scatter by: left out"
    return "\n".join(lines), note
