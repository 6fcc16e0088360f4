"""Of a file that holds several recordings, the only one that is a log of a device is taken; else the user is asked.

`CHOICES` lists the rules by which the log is found, and `table_of_log` goes through them.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from erclutch.errors import AlikeRecordingsError, LogError, SeveralRecordingsError, listed
from erclutch.logs.clock.timing import MINIMUM_ROWS
from erclutch.logs.columns.levels_in_names import fields_told_by
from erclutch.logs.log_file import (
    looked_into,
    read_table,
    readable_tables,
    recordings_of_file,
)
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import Plan
from erclutch.logs.planning.whole_plan import nearest_to_a_log, plan_if_any, plans_of_logs
from erclutch.logs.readers.found_recordings import JOINT
from erclutch.logs.table import Table
from erclutch.signals.array import Array
from erclutch.signals.device import DeviceName

if TYPE_CHECKING:
    from pandas import DataFrame

#: An answer to the question which field a log has.
_SAYS_A_FIELD = re.compile(r"""--field |--constant ["']?field=""")
_MOST_JOINED = 12  # recordings, since a device has few signals


@dataclass(frozen=True)
class RecordingsOfFile:
    """The recordings of a file, among which a log is looked for.

    Attributes:
        path: of the file.
        names: of all recordings.
        tables: of those that can be read, by name.
        logs: plans of those that are logs, by name.
        told: what the user said of columns.
        device: see `erclutch.read`.
        where: the file, for messages.
    """

    path: str | Path
    names: Sequence[str]
    tables: Mapping[str, Table]
    logs: Mapping[str, Plan]
    told: ColumnMap
    device: DeviceName | None
    where: str

    def joined(self, together: str) -> Table | None:
        """The table of several recordings that are joined by time; None where they cannot be."""
        return readable_tables(self.path, [together], self.told.decimal).get(together)


def take_the_only_log(file: RecordingsOfFile) -> Table | None:
    """The table of the only log, with a note on the others; None for several logs, or none.

    Raises:
        LogError: the log has no field, and another recording may hold the field.
    """
    if len(file.logs) != 1:
        return None
    ((name, plan),) = file.logs.items()
    beside = _with_the_field(file, name, plan)
    if beside:
        problem = (
            f"recording {name} is a log without a field, and {listed(beside)} may be the field"
        )
        joined = f"--variable {shlex.quote(JOINT.join([name, *beside]))}"
        remedy = (
            f"Join them by time: {joined}; or leave the field out: --variable {shlex.quote(name)}"
        )
        raise LogError(problem, remedy=remedy, where=file.where, option=joined)
    left_out = ", ".join(other for other in file.names if other != name)
    note = f"recording {name}: no other has columns of a motion and an effort ({left_out})"
    table = file.tables[name]
    return replace(table, notes=(note, *table.notes))


def _with_the_field(file: RecordingsOfFile, name: str, plan: Plan) -> list[str]:
    """The recordings beside the only log that hold a field, where the log has none; as a topic of a current may be."""
    said = file.told.columns.keys() | file.told.constants.keys()
    if not said.isdisjoint({"field", "E", "E1", "E2"}) or plan.sure_field:
        return []
    beside: list[str] = []
    others = [other for other in file.tables if other != name][:_MOST_JOINED]
    joints = [JOINT.join([name, other]) for other in others]
    tables_of_joints = readable_tables(file.path, joints, file.told.decimal)
    for other, joint in zip(others, joints, strict=True):
        joined = tables_of_joints.get(joint)
        if joined is not None:
            of_both = plan_if_any(joined, file.told, file.device)
            field = "" if of_both is None else of_both.sure_field
            if field and field not in file.tables[name].columns:
                beside.append(other)
            continue
        by_itself = (
            plan_if_any(file.tables[other]) if file.tables[other].rows >= MINIMUM_ROWS else None
        )
        if by_itself is not None and "field" in by_itself.signals_with_columns:
            problem = f"recording {name} is a log without a field, and {other}, which may be it, has no time in common"
            option = f"--variable {shlex.quote(name)} --field none"
            remedy = f"Put the field beside its rows, or leave it out: {option}"
            raise LogError(problem, remedy=remedy, where=Path(file.path).name, option=option)
    return beside


def ask_which_log(file: RecordingsOfFile) -> None:
    """Nothing for a file without a log.

    Raises:
        AlikeRecordingsError: all logs are read in one way, so that each may be one.
        SeveralRecordingsError: the user chooses.
    """
    if not file.logs:
        return
    first = shlex.quote(next(iter(file.logs)))
    plans = [*file.logs.values()]
    tell_fields = len(fields_told_by([*file.logs])) == len(file.logs)
    answers: set[tuple[str, ...]] = set()
    for plan in plans:
        # What the names of all logs tell need not be answered for one of them.
        open_ones = [
            each for each in plan.examples if not (tell_fields and _SAYS_A_FIELD.match(each))
        ]
        answers.add(tuple(open_ones))
    have_one_answer = len(answers) == 1 and not any(plan.doubts for plan in plans)
    option = f"--variable {first}"
    remedy = f"Choose one, such as {option}"
    if have_one_answer:
        option = " ".join(["--variable all", *answers.pop()])
        remedy = f"Take each as a log: {option}; or choose one: --variable {first}"
    problem = (
        f"{len(plans)} of {len(file.names)} recordings of the file are logs: {listed(file.logs)}"
    )
    if _are_alike(plans, {name: file.tables[name] for name in file.logs}):
        raise AlikeRecordingsError(problem, remedy=remedy, where=file.where, option=option)
    raise SeveralRecordingsError(problem, remedy=remedy, where=file.where, option=option)


def _are_alike(plans: Sequence[Plan], logs: Mapping[str, Table]) -> bool:
    """Whether recordings are read in one way without a question, and none holds the rows of another one.

    At fields of their own, that columns, settings or names tell, the same motion is no copy.
    """
    tell_fields = len(fields_told_by([*logs])) == len(logs)
    answered = {"field"} if tell_fields else set[str]()
    ways: set[tuple[tuple[str, str, str | None], ...]] = set()
    for plan in plans:
        if plan.doubts or any(question.signal not in answered for question in plan.questions):
            return False
        ways.add(tuple((each.signal, each.column, each.unit) for each in plan.signals))
    if len(ways) > 1:
        return False

    motions: list[str] = []
    for each in plans[0].signals:
        if each.signal in ("slip", "position") and each.column:
            motions.append(each.column)
    if not motions or tell_fields:
        return True
    motion = min(motions)
    courses: list[tuple[Array, Array]] = []  # of the motion and of the field
    for plan, table in zip(plans, logs.values(), strict=True):
        field = plan.signal("field")
        numbers = np.array(field.numbers if field is not None else ())
        if field is not None and field.column:
            numbers = table.columns[field.column]
        courses.append((table.columns[motion], numbers))
    for (course, field_of_course), (other, field_of_other) in combinations(courses, 2):
        # A filtered copy beside raw rows runs as they do, as far as the shorter of both goes.
        pairs = ((course, other), (field_of_course, field_of_other))
        if all(np.array_equal(a[: b.size], b[: a.size], equal_nan=True) for a, b in pairs):
            return False
    return True


def offer_to_join(file: RecordingsOfFile) -> None:
    """Recordings of which none is a log alone may be one when they are joined by time.

    The rows are those of the effort, since no effort is made up between two samples.

    Raises:
        LogError: together they are a log.
    """
    if len(file.names) > _MOST_JOINED:
        return
    with_effort: list[str] = []
    for name in file.names:
        plan = plan_if_any(file.tables[name]) if name in file.tables else None
        if plan is not None and not plan.signals_with_columns.isdisjoint(("effort", "T")):
            with_effort.append(name)
    others = [name for name in file.names if name not in with_effort]
    together = JOINT.join([*with_effort, *others])
    joined = file.joined(together)
    plan = None if joined is None else plan_if_any(joined, file.told, file.device)
    if plan is not None and plan.is_of_a_log:
        problem = f"no recording of the file is a log alone, and together they are one: {listed(file.names)}"
        option = f"--variable {shlex.quote(together)}"
        remedy = f"Join them by time: {option}"
        raise LogError(problem, remedy=remedy, where=file.where, option=option)


class RecordingChoice(NamedTuple):
    """One rule: what is known behind it, and the function that finds the log or asks the user."""

    settles: str
    rule: Callable[[RecordingsOfFile], Table | None]


#: All rules of choosing, in the order in which they are gone through.
CHOICES = (
    RecordingChoice("the only log is taken", take_the_only_log),
    RecordingChoice("of several logs the user takes one, or each", ask_which_log),
    RecordingChoice("whether recordings are a log when they are joined", offer_to_join),
)


def table_of_log(
    path: str | Path | DataFrame,
    told: ColumnMap,
    device: DeviceName | None,
    variable: str | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Table:
    """The table of a file; of several recordings without a choice that of the only log, with a note on the others.

    Args:
        path: of the file; or a DataFrame.
        told: what the user said of columns.
        device: see `erclutch.read`.
        variable: which recording; None or "": the user did not say.
        progress: see `read_table`.

    Raises:
        AlikeRecordingsError: several recordings are logs that are read in one way.
        LogError: the file cannot be read; several recordings are logs, or none is, and the remedy names those that are.
    """
    try:
        return read_table(path, variable=variable, decimal=told.decimal, told=progress)
    except SeveralRecordingsError as error:
        if variable or not isinstance(path, str | Path):
            raise
        names = recordings_of_file(path)
        if len(names) < 2:
            raise
        unchosen = error

    first = looked_into(names)
    tables = readable_tables(path, first, told.decimal)
    logs = plans_of_logs([(name, table, told) for name, table in tables.items()], device)
    # Beside a log, a table of fewer rows than a log has is a summary.
    long_logs = {name: plan for name, plan in logs.items() if tables[name].rows >= MINIMUM_ROWS}
    file = RecordingsOfFile(path, names, tables, long_logs or logs, told, device, unchosen.where)
    for choice in CHOICES if len(first) == len(names) else ():
        chosen = choice.rule(file)
        if chosen is not None:
            return chosen
    nearest = nearest_to_a_log(tables, told, device) or names[0]
    if nearest == names[0]:
        raise unchosen
    # The first recording is often a sheet of settings or results.
    option = f"--variable {shlex.quote(nearest)}"
    raise SeveralRecordingsError(
        unchosen.problem,
        remedy=f"Choose one, such as {option}, or --variable all",
        where=unchosen.where,
        option=option,
    )


def logs_among(
    path: str | Path, names: Sequence[str], told: ColumnMap, device: DeviceName | None
) -> dict[str, Table]:
    """The tables of those recordings of a file that have a motion and an effort, by name."""
    tables = readable_tables(path, names, told.decimal)
    logs = plans_of_logs([(name, table, told) for name, table in tables.items()], device)
    return {name: tables[name] for name in logs}
