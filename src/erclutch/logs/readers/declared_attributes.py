"""Weka's files (ARFF) declare each column in a line above the rows: ``@attribute 'force [kN]' numeric``."""

from __future__ import annotations

import re

from erclutch.logs.readers.cells import line_of

_BEGINS = re.compile(r"(?:\s*%[^\r\n]*[\r\n]+|\s+)*+@relation\b", re.IGNORECASE)
_ATTRIBUTE = re.compile(r"""\s*@attribute\s+(?:'([^']*)'|"([^"]*)"|(\S+))\s+\S.*""", re.IGNORECASE)
_DATA = re.compile(r"\s*@data\s*", re.IGNORECASE)
_LINE = re.compile(r"([^\r\n]*)(\r\n|\r|\n|\Z)")
_MOST_LINES = 10_000  # above the rows


def with_declared_names(text: str) -> tuple[str, str]:
    """The text with the declared names in the line above its rows, and a note; the text and "" for other texts.

    Each line stays a line, so that messages name the lines of the file.
    """
    if "@" not in text[:_MOST_LINES] or _BEGINS.match(text) is None:
        return text, ""
    names: list[str] = []
    endings: list[str] = []
    for number, match in enumerate(_LINE.finditer(text)):
        line, ending = match.groups()
        attribute = _ATTRIBUTE.fullmatch(line)
        if attribute:
            names.append(next(name for name in attribute.groups() if name is not None))
        if _DATA.fullmatch(line) and names:
            above = "".join(endings)
            return f"{above}{line_of(names, ',')}{ending}{text[match.end() :]}", (
                "the names of the columns are those of the lines @attribute"
            )
        if number > _MOST_LINES or not ending:
            break
        endings.append(ending)
    return text, ""
