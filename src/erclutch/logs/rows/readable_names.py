"""Names of columns that are too long to be understood are refused, whatever reader gave them."""

from __future__ import annotations

from erclutch.errors import placed
from erclutch.logs.columns.labels import refuse_long_names
from erclutch.logs.table import Table


def with_readable_names(table: Table) -> Table:
    """The same table.

    Raises:
        LogError: a name is too long.
    """
    with placed(table.name):
        refuse_long_names(table.columns)
    return table
