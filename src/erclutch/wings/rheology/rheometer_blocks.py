"""Exports of rheometers hold several tables under each other, each with a header of its own: this cuts them apart.

A table is read on as a text log is, so that decimal commas, dates and texts are understood in one place.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from erclutch.errors import LogError, placed
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers import found_recordings, text
from erclutch.logs.table import Table


@dataclass(frozen=True)
class Block:
    """One table of an export, as texts.

    Attributes:
        name: of the test, and of its interval where it has several.
        names: of the columns.
        units: of the columns, "" for none; in brackets or bare.
        rows: cells of each row.
        line: of the first row in the file, counted from 1.
    """

    name: str
    names: Sequence[str]
    units: Sequence[str]
    rows: Sequence[Sequence[str]]
    line: int


def cells(line: str, delimiter: str) -> list[str]:
    """Cells of a line without blanks around them; a quoted cell may hold the delimiter."""
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), list[str]())]


def delimiter_of(line: str) -> str:
    """The delimiter of a line of names: the one of tab, semicolon and comma that cuts it most."""
    return max("\t;,", key=line.count)


def chosen_table(source: LogSource, blocks: Sequence[Block], what: str) -> Table:
    """The table of the block that is wanted.

    Args:
        source: says which.
        blocks: all that the file holds.
        what: one of them is called in messages.

    Raises:
        LogError: the file holds no table, or several and none was named.
    """
    if not blocks:
        raise LogError("the export holds no table of numbers", remedy="Export the table of measured points")
    by_name = {_unique(block.name, index, blocks): block for index, block in enumerate(blocks)}
    name, block = found_recordings.choose(by_name, source.variable, what, "the export holds no test")
    note = (f"recording read from {what} {name}, 1 of {len(blocks)}",) if len(blocks) > 1 else ()
    table = _table(source, block)
    return replace(table, notes=(*note, *table.notes))


def _unique(name: str, index: int, blocks: Sequence[Block]) -> str:
    """The name of a block, with its place where an earlier block has the same name."""
    earlier = sum(block.name == name for block in blocks[:index])
    return f"{name} ({earlier + 1})" if earlier else name


def _table(source: LogSource, block: Block) -> Table:
    width = len(block.names)
    usual = Counter(map(len, block.rows)).most_common(1)[0][0]  # a lost delimiter makes a row short
    for number, row in enumerate(block.rows, start=block.line):
        if any(row[width:]) or len(row) < min(usual, width):
            problem = f"line {number} has {len(row)} cells where {width} are expected"
            raise LogError(problem, remedy="Correct or delete that line")
    bare = [unit.strip("[]() ") for unit in (*block.units, *[""] * width)][:width]
    labels = [f"{name} [{unit}]" if unit else name for name, unit in zip(block.names, bare, strict=True)]
    rows = [[*row, *[""] * width][:width] for row in block.rows]
    lines = ["\t".join(_plain(cell) for cell in row) for row in (labels, *rows)]
    with placed(f"{source.name}, table from line {block.line} on"):
        return text.read_text(replace(source, data="\n".join(lines).encode("utf-8"), variable=None))


def _plain(cell: str) -> str:
    """A cell that neither ends its line nor its column, and that starts no comment."""
    return " ".join(cell.replace('"', "'").split()).lstrip("#")
