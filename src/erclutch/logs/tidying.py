"""A table that was read is tidied, rule after rule: `TIDYINGS` lists the rules, and `tidied` goes through them.

A rule gives the table back as it is where there is nothing to tidy. Nothing of the table is called a signal yet.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from erclutch.errors import LogError
from erclutch.logs.clock.channel_times import unwoven, with_times_joined
from erclutch.logs.clock.names_over_times import with_names_at_values
from erclutch.logs.clock.one_time import with_whole_stamps
from erclutch.logs.columns.senses import with_senses
from erclutch.logs.log_reader import ROWS_WANTED
from erclutch.logs.rows.levels_across import with_rows_for_each_level
from erclutch.logs.rows.senses_across import with_a_row_for_each_sense
from erclutch.logs.rows.tidy_rows import untidied
from erclutch.logs.table import Table


class Tidying(NamedTuple):
    """One rule: what each table has behind it, and the function that makes it so."""

    settles: str
    rule: Callable[[Table], Table]


#: All rules, in the order in which they are gone through.
TIDYINGS = (
    Tidying("one time a row, though a stamp stands in several columns", with_whole_stamps),
    Tidying("a name for each channel, though it stands over its time", with_names_at_values),
    Tidying("one time for all channels, though each has its own", with_times_joined),
    Tidying("a column for each signal, though its name stands in the rows", untidied),
    Tidying("rows for each field, though it stands in the names", with_rows_for_each_level),
    Tidying("rows for each sense, though each has a column", with_a_row_for_each_sense),
    Tidying("rows without holes, though channels are woven", unwoven),
    Tidying("a speed with its sign, though a word or a number says the sense", with_senses),
)


def tidied(table: Table) -> Table:
    """The table behind all rules; the same object where there is nothing to tidy."""
    for tidying in TIDYINGS:
        table = tidying.rule(table)
    return table


def finished(table: Table, notes: Sequence[str], path: str | Path) -> Table:
    """What a reader gave, behind all rules, with the notes of its opening and the path as the user gave it.

    Raises:
        LogError: there are no rows of numbers.
    """
    if not table.columns or not table.rows:
        raise LogError("the file has no rows of numbers", remedy=ROWS_WANTED, where=table.name)
    table = tidied(table)
    return replace(table, notes=(*table.notes, *notes), path=str(path))
