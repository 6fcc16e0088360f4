"""Tables of papers write what a number scatters by into its cell (``12.3 ± 0.4``): the number is what was measured."""

from __future__ import annotations

import re

from erclutch.logs.readers.dialect import LINE_END

_FEWEST = 3  # rows: one such cell may be a remark
_PLUS_MINUS = r"[ \t]*(?:±|\+/-|\+-)[ \t]*"
_EXPONENT = r"(?:[eE][+-]?\d+)?"
_IN_A_CELL = re.compile(rf"(?<=[\d.]){_PLUS_MINUS}\d+(?:\.\d+)?{_EXPONENT}(?![.\d])")
#: Where the comma is no delimiter, it is the decimal mark of both numbers.
_WITH_COMMAS = re.compile(rf"(?<=[\d,]){_PLUS_MINUS}\d+(?:[.,]\d+)?{_EXPONENT}(?![.,\d])")
_IN_A_NAME = re.compile(
    rf"{_PLUS_MINUS}(?:s\.? ?d\.?|s\.? ?e\.?(?: ?m\.?)?|std\w*|stdev|error|Δ\w*)(?![^\W_])",
    re.IGNORECASE,
)


def without_spread_in_cells(text: str) -> tuple[str, str]:
    """The text with the numbers of such cells alone, and what is said of it; "" where there are none."""
    if not any(mark in text for mark in ("±", "+/-", "+-")):
        return text, ""
    lines = LINE_END.split(text)
    rows = [line for line in lines if _IN_A_CELL.search(line) or _WITH_COMMAS.search(line)]
    if len(rows) < _FEWEST:
        return text, ""
    pattern = _WITH_COMMAS if all(";" in row or "\t" in row for row in rows) else _IN_A_CELL
    count = 0
    for place, line in enumerate(lines):
        bare, found = pattern.subn("", line)
        lines[place] = bare if found else _IN_A_NAME.sub("", line)
        count += found
    example = pattern.search(rows[0])
    shown = example.group().strip() if example else "±"
    return "\n".join(lines), f"{count} cells hold what their numbers scatter by ({shown}): left out"
