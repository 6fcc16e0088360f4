"""Texts of hasty programs are put right: a header without its line end, brackets of lists of one and of matrices."""

from __future__ import annotations

import re

from erclutch.logs.readers.cells import Marks
from erclutch.logs.readers.dialect import lines_of

_LOOKED_AT = 1 << 16  # characters of the first line, at most
_ROWS = 3  # below the first line, which tell how many columns there are
#: A cell that holds a number in brackets. A whole one may be the unit of a ratio, ``[1]``.
_LISTED = re.compile(
    r"(?m)(^|[,;\t])[ ]*\[\s{0,4}([+-]?\d{0,20}\.\d{0,25}(?:[eE][+-]?\d{1,3})?)\s{0,4}\][ ]*(?=[,;\t\r\n]|\Z)"
)

#: Where a matrix of MATLAB begins, behind its name or alone, and what stands in it and ends it.
_MATRIX = re.compile(
    r"(?m)^[ \t]{0,40}(?:\w{1,40}[ \t]{0,9}=[ \t]{0,9})?\[(?=[ \t]{0,40}(?:[-+.\d]|\r?$))"
)
_OF_A_MATRIX = re.compile(r"[-+.,;\deE\sNaInf]*")
_END_OF_A_MATRIX = re.compile(r"\]\s{0,40};?\s{0,400}\Z")
_END_OF_A_ROW = re.compile(r"[ \t]*;[ \t]*(?:\r?\n[ \t]*)?")

#: A line that is a list of two numbers or more, as Python and NumPy print it.
_ROW_IN_BRACKETS = re.compile(
    r"(?m)^[ \t]{0,9}[\[(]{1,2}[ \t]{0,9}([-+.\d][-+.\deEnaif]*[ \t,;]++[-+.\deEnaif \t,;]*[\deEnaif.])[ \t]{0,9}"
    r"[\])]{1,2}[ \t]{0,9},?[ \t]{0,9}\r?$"
)

_OF_A_RULE = frozenset("-=|+:;, \t")  # characters
_RULED_LINES = 60  # from the first, above which a rule stands
_BRACKETED = re.compile(r"\[\s{0,4}[+-]?\d{0,20}\.")


def with_a_line_of_names(text: str) -> tuple[str, str]:
    """The text with a line end behind the names, where the first row stands in the line of the header; a note.

    A program that writes its names without a line end makes ``time,torque,0.0,1.5`` of two lines.
    """
    head = lines_of(text[:_LOOKED_AT])
    first, *others = head
    below = [line for line in others if line.strip()][:_ROWS]
    if len(below) < _ROWS:
        return text, ""
    for delimiter in ",;\t":
        has_points = delimiter == "," or "." in below[0]
        marks = Marks(delimiter, "." if has_points else ",")
        widths = {len(marks.cells(line)) for line in below}
        width = widths.pop()
        cells = marks.cells(first)
        if widths or width < 2 or len(cells) != 2 * width:
            continue
        names = cells[:width]
        row = cells[width:]
        are_names = all(names) and not any(marks.is_filled_in(name) for name in names)
        is_row = all(marks.is_filled_in(cell) for cell in row)
        if not are_names or not is_row:
            continue
        place = -1
        for _ in names:
            place = first.index(delimiter, place + 1)
        note = "the first row stands in the line of the names, without a line end between them: taken apart"
        return f"{first[:place]}\n{text[place + 1 :]}", note
    return text, ""


def without_rules(text: str) -> tuple[str, str]:
    """The text without lines of dashes between the names and the rows, as Markdown and prints of a database have."""
    head = text[:_LOOKED_AT]
    if "--" not in head:
        return text, ""
    lines = head.split("\n")
    kept: list[str] = []
    for place, line in enumerate(lines):
        # A rule is two and more runs of dashes, and else bars, colons and blanks alone.
        is_of_a_rule = place < _RULED_LINES and {*line.strip()} <= _OF_A_RULE
        if not is_of_a_rule or len(re.findall(r"--+", line)) < 2:
            kept.append(line)
    if len(kept) == len(lines):
        return text, ""
    return "\n".join(kept) + text[_LOOKED_AT:], "lines of dashes above the rows are left out"


def without_brackets(text: str) -> tuple[str, str]:
    """The text with numbers in place of lists of one number, ``[1.5]``, as Python prints them; a note."""
    if not _BRACKETED.search(text):  # this search is fast, and most brackets are those of units
        return text, ""
    plain, count = _LISTED.subn(r"\1\2", text)
    note = (
        f"{count} numbers stand in brackets, as a list of one is printed: the brackets are left out"
    )
    return plain, note if count else ""


def without_brackets_of_rows(text: str) -> tuple[str, str]:
    """The text with rows in place of printed lists of numbers, ``[0.1, 0.5, 2.3]`` or ``(0.1 0.5 2.3)``; a note.

    The brackets stand in the first and in the last cell of each row, whose columns were lost.
    """
    if not _ROW_IN_BRACKETS.search(text[:_LOOKED_AT]):
        return text, ""
    lines = [line for line in lines_of(text[:_LOOKED_AT])[:-1] if line.strip()]
    in_brackets = sum(_ROW_IN_BRACKETS.fullmatch(line) is not None for line in lines)
    if in_brackets < _ROWS or 2 * in_brackets < len(lines):
        return text, ""
    plain, count = _ROW_IN_BRACKETS.subn(r"\1", text)
    return plain, f"{count} rows stand in brackets, as lists are printed: the brackets are left out"


def without_matrix(text: str) -> tuple[str, str]:
    """The text with the rows of a matrix of MATLAB, ``[1 2; 3 4];``, a line each; a note.

    The bracket in front of the first row is a cell elsewhere, which moves its numbers by a column.
    """
    begin = _MATRIX.search(text[:_LOOKED_AT])
    end = _END_OF_A_MATRIX.search(text[-_LOOKED_AT:])
    if begin is None or end is None:
        return text, ""
    stop = max(len(text) - _LOOKED_AT, 0) + end.start()
    inside = text[begin.end() : stop]
    if ";" not in inside or not _OF_A_MATRIX.fullmatch(inside):
        return text, ""
    rows = _END_OF_A_ROW.sub("\n", inside.strip())
    note = "a matrix of MATLAB: its brackets and semicolons are left out"
    return f"{text[: begin.start()]}{rows}\n", note
