"""Parquet logs give their numeric columns. Units come from a field's metadata ``unit`` or from a label ``V [cm/s]``.

The library decodes in a child process: a damaged file once ended the whole process.
"""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import accumulate
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.labels import name_columns
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import child_process, found_recordings
from erclutch.logs.readers.budget import MEMORY, RAISED, Budget, budget_of
from erclutch.logs.table import Table, of_arrow
from erclutch.signals.array import Array

MAGIC = b"PAR1"
_PAGES = 1 << 20  # bytes of a column that are read ahead: without, a whole row group is
_READ = 65_536  # rows
# Three numbers and the beginning of a fourth, in Thrift's compact protocol.
_CHECKED_PAGE = re.compile(rb"(?:\x15[\x80-\xff]*[\x00-\x7f]){3}\x15")
_UNCHECKED = "the file has no checksums: damaged numbers in it cannot be told from good ones"
_ANEW = "Copy the file again or export it as CSV"
_IN_PIECES = "Give it to erclutch fit, which reads such a file in blocks, or split it"
_ROWS_WANTED = "Give a log with one row a sample"


def read_parquet(source: LogSource) -> Table:
    """Read a Parquet file from its bytes.

    Text and nested columns are left out and said; date columns become the clock; file metadata (such as erclutch's own
    ``erclutch`` settings) is kept in ``Table.metadata``.

    Raises:
        LogError: no Parquet file, a damaged one, or one without numbers.
    """
    data = source.data
    if data[:4] != MAGIC or data[-4:] != MAGIC or len(data) < 12:
        what = "it is cut off" if data[:4] == MAGIC else "it does not begin with PAR1"
        raise LogError(f"this is not a whole Parquet file ({what})", remedy=_ANEW)
    from pyarrow import parquet

    with _damage_named():
        file = parquet.ParquetFile(io.BytesIO(data), page_checksum_verification=True)
        budget = Budget(len(data), f"{_IN_PIECES}, or allow more by the environment: {RAISED}=8192 (MiB)")
        budget.take_names(file.metadata.num_columns)
        size = sum(file.metadata.row_group(index).total_byte_size for index in range(file.metadata.num_row_groups))
        if size < 0:
            raise LogError("the Parquet data is damaged (columns of less than no bytes)", remedy=_ANEW)
        budget.take_cells(max(size // 8, file.metadata.num_rows * file.metadata.num_columns))
        read = _numbers_and_times(file)
        pages = io.BytesIO(data)
        groups = range(file.metadata.num_row_groups)
        unchecked = not all(_has_checksums(pages, file.metadata, group, read) for group in groups)
        return _table(read, source.name, source.digest, unchecked)


def _numbers_and_times(file: Any) -> Any:
    """All columns, those of texts empty: one word of a small file may stand in a million rows."""
    import pyarrow
    from pyarrow import types

    schema: pyarrow.Schema = file.schema_arrow
    texts = (types.is_nested, types.is_string, types.is_large_string, types.is_binary, types.is_large_binary)
    left = {field.name for field in schema if any(is_kind(field.type) for is_kind in (*texts, types.is_dictionary))}
    kept = [field.name for field in schema if field.name not in left]
    if not left or len(set(schema.names)) < len(schema.names):
        return file.read()
    table = file.read(columns=kept)
    if table.schema.names != kept:  # the library also gives what is called as one of these with a point behind it
        return file.read()
    columns = [pyarrow.nulls(table.num_rows, f.type) if f.name in left else table[f.name] for f in schema]
    return pyarrow.table(columns, schema=schema)


@contextmanager
def _damage_named() -> Generator[None]:
    """Whatever the library says of a damaged file, as one error."""
    try:
        yield
    except LogError:
        raise
    except MemoryError as error:
        raise LogError("the columns need more memory than there is", remedy=_IN_PIECES) from error
    except Exception as error:  # pyarrow raises ArrowInvalid, OSError, UnicodeDecodeError, ... on damage
        problem = f"the Parquet data is damaged ({type(error).__name__}: {' '.join(str(error).split())[:120]})"
        raise LogError(problem, remedy=_ANEW) from error


def _has_checksums(pages: BinaryIO, metadata: Any, group: int, read: Any) -> bool:
    """Whether the first page of each column that was read has a checksum; the library checks it, and is silent without.

    A page's header begins with its kind and two sizes; a checksum comes next, if there is one. Only columns that were
    read can be asked: the library ends the whole process where the description of another one is damaged.
    """
    names = {field.name for field in read.schema if str(field.type) != "null"}  # a column left out is of nulls
    for column in range(metadata.num_columns):
        path = metadata.schema.column(column).path
        if not names & {path, path.partition(".")[0]}:
            continue
        chunk = metadata.row_group(group).column(column)
        pages.seek(chunk.dictionary_page_offset or chunk.data_page_offset)
        if not _CHECKED_PAGE.match(pages.read(32)):
            return False
    return True


def parquet_windows(
    source: LogSource, rows: int, margin: int, first: int = 0, last: int | None = None
) -> Iterator[tuple[int, int, Table]]:
    """A Parquet file of any size as overlapping tables, read page by page.

    Args:
        source: the file.
        rows: rows that a window stands for; the last window for up to twice as many.
        margin: rows that it holds besides on either side, where the file has them.
        first: row of the file at which the first window starts.
        last: row of the file at which the last window stops; None is the end.

    Yields:
        The rows of the file that the window stands for, [start, stop), and its table with the margins
        (`Table.first_row` tells where that begins; its digest is empty).

    Raises:
        LogError: no Parquet file, a damaged one, or one without rows of numbers.
    """
    import pyarrow
    from pyarrow import parquet

    path, name, start = source.path, source.name, first
    options: dict[str, Any] = {"buffer_size": _PAGES, "pre_buffer": False, "page_checksum_verification": True}
    with _damage_named(), parquet.ParquetFile(path, **options) as file, path.open("rb") as pages:
        if not file.metadata.num_rows:
            raise LogError("the file has no rows of numbers", remedy=_ROWS_WANTED)
        last = file.metadata.num_rows if last is None else last
        begins = _begins_of_groups(file.metadata)
        wanted = [k for k, begin in enumerate(begins[:-1]) if begins[k + 1] > first - margin and begin < last + margin]
        held: Any = file.schema_arrow.empty_table()
        held_from = begins[wanted[0]]  # row of the file
        unchecked = False
        origin: int | None = None  # tick from which all windows count
        for group, batch in _batches(file, min(rows, _READ), wanted):
            unchecked = unchecked or not _has_checksums(pages, file.metadata, group, batch)
            held = pyarrow.concat_tables([held, pyarrow.Table.from_batches([batch])])
            origin = _first_tick(held) if origin is None else origin
            while held_from + held.num_rows >= start + 2 * rows + margin and start + 2 * rows <= last:
                part = held.slice(0, start + rows + margin - held_from)
                yield start, start + rows, replace(_table(part, name, "", unchecked, origin), first_row=held_from)
                start += rows
                drop = max(start - margin - held_from, 0)
                held, held_from = held.slice(drop), held_from + drop
        part = held.slice(0, last + margin - held_from)
        yield start, last, replace(_table(part, name, "", unchecked, origin), first_row=held_from)


def _batches(file: Any, rows: int, groups: Sequence[int]) -> Iterator[tuple[int, Any]]:
    """Pieces of at most that many rows, each with the row group that it comes from."""
    for group in groups:
        for batch in file.iter_batches(batch_size=rows, row_groups=[group]):
            yield group, batch


def parquet_extent(path: Path) -> tuple[int, int]:
    """Rows and columns of a Parquet file, as its last bytes say.

    Raises:
        LogError: no Parquet file, or a damaged one.
    """
    from pyarrow import parquet

    with _damage_named():
        metadata = parquet.read_metadata(path)
    return metadata.num_rows, metadata.num_columns


def _begins_of_groups(metadata: Any) -> list[int]:
    """The first row of each row group, and the number of all rows."""
    counts = [metadata.row_group(k).num_rows for k in range(metadata.num_row_groups)]
    return list(accumulate(counts, initial=0))


def _table(table: Any, name: str, digest: str, unchecked: bool, origin: int | None = None) -> Table:
    fields = list(table.schema)
    own = [_metadata(field).get("unit") for field in fields]
    names, units, renamed = name_columns([str(field.name) for field in fields], own)
    notes = [_UNCHECKED, *renamed] if unchecked else list(renamed)
    columns: dict[str, Array] = {}
    clock: tuple[str, Array | None] = ("", None)
    for label, field, values in zip(names, fields, table.columns, strict=True):
        numbers = _numbers(values)
        stamps = _stamps(values, origin) if numbers is None and clock[1] is None else None
        if numbers is not None:
            columns[label] = numbers
        elif stamps is not None:
            clock = (label, stamps)
        else:
            notes.append(f"column {label} holds {field.type}: left out")
    if not columns:
        raise LogError("the file has no column of numbers", remedy=_ROWS_WANTED)
    metadata = {key: text for key, text in _metadata(table.schema).items() if key not in {"pandas", "ARROW:schema"}}
    kept = {label: unit for label, unit in zip(names, units, strict=True) if label in columns}
    return Table(
        name, columns, kept, digest, clock_name=clock[0], clock=clock[1], metadata=metadata, notes=tuple(notes)
    )


def _metadata(thing: Any) -> dict[str, str]:
    """Metadata of a field or a schema as texts."""
    pairs: dict[bytes, bytes] = thing.metadata or {}
    return {key.decode("utf-8", "replace"): value.decode("utf-8", "replace") for key, value in pairs.items()}


def _numbers(values: Any) -> Array | None:
    """A column as float64 (missing becomes NaN), or None if it holds no numbers."""
    import pyarrow
    from pyarrow import types

    kind = values.type
    if not (types.is_floating(kind) or types.is_integer(kind) or types.is_boolean(kind) or types.is_decimal(kind)):
        return None
    if types.is_boolean(kind):
        values = values.cast(pyarrow.uint8())
    values = values.cast(pyarrow.float64(), safe=False)
    if not values.null_count:
        return of_arrow(values)
    # Not fill_null, whose number imports pandas: half a second for each child.
    whole, missing = values.combine_chunks(), of_arrow(values.is_null().cast(pyarrow.uint8()))
    held = whole.buffers()[1]
    numbers = np.zeros(len(whole)) if held is None else np.frombuffer(held, np.float64, len(whole), 8 * whole.offset)
    return np.where(missing == 1, np.nan, numbers)


def _stamps(values: Any, origin: int | None) -> Array | None:
    """Seconds since a tick, or since the first row, of a date-time or duration column, or None."""
    import pyarrow

    if not _tells_time(values.type) or values.null_count or not len(values):
        return None
    ticks = of_arrow(values.cast(pyarrow.int64()))
    per_second = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[values.type.unit]
    return (ticks - (ticks[0] if origin is None else origin)).astype(np.float64) / per_second


def _tells_time(kind: Any) -> bool:
    from pyarrow import types

    return bool(types.is_timestamp(kind) or types.is_duration(kind))


def _first_tick(table: Any) -> int | None:
    """The first row of the first date-time or duration column; None without one, or where it is missing."""
    import pyarrow

    column = next((values for values in table.columns if _tells_time(values.type)), None)
    return column.cast(pyarrow.int64())[0].as_py() if column is not None and len(column) else None


def _claims(head: bytes) -> bool:
    return head.startswith(MAGIC)


def find(path: str, variable: str | None) -> Table:
    """The child's work where a file is read whole."""
    return read_parquet(LogSource(Path(path), Path(path).read_bytes(), ""))


def _asked(path: str, *asked: str) -> Iterator[child_process.Answer]:
    """The child's work where a file is read in windows, or where its extent alone is wanted."""
    if not asked:
        rows, columns = parquet_extent(Path(path))
        yield [], {"extent": [rows, columns]}
        return
    rows, margin, first, last = (int(word) if word else None for word in asked)
    source = LogSource(Path(path), b"", "")
    for start, stop, table in parquet_windows(source, rows or 0, margin or 0, first or 0, last):
        arrays, texts = found_recordings.answer_of_table(table)
        yield arrays, {**texts, "rows": [start, stop]}


def windows_in_child(
    source: LogSource, rows: int, margin: int, first: int = 0, last: int | None = None
) -> Iterator[tuple[int, int, Table]]:
    """`parquet_windows` in a child."""
    words = [str(number) for number in (rows, margin, first)] + ["" if last is None else str(last)]
    for arrays, texts in _pieces(source.path, *words):
        start, stop = texts["rows"]
        yield start, stop, found_recordings.table_of_answer(source, (arrays, texts))


def _extent(path: Path) -> tuple[int, int]:
    """`parquet_extent` in a child."""
    rows, columns = next(iter(_pieces(path)))[1]["extent"]
    return rows, columns


def _pieces(path: Path, *words: str) -> Iterator[child_process.Answer]:
    return child_process.stream("erclutch.logs.readers.parquet", path.resolve(), *words, memory=_memory(path))


def _memory(path: Path) -> int:
    """Bytes of address space of a child: thrice the numbers that a file may hold, beside the library."""
    return MEMORY + 3 * 8 * budget_of(path).cells


_DAMAGE = "seen where the writer added checksums to the pages; a note says where not"
READER = LogReader(
    (".parquet", ".pq"),
    _claims,
    found_recordings.in_child("parquet", memory=_memory)["read"],
    windows_in_child,
    _extent,
    tells_damage=_DAMAGE,
)

if __name__ == "__main__":
    sys.exit(child_process.serve_pieces(_asked))
