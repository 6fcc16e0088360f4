"""A log file is opened, its format is found, and its table is read: nothing of it is called a signal yet."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from erclutch.errors import placed
from erclutch.logs.columns.row_groups import group_of, rows_of
from erclutch.logs.log_reader import log_at, names_in, read_by, source_of
from erclutch.logs.table import Table
from erclutch.logs.tidying import finished

if TYPE_CHECKING:
    from pandas import DataFrame


def table_of(log: str | Path | DataFrame, variable: str | None = None) -> Table:
    """The table of a file, or that of a DataFrame.

    Raises:
        LogError: see `read`.
    """
    if isinstance(log, str | Path):
        return read_table(log, variable=variable)
    from erclutch.logs.data_frame import table_of_frame

    return table_of_frame(log)


def read_table(
    path: str | Path,
    *,
    variable: str | None = None,
    decimal: str | None = None,
    told: Callable[[int, int], None] = lambda done, total: None,
) -> Table:
    """Read a log as it is: raw columns and units, nothing converted.

    Args:
        path: see `read`.
        variable: which recording of a file that holds several: variable, group, sheet, topic; or ``COLUMN=WORD``, the
            rows in which a column has a word.
        decimal: "." or "," where the numbers of a text may be read in two ways.
        told: called with how many bytes of a long text were read, and of how many.

    Raises:
        LogError: no such file, no permission, not a log, damaged, or without a column of numbers.
    """
    group = group_of(variable)
    log = log_at(path)
    source = replace(source_of(log), variable=variable, told=told, decimal=decimal)
    if group is None or variable in names_in(log.plugin, source):
        table = read_by(log.plugin, source)
    else:
        with placed(log.path.name):
            whole = read_by(log.plugin, replace(source, variable=group.recording))
            table = rows_of(whole, group)
    return finished(table, log.notes, path)
