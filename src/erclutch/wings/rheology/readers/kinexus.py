"""Exports of Malvern's and Netzsch's rSpace (Kinexus): one table, in which "Action Name" says the test.

Names hold their units, as "Shear rate(s-¹)". Each action of a sequence is a recording.
"""

from __future__ import annotations

from collections import Counter
from itertools import groupby

from erclutch.errors import LogError
from erclutch.wings.rheology.rheometer_blocks import (
    Block,
    cells,
    delimiter_of,
    reader_of_blocks,
    require_as_many_names,
)

_ACTION = "Action Name"
_TEXTS = ("Sample Description", "Sequence Name", "Date", "Time stamp")


def _blocks(content: str) -> list[Block]:
    """The table of each action of a sequence."""
    lines = content.splitlines()
    heads = [place for place, line in enumerate(lines) if _ACTION in line]
    if not heads:
        return []
    head = heads[0]
    delimiter = delimiter_of(lines[head])
    names = cells(lines[head], delimiter)
    action = names.index(_ACTION)  # its column
    points: list[tuple[int, list[str]]] = []  # number of the line, and its cells
    for number, line in enumerate(lines[head + 1 :], start=head + 2):
        if line.strip():
            points.append((number, cells(line, delimiter)))
    if not points:
        return []

    # A file that fills most rows to the last column does not trim them: a shorter row has lost a delimiter.
    width = len(names)
    lengths = Counter(len(row) for _, row in points)
    ((usual, _),) = lengths.most_common(1)
    fewest = width if usual == width else action + 1
    if len(lengths) == 1:
        require_as_many_names(names, usual, head + 1)
    for number, row in points:
        if len(row) < fewest or any(row[width:]):
            problem = f"line {number} has {len(row)} cells where {width} are expected"
            raise LogError(problem, remedy="Correct or delete that line")

    blocks: list[Block] = []
    for name, group in groupby(points, key=lambda point: point[1][action]):
        numbers, rows = zip(*group, strict=True)
        own_name = name or f"action {len(blocks) + 1}"
        whole = Block(own_name, names, [], rows, numbers[0])
        kept: list[int] = []
        for column, label in enumerate(names):
            if label not in (_ACTION, *_TEXTS) and whole.is_filled(column):
                kept.append(column)
        blocks.append(whole.with_columns(kept))
    return blocks


def _claims(head: str) -> bool:
    """By the column's name in a line of names with units in round brackets."""
    named = next((line for line in head.splitlines() if _ACTION in line), "")
    return "(" in named and _ACTION in cells(named, delimiter_of(named))


READER = reader_of_blocks(_claims, _blocks, "action")
