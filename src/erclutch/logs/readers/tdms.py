"""TDMS logs of LabVIEW and DAQmx are read by npTDMS: a group is a recording, waveform properties give its time."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.budget import budget_of
from erclutch.logs.readers.found_recordings import Found
from erclutch.logs.table import Table

_CLOCK = ("wf_increment", "wf_start_offset", "wf_start_time")
#: A start in the file: a time stamp of 16 bytes, or a number.
_STARTS = re.compile(rb"wf_start_(?:time\x44\0\0\0.{16}|offset\n\0\0\0.{8})", re.DOTALL)
_UNITS = ("unit_string", "NI_UnitDescription")


def _group(group: Any) -> Found | None:
    """The channels of a group on the clock that most of them have; the others are left out, and this is said."""
    clocks = {one.name: tuple(one.properties.get(key) for key in _CLOCK) for one in group.channels()}
    clock = Counter(clocks.values()).most_common(1)[0][0] if clocks else (None, None, None)
    channels = {one.name: one for one in group.channels() if clocks[one.name] == clock}
    values = {name: np.asarray(one[:]) for name, one in channels.items()}
    stamps = next(((name, each) for name, each in values.items() if each.dtype.kind == "M" and each.size > 1), None)
    found = found_recordings.of_vectors(values)
    if found is None:
        return None
    given = ((name, one.properties, key) for key in _UNITS for name, one in channels.items())
    found.units = {name: properties[key] for name, properties, key in given if key in properties}
    rows = len(next(iter(found.columns.values())))
    if clock[0]:
        found.columns = {"time": (clock[1] or 0.0) + np.arange(rows) * clock[0], **found.columns}
        found.units["time"] = "s"
    elif stamps is not None and len(stamps[1]) == rows:
        found.clock = stamps[0], (stamps[1] - stamps[1][0]) / np.timedelta64(1, "s")
    for name in sorted(set(clocks) - set(channels)):
        found.notes.append(f"channel {name} has another increment or start than the other channels: left out")
    return found


def find(path: str, variable: str | None) -> Table:
    """The child's work."""
    from nptdms import TdmsFile

    budget = budget_of(Path(path))
    with TdmsFile.open(path) as heads:
        for each in (channel for group in heads.groups() for channel in group.channels()):
            budget.take_names()
            budget.take_cells(len(each))
    file = TdmsFile.read(path)
    found = {group.name: each for group in file.groups() if (each := _group(group)) is not None}
    starts = {each.properties.get(key) for one in file.groups() for each in one.channels() for key in _CLOCK[1:]}
    notes: list[str] = []
    if len(set(_STARTS.findall(Path(path).read_bytes()))) > len(starts - {None}):  # npTDMS keeps the last start
        notes.append("the acquisition was started anew within the file: its time runs on as if there were no gap")
    if file.file_status.incomplete_final_segment:
        notes.append("the last segment was not written completely: the log is cut off there")
    for each in found.values():
        each.notes += notes
    return found_recordings.chosen(found, variable, "group", "no group of the file holds channels of numbers")


_DAMAGE = "not seen: TDMS has no checksums; a log that was cut off is seen"
READER = LogReader(
    (".tdms",), lambda head: head[:4] == b"TDSm", **found_recordings.in_child("tdms", "nptdms"), tells_damage=_DAMAGE
)
