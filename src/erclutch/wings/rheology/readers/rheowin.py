"""Exports of HAAKE RheoWin: names such as "Tau in Pa" or "Tau / Pa" between semicolons, and rows like "3|12;...".

The number before the bar is the segment of the job, the number behind it the point. Segments are recordings: a hold, an
oscillation and a ramp of the rate stand under each other. In workbooks the first column is called SegIndex.
"""

from __future__ import annotations

import re

from erclutch.errors import LogError
from erclutch.logs.readers.cells import is_numeric
from erclutch.wings.rheology.rheometer_blocks import Block, cells, delimiter_of, reader_of_blocks

# The column of segments and points has no name, or "Nr-Seg".
_NAMES = re.compile(
    r"^(?:N[^;|\n]{0,15})?;.*\b(?:GP|Tau|Eta|Gamma|f|T|t) (?:in|en|/) [^;]+;", re.MULTILINE
)
# A table printed from the program has a blank name there, and a dash for the bar.
_SEGMENTS = re.compile(
    r"^(?:SegIndex[\t,;]|[ \t]*[\t,;]t in s[\t,;]t_seg in s[\t,;])", re.MULTILINE
)
_POINT = re.compile(r"(\d+)[|-]\d+")
_NAMED = re.compile(r"(.+?) (?:in|en|/) (.+)")


def _blocks(content: str) -> list[Block]:
    """The table of each segment, below the last line of names in front of it."""
    lines = content.splitlines()
    blocks: list[Block] = []
    names: list[str] = []
    units: list[str] = []
    segment = ""
    rows: list[list[str]] = []
    start = 0  # number of the segment's first row
    delimiter = ";"
    for number, line in enumerate([*lines, ""], start=1):
        if _SEGMENTS.match(line):
            delimiter = delimiter_of(line)
        row = cells(line, delimiter)
        point = _POINT.fullmatch(row[0]) if row else None
        # Two numbers at least, with either decimal mark.
        looks_measured = sum(map(is_numeric, row)) > 1
        if point is None and names and ("|" in line or looks_measured):
            raise LogError(
                f"line {number} is no row of a segment", remedy="Correct or delete that line"
            )

        segment_here = point.group(1) if point else ""
        if point is None or segment_here != segment:
            if rows:
                blocks.append(Block(f"segment {segment}", names, units, rows, start))
            segment = segment_here
            rows = []
            start = number
        if point is not None:
            ends_empty = delimiter == ";" and row[-1] == ""
            values = row[1:-1] if ends_empty else row[1:]
            # A name that fell apart would move all names behind it.
            if ends_empty and len(values) < len(names):
                problem = f"line {number} has {len(values)} values below {len(names)} names"
                raise LogError(problem, remedy="Correct that line, or the line of names above it")
            rows.append(values)
        elif _NAMES.match(line) or _SEGMENTS.match(line):
            if re.search(r"\d\|\d", line):
                raise LogError(
                    f"line {number} holds names and a row", remedy="Break the line before the row"
                )
            names = []
            units = []
            for cell in filter(None, row[1:]):
                label = _NAMED.fullmatch(cell)
                names.append(label.group(1) if label else cell)
                units.append(label.group(2) if label else "")
    without_empty: list[Block] = []
    for block in blocks:
        filled = [column for column in range(len(block.names)) if block.is_filled(column)]
        without_empty.append(block.with_columns(filled))
    return without_empty


READER = reader_of_blocks(
    lambda text: (
        "HAAKE RheoWin" in text
        or _NAMES.search(text) is not None
        or _SEGMENTS.search(text) is not None
    ),
    _blocks,
    "segment",
)
