"""A folder of logs holds other tables too: a test plan, the calibration of a load cell. They are no logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median

from erclutch.errors import ErclutchError
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.fields_beside_logs import WORKBOOKS, names_logs
from erclutch.logs.log_file import read_table, recordings_in, tables_in
from erclutch.logs.planning.whole_plan import is_log, signals_of
from erclutch.logs.table import Table

_LARGEST = 65_536  # bytes of such a table
_MOST_ROWS = 200
_OF_A_LOG = {"slip", "position", "effort"}


def tables_beside_logs(files: Sequence[Path]) -> list[Path]:
    """Small tables with units but without a motion and an effort, beside a log that has none of their columns.

    Where the columns of a log tell nothing either, no table is taken for another thing than the others.
    """
    sizes = {file: file.stat().st_size for file in files if file.is_file()}
    if len(sizes) < 2:
        return []
    # Logs of a series are alike in size: none of them is read twice.
    largest = min(_LARGEST, 0.5 * median(sizes.values()))
    plans = _plans(sizes)
    small = [file for file, size in sizes.items() if size <= largest and file not in plans]
    tables: dict[Path, Table] = {}
    # Plans, and JSON of another kind than the logs, which says something of these.
    beside: list[Path] = [*plans]
    for file in small:
        is_of_another_kind = file.suffix.lower() == ".json" and any(
            other.suffix != file.suffix for other in sizes
        )
        try:
            table = read_table(file)
        except ErclutchError:
            if is_of_another_kind:
                beside.append(file)
            continue  # whoever reads the log says what is wrong with it
        if is_of_another_kind and _OF_A_LOG.isdisjoint(signals_of(table)):
            beside.append(file)
            continue
        # Columns without any unit may be those of a short log of which nobody knows what they are.
        has_units = any(table.units.get(name) or spoken_name(name).end for name in table.columns)
        if has_units and table.rows <= _MOST_ROWS and _OF_A_LOG.isdisjoint(signals_of(table)):
            tables[file] = table
    apart = {*tables, *beside}
    others = sorted((file for file in sizes if file not in apart), key=lambda file: sizes[file])
    if not apart or not others:
        return []
    for file in others[:2]:  # one of them may be broken
        try:
            log = read_table(file)
        except ErclutchError:
            continue
        if is_log(log):
            without = [
                each
                for each, table in tables.items()
                if table.columns.keys().isdisjoint(log.columns)
            ]
            return [*beside, *without]
    return []


def _plans(sizes: Mapping[Path, int]) -> list[Path]:
    """Small workbooks beside logs of another kind that name these, or hold no motion and no effort: plans of tests."""
    plans: list[Path] = []
    for file, size in sizes.items():
        if file.suffix.lower() not in WORKBOOKS or size > _LARGEST:
            continue
        others = [other for other in sizes if other.suffix.lower() not in WORKBOOKS]
        if not others:
            continue
        if names_logs(file, others):
            plans.append(file)
            continue
        try:
            tables = tables_in(file, recordings_in(file) or [""]).values()
        except ErclutchError:
            continue  # whoever reads the log says what is wrong with it
        read = [table for table in tables if isinstance(table, Table)]
        if read and all(_OF_A_LOG.isdisjoint(signals_of(table)) for table in read):
            plans.append(file)
    return plans


def are_notes_above(files: Sequence[Path]) -> bool:
    """Whether a folder's files are small JSON that reads as no table, above inner folders that may hold the logs."""
    if not files or not any(each.is_dir() for each in files[0].parent.iterdir()):
        return False
    for file in files:
        if file.suffix.lower() != ".json" or file.stat().st_size > _LARGEST:
            return False
        try:
            read_table(file)
        except ErclutchError:
            continue
        return False
    return True
