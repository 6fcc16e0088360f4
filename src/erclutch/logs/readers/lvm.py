"""LabVIEW measurement files (.lvm) are text: a header, then segments, each with a header and a table."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from erclutch.errors import LogError, UnitError, placed
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.text_bytes import DAMAGE, decode
from erclutch.logs.readers.text_table import read_text
from erclutch.logs.readers.text_tables import read_tables
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array

_END = re.compile(r"^\*\*\*End_of_Header\*\*\*[^\n]*\n?", re.MULTILINE)
_NEXT = re.compile(r"^Channels\b", re.MULTILINE)
_COMMAS = re.compile(r"^Separator\W+Comma", re.MULTILINE)
_SEVERAL_TIMES = re.compile(r"^X_Columns\W+Multi", re.MULTILINE)


def _segment(source: LogSource, header: str, body: str, first: str) -> Table:
    """The table of a segment: units of its header, time from X_Value or else from X0 and Delta_X.

    Args:
        source: the file.
        header: lines ahead of the segment's table.
        body: the table as text.
        first: the header of the whole file, which says how all tables are written.
    """
    table = read_text(replace(source, data=body.encode()))
    separator = "," if _COMMAS.search(first) else "\t"
    values_of: dict[str, list[str]] = {}  # of a line of the header, by its first cell
    for line in header.splitlines():
        key, *values = line.split(separator)
        values_of[key.strip()] = [value.strip() for value in values]

    # The times. Where each channel has a column of them, all must be the same.
    time = table.columns.get("X_Value")
    if time is None:
        start = _number("X0", values_of)
        step = _number("Delta_X", values_of)
        time = start + step * np.arange(table.rows)
    channels: dict[str, Array] = {}
    for name, values in table.columns.items():
        if name.startswith("X_Value (") and not np.array_equal(values, time, equal_nan=True):
            raise LogError(
                "the channels have times of their own", remedy="Export them with one X column"
            )
        if not name.startswith("X_Value"):
            channels[name] = values

    # The header has a unit for each channel. Of one time for all, the channels follow it: the first is the second
    # column. Of several times, each channel follows its own: the first two columns are the first channel's. Then the
    # header may have gaps above the times; what each channel has there tells, for a channel may have no unit.
    has_several_times = _SEVERAL_TIMES.search(first) is not None
    of_each = [
        values
        for key in ("Samples", "X_Dimension", "Delta_X", "Date")
        if (values := values_of.get(key))
    ]
    if has_several_times and any(len(values) > 1 and not values[1] for values in of_each):
        has_several_times = False  # a unit stands above its column, as where there is one time
    unit_of_channel = values_of.get("Y_Unit_Label", [])
    units_of: dict[str, str | None] = {"time": "s"}
    for name in channels:
        number = table.numbers[name]  # of the column, from 1
        channel = number // 2 - 1 if has_several_times else number - 2
        unit = unit_of_channel[channel] if 0 <= channel < len(unit_of_channel) else ""
        units_of[name] = table.units.get(name) or unit or None

    notes = list(table.notes)
    samples = "".join(values_of.get("Samples", [])[:1])
    if samples.isdecimal() and table.rows < int(samples):
        notes.append(f"a segment has {table.rows} rows of {samples}")
    return replace(
        table,
        columns={"time": time, **channels},
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
        raise LogError(
            problem, remedy="Copy the file again, or export it as CSV with a column of times"
        ) from error
    return number


def _read(source: LogSource) -> Table:
    """The segments as one recording where their time goes on, else as several; LabVIEW also writes tables alone."""
    if not _claims(source.data):
        return read_tables(source)
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
    channels = {tuple(segment.columns) for segment in segments}
    goes_on = bool((np.diff(times) > 0).all())
    if len(channels) > 1 or not goes_on:
        recordings = {
            f"segment {number}": segment for number, segment in enumerate(segments, start=1)
        }
        name, table = found_recordings.choose(recordings, source.variable, "segment", "")
        return replace(
            table, notes=(*table.notes, f"recording read from {name} of {len(segments)}")
        )

    columns: dict[str, Array] = {}
    for name in segments[0].columns:
        columns[name] = np.concatenate([segment.columns[name] for segment in segments])
    notes: dict[str, None] = {}  # each once
    for segment in segments:
        notes |= dict.fromkeys(segment.notes)
    if len(segments) > 1:
        notes[f"{len(segments)} segments are joined: their time goes on"] = None
    return replace(segments[0], columns=columns, notes=tuple(notes))


def _claims(head: bytes) -> bool:
    return head.startswith(b"LabVIEW Measurement")


READER = LogReader(
    (".lvm",), _claims, _read, recordings=found_recordings.names_by(_read), tells_damage=DAMAGE
)
