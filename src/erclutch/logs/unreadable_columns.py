"""A log is refused where a column that may be a signal by its name holds no numbers: it would be read without it."""

from __future__ import annotations

from erclutch.errors import LogError, shell_word
from erclutch.logs.draft import Draft
from erclutch.logs.names import meant_by


def refuse_unreadable_signals(draft: Draft) -> None:
    """Refuse a log in which a column is called like a signal, or like the time, and holds no numbers.

    Only where nothing else was chosen for that signal, and no other column is called so: the log would be read without
    the signal.

    Raises:
        LogError: there is such a column.
    """
    table, told = draft.table, draft.told
    settled = {*told.columns, *told.constants}
    if settled & {"slip", "position"}:
        settled |= {"slip", "position"}
    wanted = draft.needed - settled
    if told.name_pattern:
        wanted = {signal for signal in wanted if f"{{{signal}}}" not in told.name_pattern}
    timed = told.time is not None or told.rate is not None or table.clock is not None

    for name, problem in table.unreadable.items():
        meant = meant_by(name, wanted, time=not timed)
        if not meant or any(meant_by(other, {meant}, time=meant == "time") for other in table.columns):
            continue
        remedy = f"Correct its cells, or say what the {meant} is: --{meant} {shell_word('NAME [unit]')}"
        remedy += ", or --field none if it was not logged" if meant == "field" else ""
        raise LogError(f"{problem}, and it is called like the {meant}", remedy=remedy)
