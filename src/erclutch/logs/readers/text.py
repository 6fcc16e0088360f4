"""Text logs: CSV of any dialect, white-space tables, DAQ exports with a header block, plain or gzipped.

The dialect is decided on the first lines (`dialect.sniff`); pandas' C parser reads the rest, rounding to the nearest
double. What goes wrong there is looked up a second time, line by line, so that the message can name line and column.
"""

from __future__ import annotations

import gzip
import io
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.errors import LogError
from erclutch.logs import dates
from erclutch.logs.dialect import LINE_END, Dialect, cells_of, is_comment, sniff
from erclutch.logs.labels import sample_period
from erclutch.logs.table import Table
from erclutch.signals import Array

if TYPE_CHECKING:
    import pandas as pd

_LARGEST = 1 << 32  # bytes after decompression
_CONTROL = bytes(set(range(32)) - set(b"\t\n\r\f\v\x1a"))


def decode(data: bytes, name: str) -> str:
    """Text of a log file: gzip undone, UTF-8 or UTF-16 (with or without mark), else Latin-1.

    Raises:
        LogError: the bytes are no text.
    """
    if data[:2] == b"\x1f\x8b":
        data = _unzip(data, name)
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        encoding = "utf-16"
    elif len(data) > 3 and data[1:2000:2].count(0) > 0.8 * len(data[1:2000:2]) and data[0]:
        encoding = "utf-16-le"
    elif len(data) > 3 and data[0:2000:2].count(0) > 0.8 * len(data[0:2000:2]) and data[1]:
        encoding = "utf-16-be"
    else:
        encoding = "utf-8-sig"
        head = data[:65536]
        odd = len(head) - len(head.translate(None, _CONTROL))
        if b"\0" in data or odd > 0.01 * len(head):
            raise _not_text(name)
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        if encoding != "utf-8-sig":
            raise _not_text(name) from None
        return data.decode("latin-1")


def _not_text(name: str) -> LogError:
    return LogError(
        "the file holds binary data, not text",
        remedy="Export it as CSV, or give a .mat (MATLAB) or .parquet file",
        where=name,
    )


def _unzip(data: bytes, name: str) -> bytes:
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as file:
            text = file.read(_LARGEST)
    except (OSError, EOFError, zlib.error) as error:
        raise LogError(f"the gzip data is damaged ({error})", remedy="Copy the file again", where=name) from error
    if len(text) == _LARGEST:
        raise LogError("the file unpacks to more than 4 GiB", remedy="Split the log", where=name)
    return text


def read_text(data: bytes, name: str, digest: str) -> Table:
    """Read a text log from its bytes.

    Args:
        data: the whole file.
        name: the file's name, for messages.
        digest: SHA-256 of the file.

    Raises:
        LogError: no text, no numbers, text in a number column (line and column are named), ragged rows.
    """
    text = decode(data, name)
    if not text.strip():
        raise LogError("the file is empty", remedy="Give a log with one row a sample", where=name)
    dialect = sniff(text, name)
    body, cut = _body(text, dialect)
    frame = _parse(body, dialect, name)
    return _table(frame, body, dialect, name, digest, cut)


def _body(text: str, dialect: Dialect) -> tuple[str, bool]:
    """The text from the first row on without comment lines, and whether a last row that was cut off is left out."""
    start = 0
    for _ in range(dialect.first):
        match = LINE_END.search(text, start)
        start = match.end() if match else start
    body = text[start:]
    if any(mark in body for mark in ("#", "%", "//")):
        lines = LINE_END.split(body)
        body = "\n".join("" if is_comment(line) else line for line in lines)  # blank: line numbers stay right
    last = max(body.rfind("\n"), body.rfind("\r")) + 1
    needed = max((index for index, numeric in enumerate(dialect.numeric) if numeric), default=0)
    unfinished = 0 < last < len(body) and len(cells_of(body[last:], dialect.delimiter)) <= needed
    return (body[:last], True) if unfinished and body[last:].strip() else (body, False)


def _parse(body: str, dialect: Dialect, name: str) -> pd.DataFrame:
    """All rows as pandas reads them; one column more than named shows rows that are too long."""
    import pandas as pd

    options: dict[str, Any] = {}
    if tuple(int(part) for part in pd.__version__.split(".")[:2]) < (3, 1):
        options["float_precision"] = "round_trip"  # later versions always round correctly
    width = len(dialect.names) + dialect.trailing + 1
    try:
        read_csv: Any = pd.read_csv  # its overloads do not take a mapping of options
        frame: pd.DataFrame = read_csv(
            io.BytesIO(body.encode("utf-8", "replace")),
            sep=dialect.delimiter or r"\s+",
            decimal=dialect.decimal,
            header=None,
            names=list(range(width)),
            index_col=False,
            skipinitialspace=True,
            low_memory=False,
            engine="c",
            **options,
        )
        return frame
    except Exception as error:  # ParserError, but also MemoryError, OverflowError and others on hostile text
        _find_ragged(body, dialect, name, [])
        problem = f"the rows cannot be read as a table ({type(error).__name__}: {str(error).strip()[:120]})"
        raise LogError(problem, remedy="Check the quotes and delimiters of the file", where=name) from error


def _table(frame: pd.DataFrame, body: str, dialect: Dialect, name: str, digest: str, cut: bool) -> Table:
    """Sort the columns into numbers, header constants, a clock and text left out."""
    columns: dict[str, Array] = {}
    constants: dict[str, float] = {}
    notes = list(dialect.notes)
    clock: tuple[str, Array] | None = None
    if cut:
        notes.append("the last row was cut off in the middle: left out")
    if dialect.trailing:
        notes.append("each row ends in a delimiter: the empty last column is left out")
    if frame.iloc[:, len(dialect.names) :].notna().to_numpy().any():
        _find_ragged(body, dialect, name, [])
    for index, label in enumerate(dialect.names):
        cells = frame.iloc[:, index]
        values = _numbers(cells, index, body, dialect, name)
        if values is None:
            stamps = dates.seconds(cells) if clock is None else None
            clock = (label, stamps) if stamps is not None else clock
            if stamps is None:
                notes.append(f"column {label} holds text in {int(cells.notna().sum())} of {len(cells)} rows: left out")
            continue
        filled = int(np.count_nonzero(~np.isnan(values)))
        if filled == 0 and len(values) > 0:
            notes.append(f"column {label} is empty: left out")
        elif filled == 1 < len(values) and not np.isnan(values[0]):
            constants[label] = float(values[0])
            notes.append(f"column {label} is filled in its first row only: kept as the constant {values[0]:g}")
        else:
            columns[label] = values
    _refuse_short_rows(columns, body, dialect, name)
    kept = {*columns, *constants}
    period = sample_period(dialect.metadata)
    if period:
        notes.append(f"sampling period {period[0]:g} s from '{period[1]}' in the header")
    return Table(
        name=name,
        columns=columns,
        units={label: unit for label, unit in zip(dialect.names, dialect.units, strict=True) if label in kept},
        digest=digest,
        numbers={label: place for place, label in enumerate(dialect.names, start=1) if label in columns},
        sample_period=period[0] if period else None,
        clock=clock[1] if clock else None,
        clock_name=clock[0] if clock else "",
        constants=constants,
        metadata=dialect.metadata,
        notes=tuple(notes),
    )


def _numbers(cells: pd.Series[Any], index: int, body: str, dialect: Dialect, name: str) -> Array | None:
    """The column as float64, or None if it is a column of text.

    Raises:
        LogError: a cell with text among numbers.
    """
    import pandas as pd

    if pd.api.types.is_numeric_dtype(cells.dtype):
        return np.ascontiguousarray(cells.to_numpy(dtype=np.float64))
    filled = cells.notna().to_numpy()
    texts = cells.astype(str).str.strip()
    plain = texts.str.replace(",", ".", regex=False) if dialect.decimal == "," else texts
    values = pd.to_numeric(plain.where(filled), errors="coerce").to_numpy(dtype=np.float64)
    bad = filled & np.isnan(values)
    if 2 * int(bad.sum()) > int(filled.sum()) and not dialect.numeric[index]:
        return None
    if not bad.any():
        return values
    row = int(np.argmax(bad))
    line = _line_numbers(body, dialect)[row]
    label = dialect.names[index]
    raise LogError(
        f"line {line}, column {label} is '{str(texts.iloc[row])[:40]}' where a number is expected"
        + (f" ({int(bad.sum())} such cells)" if bad.sum() > 1 else ""),
        remedy="Correct or empty that cell, or delete the line",
        where=name,
    )


def _line_numbers(body: str, dialect: Dialect) -> list[int]:
    """Line in the file, counted from 1, of each row."""
    return [dialect.first + 1 + at for at, line in enumerate(LINE_END.split(body)) if line.strip()]


def _refuse_short_rows(columns: dict[str, Array], body: str, dialect: Dialect, name: str) -> None:
    """Empty cells at the end of a row may be a missing value or a row that is too short; only the lines can tell."""
    last = next((label for label in reversed(dialect.names) if label in columns), None)
    empty = [] if last is None else np.flatnonzero(np.isnan(columns[last])).tolist()
    if last is not None and empty:
        _find_ragged(body, dialect, name, empty, needed=dialect.names.index(last) + 1)


def _find_ragged(body: str, dialect: Dialect, name: str, rows: list[int], needed: int | None = None) -> None:
    """Raise for the first row with a wrong number of cells; look at the given rows only, or at all."""
    width = len(dialect.names) + dialect.trailing
    lines = [(dialect.first + 1 + at, line) for at, line in enumerate(LINE_END.split(body)) if line.strip()]
    for number, line in (lines[row] for row in rows if row < len(lines)) if needed else lines:
        cells = cells_of(line, dialect.delimiter)
        extra = [cell for cell in cells[width:] if cell]
        if extra or (needed is not None and len(cells) < needed):
            hint = " (a decimal comma?)" if extra and dialect.delimiter == "," and dialect.decimal == "." else ""
            raise LogError(
                f"line {number} has {len(cells)} cells where {len(dialect.names)} are expected{hint}",
                remedy="Correct or delete that line",
                where=name,
            )
