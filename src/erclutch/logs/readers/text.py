"""Text logs are CSV of any dialect, white-space tables, or DAQ exports with a header block, plain or gzipped.

The dialect is decided on the first lines (`dialect.sniff`); pandas' C parser reads the rest, rounding to the nearest
double. What goes wrong there is looked up a second time, line by line, so that the message can name line and column.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.word_columns import names_of_rows, parting_note, words_of
from erclutch.logs.log_reader import ROWS_WANTED, LogReader, LogSource, claims_nothing
from erclutch.logs.readers import dates, first_bytes, found_recordings, numerals
from erclutch.logs.readers.budget import Budget
from erclutch.logs.readers.cells import DASHES, NO_NUMBERS, is_comment
from erclutch.logs.readers.dialect import LINE_END, SAMPLE, Dialect, sniff
from erclutch.logs.readers.header_pairs import sample_period
from erclutch.logs.readers.keyed_heads import with_keyed_heads
from erclutch.logs.readers.list_cells import without_lists
from erclutch.logs.readers.loose_text import (
    with_a_line_of_names,
    without_brackets,
    without_matrix,
    without_rules,
)
from erclutch.logs.readers.lying_tables import upright
from erclutch.logs.readers.numerals import (
    TwoDecimalMarksError,
    grouped_by_blanks,
    ungrouped,
    with_plain_digits,
    with_plain_minus,
)
from erclutch.logs.readers.pivoted_tables import with_pivoted_heads
from erclutch.logs.readers.serial_monitor import with_stamps_in_cells
from erclutch.logs.readers.side_by_side import read_side_by_side
from erclutch.logs.readers.spread_cells import without_spread_in_cells
from erclutch.logs.readers.stated_units import with_stated_units
from erclutch.logs.readers.text_bytes import (
    DAMAGE,
    ToldBytes,
    decode,
    hidden_character,
    opened,
    text_size,
    unbroken,
    with_whole_names,
    without_row_marks,
)
from erclutch.logs.readers.text_cells import BLANK, CORRECT, long_rows, read_cells, refuse_ragged
from erclutch.logs.readers.text_rows import blocks_in, rows_of_body
from erclutch.logs.readers.text_tables import read_tables
from erclutch.logs.readers.unit_cells import units_beside, without_units_in_cells
from erclutch.logs.readers.unit_columns import with_units_in_cells
from erclutch.logs.readers.waveform_lines import with_steps_above
from erclutch.logs.table import Table
from erclutch.signals.array import Array

if TYPE_CHECKING:
    import pandas as pd


def read_text(source: LogSource) -> Table:
    """Read a text log.

    Raises:
        LogError: no text, no numbers, text in a number column (line and column are named), ragged rows.
    """
    text = decode(source.data)
    if not text.strip():
        raise LogError("the file is empty", remedy=ROWS_WANTED)
    other_format = first_bytes.named_text(text)
    if other_format:
        kind, remedy = other_format
        raise LogError(f"the file is {kind}, not a table", remedy=remedy)

    text, put_right = _put_right(text)
    try:
        dialect, notes = _dialect_of(text, source.decimal)
    except TwoDecimalMarksError:
        delimiter = sniff(text).delimiter
        text, with_commas = numerals.with_decimal_points(text, delimiter)
        in_rows = 0
        if not with_commas:
            text, in_rows = numerals.with_points_in_rows(text, delimiter)
            if not in_rows:
                raise
        dialect, notes = _dialect_of(text, source.decimal)
        if in_rows:
            notes.append(
                f"numbers have a decimal comma in {in_rows} rows, and a decimal point in the others"
            )
        names = [
            dialect.names[column - 1] for column in with_commas if column <= len(dialect.names)
        ]
        if names:
            listed_names = ", ".join(names)
            notes.append(
                f"numbers have a decimal comma in column {listed_names}, and a decimal point in the others"
            )
    notes += put_right

    body, cut = rows_of_body(text, dialect)
    grouped = grouped_by_blanks(body, dialect.delimiter)
    if grouped:
        whole = ungrouped(grouped, dialect.decimal)
        notes.append(
            f"numbers have blanks or apostrophes between their thousands: {grouped} is {whole}"
        )
    frame = _parse(body, dialect, source.told)
    return _table(frame, body, dialect, source, [*cut, *notes])


def _put_right(text: str) -> tuple[str, list[str]]:
    """The text as a table of rows, whatever its logger made of these; and a note on each change.

    A search for one character is fast: most texts have none of these marks, and need no further look.
    """
    notes: list[str] = []
    if " -> " in text:
        text, stamps_in_cells = with_stamps_in_cells(text)
        notes.append(stamps_in_cells)
    if not text.isascii():
        text, digits = with_plain_digits(text)
        notes.append(digits)
    if not text.isascii():
        text, other_minus = with_plain_minus(text)
        notes.append(other_minus)
    if "]" in text:
        text, matrix = without_matrix(text)
        notes.append(matrix)
    if ";" in text:
        text = without_row_marks(text)
    broken_cells = 0
    if '"' in text:
        text, broken_cells = unbroken(text)
        text = with_whole_names(text)
    if "[" in text:
        text, brackets = without_brackets(text)
        notes.append(brackets)
    for change in (
        without_rules,
        with_steps_above,
        with_a_line_of_names,
        without_spread_in_cells,
        with_units_in_cells,
        without_units_in_cells,
        with_keyed_heads,
        upright,
        with_pivoted_heads,
    ):
        text, note = change(text)
        notes.append(note)
    if broken_cells:
        notes.append(
            f"{broken_cells} quoted cells hold a number and a line end: the line end is left out"
        )
    return text, [note for note in notes if note]


def _dialect_of(text: str, decimal: str | None) -> tuple[Dialect, list[str]]:
    """The dialect, its marks weighed over all rows of a text, and what to say of them."""
    dialect = sniff(text, decimal)
    Budget(0).take_names(len(dialect.names))
    body, _ = rows_of_body(text, dialect)
    written = numerals.weigh(body, dialect.delimiter, dialect.decimal, decimal)
    if written.decimal != dialect.decimal:
        dialect = sniff(text, written.decimal)
    if not written.thousands:
        return dialect, []

    mark = {".": "points", ",": "commas"}[written.thousands]
    note = f"numbers have {mark} between their thousands"
    whole = ungrouped(written.reason, written.decimal) if written.reason else ""
    if whole:
        note += f": {written.reason} is {whole}"
    return replace(dialect, thousands=written.thousands), [note]


def _parse(
    body: str,
    dialect: Dialect,
    told: Callable[[int, int], None],
) -> pd.DataFrame:
    """All rows as pandas reads them; one column more than named shows rows that are too long."""
    import pandas as pd

    # Later versions always round correctly.
    major, minor = pd.__version__.split(".")[:2]
    exact = (int(major), int(minor)) >= (3, 1)
    options: dict[str, Any] = {} if exact else {"float_precision": "round_trip"}
    width = len(dialect.names) + dialect.trailing + 1
    source = ToldBytes(body.encode("utf-8", "replace"), told)
    try:
        read_csv: Any = pd.read_csv  # its overloads do not take a mapping of options
        frame: pd.DataFrame = read_csv(
            source,
            sep=dialect.delimiter or r"\s+",
            decimal=dialect.decimal,
            thousands=dialect.thousands or None,
            header=None,
            names=list(range(width)),
            index_col=False,
            skipinitialspace=True,
            na_values=(*NO_NUMBERS, *DASHES),
            low_memory=False,
            engine="c",
            **options,
        )
        return frame
    except (
        Exception
    ) as error:  # ParserError, but also MemoryError, OverflowError and others on hostile text
        if source.interrupted:
            raise KeyboardInterrupt from error
        refuse_ragged(body, dialect)
        problem = f"the rows cannot be read as a table ({type(error).__name__}: {str(error).strip()[:120]})"
        raise LogError(problem, remedy="Check the quotes and delimiters of the file") from error


def _table(
    frame: pd.DataFrame,
    body: str,
    dialect: Dialect,
    source: LogSource,
    cut: list[str],
) -> Table:
    """Sort the columns into numbers, header constants, a clock and text left out."""
    notes = [*dialect.notes, *cut]
    if dialect.trailing:
        notes.append("each row ends in a delimiter: the empty last column is left out")
    notes += long_rows(frame, body, dialect)
    hidden = hidden_character(body)
    if hidden:
        line = dialect.first + 1 + len(LINE_END.findall(body, 0, hidden.start()))
        notes.append(
            f"line {line} holds a hidden character (U+{ord(hidden.group()):04X}): read as a blank"
        )

    columns: dict[str, Array] = {}
    constants: dict[str, float] = {}
    hollow: list[str] = []
    texts: dict[str, pd.Series[Any]] = {}
    unreadable: dict[str, str] = {}
    for index, label in enumerate(dialect.names):
        cells = frame.iloc[:, index]
        try:
            values, told = read_cells(cells, index, body, dialect)
        except LogError as error:
            unreadable[label] = error.problem
            continue
        notes += told
        if values is None:
            texts[label] = cells
            continue
        filled = int(np.count_nonzero(~np.isnan(values)))
        if filled == 0 and len(values) > 0:
            hollow.append(label)
            notes.append(f"column {label} is empty: left out")
        elif filled == 1 < len(values) and not np.isnan(values[0]):
            constants[label] = float(values[0])
            notes.append(
                f"column {label} is filled in its first row only: kept as the constant {values[0]:g}"
            )
        else:
            columns[label] = values

    of_lists, told_of_lists = without_lists(texts)
    columns |= {name: values for name, values in of_lists.items() if name not in columns}
    notes += told_of_lists
    clock_name, clock = dates.clock_of(texts)
    words = words_of(texts)
    units_behind = units_beside(dialect.names, texts)
    for label, unit in units_behind.items():
        notes.append(f"column {label} is in {unit}, as the column behind it says")
    for label, cells in texts.items():
        if label in (clock_name, *clock_name.split(" and ")):
            continue
        present = cells.dropna()
        first = str(present.iloc[0]).strip()[:30] if len(present) else ""
        unreadable[label] = (
            f"column {label} holds text ({first!r}) in {len(present)} of {len(cells)} rows"
        )
        notes.append(
            parting_note(label, words[label])
            if label in words
            else f"{unreadable[label]}: left out"
        )
    if unreadable and not columns:
        raise LogError(next(iter(unreadable.values())), remedy=CORRECT)
    notes += [
        f"column {label} is left out: {problem}"
        for label, problem in unreadable.items()
        if label not in texts
    ]

    # Empty cells at the end of a row may be missing values, or a row that is too short: the lines tell.
    if columns:
        of_the_file = set(columns) - set(of_lists) or {dialect.names[0]}
        last = max(of_the_file, key=dialect.names.index)
        empty = np.flatnonzero(np.isnan(columns[last])).tolist() if last in columns else []
        needed = dialect.names.index(last) + 1
        refuse_ragged(body, dialect, empty, needed=min(needed, dialect.usual or needed))
    period = None
    stated = sample_period(dialect.metadata)
    if stated:
        period, key = stated
        notes.append(f"sampling period {period:g} s from '{key}' in the header")
    kept = {*columns, *constants}
    stated_units = dict(zip(dialect.names, dialect.units, strict=True))
    units_of = {
        label: unit or units_behind.get(label)
        for label, unit in stated_units.items()
        if label in kept
    }
    units_of |= dict.fromkeys(of_lists)
    table = Table(
        name=source.name,
        columns=columns,
        units=units_of,
        digest=source.digest,
        numbers={
            label: place for place, label in enumerate(dialect.names, start=1) if label in columns
        },
        sample_period=period,
        clock=clock,
        clock_name=clock_name,
        constants=constants,
        metadata=dialect.metadata,
        notes=tuple(notes),
        unreadable=unreadable,
        hollow=tuple(hollow),
        breaks=blocks_in(body),
        words=words,
        row_names=names_of_rows(texts),
    )
    return with_stated_units(table, dialect.metadata)


# --- a text that is larger than memory --------------------------------------------------------------------------------


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
    dialect, notes = _dialect_of(head, source.decimal)
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
            table = _window_of(source, held[: stop + margin - held_from], held_from, dialect, notes)
            if not start:
                _refuse_another_reading(source, head, table)
            yield start, stop, table
            start = stop
            drop = max(stop - margin - held_from, 0)
            held = held[drop:]
            held_from += drop


def _window_of(
    source: LogSource,
    lines: Sequence[str],
    first_row: int,
    dialect: Dialect,
    notes: list[str],
) -> Table:
    """The table of some lines; errors count lines as if none above them was blank."""
    body = "".join(lines)
    here = replace(dialect, first=dialect.first + first_row)
    table = _table(_parse(body, here, lambda done, total: None), body, here, source, notes)
    # Dates count from the first row of a window, and a constant stands in the first window only.
    if table.clock is not None or table.constants:
        what = (
            f"the time {table.clock_name!r} is no number"
            if table.clock is not None
            else "a column has one number"
        )
        raise LogError(
            f"{what}, which a text that is read in blocks cannot have", remedy="Write it as Parquet"
        )
    return replace(table, first_row=first_row)


def _refuse_another_reading(source: LogSource, head: str, first: Table) -> None:
    """Hold the first rows that are read in blocks against those of a text that is read whole.

    Raises:
        LogError: they differ: tables that lie or stand beside each other, rows of words, units in cells.
    """
    lines = head if len(head) <= SAMPLE else head[: head.rfind("\n") + 1]
    remedy = "Give a larger --memory, so that it is read whole, or write it as Parquet with a column for each signal"
    try:
        whole = _read(replace(source, data=lines.encode(), variable=None))
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


def _read(source: LogSource) -> Table:
    return read_side_by_side(source, read_text) or read_tables(source, read_text)


READER = LogReader(
    suffixes=(".csv", ".txt", ".tsv", ".dat", ".asc", ".log"),
    claims=claims_nothing,
    read=_read,
    windows=text_windows,
    extent=text_extent,
    recordings=found_recordings.names_by(_read),
    tells_damage=DAMAGE,
)
