"""Exports of rheometers hold several tables under each other, each with a header of its own: this cuts them apart.

A table is read on as a text log is, so that decimal commas, dates and texts are understood in one place.
"""

from __future__ import annotations

import codecs
import csv
import itertools
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from erclutch.errors import LogError, placed
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.text_bytes import DAMAGE, decode
from erclutch.logs.readers.text_table import read_text
from erclutch.logs.readers.text_tables import read_tables
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

    def is_filled(self, column: int) -> bool:
        """Whether a row has something in a column."""
        return any(column < len(row) and row[column] for row in self.rows)

    def with_columns(self, kept: Sequence[int]) -> Block:
        """The table with these columns alone. Cells beyond the last name stay: a row with too many is refused later."""
        rows: list[list[str]] = []
        for row in self.rows:
            cells_kept = [row[column] if column < len(row) else "" for column in kept]
            rows.append([*cells_kept, *row[len(self.names) :]])
        names = [self.names[column] for column in kept]
        units = [self.units[column] for column in kept] if self.units else []
        return replace(
            self,
            names=names,
            units=units,
            rows=rows,
        )


def cells(line: str, delimiter: str) -> list[str]:
    """Cells of a line without blanks around them; a quoted cell may hold the delimiter."""
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), list[str]())]


def require_as_many_names(names: Sequence[str], cells_below: int, line: int) -> None:
    """Refuse a line with more names than each line below it has cells: a delimiter too many moves the names behind it.

    Args:
        names: of the line; delimiters at its end are none.
        cells_below: of each line below.
        line: its number.

    Raises:
        LogError: there are more names.
    """
    named = max((place + 1 for place, name in enumerate(names) if name), default=0)
    if named > cells_below:
        problem = f"line {line} has {named} names, and each line below has {cells_below} cells"
        raise LogError(
            problem, remedy="Correct the line of names, or end each row with empty cells"
        )


def delimiter_of(line: str) -> str:
    """The delimiter of a line of names: the one of tab, semicolon and comma that cuts it most."""
    return max("\t;,", key=line.count)


def reader_of_blocks(
    claims: Callable[[str], bool],
    blocks_of: Callable[[str], list[Block] | None],
    what: str,
    note: str = "",
) -> LogReader:
    """A reader of texts that hold several tables.

    Args:
        claims: whether it reads a file that begins with such a text.
        blocks_of: the tables of a text; None for a plain table below a head of the instrument.
        what: one of them is called in messages.
        note: said of each table.
    """

    def claims_head(head: bytes) -> bool:
        is_wide = head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        if is_wide:
            return claims(head.decode("utf-16", errors="replace"))
        return claims(head.replace(b"\0", b"").decode("utf-8", errors="replace"))

    def read(source: LogSource) -> Table:
        blocks = blocks_of(decode(source.data))
        if blocks is None:
            return read_tables(source)
        if not blocks:
            raise LogError(
                "the export holds no table of numbers", remedy="Export the table of measured points"
            )
        by_name: dict[str, Block] = {}
        counts: Counter[str] = Counter()
        for block in blocks:
            counts[block.name] += 1
            count = counts[block.name]
            by_name[f"{block.name} ({count})" if count > 1 else block.name] = block
        name, chosen = found_recordings.choose(
            by_name, source.variable, what, "the export holds no test"
        )
        # The block is read as a text log of its own, with tabs between its cells.
        width = len(chosen.names)
        lengths = Counter(map(len, chosen.rows))
        ((usual, _),) = lengths.most_common(1)  # a lost delimiter makes a row short
        for number, row in enumerate(chosen.rows, start=chosen.line):
            if any(row[width:]) or len(row) < min(usual, width):
                problem = f"line {number} has {len(row)} cells where {width} are expected"
                raise LogError(problem, remedy="Correct or delete that line")
        labels: list[str] = []
        for name_of_column, unit in itertools.zip_longest(
            chosen.names, chosen.units[:width], fillvalue=""
        ):
            bare = unit.strip("[]() ")
            labels.append(f"{name_of_column} [{bare}]" if bare else name_of_column)
        missing = [""] * width
        rows = [[*row, *missing][:width] for row in chosen.rows]
        lines: list[str] = []
        for row in (labels, *rows):
            # No cell ends its line or its column, and none starts a comment.
            plain = [" ".join(cell.replace('"', "'").split()).lstrip("#") for cell in row]
            lines.append("\t".join(plain))
        written = "\n".join(lines).encode("utf-8")
        with placed(f"{source.name}, table from line {chosen.line} on"):
            table = read_text(replace(source, data=written, variable=None))

        notes = [note] if note else []
        if len(blocks) > 1:
            notes.append(f"recording read from {what} {name}, 1 of {len(blocks)}")
        return replace(table, notes=(*notes, *table.notes))

    return LogReader(
        suffixes=(),
        claims=claims_head,
        read=read,
        recordings=found_recordings.names_by(read),
        tells_damage=DAMAGE,
    )
