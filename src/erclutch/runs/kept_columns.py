"""The columns that a run keeps are decoded in a process of their own, within a budget: a run may come from anywhere."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from erclutch.logs.readers import child_process
from erclutch.logs.readers.budget import MEMORY, MORE, Budget, budget_of
from erclutch.logs.table import of_arrow
from erclutch.signals.array import Array


def kept_columns(path: Path) -> dict[str, Array]:
    """The columns of numbers of a run's predictions.parquet, each (n,), by name.

    Raises:
        LogError: it is damaged, or unpacks to more than a file of its size may.
    """
    # Thrice the numbers that it may hold, beside the library.
    memory = MEMORY + 3 * 8 * budget_of(path).cells
    arrays, texts = child_process.run("erclutch.runs.kept_columns", path.resolve(), memory=memory)
    return dict(zip(texts["names"], arrays, strict=True))


def decoded(path: str) -> child_process.Answer:
    """The child's work."""
    import pyarrow
    import pyarrow.parquet as pq

    # Not read_table, which imports pandas to no end.
    with (
        open(path, "rb") as opened,
        pq.ParquetFile(opened, page_checksum_verification=True) as file,
    ):
        metadata = file.metadata
        budget = Budget(Path(path).stat().st_size, MORE)
        budget.take_names(metadata.num_columns)
        budget.take_cells(metadata.num_rows * metadata.num_columns)
        # The name of a row's log is text.
        names = [name for name in file.schema_arrow.names if name != "log"]
        table: Any = file.read(columns=names)
    columns = [table[name].cast(pyarrow.float64()) for name in names]
    return [of_arrow(column) for column in columns], {"names": names}


if __name__ == "__main__":
    sys.exit(child_process.serve(decoded))
