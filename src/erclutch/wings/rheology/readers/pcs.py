"""Text exports of PCS Instruments' tribometers (MTM, EHD, ETM): steps under each other, each with a table of its own.

A step begins with "Step 2 started at ..." and lines about the step; its names stand in the line above its first row.
"""

from __future__ import annotations

import re

from erclutch.logs.readers.cells import is_number
from erclutch.wings.rheology.rheometer_blocks import Block, cells, reader_of_blocks

_STEP = re.compile(r"(Step \d+)(?: \"[^\"]*\")? started at")
_FEWEST = 3  # columns of a table; lines about the step have a word and a number


def _blocks(content: str) -> list[Block]:
    """The table of each step."""
    lines = content.splitlines()
    blocks: list[Block] = []
    step = ""
    names: list[str] = []  # cells of the line above
    rows: list[list[str]] = []
    for number, line in enumerate([*lines, ""], start=1):
        row = cells(line, "\t")
        if len(row) >= _FEWEST and is_number(row[0], ".") and len(names) >= _FEWEST:
            rows.append(row)
            continue
        if rows:  # the table ends here
            block = Block(step, names, [], rows, number - len(rows))
            kept: list[int] = []  # columns with a name of their own that hold something
            for column, name in enumerate(names):
                if name and block.is_filled(column) and name not in names[:column]:
                    kept.append(column)
            blocks.append(block.with_columns(kept))
            rows = []
        names = row
        begins = _STEP.match(line)
        if begins:
            step = begins.group(1)
            names = []
    return blocks


READER = reader_of_blocks(
    lambda text: "Test Data File" in text[:200] and _STEP.search(text) is not None,
    _blocks,
    "step",
)
