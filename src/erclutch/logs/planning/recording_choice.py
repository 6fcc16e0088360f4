"""Of a file that holds several recordings, the only one that is a log of a device is taken; else the user is asked."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np

from erclutch.errors import AlikeRecordingsError, LogError, listed
from erclutch.logs.clock.timing import MINIMUM_ROWS
from erclutch.logs.columns.levels_in_names import differ_by_field
from erclutch.logs.log_file import read_table, readable_tables, recordings_of_file
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import Plan
from erclutch.logs.planning.whole_plan import plan_if_any
from erclutch.logs.readers.found_recordings import JOINT
from erclutch.logs.table import Table
from erclutch.signals.array import Array
from erclutch.signals.device import DeviceName

_MOST = 40  # recordings that are looked into
_MOST_JOINED = 12  # recordings, since a device has few signals


def table_of_log(
    path: str | Path,
    told: ColumnMap,
    device: DeviceName | None,
    variable: str | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Table:
    """The table of a file; of several recordings without a choice that of the only log, with a note on the others.

    Args:
        path: of the file.
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
    except LogError as error:
        if variable or "several recordings" not in error.problem:
            raise
        names = recordings_of_file(path)
        if not 1 < len(names) <= _MOST:
            raise
        unchosen = error

    tables = readable_tables(path, names, told.decimal)
    logs: dict[str, Table] = {}
    plans: dict[str, Plan] = {}  # of those that are logs
    for name, table in tables.items():
        plan = plan_if_any(table, told, device)
        if plan is not None and plan.is_of_a_log:
            logs[name] = table
            plans[name] = plan
    # Beside a log, a table of fewer rows than a log has is a summary.
    long_logs = {name: table for name, table in logs.items() if table.rows >= MINIMUM_ROWS}
    logs = long_logs or logs
    if len(logs) == 1:
        name, table = next(iter(logs.items()))
        beside = _with_the_field(path, name, plans[name], tables, told, device)
        if beside:
            problem = (
                f"recording {name} is a log without a field, and {listed(beside)} may be the field"
            )
            together = shlex.quote(JOINT.join([name, *beside]))
            remedy = f"Join them by time: --variable {together}; or leave the field out: --variable {shlex.quote(name)}"
            raise LogError(problem, remedy=remedy, where=unchosen.where)
        left_out = ", ".join(other for other in names if other != name)
        note = f"recording {name}: no other has columns of a motion and an effort ({left_out})"
        return replace(table, notes=(note, *table.notes))

    if len(logs) > 1:
        first = shlex.quote(next(iter(logs)))
        plans_of_logs = [plans[name] for name in logs]
        answers = {plan.examples for plan in plans_of_logs}
        have_one_answer = len(answers) == 1 and not any(plan.doubts for plan in plans_of_logs)
        if have_one_answer:
            options = " ".join(["--variable all", *answers.pop()])
            remedy = f"Take each as a log: {options}; or choose one: --variable {first}"
        else:
            remedy = f"Choose one, such as --variable {first}"
        problem = f"{len(logs)} of {len(names)} recordings of the file are logs: {listed(logs)}"
        if _are_alike(plans_of_logs, logs):
            raise AlikeRecordingsError(problem, remedy=remedy, where=unchosen.where)
        raise LogError(problem, remedy=remedy, where=unchosen.where)

    # No recording is a log alone. Joined by time they may be one; the rows are those of the effort, since no effort is
    # made up between two samples.
    if len(names) > _MOST_JOINED:
        raise unchosen
    with_effort: list[str] = []
    for name in names:
        plan = plan_if_any(tables[name]) if name in tables else None
        if plan is not None and not plan.signals_with_columns.isdisjoint(("effort", "T")):
            with_effort.append(name)
    others = [name for name in names if name not in with_effort]
    together = JOINT.join([*with_effort, *others])
    joined = readable_tables(path, [together], told.decimal).get(together)
    plan = None if joined is None else plan_if_any(joined, told, device)
    if plan is None or not plan.is_of_a_log:
        raise unchosen
    problem = f"no recording of the file is a log alone, and together they are one: {listed(names)}"
    raise LogError(
        problem,
        remedy=f"Join them by time: --variable {shlex.quote(together)}",
        where=unchosen.where,
    )


def _with_the_field(
    path: str | Path,
    name: str,
    plan: Plan,
    tables: Mapping[str, Table],
    told: ColumnMap,
    device: DeviceName | None,
) -> list[str]:
    """The recordings beside the only log that hold a field, where the log has none; as a topic of a current may be."""
    said = told.columns.keys() | told.constants.keys()
    if not said.isdisjoint({"field", "E", "E1", "E2"}) or plan.sure_field:
        return []
    beside: list[str] = []
    for other in [other for other in tables if other != name][:_MOST_JOINED]:
        together = JOINT.join([name, other])
        joined = readable_tables(path, [together], told.decimal).get(together)
        if joined is not None:
            of_both = plan_if_any(joined, told, device)
            field = "" if of_both is None else of_both.sure_field
            if field and field not in tables[name].columns:
                beside.append(other)
            continue
        by_itself = plan_if_any(tables[other]) if tables[other].rows >= MINIMUM_ROWS else None
        if by_itself is not None and "field" in by_itself.signals_with_columns:
            problem = f"recording {name} is a log without a field, and {other}, which may be it, has no time in common"
            remedy = f"Put the field beside its rows, or leave it out: --variable {shlex.quote(name)} --field none"
            raise LogError(problem, remedy=remedy, where=Path(path).name)
    return beside


def _are_alike(plans: Sequence[Plan], logs: Mapping[str, Table]) -> bool:
    """Whether recordings are read in one way without a question, and none holds the rows of another one.

    At fields of their own, that columns, settings or names tell, the same motion is no copy.
    """
    ways: set[tuple[tuple[str, str, str | None], ...]] = set()
    for plan in plans:
        if plan.questions or plan.doubts:
            return False
        ways.add(tuple((each.signal, each.column, each.unit) for each in plan.signals))
    if len(ways) > 1:
        return False

    motions: list[str] = []
    for each in plans[0].signals:
        if each.signal in ("slip", "position") and each.column:
            motions.append(each.column)
    if not motions or differ_by_field([*logs]):
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


def logs_among(
    path: str | Path, names: Sequence[str], told: ColumnMap, device: DeviceName | None
) -> dict[str, Table]:
    """The tables of those recordings of a file that have a motion and an effort, by name."""
    logs: dict[str, Table] = {}
    for name, table in readable_tables(path, names, told.decimal).items():
        plan = plan_if_any(table, told, device)
        if plan is not None and plan.is_of_a_log:
            logs[name] = table
    return logs
