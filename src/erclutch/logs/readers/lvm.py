"""LabVIEW measurement files (.lvm) are text: a header, then segments, each with a header and a table."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from erclutch.errors import LogError, UnitError, placed
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import found_recordings, text
from erclutch.logs.readers.text_bytes import DAMAGE, decode
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array

_END = re.compile(r"^\*\*\*End_of_Header\*\*\*[^\n]*\n?", re.MULTILINE)
_NEXT = re.compile(r"^Channels\b", re.MULTILINE)


def _segment(source: LogSource, header: str, body: str, first: str) -> Table:
    """The table of a segment: units of its header, time from X_Value or else from X0 and Delta_X.

    Args:
        source: the file.
        header: lines ahead of the segment's table.
        body: the table as text.
        first: the header of the whole file, which says how all tables are written.
    """
    table = text.read_text(replace(source, data=body.encode()))
    separator = "," if re.search(r"^Separator\W+Comma", first, re.MULTILINE) else "\t"
    values_of: dict[str, list[str]] = {}  # of a line of the header, by its first cell
    for line in header.splitlines():
        key, *values = (cell.strip() for cell in line.split(separator))
        values_of[key] = values

    # The times. Where each channel has a column of them, all must be the same.
    time = table.columns.get("X_Value")
    if time is None:
        start = _number("X0", values_of)
        step = _number("Delta_X", values_of)
        time = start + step * np.arange(table.rows)
    else:
        others = [values for name, values in table.columns.items() if name.startswith("X_Value (")]
        if not all(np.array_equal(other, time, equal_nan=True) for other in others):
            raise LogError("the channels have times of their own", remedy="Export them with one X column")
    columns = {name: values for name, values in table.columns.items() if not name.startswith("X_Value")}

    # The header has a unit for each channel: of one time for all, the channels follow it; of several, each follows its.
    several_times = re.search(r"^X_Columns\W+Multi", first, re.MULTILINE)
    apart = 2 if several_times else 1
    of_channels = values_of.get("Y_Unit_Label", [])
    unit_at = dict(enumerate(of_channels, start=1 if several_times else 2))
    units_of: dict[str, str | None] = {"time": "s"}
    for name in columns:
        units_of[name] = table.units.get(name) or unit_at.get(table.numbers[name] // apart) or None

    notes = list(table.notes)
    count = "".join(values_of.get("Samples", [])[:1])
    if count.isdecimal() and table.rows < int(count):
        notes.append(f"a segment has {table.rows} rows of {count}")
    return replace(
        table,
        columns={"time": time, **columns},
        units=units_of,
        numbers={},
        notes=tuple(notes),
    )


def _number(key: str, values_of: Mapping[str, Sequence[str]]) -> float:
    """The first number of a line of a header.

    Raises:
        LogError: there is none.
    """
    written = "".join(values_of.get(key, [])[:1])
    try:
        number, _ = units.quantity(written.replace(",", "."))
    except UnitError as error:
        problem = f"there is no X_Value, and {key} is {written!r:.40}, not a number"
        raise LogError(problem, remedy="Copy the file again, or export it as CSV with a column of times") from error
    return number


def _read(source: LogSource) -> Table:
    """The segments as one recording where their time goes on, else as several; LabVIEW also writes tables alone."""
    if not _claims(source.data):
        return text.READER.read(source)
    first, *parts = _END.split(decode(source.data).replace("\r\n", "\n"))
    if len(parts) < 2:
        raise LogError("the file has no segment", remedy="Copy the file again, or export it as CSV")
    segments: list[Table] = []
    header, *tables = parts
    for part in tables:
        # Behind a table stands the header of the next.
        following = _NEXT.search(part)
        end = following.start() if following else len(part)
        with placed(f"{source.name}, segment {len(segments) + 1}"):
            segments.append(_segment(source, header, part[:end], first))
        header = part[end:]

    times = np.concatenate([segment.columns["time"] for segment in segments])
    same_channels = len({tuple(segment.columns) for segment in segments}) == 1
    if not same_channels or not (np.diff(times) > 0).all():
        recordings = {f"segment {number}": segment for number, segment in enumerate(segments, start=1)}
        name, table = found_recordings.choose(recordings, source.variable, "segment", "")
        return replace(table, notes=(*table.notes, f"recording read from {name} of {len(segments)}"))

    columns: dict[str, Array] = {}
    for name in segments[0].columns:
        columns[name] = np.concatenate([segment.columns[name] for segment in segments])
    notes = list(dict.fromkeys(note for segment in segments for note in segment.notes))
    if len(segments) > 1:
        notes.append(f"{len(segments)} segments are joined: their time goes on")
    return replace(segments[0], columns=columns, notes=tuple(notes))


def _claims(head: bytes) -> bool:
    return head.startswith(b"LabVIEW Measurement")


READER = LogReader((".lvm",), _claims, _read, recordings=found_recordings.names_by(_read), tells_damage=DAMAGE)
