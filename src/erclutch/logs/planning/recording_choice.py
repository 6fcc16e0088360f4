"""Of a file that holds several recordings, the only one that is a log of a device is taken; else the user is asked."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np

from erclutch.errors import AlikeRecordingsError, LogError
from erclutch.logs.clock.timing import MINIMUM_ROWS
from erclutch.logs.log_file import read_table, recordings_in, tables_in
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import Plan
from erclutch.logs.planning.whole_plan import is_log, plan_of, signals_of
from erclutch.logs.readers.found_recordings import JOINT
from erclutch.logs.table import Table, listed
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
        names = recordings_in(path)
        if not 1 < len(names) <= _MOST:
            raise
        unchosen = error

    tables = tables_of(path, names, told)
    logs = {name: table for name, table in tables.items() if is_log(table, told, device)}
    # Beside a log, a table of fewer rows than a log has is a summary.
    logs = {name: table for name, table in logs.items() if table.rows >= MINIMUM_ROWS} or logs
    if len(logs) == 1:
        name, table = next(iter(logs.items()))
        others = ", ".join(other for other in names if other != name)
        note = f"recording {name}: no other has columns of a motion and an effort ({others})"
        return replace(table, notes=(note, *table.notes))

    if len(logs) > 1:
        first = shlex.quote(next(iter(logs)))
        plans = [plan_of(table, told, device=device) for table in logs.values()]
        answers = {plan.examples for plan in plans}
        remedy = f"Choose one, such as --variable {first}"
        if len(answers) == 1 and not any(plan.doubts for plan in plans):
            options = " ".join(["--variable all", *answers.pop()])
            remedy = f"Take each as a log: {options}; or choose one: --variable {first}"
        problem = f"{len(logs)} of {len(names)} recordings of the file are logs: {listed(logs)}"
        kind = AlikeRecordingsError if _are_alike(plans, list(logs.values())) else LogError
        raise kind(problem, remedy=remedy, where=unchosen.where)

    # No recording is a log alone. Joined by time they may be one; the rows are those of the effort, since no effort is
    # made up between two samples.
    if len(names) > _MOST_JOINED:
        raise unchosen
    efforts = [name for name in names if name in tables and signals_of(tables[name]) & {"effort", "T"}]
    together = JOINT.join([*efforts, *(name for name in names if name not in efforts)])
    joined = tables_of(path, [together], told).get(together)
    if joined is None or not is_log(joined, told, device):
        raise unchosen
    problem = f"no recording of the file is a log alone, and together they are one: {listed(names)}"
    raise LogError(problem, remedy=f"Join them by time: --variable {shlex.quote(together)}", where=unchosen.where)


def _are_alike(plans: Sequence[Plan], tables: Sequence[Table]) -> bool:
    """Whether recordings are read in one way without a question, and none holds the rows of another one."""
    ways: set[tuple[tuple[str, str, str | None], ...]] = set()
    for plan in plans:
        if plan.questions or plan.doubts:
            return False
        ways.add(tuple((each.signal, each.column, each.unit) for each in plan.signals))
    if len(ways) > 1:
        return False
    moving = [each for each in plans[0].signals if each.signal in ("slip", "position")]
    motion = min((each.column for each in moving if each.column), default=None)
    if motion is None:
        return True
    courses = [table.columns[motion] for table in tables]
    return not any(_holds(course, other) for course, other in combinations(courses, 2))


def _holds(one: Array, other: Array) -> bool:
    """Whether two motions run alike as far as the shorter goes, as in a filtered copy beside raw rows."""
    rows = min(one.size, other.size)
    return bool(np.array_equal(one[:rows], other[:rows], equal_nan=True))


def logs_among(path: str | Path, names: Sequence[str], told: ColumnMap, device: DeviceName | None) -> dict[str, Table]:
    """The tables of those recordings of a file that have a motion and an effort, by name."""
    tables = tables_of(path, names, told)
    return {name: table for name, table in tables.items() if is_log(table, told, device)}


def tables_of(path: str | Path, names: Sequence[str], told: ColumnMap) -> dict[str, Table]:
    """The tables of recordings of a file, by name; a recording that is none has no table."""
    found = tables_in(path, names, told.decimal)
    return {name: table for name, table in found.items() if not isinstance(table, LogError)}
