"""Texts of hasty programs are put right: a header without its line end, numbers in the brackets of a list of one."""

from __future__ import annotations

import re

from erclutch.logs.readers.cells import Marks
from erclutch.logs.readers.dialect import LINE_END

_LOOKED_AT = 1 << 16  # characters of the first line, at most
_ROWS = 3  # below the first line, which tell how many columns there are
#: A cell that holds a number in brackets. A whole one may be the unit of a ratio, ``[1]``.
_LISTED = re.compile(
    r"(?m)(^|[,;\t])[ ]*\[\s{0,4}([+-]?\d{0,20}\.\d{0,25}(?:[eE][+-]?\d{1,3})?)\s{0,4}\][ ]*(?=[,;\t\r\n]|\Z)"
)

_BRACKETED = re.compile(r"\[\s{0,4}[+-]?\d{0,20}\.")


def with_a_line_of_names(text: str) -> tuple[str, str]:
    """The text with a line end behind the names, where the first row stands in the line of the header; a note.

    A program that writes its names without a line end makes ``time,torque,0.0,1.5`` of two lines.
    """
    head = LINE_END.split(text[:_LOOKED_AT])
    first, below = head[0], [line for line in head[1:] if line.strip()][:_ROWS]
    if len(below) < _ROWS:
        return text, ""
    for delimiter in ",;\t":
        marks = Marks(delimiter, "," if delimiter != "," and "." not in below[0] else ".")
        widths = {len(marks.cells(line)) for line in below}
        cells = marks.cells(first)
        width = widths.pop()
        if widths or width < 2 or len(cells) != 2 * width:
            continue
        names, row = cells[:width], cells[width:]
        if not all(map(marks.is_filled_in, row)) or not all(names) or any(map(marks.is_filled_in, names)):
            continue
        place = -1
        for _ in names:
            place = first.index(delimiter, place + 1)
        note = "the first row stands in the line of the names, without a line end between them: taken apart"
        return f"{first[:place]}\n{text[place + 1 :]}", note
    return text, ""


def without_brackets(text: str) -> tuple[str, str]:
    """The text with numbers in place of lists of one number, ``[1.5]``, as Python prints them; a note."""
    if not _BRACKETED.search(text):  # a search for a character is fast, and most brackets are those of units
        return text, ""
    plain, count = _LISTED.subn(r"\1\2", text)
    return (
        plain,
        f"{count} numbers stand in brackets, as a list of one is printed: the brackets are left out" if count else "",
    )
