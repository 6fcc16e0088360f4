"""TDMS logs of LabVIEW and DAQmx are read by npTDMS: a group is a recording, waveform properties give its time."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings, reader_in_child
from erclutch.logs.readers.budget import budget_of
from erclutch.logs.readers.found_recordings import Found
from erclutch.logs.readers.vectors import of_vectors
from erclutch.logs.table import Table

_CLOCK = ("wf_increment", "wf_start_offset", "wf_start_time")
#: A start in the file: a time stamp of 16 bytes, or a number.
_STARTS = re.compile(rb"wf_start_(?:time\x44\0\0\0.{16}|offset\n\0\0\0.{8})", re.DOTALL)
_UNITS = ("unit_string", "NI_UnitDescription")
_ONE_START = 0.1  # of an increment, by which channels that were started together differ


def _group(group: Any) -> Found | None:
    """The channels of a group on the clock that most of them have; the others are left out, and this is said."""
    # Increment, offset and start of each channel; starts that differ by less than a sample are one, the first.
    clocks: dict[str, tuple[Any, Any, Any]] = {}
    for channel in group.channels():
        increment, offset, start = (channel.properties.get(key) for key in _CLOCK)
        for known in clocks.values():
            begun = known[2]
            have_one_grid = increment and known[:2] == (increment, offset)
            if have_one_grid and start is not None and begun is not None:
                apart = abs(float((start - begun) / np.timedelta64(1, "s")))
                start = begun if apart <= _ONE_START * increment else start
        clocks[channel.name] = increment, offset, start
    if not clocks:
        return None
    clock = Counter(clocks.values()).most_common(1)[0][0]
    increment, offset, _ = clock  # s, s, date
    channels = [channel for channel in group.channels() if clocks[channel.name] == clock]
    hollow = [channel.name for channel in channels if not len(channel)]
    values = {channel.name: np.asarray(channel[:]) for channel in channels}

    recording = of_vectors(values)
    if recording is None:
        return None
    for key in _UNITS:  # where a channel has both, the later key counts
        for channel in channels:
            if key in channel.properties:
                recording.units[channel.name] = channel.properties[key]

    rows = len(next(iter(recording.columns.values())))
    dates = [
        (name, stamps)
        for name, stamps in values.items()
        if stamps.dtype.kind == "M" and stamps.size > 1
    ]
    if increment:
        time = (offset or 0.0) + np.arange(rows) * increment
        recording.columns = {"time": time, **recording.columns}
        recording.units["time"] = "s"
    elif dates and len(dates[0][1]) == rows:
        name, stamps = dates[0]
        recording.clock = name, (stamps - stamps[0]) / np.timedelta64(1, "s")

    notes: list[str] = []
    if hollow:
        notes.append(f"channels without a value left out: {found_recordings.listed(hollow)}")
        if any("NI_ArrayColumn" in channel.properties for channel in channels):
            full = ", ".join(name for name in recording.columns if name not in hollow)
            notes.append(f"the values of all {len(channels)} channels may stand in {full}, in turn")
    for name in sorted(clocks):
        if clocks[name] != clock:
            other = "has another increment or start than the other channels"
            notes.append(f"channel {name} {other}: left out")
    recording.notes += notes
    return recording


def find(path: str, variable: str | None) -> Table:
    """The child's work."""
    from nptdms import TdmsFile

    budget = budget_of(Path(path))
    with TdmsFile.open(path) as heads:
        for group in heads.groups():
            for channel in group.channels():
                budget.take_names()
                budget.take_cells(len(channel))

    file = TdmsFile.read(path)
    recordings: dict[str, Found] = {}
    starts: set[Any] = set()  # that npTDMS knows: the last of each channel
    for group in file.groups():
        recording = _group(group)
        if recording is not None:
            recordings[group.name] = recording
        for channel in group.channels():
            starts.update(channel.properties.get(key) for key in _CLOCK[1:])

    notes: list[str] = []
    starts_in_file = {*_STARTS.findall(Path(path).read_bytes())}
    if len(starts_in_file) > len(starts - {None}):
        notes.append(
            "the acquisition was started anew within the file: its time runs on as if there were no gap"
        )
    if file.file_status.incomplete_final_segment:
        notes.append("the last segment was not written completely: the log is cut off there")
    for recording in recordings.values():
        recording.notes += notes
    return found_recordings.chosen(
        recordings, variable, "group", "no group of the file holds channels of numbers"
    )


READER = LogReader(
    suffixes=(".tdms",),
    claims=lambda head: head[:4] == b"TDSm",
    **reader_in_child.in_child("tdms", "nptdms"),
    tells_damage="not seen: TDMS has no checksums; a log that was cut off is seen",
)
