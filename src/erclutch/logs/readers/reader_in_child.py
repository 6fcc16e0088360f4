"""A reader may work in a child with limits: its module finds the recordings of a file, and one comes back as a table.

The reader's module has ``find(path, variable) -> Table``. Where its files hold numbers as texts it has
``find_with_mark(path, variable, decimal)`` too, for a decimal mark that the user named. This module, run with -m, is
the child that calls them; `in_child` starts the child and fetches the table.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypedDict

import numpy as np

from erclutch.errors import LogError, SeveralRecordingsError
from erclutch.logs.log_reader import LogSource, states_of, unchanged
from erclutch.logs.readers import child_process
from erclutch.logs.readers.budget import budget_of
from erclutch.logs.readers.found_recordings import ALL, EACH, RecordingNames, SeveralTables
from erclutch.logs.table import Table, WordColumn
from erclutch.signals.array import Array

_TEXTS = (
    "units",
    "numbers",
    "sample_period",
    "clock_name",
    "constants",
    "metadata",
    "notes",
    "first_row",
    "unreadable",
    "hollow",
    "row_names",
    "unsure_names",
    "torn_rows",
)
_CHILD = "erclutch.logs.readers.reader_in_child"  # the module that a child runs


class InChild(TypedDict):
    """The functions of a `LogReader` that start a child."""

    read: Callable[[LogSource], Table]
    recordings: Callable[[LogSource], Sequence[str]]
    each: Callable[[LogSource], Mapping[str, Table | LogError]]


def in_child(
    reader: str,
    library: str | None = None,
    memory: Callable[[Path], int] = lambda path: budget_of(path).memory,
    reads_all: bool = False,
) -> InChild:
    """A reader's functions: a child with limits runs ``find(path, variable) -> Table`` of its module.

    Args:
        reader: the module, beside this module.
        library: the package of the extra ``formats`` that the child imports; None: it needs none.
        memory: bytes of address space of the child for a file.
        reads_all: whether the names of the recordings are known only once all of them are read: then they are kept.
    """

    def answer(source: LogSource, variable: str | None) -> child_process.Answer:
        if library and find_spec(library) is None:
            problem = (
                f"a file of this format is read by the package {library}, which is not installed"
            )
            raise LogError(problem, remedy='Install it: pip install "erclutch[formats]"')
        path = source.path.resolve()
        with unchanged(source.states or states_of([path])):
            words = (reader, variable or "", *([source.decimal] if source.decimal else []))
            return child_process.run(_CHILD, path, *words, memory=memory(path))

    # The tables of the last file whose recordings were all read at once, by its digest.
    kept: dict[str, Mapping[str, Table | LogError]] = {}

    def read(source: LogSource) -> Table:
        tables = kept.get(source.digest, {})
        table = tables.get(source.variable or "")
        if isinstance(table, Table):
            return table
        found = answer(source, source.variable)
        if "each" in found[1]:
            kept.clear()
            kept[source.digest] = tables_of_answer(source, found)
            raise SeveralRecordingsError(**found[1]["refused"])
        return table_of_answer(source, found)

    def recordings(source: LogSource) -> list[str]:
        if reads_all:
            return [name for name, table in each(source).items() if isinstance(table, Table)]
        return [str(name) for name in answer(source, ALL)[1]["recordings"]]

    def each(source: LogSource) -> Mapping[str, Table | LogError]:
        if source.digest in kept and not source.variable:
            return kept[source.digest]
        # One child for all names: its start takes longer than a table of most files.
        asked = f"{EACH}\n{source.variable}" if source.variable else EACH
        tables = tables_of_answer(source, answer(source, asked))
        if reads_all and not source.variable:
            kept.clear()
            kept[source.digest] = tables
        return tables

    return {"read": read, "recordings": recordings, "each": each}


def table_of_answer(source: LogSource, answer: child_process.Answer) -> Table:
    """What `answer_of_table` made of a table, as that table, with name and digest of the file."""
    arrays, texts = answer
    columns = dict(zip(texts["labels"], arrays, strict=False))
    rest = arrays[len(columns) :]  # those of words, then the clock
    words: dict[str, WordColumn] = {}
    for (name, different), of_row in zip(texts["words"], rest, strict=False):
        words[name] = WordColumn(tuple(different), of_row.astype(np.int32))
    clock = rest[-1] if len(rest) > len(words) else None
    others: dict[str, Any] = {key: texts[key] for key in _TEXTS}
    others["notes"] = tuple(texts["notes"])
    others["hollow"] = tuple(texts["hollow"])
    others["row_names"] = tuple(texts["row_names"])
    return Table(source.name, columns, digest=source.digest, clock=clock, words=words, **others)


def answer_of_table(table: Table) -> child_process.Answer:
    """A table as a child sends it: vectors, those of words and the clock last, and texts."""
    clock = [] if table.clock is None else [table.clock]
    parting = [column.of_row.astype(np.float64) for column in table.words.values()]
    texts: dict[str, Any] = {key: getattr(table, key) for key in _TEXTS}
    texts["labels"] = list(table.columns)
    texts["words"] = [(name, column.words) for name, column in table.words.items()]
    return [*table.columns.values(), *parting, *clock], texts


def tables_of_answer(
    source: LogSource, answer: child_process.Answer
) -> dict[str, Table | LogError]:
    """What `answer_of_each` made of tables: these tables, by the names of their recordings."""
    arrays, texts = answer
    tables: dict[str, Table | LogError] = {}
    for name, own in texts["each"].items():
        if "problem" in own:
            tables[name] = LogError(own["problem"], remedy=own["remedy"])
            continue
        tables[name] = table_of_answer(source, (arrays[: own["arrays"]], own))
        arrays = arrays[own["arrays"] :]
    return tables


def answer_of_each(tables: Mapping[str, Table | LogError]) -> child_process.Answer:
    """Tables as a child sends them at once, and what stands against a recording in place of its table."""
    arrays: list[Array] = []
    each: dict[str, Any] = {}
    for name, table in tables.items():
        if isinstance(table, LogError):
            each[name] = {"problem": table.problem, "remedy": table.remedy}
            continue
        own, texts = answer_of_table(table)
        arrays += own
        each[name] = {**texts, "arrays": len(own)}
    return arrays, {"each": each}


def answer_of(path: str, reader: str, variable: str, decimal: str = "") -> child_process.Answer:
    """The child's side of `in_child`.

    A reader may bring ``find_each(path)``, which reads all recordings of a file at once; else they are found in turn.
    """
    module = import_module(f"erclutch.logs.readers.{reader}")
    find: Callable[[str, str | None], Table] = module.find
    if decimal and hasattr(module, "find_with_mark"):
        find = partial(module.find_with_mark, decimal=decimal)
    asked, *names = variable.split("\n") if variable.startswith(EACH) else [variable]
    try:
        if asked != EACH:
            return answer_of_table(find(path, variable or None))
        if not names and hasattr(module, "find_each"):
            return answer_of_each(module.find_each(path))
        if not names:
            find(path, ALL)
    except RecordingNames as answer:
        if asked != EACH:
            return [], {"recordings": answer.names}
        names = answer.names
    except SeveralTables as several:
        arrays, texts = answer_of_each(several.tables)
        refused = {
            "problem": several.problem,
            "remedy": several.remedy,
            "option": several.option,
        }
        return arrays, {**texts, "refused": refused}
    tables: dict[str, Table | LogError] = {}
    for name in names:
        try:
            tables[name] = find(path, name)
        except LogError as error:
            tables[name] = error
    return answer_of_each(tables)


if __name__ == "__main__":
    sys.exit(child_process.serve(answer_of))
