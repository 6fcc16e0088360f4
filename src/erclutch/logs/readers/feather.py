"""Feather logs (Arrow's own files) give their columns as Parquet logs do; a child process decodes them."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import reader_in_child
from erclutch.logs.readers.arrow_table import table_of_arrow
from erclutch.logs.readers.budget import budget_of
from erclutch.logs.table import Table

_MAGIC = b"ARROW1\0\0"


def find(path: str, variable: str | None) -> Table:
    """The child's work."""
    return find_with_mark(path, variable, None)


def find_with_mark(path: str, variable: str | None, decimal: str | None) -> Table:
    """The child's work, where the user named the decimal mark of numbers that are texts."""
    from pyarrow import ipc

    file = Path(path)
    try:
        table: Any = ipc.open_file(io.BytesIO(file.read_bytes())).read_all()
        table.validate(full=True)
    except MemoryError:
        raise
    except Exception as error:  # pyarrow raises ArrowInvalid, OSError, ... on damage
        problem = f"the Feather data is damaged ({type(error).__name__}: {' '.join(str(error).split())[:120]})"
        raise LogError(problem, remedy="Copy the file again or export it as CSV") from error
    budget = budget_of(file)
    budget.take_names(table.num_columns)
    budget.take_cells(table.num_rows * table.num_columns)
    return table_of_arrow(table, file.name, "", unchecked=True, decimal=decimal)


READER = LogReader(
    suffixes=(".feather", ".arrow"),
    claims=lambda head: head.startswith(_MAGIC),
    read=reader_in_child.in_child("feather")["read"],
    tells_damage="not seen",
)
