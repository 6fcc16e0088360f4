"""LabVIEW measurement files (.lvm) are text: a header, then segments, each with a header and a table."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import found_recordings, text
from erclutch.logs.table import Table
from erclutch.signals import units

_END = re.compile(r"^\*\*\*End_of_Header\*\*\*[^\n]*\n?", re.MULTILINE)
_NEXT = re.compile(r"^Channels\b", re.MULTILINE)


def _segment(source: LogSource, header: str, body: str, multi: bool) -> Table:
    """The table of a segment: units of its header, time from X_Value or else from X0 and Delta_X."""
    table = text.read_text(replace(source, data=body.encode()))
    lines = [[cell.strip() for cell in re.split(r"[\t;]|,(?=\D)|, ", line)] for line in header.splitlines()]
    pairs = {key: values for key, *values in lines}
    time = table.columns.get("X_Value")
    columns = {name: values for name, values in table.columns.items() if not name.startswith("X_Value")}
    others = [values for name, values in table.columns.items() if name.startswith("X_Value (")]
    if time is not None and any(not np.array_equal(each, time, equal_nan=True) for each in others):
        raise LogError("the channels have times of their own", remedy="Export them with one X column")
    if time is None:
        start, step = (units.quantity(pairs.get(key, [""])[0])[0] for key in ("X0", "Delta_X"))
        time = start + step * np.arange(table.rows)
    said = pairs.get("Y_Unit_Label", [])
    place = {name: table.numbers[name] // 2 - 1 if multi else table.numbers[name] - 2 for name in columns}
    own = {name: said[at] or None for name, at in place.items() if at < len(said)}
    count = pairs.get("Samples", [""])[0]
    short = count.isdecimal() and table.rows < int(count)
    notes = (*table.notes, *([f"a segment has {table.rows} rows of {count}: it is cut off"] if short else []))
    kept = {"time": "s", **{name: table.units.get(name) or own.get(name) for name in columns}}
    return replace(table, columns={"time": time, **columns}, units=kept, numbers={}, notes=notes)


def _read(source: LogSource) -> Table:
    """The segments as one recording where their time goes on, else as several."""
    first, *parts = _END.split(text.decode(source.data).replace("\r\n", "\n"))
    if len(parts) < 2:
        raise LogError("the file has no segment", remedy="Copy the file again, or export it as CSV")
    multi = re.search(r"^X_Columns\W+Multi", first, re.MULTILINE) is not None
    header, segments = parts[0], list[Table]()
    for part in parts[1:]:
        cut = _NEXT.search(part)
        segments.append(_segment(source, header, part[: cut.start()] if cut else part, multi))
        header = part[cut.start() :] if cut else ""
    times = np.concatenate([each.columns["time"] for each in segments])
    if len({tuple(each.columns) for each in segments}) > 1 or not (np.diff(times) > 0).all():
        found = {f"segment {number}": each for number, each in enumerate(segments, start=1)}
        name, table = found_recordings.choose(found, source.variable, "segment", "")
        return replace(table, notes=(*table.notes, f"recording read from {name} of {len(segments)}"))
    columns = {name: np.concatenate([each.columns[name] for each in segments]) for name in segments[0].columns}
    more = (f"{len(segments)} segments are joined: their time goes on",) if len(segments) > 1 else ()
    notes = dict.fromkeys(note for each in segments for note in each.notes)
    return replace(segments[0], columns=columns, notes=(*notes, *more))


READER = LogReader((".lvm",), lambda head: head.startswith(b"LabVIEW Measurement"), _read, tells_damage=text.DAMAGE)
