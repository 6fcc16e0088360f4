"""Programs that show a serial port write the time of day in front of each line of a log."""

from __future__ import annotations

import re

#: As the Arduino IDE writes the time of day in front of a line.
STAMP = re.compile(r"^(\d\d:\d\d:\d\d\.\d{3}) -> ?", re.MULTILINE)
_FEWEST_ROWS = 3
_LINE = re.compile(r"[^\r\n]+")
_DIGIT = re.compile(r"\s*[-+.]?\d")


def with_stamps_in_cells(text: str) -> tuple[str, str]:
    """The text with the stamps of a serial monitor as cells of a column ``Time``, and a note; "" where it has none."""
    stamped = len(STAMP.findall(text))
    lines = len(_LINE.findall(text))
    if stamped < _FEWEST_ROWS or stamped < lines:
        return text, ""
    behind = STAMP.sub("", text)
    mark = max(",;\t", key=behind.count)
    if not behind.count(mark):
        mark = " "

    def cell(stamp: re.Match[str]) -> str:
        """The stamp in front of a row, and the name of its column in front of names."""
        return (stamp.group(1) if _DIGIT.match(text, stamp.end()) else "Time") + mark

    return STAMP.sub(cell, text), "the stamps of a serial monitor are column Time"
