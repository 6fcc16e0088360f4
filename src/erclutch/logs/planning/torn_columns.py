"""A column of which a few cells are no numbers is read where a signal needs it, once the user drops those rows.

A fault of the logger, a word in place of a number or a cell too many damages rows. Which number stood there nobody
knows; without these rows the log is what it was. A column that no signal needs stays out, as it is told.
"""

from __future__ import annotations

from dataclasses import replace

from erclutch.errors import MappingError
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.vocabulary import OTHER, TOLD
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.named_columns import unreadable_signals

_DROP = "--invalid drop"


def read_torn_columns(draft: Draft) -> None:
    """Put torn columns that a signal needs back into the table, and ask whether the damaged rows are dropped."""
    table = draft.table
    wanted = {*unreadable_signals(draft)}
    # Names that may be those of a signal that nobody named, and that no other name may be of.
    settled = {*draft.told.columns, *draft.told.constants}
    if settled & {"slip", "position"}:
        settled |= {"slip", "position"}
    in_other_names = {signal for name in table.columns for signal in spoken_name(name).may_be}
    open_signals = draft.needed - settled - in_other_names
    for name in table.torn:
        said = spoken_name(name)
        if said.may_be & open_signals and not said.says(TOLD | OTHER):
            wanted.add(name)
    # Those that the user named.
    for choice in (*draft.told.columns.values(), draft.told.time):
        if choice is not None:
            label = str(choice.column).strip().removeprefix("-").strip()
            wanted |= {label, split_label(label)[0]}
    torn = {
        name: values
        for name, values in table.torn.items()
        if name in wanted and values.size == table.rows
    }
    problems = [table.unreadable[name] for name in torn]
    if table.torn_rows:
        problems.insert(0, table.torn_rows)
    if not problems:
        return
    if torn:
        columns = {**table.columns, **torn}
        in_the_file = sorted(columns, key=lambda name: table.numbers.get(name, len(columns)))
        draft.table = replace(
            table,
            columns={name: columns[name] for name in in_the_file},
            unreadable={name: why for name, why in table.unreadable.items() if name not in torn},
        )
        told = [f"column {name} is left out: {table.unreadable[name]}" for name in torn]
        draft.notes[:] = [note for note in draft.notes if note not in told]
    problem = "; ".join(problems)
    if draft.invalid == "drop":
        draft.notes.append(f"{problem}: no number there")
        return
    remedy = f"Leave such rows out: {_DROP}; or correct them"
    draft.ask("invalid", MappingError(problem, remedy=remedy), _DROP)
