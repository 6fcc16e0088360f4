"""The first look at a table: what two shafts differ by becomes a column, then what all columns say is seen once."""

from __future__ import annotations

from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.columns.two_shafts import with_differences
from erclutch.logs.planning.draft import Draft


def make_differences(draft: Draft) -> None:
    """Make a column of what two shafts differ by, and of each difference that the user named.

    Raises:
        MappingError: a difference of two units.
    """
    draft.table, draft.told = with_differences(draft.table, draft.told)


def see_columns(draft: Draft) -> None:
    """See what each column says by its name, its unit and its numbers; a column without a number says nothing."""
    draft.seen = seen_columns(draft.table, whole=draft.is_whole)
    numberless = [name for name in draft.seen.empty if name in draft.table.columns]
    if numberless:
        draft.notes.append(f"no number in any row: column {', '.join(numberless)}: left out")
