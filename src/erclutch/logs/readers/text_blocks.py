"""A text that is larger than memory is read in blocks of rows; the dialect is that of its first lines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers.cells import is_comment
from erclutch.logs.readers.dialect import LINE_END, SAMPLE, sniff
from erclutch.logs.readers.text_bytes import opened, text_size
from erclutch.logs.readers.text_cells import BLANK
from erclutch.logs.readers.text_table import table_of_rows, weighed_dialect
from erclutch.logs.readers.text_tables import read_tables
from erclutch.logs.table import Table


def text_windows(
    source: LogSource,
    rows: int,
    margin: int,
    first: int = 0,
    last: int | None = None,
) -> Iterator[tuple[int, int, Table]]:
    """A text log of any length as overlapping tables; the dialect is that of its first lines. See `log_reader.Windows`.

    Raises:
        LogError: see `read_text`; a time in words or numbers above the rows, which no later window has.
    """
    head = _head_of(source.path)
    dialect, notes = weighed_dialect(head, source.decimal)
    with opened(source.path) as text:
        for _ in range(dialect.first):
            next(text, "")
        lines = (line for line in text if line.strip(BLANK) and not is_comment(line))
        held: list[str] = []
        held_from = max(first - margin, 0)  # row of the file, as all that follows
        next(islice(lines, held_from, held_from), None)  # skips the lines before
        start = first
        ended = False
        while not ended:
            # The last window stands for up to twice as many rows, so it is known two windows ahead.
            reached = start + 2 * rows
            if last is not None:
                reached = min(reached, last)
            held += islice(lines, max(reached + margin - held_from - len(held), 0))
            known = held_from + len(held)
            ended = known < reached + margin or reached == last
            stop = start + rows
            if ended:
                stop = known if last is None else min(known, last)
            body = "".join(held[: stop + margin - held_from])
            # Errors count lines as if none above them was blank.
            here = replace(dialect, first=dialect.first + held_from)
            table = table_of_rows(body, here, source, notes)
            # Dates count from the first row of a window, and a constant stands in the first window only.
            if table.clock is not None or table.constants:
                what = "a column has one number"
                if table.clock is not None:
                    what = f"the time {table.clock_name!r} is no number"
                problem = f"{what}, which a text that is read in blocks cannot have"
                raise LogError(problem, remedy="Write it as Parquet")
            table = replace(table, first_row=held_from)
            if not start:
                _refuse_another_reading(source, head, table)
            yield start, stop, table
            start = stop
            drop = max(stop - margin - held_from, 0)
            held = held[drop:]
            held_from += drop


def _refuse_another_reading(source: LogSource, head: str, first: Table) -> None:
    """Hold the first rows that are read in blocks against those of a text that is read whole.

    Raises:
        LogError: they differ: tables that lie or stand beside each other, rows of words, units in cells.
    """
    lines = head if len(head) <= SAMPLE else head[: head.rfind("\n") + 1]
    remedy = "Give a larger --memory, so that it is read whole, or write it as Parquet with a column for each signal"
    try:
        whole = read_tables(replace(source, data=lines.encode(), variable=None))
    except LogError as error:
        raise LogError(f"in blocks it cannot be read: {error.problem}", remedy=remedy) from error
    rows = min(whole.rows, first.rows)
    same = list(whole.columns) == list(first.columns) and whole.units == first.units and rows > 0
    for name in whole.columns if same else ():
        same = same and np.array_equal(
            whole.columns[name][:rows], first.columns[name][:rows], equal_nan=True
        )
    if not same:
        problem = f"read whole, its first rows have the columns {whole.listed}, and in blocks {first.listed}"
        if list(whole.columns) == list(first.columns):
            problem = "read whole, its first rows have other numbers or units than in blocks"
        raise LogError(problem, remedy=remedy)


def text_extent(path: Path) -> tuple[int, int]:
    """Rows and columns of a text log: rows by its size over the mean length of its first lines.

    Raises:
        LogError: the first lines are no table of numbers.
    """
    head = _head_of(path)
    lines = len(LINE_END.findall(head)) + 1
    bytes_of_head = max(len(head.encode("utf-8", "replace")), 1)
    rows = -(-text_size(path) * lines // bytes_of_head)
    return rows, len(sniff(head).names)


def _head_of(path: Path) -> str:
    """More characters than `sniff` looks at."""
    with opened(path) as text:
        return text.read(SAMPLE + 1)
