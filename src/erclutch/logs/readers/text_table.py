"""A text that holds one table is read in one column of steps, from its bytes to its columns.

The dialect is decided on the first lines (`dialect.sniff`); pandas' C parser reads the rest, rounding to the nearest
double. What goes wrong there is looked up a second time, line by line, so that the message can name line and column.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.log_reader import ROWS_WANTED, LogSource
from erclutch.logs.readers import first_bytes, numerals
from erclutch.logs.readers.budget import Budget
from erclutch.logs.readers.cells import DASHES, NO_NUMBERS
from erclutch.logs.readers.counted_periods import period_of_a_count
from erclutch.logs.readers.dialect import LINE_END, Dialect, sniff
from erclutch.logs.readers.header_pairs import sample_period
from erclutch.logs.readers.names_and_cells import last_name_without_a_cell
from erclutch.logs.readers.numerals import TwoDecimalMarksError, grouped_by_blanks, ungrouped
from erclutch.logs.readers.stated_units import with_stated_units
from erclutch.logs.readers.text_bytes import ToldBytes, decode, hidden_character
from erclutch.logs.readers.text_cells import have_ended, long_rows, refuse_ragged, without_torn_rows
from erclutch.logs.readers.text_columns import sorted_columns
from erclutch.logs.readers.text_put_right import put_right
from erclutch.logs.readers.text_rows import blocks_in, rows_of_body
from erclutch.logs.readers.told_units import texts_below, with_told_units
from erclutch.logs.table import Table

if TYPE_CHECKING:
    import pandas as pd


def read_text(source: LogSource) -> Table:
    """Read a text log.

    Raises:
        LogError: no text, no numbers, text in a number column (line and column are named), ragged rows.
    """
    # 1. Bytes become characters.
    text = decode(source.data)
    if not text.strip():
        raise LogError("the file is empty", remedy=ROWS_WANTED)
    other_format = first_bytes.named_text(text)
    if other_format:
        kind, remedy = other_format
        raise LogError(f"the file is {kind}, not a table", remedy=remedy)

    # 2. What loggers, instruments and people made of a table becomes rows again.
    text, changes = put_right(text)

    # 3. The lines above the rows and the numbers in them say how to read these.
    try:
        dialect, notes = weighed_dialect(text, source.decimal)
    except TwoDecimalMarksError:
        delimiter = sniff(text).delimiter
        text, with_commas = numerals.with_decimal_points(text, delimiter)
        in_rows = 0
        if not with_commas:
            text, in_rows = numerals.with_points_in_rows(text, delimiter)
            if not in_rows:
                raise
        dialect, notes = weighed_dialect(text, source.decimal)
        count = len(dialect.names)
        names = [dialect.names[column - 1] for column in with_commas if column <= count]
        where = f"in {in_rows} rows" if in_rows else f"in column {', '.join(names)}"
        if in_rows or names:
            notes.append(f"numbers have a decimal comma {where}, and a decimal point in the others")
    notes += changes

    # 4. The rows are cut out of the text.
    body, cut, below = rows_of_body(text, dialect)
    grouped = grouped_by_blanks(body, dialect.delimiter)
    if grouped:
        whole = ungrouped(grouped, dialect.decimal)
        notes.append(
            f"numbers have blanks or apostrophes between their thousands: {grouped} is {whole}"
        )

    # 5. Their cells become columns.
    return table_of_rows(body, dialect, source, [*cut, *notes], below)


def read_cells(source: LogSource, labels: Iterable[str], rows: Iterable[Sequence[str]]) -> Table:
    """Cells that a reader found in lines of another form are read on as a text that holds one table.

    Args:
        source: the file.
        labels: of the columns.
        rows: a cell for each label, "" where there is none.

    Raises:
        LogError: see `read_text`.
    """
    written = io.StringIO()
    table = csv.writer(written)
    table.writerow(labels)
    table.writerows(rows)
    return read_text(replace(source, data=written.getvalue().encode()))


def weighed_dialect(text: str, decimal: str | None) -> tuple[Dialect, list[str]]:
    """The dialect, its marks weighed over all rows of a text, and what to say of them."""
    dialect = sniff(text, decimal)
    Budget(0).take_names(len(dialect.names))
    body, *_ = rows_of_body(text, dialect)
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


def table_of_rows(
    body: str,
    dialect: Dialect,
    source: LogSource,
    notes_above: Sequence[str],
    below: Sequence[str] = (),
) -> Table:
    """The rows of a text as a table.

    Args:
        body: the rows as text.
        dialect: of the text.
        source: where it comes from.
        notes_above: a sentence on each change that made rows of the text.
        below: lines without a number below the rows.

    Raises:
        LogError: see `read_text`.
    """
    frame, body, torn, torn_rows = _parsed_without_torn_rows(body, dialect, source.told)
    notes = [*dialect.notes, *notes_above]
    if dialect.trailing:
        notes.append("each row ends in a delimiter: the empty last column is left out")
    notes += long_rows(frame, body, dialect)
    hidden = hidden_character(body)
    if hidden:
        line = dialect.first + 1 + len(LINE_END.findall(body, 0, hidden.start()))
        code = f"U+{ord(hidden.group()):04X}"
        notes.append(f"line {line} holds a hidden character ({code}): read as a blank")

    held = sorted_columns(frame, body, dialect)
    columns = held.columns
    notes += held.notes
    # Empty cells at the end of a row may be missing values, or a row that is too short: the lines tell.
    if columns:
        of_the_file = columns.keys() - {*held.of_lists} or {dialect.names[0]}
        last = max(of_the_file, key=dialect.names.index)
        empty = np.flatnonzero(np.isnan(columns[last])).tolist() if last in columns else []
        empty = [row for row in empty if row not in {*torn}]
        needed = dialect.names.index(last) + 1
        if empty and have_ended(body, dialect, empty, len(frame)):
            needed = 0
        refuse_ragged(body, dialect, empty, needed=min(needed, dialect.usual or needed))

    unsure_names = dialect.unsure_names
    if not unsure_names:
        unsure_names = last_name_without_a_cell(dialect.names, dialect.cells_below, held.hollow)
        notes += [unsure_names] if unsure_names else []

    # The lines above the rows say the units, and perhaps the time from row to row.
    units_of: dict[str, str | None] = {}
    for label, unit in zip(dialect.names, dialect.units, strict=True):
        if label in columns or label in held.constants or label in held.torn:
            units_of[label] = unit or held.units_behind.get(label)
    units_of |= dict.fromkeys(held.of_lists)
    period = None
    stated_period = sample_period(dialect.metadata)
    may_state_one = stated_period is None and bool(dialect.metadata)
    if may_state_one and not any(spoken_name(label).is_time for label in columns):
        stated_period = period_of_a_count(dialect.metadata, len(frame))
    if stated_period:
        period, key = stated_period
        notes.append(f"sampling period {period:g} s from '{key}' in the header")
    places = enumerate(dialect.names, start=1)
    table = Table(
        name=source.name,
        columns=columns,
        units=units_of,
        digest=source.digest,
        numbers={name: place for place, name in places if name in columns or name in held.torn},
        sample_period=period,
        clock=held.clock,
        clock_name=held.clock_name,
        constants=held.constants,
        metadata={**held.only_words, **dialect.metadata},
        notes=tuple(notes),
        unreadable=held.unreadable,
        torn=held.torn,
        torn_rows=torn_rows,
        hollow=held.hollow,
        breaks=blocks_in(body),
        words=held.words,
        row_names=held.row_names,
        unsure_names=unsure_names,
    )
    texts = [*dialect.metadata.items(), *texts_below(below)]
    return with_told_units(with_stated_units(table, dialect.metadata), texts)


def _parsed_without_torn_rows(
    body: str, dialect: Dialect, told: Callable[[int, int], None]
) -> tuple[pd.DataFrame, str, list[int], str]:
    """All rows, their text, which few of them have too many cells and are empty in both, and what is wrong."""
    try:
        frame = _parsed(body, dialect, told)
        if not frame.iloc[:, -1].notna().any():
            return frame, body, [], ""
    except LogError:
        frame = None
    without, torn, problem = without_torn_rows(body, dialect)
    if not torn and frame is not None:
        return frame, body, [], ""
    return _parsed(without, dialect, told), without, torn, problem


def _parsed(body: str, dialect: Dialect, told: Callable[[int, int], None]) -> pd.DataFrame:
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
    except Exception as error:
        # A ParserError; on hostile text also a MemoryError, an OverflowError and others.
        if source.interrupted:
            raise KeyboardInterrupt from error
        refuse_ragged(body, dialect)
        problem = f"the rows cannot be read as a table ({type(error).__name__}: {str(error).strip()[:120]})"
        raise LogError(problem, remedy="Check the quotes and delimiters of the file") from error
