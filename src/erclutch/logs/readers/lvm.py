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

_END = re.compile(r"^\*\*\*End_of_Header\*\*\*[^\n]*\n?", re.MULTILINE)
_NEXT = re.compile(r"^Channels\b", re.MULTILINE)


def _segment(source: LogSource, header: str, body: str, first: str) -> Table:
    """The table of a segment: units of its header, time from X_Value or else from X0 and Delta_X."""
    table = text.read_text(replace(source, data=body.encode()))
    separator = "," if re.search(r"^Separator\W+Comma", first, re.MULTILINE) else "\t"
    lines = [[cell.strip() for cell in line.split(separator)] for line in header.splitlines()]
    pairs, multi = {key: values for key, *values in lines}, re.search(r"^X_Columns\W+Multi", first, re.MULTILINE)
    time = table.columns.get("X_Value")
    columns = {name: values for name, values in table.columns.items() if not name.startswith("X_Value")}
    others = [values for name, values in table.columns.items() if name.startswith("X_Value (")]
    if time is not None and any(not np.array_equal(each, time, equal_nan=True) for each in others):
        raise LogError("the channels have times of their own", remedy="Export them with one X column")
    if time is None:
        start, step = (_number(key, pairs) for key in ("X0", "Delta_X"))
        time = start + step * np.arange(table.rows)
    said = dict(enumerate(pairs.get("Y_Unit_Label", []), start=1 if multi else 2))
    own = {name: said.get(table.numbers[name] // (2 if multi else 1)) or None for name in columns}
    count = "".join(pairs.get("Samples", [])[:1])
    cut = [f"a segment has {table.rows} rows of {count}"] if count.isdecimal() and table.rows < int(count) else []
    kept = {"time": "s", **{name: table.units.get(name) or own[name] for name in columns}}
    return replace(table, columns={"time": time, **columns}, units=kept, numbers={}, notes=(*table.notes, *cut))


def _number(key: str, pairs: Mapping[str, Sequence[str]]) -> float:
    """The first number of a line of a header.

    Raises:
        LogError: there is none.
    """
    text = "".join(pairs.get(key, [])[:1])
    try:
        return units.quantity(text.replace(",", "."))[0]
    except UnitError as error:
        problem = f"there is no X_Value, and {key} is {text!r:.40}, not a number"
        raise LogError(problem, remedy="Copy the file again, or export it as CSV with a column of times") from error


def _read(source: LogSource) -> Table:
    """The segments as one recording where their time goes on, else as several."""
    first, *parts = _END.split(decode(source.data).replace("\r\n", "\n"))
    if len(parts) < 2:
        raise LogError("the file has no segment", remedy="Copy the file again, or export it as CSV")
    header, segments = parts[0], list[Table]()
    for part in parts[1:]:
        cut = _NEXT.search(part)
        with placed(f"{source.name}, segment {len(segments) + 1}"):
            segments.append(_segment(source, header, part[: cut.start()] if cut else part, first))
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


def _claims(head: bytes) -> bool:
    return head.startswith(b"LabVIEW Measurement")


READER = LogReader((".lvm",), _claims, _read, recordings=found_recordings.names_by(_read), tells_damage=DAMAGE)
