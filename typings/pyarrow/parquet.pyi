from collections.abc import Iterator, Sequence
from os import PathLike
from typing import IO, Any

from pyarrow import RecordBatch, Schema, Table

_Source = str | PathLike[str] | IO[bytes]

class RowGroupMetaData:
    total_byte_size: int
    num_rows: int

class FileMetaData:
    num_rows: int
    num_columns: int
    num_row_groups: int
    def row_group(self, i: int) -> RowGroupMetaData: ...

class ParquetFile:
    metadata: FileMetaData
    schema_arrow: Schema
    def __init__(
        self,
        source: _Source,
        *,
        buffer_size: int = ...,
        pre_buffer: bool = ...,
        page_checksum_verification: bool = ...,
    ) -> None: ...
    def __enter__(self) -> ParquetFile: ...
    def __exit__(self, *error: object) -> None: ...
    def read(self, columns: Sequence[str] | None = ...) -> Table: ...
    def iter_batches(
        self,
        batch_size: int = ...,
        row_groups: Sequence[int] | None = ...,
        columns: Sequence[str] | None = ...,
    ) -> Iterator[RecordBatch]: ...

class ParquetWriter:
    def __init__(
        self,
        where: _Source,
        schema: Schema,
        *,
        compression: str = ...,
        use_dictionary: bool | Sequence[str] = ...,
        use_byte_stream_split: bool | Sequence[str] = ...,
        write_page_checksum: bool = ...,
    ) -> None: ...
    def __enter__(self) -> ParquetWriter: ...
    def __exit__(self, *error: object) -> None: ...
    def write_table(self, table: Table, row_group_size: int | None = ...) -> None: ...
    def close(self) -> None: ...

def read_table(
    source: _Source, *, columns: Sequence[str] | None = ..., schema: Schema | None = ...
) -> Table: ...
def read_metadata(where: _Source) -> FileMetaData: ...
def read_schema(where: _Source) -> Schema: ...
def write_table(
    table: Table,
    where: _Source,
    *,
    row_group_size: int | None = ...,
    compression: str = ...,
    use_dictionary: bool | Sequence[str] = ...,
    use_byte_stream_split: bool | Sequence[str] = ...,
    write_page_checksum: bool = ...,
    **further: Any,
) -> None: ...
