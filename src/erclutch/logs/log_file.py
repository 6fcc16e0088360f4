"""A log file becomes a table: it is opened and read, and its table is tidied; of several recordings each has a table.

Nothing of a table is called a signal yet. `TIDYINGS` lists the rules by which it is tidied. A rule gives the table back
as it is where there is nothing to tidy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from erclutch.errors import LogError, placed
from erclutch.logs.clock.channel_times import unwoven, with_times_joined
from erclutch.logs.clock.digits_of_a_clock import with_clock_of_digits
from erclutch.logs.clock.names_over_times import with_names_at_values
from erclutch.logs.clock.one_time import with_whole_stamps
from erclutch.logs.clock.pairs_of_columns import with_pairs_named
from erclutch.logs.columns.marked_levels import with_levels_of_marks
from erclutch.logs.columns.row_groups import groups_in, rows_of
from erclutch.logs.columns.senses import with_senses, with_senses_of_sizes
from erclutch.logs.log_reader import (
    ROWS_WANTED,
    LogReader,
    log_at,
    names_in,
    read_by,
    read_once,
    source_of,
    source_with,
)
from erclutch.logs.rows.fields_in_words import with_fields_of_words
from erclutch.logs.rows.joint_states import with_joint_states_named
from erclutch.logs.rows.largest_doubles import without_largest_doubles
from erclutch.logs.rows.levels_across import (
    with_rows_for_each_level,
    with_rows_for_each_timed_level,
)
from erclutch.logs.rows.levels_filled_down import with_levels_filled_down
from erclutch.logs.rows.levels_of_a_legend import with_levels_of_a_legend
from erclutch.logs.rows.peak_speeds import with_peak_speeds
from erclutch.logs.rows.readable_names import with_readable_names
from erclutch.logs.rows.senses_across import with_a_row_for_each_sense
from erclutch.logs.rows.tidy_rows import untidied
from erclutch.logs.rows.worded_levels import with_places_of_words
from erclutch.logs.table import A_COLUMN_EACH, Table

if TYPE_CHECKING:
    from pandas import DataFrame


_MOST = 400  # recordings among which the only log is looked for
_FIRST_OF_MANY = 20  # recordings of more than that: by their columns one is proposed
EACH = "all"  # in place of a recording's name, or of a word


class Group(NamedTuple):
    """Which rows of which recording are wanted: ``COLUMN=WORD`` or ``RECORDING; COLUMN=WORD``."""

    recording: str | None
    column: str
    word: str


class Tidying(NamedTuple):
    """One rule: what each table has behind it, and the function that makes it so."""

    settles: str
    rule: Callable[[Table], Table]


#: Its column may part the rows.
OF_MARKS = Tidying(
    "one column of levels, though each has a column of 0 and 1", with_levels_of_marks
)
#: All rules, in the order in which they are gone through.
TIDYINGS = (
    Tidying("names that can be read", with_readable_names),
    Tidying("no number where the largest that there is stands for none", without_largest_doubles),
    Tidying("names for what an echo of joint states holds", with_joint_states_named),
    Tidying("a clock in s, though its digits hold hours and minutes", with_clock_of_digits),
    Tidying("one time a row, though a stamp stands in several columns", with_whole_stamps),
    Tidying("rows for each field, though it has a time of its own", with_rows_for_each_timed_level),
    Tidying("a name for each channel, though it stands over its time", with_names_at_values),
    Tidying("a time and a name for each channel, though it is a pair of columns", with_pairs_named),
    Tidying("one time for all channels, though each has its own", with_times_joined),
    Tidying("a column for each signal, though its name stands in the rows", untidied),
    Tidying(
        "a level in each of its rows, though the first alone gives it", with_levels_filled_down
    ),
    OF_MARKS,
    Tidying("a field in each row, though lines above tell it", with_levels_of_a_legend),
    Tidying("a number for each level, though words tell it", with_places_of_words),
    Tidying("a field in each row, though a text tells it", with_fields_of_words),
    Tidying("rows for each field, though it stands in the names", with_rows_for_each_level),
    Tidying("rows for each sense, though each has a column", with_a_row_for_each_sense),
    Tidying("a peak speed, though a test has amplitude and frequency", with_peak_speeds),
    Tidying("rows without holes, though channels are woven", unwoven),
    Tidying("a speed with its sign, though a word or a number says the sense", with_senses),
    Tidying("a speed and an effort with their signs, though both are sizes", with_senses_of_sizes),
)


def read_table(
    path: str | Path | DataFrame,
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
    if log.memory is not None:
        variable = None  # what is in memory is one recording
    source = replace(source_of(log), variable=variable, told=told, decimal=decimal)
    if group is not None and variable not in names_in(log.plugin, source):
        with placed(log.path.name):
            whole = read_once(log.path, source.digest, group.recording, decimal)
            table = rows_of(OF_MARKS.rule(whole), group.column, group.word)
    else:
        table = read_by(log.plugin, source)
    return finished(table, log.notes, path)


def group_of(variable: str | None) -> Group | None:
    """The rows that a text such as ``material=steel`` asks for; None for the name of a recording."""
    recording, parted, choice = (variable or "").rpartition("; ")
    column, equals, word = choice.partition("=")
    if not equals or not column.strip() or not word.strip():
        return None
    return Group(recording if parted else None, column.strip(), word.strip())


def wants_each(variable: str | None) -> bool:
    """Whether each recording of a file, or the rows of each word of a column, are wanted as logs."""
    group = group_of(variable)
    return variable == EACH or (group is not None and group.word == EACH)


def tidied(table: Table) -> Table:
    """The table behind all rules; the same object where there is nothing to tidy."""
    rows = table.columns
    for tidying in TIDYINGS:
        table = tidying.rule(table)
    if table.torn and any(table.columns.get(name) is not values for name, values in rows.items()):
        return replace(table, torn={})  # its rows may be others now
    return table


def finished(table: Table, notes: Sequence[str], path: str | Path | DataFrame) -> Table:
    """What a reader gave, behind all rules, with the notes of its opening and the path as the user gave it.

    The rows of a DataFrame stay its rows, for estimates go back beside them: no rule makes others of them.

    Raises:
        LogError: there are no rows of numbers, the table lies on its side, or a name is too long.
    """
    if not table.columns or not table.rows:
        raise LogError("the file has no rows of numbers", remedy=ROWS_WANTED, where=table.name)
    if table.lying:  # before rules understand its names
        raise LogError(table.lying, remedy=A_COLUMN_EACH, where=table.name)
    if isinstance(path, str | Path):
        table = replace(tidied(table), path=str(path))
    return replace(table, notes=(*table.notes, *notes))


def tables_in(
    path: str | Path, names: Sequence[str], decimal: str | None = None
) -> dict[str, Table | LogError]:
    """The tables of recordings of a file, by name, or what stands against one: the file is read once where it can be.

    Args:
        path: see `read`.
        names: of recordings.
        decimal: see `read_table`.
    """
    log = log_at(path)
    reader = log.plugin.of_type(LogReader)
    at_once: Mapping[str, Table | LogError] = {}
    if reader.each is not None and len(names) > 1:
        with suppress(LogError):  # such as too much for one reading
            at_once = _at_once(log.path, source_of(log).digest)
        joints = tuple(name for name in names if name not in at_once)
        if len(joints) > 1:
            with suppress(LogError):
                at_once = {**at_once, **_at_once(log.path, source_of(log).digest, joints)}
    tables: dict[str, Table | LogError] = {}
    for name in names:
        try:
            table = at_once.get(name)
            if table is None:
                tables[name] = read_table(path, variable=name or None, decimal=decimal)
            elif isinstance(table, LogError):
                tables[name] = table
            else:
                table = replace(table, damage=reader.tells_damage)
                tables[name] = finished(table, log.notes, path)
        except LogError as error:
            tables[name] = error
    return tables


def readable_tables(
    path: str | Path, names: Sequence[str], decimal: str | None = None
) -> dict[str, Table]:
    """The tables of recordings of a file, by name; a recording that is none has no table. See `tables_in`."""
    tables = tables_in(path, names, decimal)
    return {name: table for name, table in tables.items() if not isinstance(table, LogError)}


def recordings_in(path: str | Path, variable: str | None = None) -> list[str]:
    """Names of the recordings that a file holds beside each other; none where it is a recording itself.

    Args:
        path: of the file.
        variable: ``COLUMN=all`` for the rows of each word of a column; anything else: what the file holds.

    Raises:
        LogError: the file cannot be read, or has no such column.
    """
    group = group_of(variable)
    if group is not None and group.word == EACH:
        with placed(Path(path).name):
            parted = groups_in(read_table(path, variable=group.recording), group.column)
        return [f"{group.recording}; {name}" if group.recording else name for name in parted]
    return recordings_of_file(path)


def recordings_of_file(path: str | Path) -> list[str]:
    """Names of the recordings that the format of a file tells apart; none where it is a recording itself.

    Raises:
        LogError: the file cannot be read.
    """
    log = log_at(path)
    if log.plugin.of_type(LogReader).recordings is None:
        return []
    return list(_names_at_once(log.path, source_of(log).digest))


def looked_into(names: Sequence[str]) -> Sequence[str]:
    """The recordings of a file that are looked into: all of them, or the first of very many, which are mostly alike."""
    return names if len(names) <= _MOST else names[:_FIRST_OF_MANY]


@lru_cache(maxsize=2)
def _at_once(
    file: Path, digest: str, names: tuple[str, ...] = ()
) -> Mapping[str, Table | LogError]:
    """The tables of all recordings of a file, or of those named; a look at a file asks for both several times."""
    log = log_at(file)
    each = log.plugin.of_type(LogReader).each
    assert each is not None
    source = replace(source_with(log, digest), variable="\n".join(names) or None)
    with log.plugin.working(f"failed on {file.name}"):
        return each(source)


@lru_cache(maxsize=1)
def _names_at_once(file: Path, digest: str) -> tuple[str, ...]:
    """The names of these recordings."""
    log = log_at(file)
    return tuple(names_in(log.plugin, source_with(log, digest)))
