"""Cells may be written as formulas so that a spreadsheet shows them as they are: ``="0.001"``, ``=0.001``.

The number or the name in such a cell is meant. A formula that wants computing, such as ``=B2*C2``, stays words.
"""

from __future__ import annotations

import re

from erclutch.files.spreadsheet_cells import is_plain_number

_CELL = r"(?:(?<=[,;\t|\r\n])|\A)[ ]*"
_END = r"[ ]*(?=[,;\t|\r\n]|\Z)"
_NUMBER = r"[+-]?(?:\d+(?:[.,]\d+)?|[.,]\d+)(?:[eE][+-]?\d+)?"
#: ``="text"``, in a cell of its own or in a quoted cell whose quotes are doubled.
_QUOTED = re.compile(rf'{_CELL}(?:"=""([^"\r\n]*)"""|="([^"\r\n]*)"){_END}')
_BARE = re.compile(rf"{_CELL}(?:=|')({_NUMBER}){_END}")


def without_formula_marks(text: str) -> tuple[str, str]:
    """The text with what such cells show, and a note; the text and "" where there are none."""
    first = ""

    def shown(match: re.Match[str]) -> str:
        nonlocal first
        content = next(group for group in match.groups() if group is not None).strip()
        first = first or f"{match[0].strip()} is {content}"
        return content if is_plain_number(content) else f'"{content}"'

    def number(match: re.Match[str]) -> str:
        nonlocal first
        first = first or f"{match[0].strip()} is {match[1]}"
        return match[1]

    if '="' in text:
        text = _QUOTED.sub(shown, text)
    text = _BARE.sub(number, text)
    return (
        text,
        f"cells written as formulas hold what a spreadsheet shows: {first}" if first else "",
    )
