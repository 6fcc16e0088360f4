"""Whether a table is a log, as far as the names and units of its columns tell."""

from __future__ import annotations

from erclutch.errors import ErclutchError
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.planning import plan_of
from erclutch.logs.table import Table
from erclutch.signals.device import DeviceName


def is_log(table: Table, told: ColumnMap | None = None, device: DeviceName | None = None) -> bool:
    """Whether a table has columns of a motion and an effort.

    Args:
        table: columns as in the file.
        told: what the user said of them; None: nothing.
        device: whose signals count; see `plan_of`.
    """
    try:
        return plan_of(table, told or ColumnMap(), device=device).is_of_a_log
    except ErclutchError:
        return False


def signals_of(table: Table) -> set[str]:
    """Signals that have a column in a table, by names and units alone."""
    try:
        return {each.signal for each in plan_of(table, ColumnMap()).signals if each.column}
    except ErclutchError:
        return set()
