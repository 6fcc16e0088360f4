"""A cell of a CSV that somebody else named, such as a column ``=HYPERLINK(...)``, must not become a formula."""

from __future__ import annotations

import re

_FORMULA = re.compile(r"[=+\-@\t\r]")
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?")


def shown_as_words(cell: str) -> str:
    """A cell with an apostrophe in front where a spreadsheet would compute it; numbers and other words as they are."""
    is_formula = _FORMULA.match(cell) is not None and not is_plain_number(cell)
    return f"'{cell}" if is_formula else cell


def is_plain_number(cell: str) -> bool:
    """Whether a cell is a number with a decimal point, as every spreadsheet takes it."""
    return _NUMBER.fullmatch(cell) is not None
