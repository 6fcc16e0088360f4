"""A testing machine may fill up the settings above its table to the width of the table: ``Length,50,mm,,``.

A number among empty cells looks like a row with gaps. Such lines end behind their last word here.
"""

from __future__ import annotations

import re
from itertools import islice

from erclutch.logs.readers.cells import cells_of, is_numeric

_DELIMITERS = (",", ";", "\t")
_MOST = 200  # lines above the names
_LONGEST = 3  # cells of a setting: a name, a number and its unit
_FEWEST = 2  # settings
_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n|\Z)")


def without_padded_settings(text: str) -> tuple[str, str]:
    """The text without the empty cells behind the settings above its names; unchanged for other texts. And a note."""
    first = next(_LINE.finditer(text)).group().rstrip("\r\n")
    delimiter = next((each for each in _DELIMITERS if first.endswith(each)), None)
    if delimiter is None:
        return text, ""

    width = len(cells_of(first, delimiter))
    bare: list[str] = []
    settings = 0
    end = 0  # of the lines above the names, in the text
    for match in islice(_LINE.finditer(text), _MOST):
        line = match.group().rstrip("\r\n")
        cells = cells_of(line, delimiter)
        filled = [cell for cell in cells if cell]
        if len(filled) == width and not any(map(is_numeric, filled)):
            is_a_head = settings >= _FEWEST and width > _LONGEST
            return ("".join(bare) + text[end:] if is_a_head else text), ""
        is_setting = bool(filled) and not is_numeric(cells[0]) and cells[: len(filled)] == filled
        if len(cells) != width or (filled and not is_setting) or len(filled) > _LONGEST:
            return text, ""
        settings += bool(filled)
        ending = match.group().removeprefix(line)
        bare.append(line.rstrip(delimiter) + ending)
        end = match.end()
    return text, ""
