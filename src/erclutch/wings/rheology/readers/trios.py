"""Text exports of TA Instruments' TRIOS: "[step]", the step's name, names, units and points of each step.

Another form has one table: "Variables" before the names, and "Data point" before each row.
"""

from __future__ import annotations

import re
from itertools import pairwise

from erclutch.errors import LogError
from erclutch.logs.readers.cells import is_numeric
from erclutch.wings.rheology.rheometer_blocks import (
    Block,
    cells,
    delimiter_of,
    reader_of_blocks,
    require_as_many_names,
)

_STEP = "[step]"
_NEAR = 5  # lines from a step's mark to its first row: its name, names, units
_VARIABLES = "variables"
_POINT = "data point"
#: Of a file without the mark of a step, in small letters; a mark of UTF-8 may stand before it.
_HEAD = re.compile(r"\s*\ufeff?filename[\t,;][^\n]*\n(?:instrument|operator|sample)", re.ASCII)


def _blocks(content: str) -> list[Block] | None:
    """The table of each step that has points; None for a plain table below a head of TRIOS."""
    lines = content.splitlines()
    for number, line in enumerate(lines, start=1):
        bare = line.strip().lower()
        # A damaged mark, or a lost line end beside it, hides the step that begins here.
        if bare != _STEP and (bare.endswith(_STEP[1:]) or bare.startswith(_STEP)):
            part = _STEP[1:] if bare.endswith(_STEP[1:]) else _STEP
            problem = f"line {number} holds {part!r}, and the mark of a step is a line {_STEP}"
            raise LogError(problem, remedy="Correct that line")
    # A section with rows of numbers is a step, also where its mark is damaged.
    starts: list[int] = []
    for at, line in enumerate(lines):
        bare = line.strip()
        is_in_brackets = bare.startswith("[") and ("\t" not in bare or bare.endswith("]"))
        if not bare.lower().endswith(_STEP) and not is_in_brackets:
            continue
        soon = [cells(below, delimiter_of(below)) for below in lines[at + 1 : at + 1 + _NEAR]]
        has_numbers = any(len(row) > 1 and all(map(is_numeric, row)) for row in soon)
        if has_numbers or bare.lower() == _STEP:
            starts.append(at)
    blocks = [] if starts else _points(lines)
    for start, end in pairwise([*starts, len(lines)]):
        body = [at for at in range(start + 1, end) if lines[at].strip()]
        if len(body) < 4:
            continue  # a step without points
        named, *table = body
        delimiter = delimiter_of(lines[table[0]])
        names = cells(lines[table[0]], delimiter)
        units = cells(lines[table[1]], delimiter)
        points = table[2:]
        if any(map(is_numeric, units)):  # a table without units
            units = []
            points = table[1:]
        rows: list[list[str]] = []
        for at in points:
            if lines[at].lstrip().startswith("["):
                break  # the next section
            rows.append(cells(lines[at], delimiter))
        if rows and {*map(len, rows)} == {len(units)}:
            require_as_many_names(names, len(units), table[0] + 1)
        if rows:
            blocks.append(Block(lines[named].strip(), names, units, rows, points[0] + 1))
    if not blocks and _STEP not in content.lower():
        return None
    return blocks


def _points(lines: list[str]) -> list[Block]:
    """The table of a file without steps: rows that begin with "Data point"."""
    heads = [at for at, line in enumerate(lines) if line.lower().startswith(_VARIABLES)]
    if not heads:
        return []
    named = heads[0]
    delimiter = delimiter_of(lines[named])
    _, *names = cells(lines[named], delimiter)
    units: list[str] | None = None
    rows: list[list[str]] = []
    first = 0  # number of the first row
    for at in range(named + 1, len(lines)):
        if not lines[at].strip():
            continue
        mark, *row = cells(lines[at], delimiter)
        if mark.lower() == _POINT:
            first = first or at + 1
            rows.append(row)
        elif not mark and units is None:
            units = row
    if not rows:
        return []
    return [Block("points", names, units or [], rows, first)]


READER = reader_of_blocks(
    lambda text: (
        _STEP in text.lower()
        or "trios version" in text.lower()
        or _HEAD.match(text.lower()) is not None
    ),
    _blocks,
    "step",
)
