"""Text exports of PCS Instruments' tribometers (MTM, EHD, ETM): steps under each other, each with a table of its own.

A step begins with "Step 2 started at ..." and lines about the step; its names stand in the line above its first row.
"""

from __future__ import annotations

import re

from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.dialect import is_number
from erclutch.logs.readers.text_bytes import DAMAGE, decode
from erclutch.logs.table import Table
from erclutch.wings.rheology.rheometer_blocks import Block, cells, chosen_table

_STEP = re.compile(r"(Step \d+)(?: \"[^\"]*\")? started at")
_FEWEST = 3  # columns of a table; lines about the step have a word and a number


def _blocks(content: str) -> list[Block]:
    lines = content.splitlines()
    blocks: list[Block] = []
    step, names, rows, start = "", list[str](), list[list[str]](), 0
    for at, line in enumerate([*lines, ""]):
        row = cells(line, "\t")
        if len(row) >= _FEWEST and is_number(row[0], ".") and len(names) >= _FEWEST:
            start = start or at + 1
            rows.append(row)
            continue
        if rows:
            blocks.append(_with_named_columns(Block(step, names, [], rows, start)))
            rows, start = [], 0
        names = row
        if found := _STEP.match(line):
            step, names = found.group(1), []
    return blocks


def _with_named_columns(block: Block) -> Block:
    """A table without columns that have no name or hold nothing, and without a second column of the same name."""
    names = list(block.names)
    filled = [any(i < len(row) and row[i] for row in block.rows) for i in range(len(names))]
    kept = [i for i, name in enumerate(names) if name and filled[i] and name not in names[:i]]
    rows = [[row[i] if i < len(row) else "" for i in kept] for row in block.rows]
    return Block(block.name, [names[i] for i in kept], [], rows, block.line)


def _read(source: LogSource) -> Table:
    return chosen_table(source, _blocks(decode(source.data)), "step")


def _claims(head: bytes) -> bool:
    plain = head.replace(b"\0", b"").decode("latin-1")
    return "Test Data File" in plain[:200] and _STEP.search(plain) is not None


READER = LogReader((), _claims, _read, recordings=found_recordings.names_by(_read), tells_damage=DAMAGE)
