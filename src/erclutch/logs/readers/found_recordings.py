"""A file of measurement software may hold several recordings: what its readers share.

A reader's module finds the recordings, chooses one and makes a table of it: ``find``. This module, run with -m, is the
child that calls ``find``; `in_child` starts the child and fetches the table.
"""

from __future__ import annotations

import re
import shlex
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypedDict, TypeVar

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.labels import name_columns, split_label
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers import child_process
from erclutch.logs.readers.budget import budget_of
from erclutch.logs.table import Table, WordColumn
from erclutch.signals.array import Array

TIME = re.compile(r"t|time|zeit|tout|timestamps?|time_?s", re.I)
#: Names that say nothing of a signal: its file or its recording says it.
NO_NAME = re.compile(r"c\d+|y|x|val|values?|data|signal|samples?|reading|measurements?|wert|valeur|valor", re.I)
_TEXTS = ("units", "numbers", "sample_period", "clock_name", "constants", "metadata", "notes", "first_row")
_T = TypeVar("_T")
_KEEPS = 0.2  # share of the rows from which on a column keeps its levels
#: In place of a name: the names of all recordings are wanted, or their tables. No recording is called so.
ALL = "*"
EACH = "**"
WORKSPACE = "workspace"  # the vectors that lie beside the structs of a MATLAB file
_TOP = ("/", WORKSPACE)
JOINT = " + "  # between names of recordings or files that are joined by time
_CHILD = "erclutch.logs.readers.found_recordings"  # the module that a child runs


class RecordingNames(Exception):  # noqa: N818  # an answer, not an error
    """What a choice among recordings raises where their names are wanted."""

    def __init__(self, names: Iterable[str]) -> None:
        self.names = list(names)


@dataclass
class Found:
    """One recording: columns by label with units, and what else was said about it."""

    columns: dict[str, Array]
    units: dict[str, str | None] = field(default_factory=dict[str, "str | None"])
    period: float | None = None
    constants: dict[str, float] = field(default_factory=dict[str, float])
    metadata: dict[str, str] = field(default_factory=dict[str, str])
    notes: list[str] = field(default_factory=list[str])
    clock: tuple[str, Array] | None = None

    def table(self) -> Table:
        """The recording as a table without file name and digest; labels become names and units."""
        own_units = [self.units.get(label) for label in self.columns]
        names, units, renamed = name_columns(list(self.columns), own_units)
        clock_name, clock = self.clock or ("", None)
        return Table(
            name="",
            columns=dict(zip(names, self.columns.values(), strict=True)),
            units=dict(zip(names, units, strict=True)),
            digest="",
            sample_period=self.period,
            clock=clock,
            clock_name=clock_name,
            constants=self.constants,
            metadata=self.metadata,
            notes=(*self.notes, *renamed),
        )


def choose(
    recordings: Mapping[str, _T],
    variable: str | None,
    what: str,
    none: str,
    more: str = "",
) -> tuple[str, _T]:
    """The only recording of a file, or the one that ``variable`` names, with its name.

    Args:
        recordings: those of the file, by name.
        variable: what the user chose.
        what: what the format calls a recording, such as "group".
        none: the problem where there is none.
        more: what else helps where there are several.

    Raises:
        LogError: none, several without a choice, or none of that name.
        RecordingNames: ``variable`` is `ALL`.
    """
    if variable == ALL:
        raise RecordingNames(recordings)
    if variable and variable not in recordings:
        problem = f"there is no {what} '{variable}' of numbers (there are: {listed(recordings)})"
        raise LogError(problem, remedy="Give one of these as --variable" if recordings else "Leave --variable out")
    if not recordings:
        raise LogError(none, remedy="Record the signals as numbers of one length, or export them as CSV")
    first = next(iter(recordings))
    if not variable and len(recordings) > 1:
        problem = f"the file holds several recordings: {listed(recordings)}"
        remedy = f"Choose one, such as --variable {shlex.quote(first)}, or --variable all{more}"
        raise LogError(problem, remedy=remedy)
    name = variable or first
    return name, recordings[name]


def names_by(read: Callable[[LogSource], Table]) -> Callable[[LogSource], list[str]]:
    """What lists the recordings of a file, from what reads one of them by `choose`."""

    def recordings(source: LogSource) -> list[str]:
        try:
            read(replace(source, variable=ALL))
        except RecordingNames as answer:
            return answer.names
        return []

    return recordings


def chosen(recordings: Mapping[str, Found], variable: str | None, what: str, none: str) -> Table:
    """The table of the recording that `choose` takes, or of several joined by time; a note names the recording."""
    names = [name.strip() for name in (variable or "").split(JOINT)]
    is_joint = len(names) > 1 and variable not in recordings
    if is_joint and all(name in recordings for name in names):
        together = {name: recordings[name] for name in names}
        return joined_by_time(together, what).table()
    if variable not in recordings:
        recordings = gathered(recordings)
    name, recording = choose(recordings, variable, what, none, join_hint(recordings))
    recording.notes.insert(0, f"recording read from {what} {name}")
    return recording.table()


def join_hint(recordings: Mapping[str, Found]) -> str:
    """How to join the recordings that have a time, the longest first, as the end of a remedy."""
    rows: dict[str, int] = {}  # of each recording that has a time
    for name, recording in recordings.items():
        if time_of(recording):
            first_column = next(iter(recording.columns.values()))
            rows[name] = first_column.size
    if len(rows) < 2:
        return ""
    longest_first = sorted(rows, key=lambda name: -rows[name])
    return f", or join them by time: --variable {shlex.quote(JOINT.join(longest_first))}"


def time_of(recording: Found) -> str | None:
    """The label of a recording's time, if it has one."""
    for label in recording.columns:
        name, _ = split_label(label)
        if TIME.fullmatch(name.strip()):
            return label
    return None


def joined_by_time(recordings: Mapping[str, Found], what: str) -> Found:
    """Recordings of other rates beside the first, at the first's times, as far as all of them have rows.

    A column that keeps its levels (a command) holds each value until the next; any other is joined by straight lines.

    Args:
        recordings: by name; the times are those of the first.
        what: what the format calls a recording.

    Raises:
        LogError: a recording without times that grow, or no time that all of them have.
    """
    recordings = {name: _with_its_name(recording, name) for name, recording in recordings.items()}
    clocks: dict[str, Array] = {}  # s
    for name, recording in recordings.items():
        label = time_of(recording)
        times = None if label is None else recording.columns[label]
        if times is None or times.size < 2 or not bool(np.all(np.diff(times) > 0)):
            problem = f"{what} {name} has no time that grows from row to row"
            raise LogError(problem, remedy="Join others, or choose one")
        clocks[name] = times

    (first, base), *others = recordings.items()
    begin = max(float(times[0]) for times in clocks.values())
    end = min(float(times[-1]) for times in clocks.values())
    inside = (clocks[first] >= begin) & (clocks[first] <= end)
    if not inside.any():
        raise LogError(f"there is no time that all of {listed(recordings)} have", remedy="Choose one of them")
    at = clocks[first][inside]  # s, shape (rows,)
    columns = {label: values[inside] for label, values in base.columns.items()}
    units = dict(base.units)
    notes = [f"recordings joined at the times of {what} {first}: {', '.join(recordings)}", *base.notes]
    outside = int(np.count_nonzero(~inside))
    if outside:
        notes.append(f"{outside} rows of {first} before or after the others left out")

    for name, recording in others:
        clock = clocks[name]
        time = time_of(recording)
        has_same_times = np.array_equal(clock, clocks[first])
        last_before = np.searchsorted(clock, at, side="right") - 1  # row, shape (rows,)
        for label, values in recording.columns.items():
            if label == time:
                continue
            repeats = np.count_nonzero(np.diff(values) == 0.0)
            if has_same_times:
                joined = values[last_before]
                how = "at the same times"
            elif repeats > _KEEPS * (values.size - 1):
                joined = values[last_before]
                how = "each value held until the next"
            else:
                joined = np.asarray(np.interp(at, clock, values), np.float64)
                how = "joined by straight lines"
            own_label = label if label not in columns else f"{label} ({name})"
            columns[own_label] = joined
            units[own_label] = recording.units.get(label)
            notes.append(f"column {own_label} of {name}: {how}")
    return replace(base, columns=columns, units=units, notes=notes)


def gathered(found: Mapping[str, Found]) -> dict[str, Found]:
    """Recordings that are parts of one, as one: a single signal each on equal times, or several below the time of all.

    Runs of one test are no parts: each of them has all signals, and a time of its own.
    """
    clocks = {name: time_of(recording) for name, recording in found.items()}
    timed = [name for name, label in clocks.items() if label is not None]
    sizes = {next(iter(recording.columns.values())).size for recording in found.values()}
    if len(found) < 2 or len(sizes) != 1 or len(timed) not in (1, len(found)):
        return {**found}
    first = timed[0]
    base = found[first]
    if len(timed) > 1:
        times = [found[name].columns[clocks[name] or ""] for name in timed]
        single = all(len(recording.columns) == 2 for recording in found.values())
        named = [_with_its_name(recording, name) for name, recording in found.items()]
        signals = [label for recording in named for label in recording.columns if label != time_of(recording)]
        all_differ = len({*signals}) == len(signals)
        if not single or not all_differ or not all(np.array_equal(time, times[0]) for time in times[1:]):
            return {**found}
    else:
        others = [name for name in found if name != first]
        is_above = first in _TOP or all(name.startswith((f"{first}.", f"{first}/")) for name in others)
        if not is_above or any(found[name].period is not None for name in others):
            return {**found}

    labels = Counter(label for recording in found.values() for label in recording.columns)
    columns: dict[str, Array] = {}
    units: dict[str, str | None] = {}
    constants: dict[str, float] = {}
    notes = [f"one recording of the parts {listed(found)}, which have one time"]
    for name, recording in found.items():
        named = _with_its_name(recording, name) if len(timed) > 1 else recording
        for label, values in named.columns.items():
            if label == time_of(named) and name != first:
                continue
            own = label if labels[label] < 2 or label == clocks[first] else f"{re.split(r'[./]', name)[-1]}.{label}"
            if own in columns:
                return {**found}
            columns[own] = values
            units[own] = named.units.get(label)
        constants |= named.constants
        notes += named.notes
    return {JOINT.join(found): replace(base, columns=columns, units=units, constants=constants, notes=notes)}


def _with_its_name(recording: Found, name: str) -> Found:
    """A recording of one signal; its column is called as the recording where its own name says nothing."""
    time = time_of(recording)
    signals = [label for label in recording.columns if label != time]
    if len(signals) != 1 or not NO_NAME.fullmatch(signals[0]):
        return recording
    last_part = re.split(r"[./]", name)[-1]
    renamed = {signals[0]: last_part}
    columns = {renamed.get(label, label): values for label, values in recording.columns.items()}
    units = {renamed.get(label, label): unit for label, unit in recording.units.items()}
    return replace(recording, columns=columns, units=units)


def listed(names: Iterable[str]) -> str:
    """Names for a message, the first 20 of them."""
    every = list(names) or ["none"]
    more = ", ..." if len(every) > 20 else ""
    return ", ".join(every[:20]) + more


class InChild(TypedDict):
    """The functions of a `LogReader` that start a child."""

    read: Callable[[LogSource], Table]
    recordings: Callable[[LogSource], Sequence[str]]
    each: Callable[[LogSource], Mapping[str, Table | LogError]]


def in_child(
    reader: str, library: str | None = None, memory: Callable[[Path], int] = lambda path: budget_of(path).memory
) -> InChild:
    """A reader's functions: a child with limits runs ``find(path, variable) -> Table`` of its module.

    Args:
        reader: the module, beside this module.
        library: the package of the extra ``formats`` that the child imports; None: it needs none.
        memory: bytes of address space of the child for a file.
    """

    def answer(source: LogSource, variable: str | None) -> child_process.Answer:
        if library and find_spec(library) is None:
            problem = f"a file of this format is read by the package {library}, which is not installed"
            raise LogError(problem, remedy='Install it: pip install "erclutch[formats]"')
        path = source.path.resolve()
        return child_process.run(_CHILD, path, reader, variable or "", memory=memory(path))

    def read(source: LogSource) -> Table:
        return table_of_answer(source, answer(source, source.variable))

    def recordings(source: LogSource) -> list[str]:
        return [str(name) for name in answer(source, ALL)[1]["recordings"]]

    def each(source: LogSource) -> dict[str, Table | LogError]:
        return tables_of_answer(source, answer(source, EACH))

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
    return Table(source.name, columns, digest=source.digest, clock=clock, words=words, **others)


def answer_of_table(table: Table) -> child_process.Answer:
    """A table as a child sends it: vectors, those of words and the clock last, and texts."""
    clock = [] if table.clock is None else [table.clock]
    parting = [column.of_row.astype(np.float64) for column in table.words.values()]
    texts: dict[str, Any] = {key: getattr(table, key) for key in _TEXTS}
    texts["labels"] = list(table.columns)
    texts["words"] = [(name, column.words) for name, column in table.words.items()]
    return [*table.columns.values(), *parting, *clock], texts


def tables_of_answer(source: LogSource, answer: child_process.Answer) -> dict[str, Table | LogError]:
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


def answer_of(path: str, reader: str, variable: str) -> child_process.Answer:
    """The child's side of `in_child`.

    A reader may bring ``find_each(path)``, which reads all recordings of a file at once; else they are found in turn.
    """
    module = import_module(f"erclutch.logs.readers.{reader}")
    find: Callable[[str, str | None], Table] = module.find
    try:
        if variable != EACH:
            return answer_of_table(find(path, variable or None))
        if hasattr(module, "find_each"):
            return answer_of_each(module.find_each(path))
        find(path, ALL)
    except RecordingNames as answer:
        if variable != EACH:
            return [], {"recordings": answer.names}
        tables: dict[str, Table | LogError] = {}
        for name in answer.names:
            try:
                tables[name] = find(path, name)
            except LogError as error:
                tables[name] = error
        return answer_of_each(tables)
    return answer_of_each({})


if __name__ == "__main__":
    from erclutch.logs.readers import found_recordings  # readers raise the errors of the module of this name

    sys.exit(child_process.serve(found_recordings.answer_of))
