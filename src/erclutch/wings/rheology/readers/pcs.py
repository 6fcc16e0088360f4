"""Text exports of PCS Instruments' tribometers (MTM, EHD, ETM): steps under each other, each with a table of its own.

A step begins with "Step 2 started at ..." and lines about the step; its names stand in the line above its first row.
"""

from __future__ import annotations

import re

from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.cells import is_number
from erclutch.logs.readers.text_bytes import DAMAGE, decode
from erclutch.logs.table import Table
from erclutch.wings.rheology.rheometer_blocks import Block, cells, chosen_table

_STEP = re.compile(r"(Step \d+)(?: \"[^\"]*\")? started at")
_FEWEST = 3  # columns of a table; lines about the step have a word and a number


def _blocks(content: str) -> list[Block]:
    lines = content.splitlines()
    blocks: list[Block] = []
    step = ""
    names: list[str] = []  # cells of the line above
    rows: list[list[str]] = []
    for number, line in enumerate([*lines, ""], start=1):
        row = cells(line, "\t")
        if len(row) >= _FEWEST and is_number(row[0], ".") and len(names) >= _FEWEST:
            rows.append(row[: len(names)])
            continue
        if rows:  # the table ends here
            blocks.append(_with_named_columns(Block(step, names, [], rows, number - len(rows))))
            rows = []
        names = row
        begins = _STEP.match(line)
        if begins:
            step = begins.group(1)
            names = []
    return blocks


def _with_named_columns(block: Block) -> Block:
    """A table without columns that have no name or hold nothing, and without a second column of the same name."""
    kept: list[int] = []
    for column, name in enumerate(block.names):
        repeated = name in block.names[:column]
        if name and block.is_filled(column) and not repeated:
            kept.append(column)
    return block.with_columns(kept)


def _read(source: LogSource) -> Table:
    return chosen_table(source, _blocks(decode(source.data)), "step")


def _claims(head: bytes) -> bool:
    plain = head.replace(b"\0", b"").decode("latin-1")
    return "Test Data File" in plain[:200] and _STEP.search(plain) is not None


READER = LogReader((), _claims, _read, recordings=found_recordings.names_by(_read), tells_damage=DAMAGE)
