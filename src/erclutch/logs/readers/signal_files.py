"""One file a signal: a folder of such files, or files named as ``a.csv + b.csv``, is one log, put together by time.

Each file has a time and one or a few columns. The rows are those of the file with the effort, so that no effort is made
up between two samples. The clocks of all files are taken for one clock.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from erclutch.errors import ErclutchError, LogError, printable
from erclutch.files.given_files import opened_plainly
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.log_reader import (
    HEAD,
    LogReader,
    LogSource,
    claims_nothing,
    log_suffixes,
    may_be_log,
    read_by,
    readable,
    reader_of,
    unchanged,
)
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.planning.clock_planning import clock_plan
from erclutch.logs.planning.whole_plan import is_log, signals_of
from erclutch.logs.readers.found_recordings import JOINT, NO_NAME, Found, joined_by_time
from erclutch.logs.readers.text_tables import is_prose
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_MOST = 12  # files: a device has few signals, and a folder of more holds logs
_LOOKED_AT = 1 << 16  # bytes of a text that tell what its columns are
_LARGEST_LOOKED_AT = 1 << 22  # bytes of a file that is read whole to look at its columns
_SHARED = 0.5  # share of the longest file that all files must have


@dataclass(frozen=True)
class _Stamps:
    """The times of one file.

    Attributes:
        column: that holds them.
        seconds: shape (rows,).
        unit: as written; None: none is.
    """

    column: str
    seconds: Array
    unit: str | None


def parts_of(path: Path) -> list[Path]:
    """The files that a folder holds, or that a name such as ``a.csv + b.csv`` lists; none for any other path."""
    if path.is_dir():
        return [file for file in _logs_in(path) if not is_prose(file)]
    names = [name.strip() for name in path.name.split(JOINT)]
    parts = [path.with_name(name) for name in names if name]
    if len(parts) < 2 or path.exists():
        return []
    return parts if all(part.is_file() for part in parts) else []


def _logs_in(folder: Path) -> list[Path]:
    suffixes = log_suffixes()
    return sorted(file for file in folder.iterdir() if may_be_log(file, suffixes))


def together(paths: Sequence[Path]) -> Path | None:
    """Several files of a folder as the path of one log, where each of them holds signals that the others lack."""
    folders = {path.parent for path in paths}
    if len(folders) != 1 or not 1 < len(paths) <= _MOST:
        return None
    path = paths[0].with_name(JOINT.join(each.name for each in paths))
    parts = parts_of(path)
    return path if len(parts) == len(paths) and _one_log(parts) else None


def _is_one_log(path: Path) -> bool:
    """Whether a folder is one log; files that are named together are one because the user says so."""
    parts = parts_of(path)
    if not path.is_dir():
        return bool(parts)
    return 1 < len(parts) <= _MOST and _one_log(parts)


def _one_log(parts: Sequence[Path]) -> bool:
    stats = [(part, part.stat()) for part in parts]
    return _one_log_of(tuple((part, stat.st_size, stat.st_mtime_ns) for part, stat in stats))


@lru_cache(maxsize=16)
def _one_log_of(files: tuple[tuple[Path, int, int], ...]) -> bool:
    """Whether files hold a log only together: none has a motion and an effort, all of them have both.

    Args:
        files: each with its size and the time of its last change, so that a changed file is looked at again.
    """
    tables: dict[str, Table] = {}
    times: dict[str, _Stamps] = {}
    for path, size, _ in files:
        # The first rows of a text, or the whole of another small file.
        try:
            with path.open("rb") as file:
                data = file.read(_LOOKED_AT)
                plugin, _ = reader_of(data[:HEAD], path.suffix)
                if plugin.name == "text" and size > len(data):
                    whole_lines = data.rfind(b"\n") + 1
                    data = data[:whole_lines]
                elif size > _LARGEST_LOOKED_AT:
                    return False
                else:
                    data += file.read()
            table = read_by(plugin, LogSource(path, data, ""))
        except (ErclutchError, OSError):
            return False  # it is no table

        stamps = None if is_log(table) else _stamps(table)
        if stamps is None:
            return False
        tables[path.name] = table
        times[path.name] = stamps

    # Their first rows beside each other, at times made up: only names and units count here.
    rows = min(table.rows for table in tables.values())
    columns: dict[str, Array] = {"time": np.arange(rows, dtype=np.float64) * 1e-3}
    units: dict[str, str | None] = {"time": "s"}
    for file, names in _names(tables, times).items():
        table = tables[file]
        for label, name in names.items():
            units[name] = table.units.get(label)
            if label in table.columns:
                columns[name] = table.columns[label][:rows]
    return is_log(Table("", columns, units, ""))


def _stamps(table: Table) -> _Stamps | None:
    """The times of a table; None where no column holds them."""
    try:
        clock = clock_plan(seen_columns(table), ColumnMap(), [])
    except ErclutchError:
        return None
    if clock.kind != "column":
        return None  # rows or dates are counted from the first row of each file
    return _Stamps(clock.column, table.columns[clock.column] * clock.factor, clock.unit)


def _names(tables: Mapping[str, Table], times: Mapping[str, _Stamps]) -> dict[str, dict[str, str]]:
    """Names that tell the columns of all files apart, by file and label; the times have none."""
    labels = {file: [*table.columns, *table.unreadable] for file, table in tables.items()}
    uses = Counter(label for own in labels.values() for label in own)
    names: dict[str, dict[str, str]] = {}
    for file in tables:
        own = [label for label in labels[file] if label != times[file].column]
        stem = Path(file).stem
        names[file] = {}
        for label in own:
            tells = uses[label] == 1 and not NO_NAME.fullmatch(label)
            if tells:
                names[file][label] = label
            else:
                names[file][label] = stem if len(own) == 1 else f"{stem} {label}"
    return names


def _read(source: LogSource) -> Table:
    """The files of a log as one table; see the module.

    Raises:
        LogError: a file has no times, some times have a unit and some none, or the files share too little time.
    """
    parts = parts_of(source.path)
    tables: dict[str, Table] = {}
    with unchanged(source.states):
        for part in parts:
            with readable(part), opened_plainly(part) as content:
                data = content.read()
            plugin, _ = reader_of(data[:HEAD], part.suffix)
            digest = hashlib.sha256(data).hexdigest()
            file = LogSource(part, data, digest, decimal=source.decimal)
            tables[printable(part.name)] = read_by(plugin, file)
    times: dict[str, _Stamps] = {}
    for file, table in tables.items():
        stamps = _stamps(table)
        if stamps is None:
            problem = f"{file} has no column of times in numbers, by which it could be joined with the others"
            remedy = "Give each file a time in s, or one file with all signals"
            raise LogError(problem, remedy=remedy)
        times[file] = stamps
    bare = [file for file, stamps in times.items() if not stamps.unit]
    with_unit = [file for file, stamps in times.items() if stamps.unit]
    if bare and with_unit:
        other = f"that of {with_unit[0]} is in {times[with_unit[0]].unit}"
        problem = f"the time of {bare[0]} has no unit, and {other}"
        raise LogError(problem, remedy="Write the unit into each header, such as 'time [s]'")
    names = _names(tables, times)

    signals: dict[str, Found] = {}
    unreadable: dict[str, str] = {}
    # First the file with the effort; where none is sure, the file with most rows in a second.
    order: dict[str, tuple[bool, float]] = {}
    for file, table in tables.items():
        steps = np.diff(times[file].seconds)
        step = float(np.median(steps)) if steps.size else float("inf")
        has_effort = bool(signals_of(table) & {"effort", "T"})
        order[file] = (not has_effort, step)
    files = sorted(tables, key=lambda file: order[file])
    for file in files:
        table = tables[file]
        recording = Found({"time": times[file].seconds}, {"time": "s"})
        for label, name in names[file].items():
            if label in table.columns:
                recording.columns[name] = table.columns[label]
                recording.units[name] = table.units.get(label)
        for label, problem in table.unreadable.items():
            unreadable[names[file][label]] = f"{file}, {problem}"
        signals[file] = recording

    begins = {file: float(times[file].seconds[0]) for file in files}
    ends = {file: float(times[file].seconds[-1]) for file in files}
    spans = {file: ends[file] - begins[file] for file in files}  # s
    longest = max(spans, key=lambda file: spans[file])
    shared = min(ends.values()) - max(begins.values())
    if not shared >= _SHARED * spans[longest]:
        of_longest = f"of the {spans[longest]:.4g} s of {longest}"
        problem = f"the files share {max(shared, 0.0):.4g} s {of_longest}"
        raise LogError(problem, remedy="Check the units of their times, or give files of one time")
    joined = joined_by_time(signals, "file")

    notes = [*joined.notes, "the clocks of the files are taken for one clock"]
    notes += [f"{file}: {note}" for file, table in tables.items() for note in table.notes]
    if source.path.is_dir():
        for path in _logs_in(source.path):
            if path not in parts:
                words = "holds words and no rows of numbers"
                notes.append(f"{printable(path.name)} {words}: left out")
    table = replace(joined, notes=notes).table()
    unit = "s" if with_unit else None
    return replace(
        table,
        name=source.name,
        digest=source.digest,
        units={**table.units, "time": unit},
        unreadable=unreadable,
    )


READER = LogReader(
    suffixes=(),
    claims=claims_nothing,
    read=_read,
    joins=_is_one_log,
    parts=parts_of,
    tells_damage="not seen or seen as in each of its files",
)
