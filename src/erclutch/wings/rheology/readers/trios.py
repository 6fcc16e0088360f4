"""Text exports of TA Instruments' TRIOS: "[step]", the step's name, names, units and points of each step."""

from __future__ import annotations

from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.dialect import is_number
from erclutch.logs.readers.text_bytes import DAMAGE, decode
from erclutch.logs.table import Table
from erclutch.wings.rheology.rheometer_blocks import Block, cells, chosen_table, delimiter_of

_STEP = "[step]"


def _blocks(content: str) -> list[Block]:
    lines = content.splitlines()
    starts = [at for at, line in enumerate(lines) if line.strip().lower() == _STEP]
    blocks: list[Block] = []
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        body = [at for at in range(start + 1, end) if lines[at].strip()]
        if len(body) < 4:
            continue  # a step without points
        named, *table = body
        delimiter = delimiter_of(lines[table[0]])
        names, units = cells(lines[table[0]], delimiter), cells(lines[table[1]], delimiter)
        points = table[2:]
        if any(is_number(cell, mark) for cell in units for mark in ".,"):
            units, points = [], table[1:]  # a table without units
        rows: list[list[str]] = []
        for at in points:
            if lines[at].lstrip().startswith("["):
                break  # the next section
            rows.append(cells(lines[at], delimiter))
        if rows:
            blocks.append(Block(lines[named].strip(), names, units, rows, points[0] + 1))
    return blocks


def _read(source: LogSource) -> Table:
    return chosen_table(source, _blocks(decode(source.data)), "step")


def _claims(head: bytes) -> bool:
    plain = head.replace(b"\0", b"").lower()
    return b"[step]" in plain or (b"[parameters]" in plain and b"trios" in plain)


READER = LogReader((), _claims, _read, recordings=found_recordings.names_by(_read), tells_damage=DAMAGE)
