"""A file of measurement software may hold several recordings: one is chosen, or several are joined by time."""

from __future__ import annotations

import re
import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError, SeveralRecordingsError
from erclutch.logs.columns.labels import name_columns, own_unit, split_label
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.log_reader import LogSource
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.full_turns import FULL_TURNS, between_samples, starts_again

TIME = re.compile(r"t|time|zeit|tout|timestamps?|time_?s", re.I)
#: Names that say nothing of a signal: its file or its recording says it.
NO_NAME = re.compile(
    r"c\d+|y|x|val|values?|data|signal|samples?|reading|measurements?|wert|valeur|valor", re.I
)
_T = TypeVar("_T")
_NEARLY = 0.9  # share of a full turn that a sensor which starts again goes through
_NO_ANGLE = ("1", "")
_SLOW = 50.0  # times the usual step of the first recording: a slower one holds its first and last value for a step
_KEEPS = 0.2  # share of the rows from which on a column keeps its levels
#: In place of a name: the names of all recordings are wanted, or their tables. No recording is called so.
ALL = "*"
EACH = "**"
WORKSPACE = "workspace"  # the vectors that lie beside the structs of a MATLAB file
_TOP = ("/", WORKSPACE)
JOINT = " + "  # between names of recordings or files that are joined by time


class RecordingNames(Exception):  # noqa: N818  # an answer, not an error
    """What a choice among recordings raises where their names are wanted."""

    def __init__(self, names: Iterable[str]) -> None:
        self.names = list(names)


class SeveralTables(SeveralRecordingsError):  # noqa: N818  # an answer, and the error for whoever asked for one table
    """What a choice among recordings raises that were all read on the way: a look at the file asks for them next."""

    def __init__(self, error: SeveralRecordingsError, tables: Mapping[str, Table]) -> None:
        super().__init__(error.problem, remedy=error.remedy, option=error.option)
        self.tables = tables


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
    unreadable: dict[str, str] = field(default_factory=dict[str, str])

    def table(self) -> Table:
        """The recording as a table without file name and digest; labels become names and units."""
        own_units = [self.units.get(label) for label in self.columns]
        names, units_of, renamed = name_columns(list(self.columns), own_units)
        clock_name, clock = self.clock or ("", None)
        return Table(
            name="",
            columns=dict(zip(names, self.columns.values(), strict=True)),
            units=dict(zip(names, units_of, strict=True)),
            digest="",
            sample_period=self.period,
            clock=clock,
            clock_name=clock_name,
            constants=self.constants,
            metadata=self.metadata,
            notes=(*self.notes, *renamed),
            unreadable=self.unreadable,
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
        LogError: none, or none of that name. SeveralRecordingsError: several without a choice.
        RecordingNames: ``variable`` is `ALL`.
    """
    if variable == ALL:
        raise RecordingNames(recordings)
    if variable and variable not in recordings:
        problem = f"there is no {what} '{variable}' of numbers (there are: {listed(recordings)})"
        raise LogError(
            problem,
            remedy="Give one of these as --variable" if recordings else "Leave --variable out",
        )
    if not recordings:
        raise LogError(
            none, remedy="Record the signals as numbers of one length, or export them as CSV"
        )
    first = next(iter(recordings))
    if not variable and len(recordings) > 1:
        problem = f"the file holds several recordings: {listed(recordings)}"
        option = f"--variable {shlex.quote(first)}"
        remedy = f"Choose one, such as {option}, or --variable all{more}"
        raise SeveralRecordingsError(problem, remedy=remedy, option=option)
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


def joint_table(tables: Mapping[str, Table], variable: str, what: str) -> Table | None:
    """The tables that a joint name says, joined by time; None where the name is no such joint.

    Args:
        tables: of all recordings of a file, by name.
        variable: what the user chose.
        what: what the format calls a recording.

    Raises:
        LogError: see `joined_by_time`.
    """
    names = [name.strip() for name in variable.split(JOINT)]
    if len(names) < 2 or variable in tables or not all(name in tables for name in names):
        return None
    recordings: dict[str, Found] = {}
    for name in names:
        table = tables[name]
        recording = Found(
            {**table.columns},
            {**table.units},
            None,
            {**table.constants},
            {**table.metadata},
            [*table.notes],
        )
        label = time_of(recording)
        unit = recording.units.get(label or "")
        if label and unit and units.is_unit(unit) and (seconds := units.fits(unit, ("s",))):
            recording.columns[label] = recording.columns[label] * seconds[0]
            recording.units[label] = "s"
        recordings[name] = recording
    return joined_by_time(recordings, what).table()


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

    A slow recording (a temperature once a second) has rows for a step of its own before its first and behind its last
    sample, too: it holds these two, and cuts nothing of a quick log.
    A column that keeps its levels (a command) holds each value until the next; any other is joined by straight lines.
    An angle that starts again after a full turn goes the shorter way.

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
    usual_steps = {name: float(np.median(np.diff(times))) for name, times in clocks.items()}  # s
    holds: dict[str, float] = {}  # s, for how long the ends of a recording hold
    for name, step in usual_steps.items():
        holds[name] = step if step >= _SLOW * usual_steps[first] else 0.0
    begin = max(float(times[0]) - holds[name] for name, times in clocks.items())
    end = min(float(times[-1]) + holds[name] for name, times in clocks.items())
    inside = (clocks[first] >= begin) & (clocks[first] <= end)
    if not inside.any():
        raise LogError(
            f"there is no time that all of {listed(recordings)} have", remedy="Choose one of them"
        )
    at = clocks[first][inside]  # s, shape (rows,)
    columns = {label: values[inside] for label, values in base.columns.items()}
    units_of = dict(base.units)
    notes = [
        f"recordings joined at the times of {what} {first}: {', '.join(recordings)}",
        *base.notes,
    ]
    outside = int(np.count_nonzero(~inside))
    if outside:
        notes.append(f"{outside} rows of {first} before or after the others left out")

    for name, recording in others:
        clock = clocks[name]
        time = time_of(recording)
        has_same_times = np.array_equal(clock, clocks[first])
        held_for = max(clock[0] - at[0], at[-1] - clock[-1], 0.0)  # s
        if held_for > 0.0:
            ends = f"its first and last value are held before and behind its samples, for up to {held_for:.3g} s"
            notes.append(f"{name} is slow: {ends}")
        within = np.clip(at, clock[0], clock[-1])  # s
        last_before = np.searchsorted(clock, within, side="right") - 1  # row, shape (rows,)
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
            elif turn := turn_after_which_it_starts_again(
                label, recording.units.get(label), values
            ):
                joined = between_samples(within, clock, values, turn)
                how = "joined by straight lines, over its jumps after a full turn too"
            else:
                joined = np.asarray(np.interp(within, clock, values), np.float64)
                how = "joined by straight lines"
            own_label = label if label not in columns else f"{label} ({name})"
            columns[own_label] = joined
            units_of[own_label] = recording.units.get(label)
            notes.append(f"column {own_label} of {name}: {how}")
    return replace(base, columns=columns, units=units_of, notes=notes)


def turn_after_which_it_starts_again(label: str, unit: str | None, values: Array) -> float | None:
    """A full turn in the unit of an angle that jumps after it; None where nothing starts again.

    Where no unit is told, the name says that a column is a position, and its range whether it is in rad or deg.
    """
    name, unit_in_label = split_label(label)
    told = own_unit(name, unit or unit_in_label, ("rad",))
    if told:
        angle = units.fits(told, ("rad",)) if units.is_unit(told) else None
        turns = [FULL_TURNS[0] / angle[0]] if angle and told not in _NO_ANGLE else []
    else:
        may_turn = "position" in spoken_name(name).may_be
        turns = [turn for turn in FULL_TURNS if may_turn and np.ptp(values) > _NEARLY * turn]
    return next((turn for turn in turns if starts_again(values, turn)), None)


def joined_topics(
    topics: Mapping[str, tuple[NDArray[np.int64], Mapping[str, Array]]],
    units_of: Mapping[str, dict[str, str | None]],
) -> Table:
    """Topics of messages joined at the times of the first; the stamps inside the messages are left out.

    Args:
        topics: when the messages were logged in ns, shape (n,), and their numbers by label, each of shape (n,).
        units_of: the units of a topic's columns, where they are known.
    """
    begin = min(times[0] for times, _ in topics.values())
    parts: dict[str, Found] = {}
    for name, (times, columns) in topics.items():
        own: dict[str, Array] = {"time [s]": (times - begin).astype(np.float64) * 1e-9}
        for label, values in columns.items():
            if not label.endswith("stamp [s]"):
                own[label] = values
        parts[name] = Found(own, units_of.get(name, {}))
    return joined_by_time(parts, "topic").table()


def gathered(recordings: Mapping[str, Found]) -> dict[str, Found]:
    """Recordings that are parts of one, as one: a single signal each on equal times, or several below the time of all.

    Runs of one test are no parts: each of them has all signals, and a time of its own.
    """
    apart = {**recordings}
    times: dict[str, str] = {}
    for name, recording in recordings.items():
        label = time_of(recording)
        if label is not None:
            times[name] = label
    lengths = {next(iter(recording.columns.values())).size for recording in recordings.values()}
    if len(recordings) < 2 or len(lengths) != 1 or len(times) not in (1, len(recordings)):
        return apart
    first, time_of_first = next(iter(times.items()))
    parts = apart
    if len(times) == 1:
        others = [name for name in recordings if name != first]
        is_above = first in _TOP or all(
            name.startswith((f"{first}.", f"{first}/")) for name in others
        )
        has_own_rate = any(recordings[name].period is not None for name in others)
        if not is_above or has_own_rate:
            return apart
    else:
        parts = {name: _with_its_name(recording, name) for name, recording in recordings.items()}
        signals: list[str] = []
        for part in parts.values():
            signals += [label for label in part.columns if label != time_of(part)]
        have_one_signal = all(len(recording.columns) == 2 for recording in recordings.values())
        all_differ = len({*signals}) == len(signals)
        stamps = recordings[first].columns[time_of_first]
        have_one_time = all(
            np.array_equal(recordings[name].columns[label], stamps) for name, label in times.items()
        )
        if not (have_one_signal and all_differ and have_one_time):
            return apart

    # How many parts have a label.
    counts = Counter(label for recording in recordings.values() for label in recording.columns)
    columns: dict[str, Array] = {}
    units_of: dict[str, str | None] = {}
    constants: dict[str, float] = {}
    notes = [f"one recording of the parts {listed(recordings)}, which have one time"]
    for name, part in parts.items():
        for label, values in part.columns.items():
            if label == time_of(part) and name != first:
                continue
            own_label = label
            if counts[label] > 1 and label != time_of_first:
                own_label = f"{_last_part(name)}.{label}"
            if own_label in columns:
                return apart
            columns[own_label] = values
            units_of[own_label] = part.units.get(label)
        constants |= part.constants
        notes += part.notes
    together = replace(
        recordings[first], columns=columns, units=units_of, constants=constants, notes=notes
    )
    return {JOINT.join(recordings): together}


def _with_its_name(recording: Found, name: str) -> Found:
    """A recording of one signal; its column is called as the recording where its own name says nothing."""
    time = time_of(recording)
    signals = [label for label in recording.columns if label != time]
    if len(signals) != 1 or not NO_NAME.fullmatch(signals[0]):
        return recording
    renamed = {signals[0]: _last_part(name)}
    columns = {renamed.get(label, label): values for label, values in recording.columns.items()}
    units_of = {renamed.get(label, label): unit for label, unit in recording.units.items()}
    return replace(recording, columns=columns, units=units_of)


def _last_part(name: str) -> str:
    """The last part of a recording's name: ``speed`` of ``bench/speed`` and of ``log.speed``."""
    return re.split(r"[./]", name)[-1]


def told_apart(labels: Sequence[str]) -> list[str]:
    """Labels of signals; those of one name are ``speed (1) [rpm]``, ``speed (2) [rpm]``, so that none is lost."""
    uses = Counter(labels)
    numbers: Counter[str] = Counter()
    apart: list[str] = []
    for label in labels:
        numbers[label] += 1
        name, bracket, unit = label.partition(" [")
        numbered = f"{name} ({numbers[label]}){bracket}{unit}"
        apart.append(numbered if uses[label] > 1 else label)
    return apart


def listed(names: Iterable[str]) -> str:
    """Names for a message, the first 20 of them."""
    every = list(names) or ["none"]
    more = ", ..." if len(every) > 20 else ""
    return ", ".join(every[:20]) + more
