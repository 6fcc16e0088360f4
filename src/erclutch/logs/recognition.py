"""Whether a table is a log, as far as the names and units of its columns tell."""

from __future__ import annotations

from erclutch.errors import ErclutchError
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import NEEDS, Plan
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
        return has_motion_and_effort(plan_of(table, told or ColumnMap(), device=device))
    except ErclutchError:
        return False


def signals_of(table: Table | None) -> set[str]:
    """Signals that have a column in a table, by names and units alone."""
    if table is None:
        return set()
    try:
        return {each.signal for each in plan_of(table, ColumnMap()).signals if each.column}
    except ErclutchError:
        return set()


def has_motion_and_effort(plan: Plan) -> bool:
    """Whether a plan found all but the field, or knows several columns that may be it."""
    found = {each.signal for each in plan.signals if each.column}
    found |= {each.signal for each in plan.questions if "may be any of" in each.problem}
    groups = [group for group in NEEDS[plan.device] if ("field",) not in group]
    return all(any(found & {*option} for option in group) for group in groups)
