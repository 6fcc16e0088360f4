"""One file a signal: a folder of such files, or files named as ``a.csv + b.csv``, is one log, put together by time.

Each file has a time and one or a few columns. The rows are those of the file with the effort, so that no effort is made
up between two samples. The clocks of all files are taken for one clock.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from erclutch.errors import ErclutchError, LogError, printable
from erclutch.logs.clock_planning import clock_plan
from erclutch.logs.log_reader import HEAD, LogReader, LogSource, claims_nothing, log_suffixes, read_by, reader_of
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.readers.found_recordings import JOINT, NO_NAME, Found, joined_by_time
from erclutch.logs.readers.text_tables import is_prose
from erclutch.logs.recognition import is_log, signals_of
from erclutch.logs.seen_columns import seen_columns
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_MOST = 12  # files: a device has few signals, and a folder of more holds logs
_LOOKED_AT = 1 << 16  # bytes of a text that tell what its columns are
_LARGEST_LOOKED_AT = 1 << 22  # bytes of a file that is read whole to look at its columns
_SHARED = 0.5  # share of the longest file that all files must have


def parts_of(path: Path) -> list[Path]:
    """The files that a folder holds, or that a name such as ``a.csv + b.csv`` lists; none for any other path."""
    if path.is_dir():
        suffixes = log_suffixes()
        files = sorted(each for each in path.iterdir() if each.suffix.lower() in suffixes and each.is_file())
        return [each for each in files if not is_prose(each)]
    names = [name.strip() for name in path.name.split(JOINT)]
    parts = [path.with_name(name) for name in names if name]
    return parts if len(parts) > 1 and not path.exists() and all(part.is_file() for part in parts) else []


def together(paths: Sequence[Path]) -> Path | None:
    """Several files of a folder as the path of one log, where each of them holds signals that the others lack."""
    if len({path.parent for path in paths}) != 1 or not 1 < len(paths) <= _MOST:
        return None
    path = paths[0].with_name(JOINT.join(each.name for each in paths))
    return path if len(parts_of(path)) == len(paths) and _one_log(path) else None


def _is_one_log(path: Path) -> bool:
    """Whether a folder is one log; files that are named together are one because the user says so."""
    parts = parts_of(path)
    return bool(parts) and (not path.is_dir() or (1 < len(parts) <= _MOST and _one_log(path)))


def _one_log(path: Path) -> bool:
    files = [(each, each.stat()) for each in parts_of(path)]
    return _one_log_of(tuple((each, stat.st_size, stat.st_mtime_ns) for each, stat in files))


@lru_cache(maxsize=16)
def _one_log_of(files: tuple[tuple[Path, int, int], ...]) -> bool:
    """Whether files hold a log only together: none has a motion and an effort, all of them have both.

    Args:
        files: each with its size and the time of its last change, so that a changed file is looked at again.
    """
    tables: dict[str, Table] = {}
    for path, size, _ in files:
        table = _looked_at(path, size)
        if table is None or is_log(table) or _stamps(table) is None:
            return False
        tables[path.name] = table
    rows = min(table.rows for table in tables.values())
    columns: dict[str, Array] = {"time": np.arange(rows, dtype=np.float64) * 1e-3}
    units: dict[str, str | None] = {"time": "s"}
    for file, names in _names(tables).items():
        readable = tables[file].columns
        columns |= {name: readable[label][:rows] for label, name in names.items() if label in readable}
        units |= {name: tables[file].units.get(label) for label, name in names.items()}
    return is_log(Table("", columns, units, ""))


def _looked_at(path: Path, size: int) -> Table | None:
    """The first rows of a text, or the whole of another small file; None for what is no table."""
    try:
        with path.open("rb") as file:
            data = file.read(_LOOKED_AT)
            plugin, _ = reader_of(data[:HEAD], path.suffix)
            if plugin.name == "text" and size > len(data):
                data = data[: data.rfind(b"\n") + 1]
            elif size > _LARGEST_LOOKED_AT:
                return None
            else:
                data += file.read()
        return read_by(plugin, LogSource(path, data, ""))
    except (ErclutchError, OSError):
        return None


def _stamps(table: Table) -> tuple[str, Array, str | None] | None:
    """The column of a table's time, its stamps in s, shape (rows,), and the unit as written; None without such one."""
    try:
        clock = clock_plan(seen_columns(table), ColumnMap(), [])
    except ErclutchError:
        return None
    if clock.kind != "column":
        return None  # rows or dates are counted from the first row of each file
    return clock.column, table.columns[clock.column] * clock.factor, clock.unit


def _names(tables: Mapping[str, Table]) -> dict[str, dict[str, str]]:
    """Names that tell the columns of all files apart, by file and label; the times have none."""
    labels = Counter(label for table in tables.values() for label in (*table.columns, *table.unreadable))
    names: dict[str, dict[str, str]] = {}
    for file, table in tables.items():
        stamps = _stamps(table)
        own = [label for label in (*table.columns, *table.unreadable) if stamps is None or label != stamps[0]]
        stem = Path(file).stem
        names[file] = {label: label for label in own}
        for label in own:
            if labels[label] > 1 or NO_NAME.fullmatch(label):
                names[file][label] = stem if len(own) == 1 else f"{stem} {label}"
    return names


def _read(source: LogSource) -> Table:
    """The files of a log as one table; see the module."""
    parts = parts_of(source.path)
    tables = {printable(part.name): _part(part, source) for part in parts}
    times = {file: _stamps(table) for file, table in tables.items()}
    for file, stamps in times.items():
        if stamps is None:
            problem = f"{file} has no column of times in numbers, by which it could be joined with the others"
            raise LogError(problem, remedy="Give each file a time in s, or one file with all signals")
    written = {file: stamps[2] for file, stamps in times.items() if stamps}
    bare = [file for file, unit in written.items() if not unit]
    if bare and len(bare) < len(written):
        other = next(file for file, unit in written.items() if unit)
        problem = f"the time of {bare[0]} has no unit, and that of {other} is in {written[other]}"
        raise LogError(problem, remedy="Write the unit into each header, such as 'time [s]'")
    found: dict[str, Found] = {}
    unreadable: dict[str, str] = {}
    names = _names(tables)
    for file in _effort_first(tables):
        table, stamps = tables[file], times[file]
        readable = {name: label for label, name in names[file].items() if label in table.columns}
        held = {"time": np.zeros(0) if stamps is None else stamps[1]}
        held |= {name: table.columns[label] for name, label in readable.items()}
        found[file] = Found(held, {"time": "s", **{name: table.units.get(label) for name, label in readable.items()}})
        unreadable |= {names[file][label]: f"{file}, {problem}" for label, problem in table.unreadable.items()}
    _require_overlap(found)
    joined = joined_by_time(found, "file")
    notes = [f"{file}: {note}" for file, table in tables.items() for note in table.notes]
    suffixes = log_suffixes()
    inside = sorted(source.path.iterdir()) if source.path.is_dir() else []
    beside = [each.name for each in inside if each.suffix.lower() in suffixes and each not in parts]
    notes += [f"{printable(name)} holds words and no rows of numbers: left out" for name in beside]
    notes = [*joined.notes, "the clocks of the files are taken for one clock", *notes]
    table = replace(joined, notes=notes).table()
    units = {**table.units, "time": None if bare else "s"}
    return replace(table, name=source.name, digest=source.digest, units=units, unreadable=unreadable)


def _part(path: Path, source: LogSource) -> Table:
    data = path.read_bytes()
    plugin, _ = reader_of(data[:HEAD], path.suffix)
    return read_by(plugin, LogSource(path, data, hashlib.sha256(data).hexdigest(), decimal=source.decimal))


def _effort_first(tables: Mapping[str, Table]) -> list[str]:
    """The files, first the file with the effort; where none is sure, the file with most rows in a second."""

    def place(file: str) -> tuple[bool, float]:
        stamps = _stamps(tables[file])
        steps = np.diff(stamps[1]) if stamps else np.zeros(0)
        step = float(np.median(steps)) if steps.size else float("inf")
        return not signals_of(tables[file]) & {"effort", "T"}, step

    return sorted(tables, key=place)


def _require_overlap(found: Mapping[str, Found]) -> None:
    ends = {file: (float(each.columns["time"][0]), float(each.columns["time"][-1])) for file, each in found.items()}
    longest = max(ends, key=lambda file: ends[file][1] - ends[file][0])
    span = ends[longest][1] - ends[longest][0]
    shared = min(end for _, end in ends.values()) - max(begin for begin, _ in ends.values())
    if not shared >= _SHARED * span:
        problem = f"the files share {max(shared, 0.0):.4g} s of the {span:.4g} s of {longest}"
        raise LogError(problem, remedy="Check the units of their times, or give files of one time")


READER = LogReader(
    (), claims_nothing, _read, joins=_is_one_log, tells_damage="not seen or seen as in each of its files"
)
