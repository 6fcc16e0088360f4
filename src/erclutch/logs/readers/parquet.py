"""Parquet logs give their numeric columns. Units come from a field's metadata ``unit`` or from a label ``V [cm/s]``.

The library decodes in a child process: a damaged file once ended the whole process.
"""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import accumulate, pairwise
from pathlib import Path
from typing import Any, BinaryIO

from erclutch.errors import LogError
from erclutch.logs.log_reader import ROWS_WANTED, LogReader, LogSource
from erclutch.logs.readers import child_process, reader_in_child
from erclutch.logs.readers.arrow_lists import is_of_number_lists
from erclutch.logs.readers.arrow_table import first_tick, is_text, table_of_arrow
from erclutch.logs.readers.budget import MEMORY, RAISED, Budget, budget_of
from erclutch.logs.table import Table

MAGIC = b"PAR1"
_PAGES = 1 << 20  # bytes of a column that are read ahead: without, a whole row group is
_READ = 65_536  # rows
# Three numbers and the beginning of a fourth, in Thrift's compact protocol.
_CHECKED_PAGE = re.compile(rb"(?:\x15[\x80-\xff]*[\x00-\x7f]){3}\x15")
_ANEW = "Copy the file again or export it as CSV"
_IN_PIECES = "Give it to erclutch fit, which reads such a file in blocks, or split it"


def read_parquet(source: LogSource) -> Table:
    """Read a Parquet file from its bytes.

    Text and nested columns are left out and said, but for switches and words that part the rows; date columns become
    the clock; file metadata (such as erclutch's own
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
        schema = file.schema_arrow
        words = [field.name for field in schema if is_text(field.type)]
        all_differ = len({*schema.names}) == len(schema.names)
        if words and all_differ:  # a dictionary has each word once, and a number a row
            options: dict[str, Any] = {"page_checksum_verification": True, "read_dictionary": words}
            file = parquet.ParquetFile(io.BytesIO(data), **options)
        metadata = file.metadata
        groups = range(metadata.num_row_groups)
        size = sum(metadata.row_group(group).total_byte_size for group in groups)
        remedy = f"{_IN_PIECES}, or allow more by the environment: {RAISED}=8192 (MiB)"
        budget = Budget(len(data), remedy)
        budget.take_names(metadata.num_columns)
        if size < 0:
            problem = "the Parquet data is damaged (columns of less than no bytes)"
            raise LogError(problem, remedy=_ANEW)
        budget.take_cells(max(size // 8, metadata.num_rows * metadata.num_columns))

        read = _numbers_and_times(file)
        pages = io.BytesIO(data)
        unchecked = not all(_has_checksums(pages, metadata, group, read) for group in groups)
        return table_of_arrow(read, source.name, source.digest, unchecked, decimal=source.decimal)


def _numbers_and_times(file: Any) -> Any:
    """All columns, those of bytes and of plain texts empty: a word of a small file may stand in 10^6 rows."""
    import pyarrow
    from pyarrow import types

    schema: pyarrow.Schema = file.schema_arrow
    kinds = (
        types.is_nested,
        types.is_string,
        types.is_large_string,
        types.is_binary,
        types.is_large_binary,
    )
    texts: set[str] = set()
    for field in schema:
        if any(is_kind(field.type) for is_kind in kinds) and not is_of_number_lists(field.type):
            texts.add(field.name)
    kept = [field.name for field in schema if field.name not in texts]
    if not texts or len(set(schema.names)) < len(schema.names):
        return file.read()
    table = file.read(columns=kept)
    # The library also gives a column whose name begins as another one's, with a point behind.
    if table.schema.names != kept:
        return file.read()

    columns: list[Any] = []
    for field in schema:
        is_text = field.name in texts
        columns.append(pyarrow.nulls(table.num_rows, field.type) if is_text else table[field.name])
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
    # On damage pyarrow raises ArrowInvalid, OSError, UnicodeDecodeError, ...
    except Exception as error:
        said = " ".join(str(error).split())[:120]
        problem = f"the Parquet data is damaged ({type(error).__name__}: {said})"
        raise LogError(problem, remedy=_ANEW) from error


def _has_checksums(pages: BinaryIO, metadata: Any, group: int, read: Any) -> bool:
    """Whether the first page of each column that was read has a checksum; the library checks it, and is silent without.

    A page's header begins with its kind and two sizes; a checksum comes next, if there is one. Only columns that were
    read can be asked: the library ends the whole process where the description of another one is damaged.
    """
    # A column that was left out is of nulls.
    names = {field.name for field in read.schema if str(field.type) != "null"}
    for column in range(metadata.num_columns):
        path = metadata.schema.column(column).path
        if not any(path == name or path.startswith(f"{name}.") for name in names):
            continue
        chunk = metadata.row_group(group).column(column)
        pages.seek(chunk.dictionary_page_offset or chunk.data_page_offset)
        if not _CHECKED_PAGE.match(pages.read(32)):
            return False
    return True


def parquet_windows(
    source: LogSource,
    rows: int,
    margin: int,
    first: int = 0,
    last: int | None = None,
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

    options: dict[str, Any] = {
        "buffer_size": _PAGES,
        "pre_buffer": False,
        "page_checksum_verification": True,
    }
    path = source.path
    with _damage_named(), parquet.ParquetFile(path, **options) as file, path.open("rb") as pages:
        metadata = file.metadata
        if not metadata.num_rows:
            raise LogError("the file has no rows of numbers", remedy=ROWS_WANTED)
        if last is None:
            last = metadata.num_rows
        counts = [metadata.row_group(group).num_rows for group in range(metadata.num_row_groups)]
        begins = list(accumulate(counts, initial=0))  # first row of each group; the number of all
        wanted: list[int] = []
        for group, (begin, end) in enumerate(pairwise(begins)):
            if end > first - margin and begin < last + margin:
                wanted.append(group)

        held: Any = file.schema_arrow.empty_table()
        held_from = begins[wanted[0]]  # row of the file
        start = first
        unchecked = False
        origin: int | None = None  # tick from which all windows count

        def window(stop: int) -> Table:
            """The table of the rows up to one of the file, and the margin behind it."""
            part = held.slice(0, stop + margin - held_from)
            table = table_of_arrow(part, source.name, "", unchecked, origin)
            return replace(table, first_row=held_from)

        for group in wanted:
            for batch in file.iter_batches(batch_size=min(rows, _READ), row_groups=[group]):
                unchecked = unchecked or not _has_checksums(pages, metadata, group, batch)
                held = pyarrow.concat_tables([held, pyarrow.Table.from_batches([batch])])
                if origin is None:
                    origin = first_tick(held)
                # The last window stands for up to twice as many rows.
                while start + 2 * rows <= last:
                    if held_from + held.num_rows < start + 2 * rows + margin:
                        break
                    yield start, start + rows, window(start + rows)
                    start += rows
                    drop = max(start - margin - held_from, 0)
                    held = held.slice(drop)
                    held_from += drop
        yield start, last, window(last)


def parquet_extent(path: Path) -> tuple[int, int]:
    """Rows and columns of a Parquet file, as its last bytes say.

    Raises:
        LogError: no Parquet file, or a damaged one.
    """
    from pyarrow import parquet

    with _damage_named():
        metadata = parquet.read_metadata(path)
    return metadata.num_rows, metadata.num_columns


def find(path: str, variable: str | None) -> Table:
    """The child's work where a file is read whole."""
    return find_with_mark(path, variable, None)


def find_with_mark(path: str, variable: str | None, decimal: str | None) -> Table:
    """The child's work, where the user named the decimal mark of numbers that are texts."""
    return read_parquet(LogSource(Path(path), Path(path).read_bytes(), "", decimal=decimal))


def _asked(path: str, *asked: str) -> Iterator[child_process.Answer]:
    """The child's work where a file is read in windows, or where its extent alone is wanted."""
    if not asked:
        rows, columns = parquet_extent(Path(path))
        yield [], {"extent": [rows, columns]}
        return
    rows, margin, first, last = (int(word) if word else None for word in asked)
    source = LogSource(Path(path), b"", "")
    for start, stop, table in parquet_windows(source, rows or 0, margin or 0, first or 0, last):
        arrays, texts = reader_in_child.answer_of_table(table)
        yield arrays, {**texts, "rows": [start, stop]}


def windows_in_child(
    source: LogSource,
    rows: int,
    margin: int,
    first: int = 0,
    last: int | None = None,
) -> Iterator[tuple[int, int, Table]]:
    """`parquet_windows` in a child."""
    words = [str(number) for number in (rows, margin, first)]
    words.append("" if last is None else str(last))
    for arrays, texts in _pieces(source.path, *words):
        start, stop = texts["rows"]
        yield start, stop, reader_in_child.table_of_answer(source, (arrays, texts))


def _extent(path: Path) -> tuple[int, int]:
    """`parquet_extent` in a child."""
    rows, columns = next(iter(_pieces(path)))[1]["extent"]
    return rows, columns


def _pieces(path: Path, *words: str) -> Iterator[child_process.Answer]:
    return child_process.stream(
        "erclutch.logs.readers.parquet", path.resolve(), *words, memory=_memory(path)
    )


def _memory(path: Path) -> int:
    """Bytes of address space of a child: thrice the numbers that a file may hold, beside the library."""
    return MEMORY + 3 * 8 * budget_of(path).cells


READER = LogReader(
    suffixes=(".parquet", ".pq"),
    claims=lambda head: head.startswith(MAGIC),
    read=reader_in_child.in_child("parquet", memory=_memory)["read"],
    windows=windows_in_child,
    extent=_extent,
    tells_damage="seen where the writer added checksums to the pages; a note says where not",
)

if __name__ == "__main__":
    sys.exit(child_process.serve_pieces(_asked))
