"""MDF logs (.mf4, .mdf, .dat) are read by asammdf: a channel group is a recording, groups of one time are one."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings, reader_in_child
from erclutch.logs.readers.budget import budget_of
from erclutch.logs.readers.found_recordings import Found
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array


def find(path: str, variable: str | None) -> Table:
    """The child's work."""
    from asammdf import MDF

    budget = budget_of(Path(path))
    recordings: dict[str, Found] = {}
    clocks: dict[str, Array] = {}  # s, of each recording
    with MDF(path) as mdf:
        for index, group in enumerate(mdf.groups):
            head = group.channel_group
            budget.take_names(len(group.channels))
            budget.take_cells(head.cycles_nr * len(group.channels))

            said = getattr(head, "acq_name", "") or getattr(head, "comment", "")
            is_name = 0 < len(said) < 60 and said.isprintable() and said not in recordings
            name = said if is_name else f"group {index + 1}"
            time = np.asarray(mdf.get_master(index), dtype=np.float64)
            master = mdf.masters_db.get(index)  # place of the channel that is the time

            # Groups at the same times are one recording.
            same_clock = (other for other, clock in clocks.items() if np.array_equal(clock, time))
            joined_to = None if master is None else next(same_clock, None)
            recording = Found({}) if joined_to is None else recordings[joined_to]
            if master is not None and not recording.columns:
                channel = group.channels[master]
                label = channel.name or "time"
                recording.columns[label] = time
                recording.units[label] = channel.unit or "s"
            mark = f"group {name}" if units.is_unit(name) else name  # "(A)" would be read as a unit
            for place, channel in enumerate(group.channels):
                if place == master:
                    continue
                signal = mdf.get(group=index, index=place, ignore_invalidation_bits=True)
                if signal.samples.dtype.kind not in "biuf" or signal.samples.ndim != 1:
                    other = "holds no plain numbers (text or bus frames)"
                    recording.notes.append(f"channel {channel.name} {other}: left out")
                    continue
                if len(signal.samples) != len(time):
                    problem = f"channel {channel.name} is cut off"
                    raise LogError(problem, remedy="Copy the file again")

                # The group tells channels of one name apart.
                of_group = f"{channel.name} ({mark})"
                labels = (channel.name, of_group, f"{channel.name} ({mark}, channel {place})")
                label = next(each for each in labels if each not in recording.columns)
                values = signal.samples.astype(np.float64)
                recording.columns[label] = values
                recording.units[label] = signal.unit or None
                if signal.invalidation_bits is None:
                    continue
                invalid = np.asarray(signal.invalidation_bits, dtype=bool)
                if invalid.any():
                    values[invalid] = np.nan
                    marked = f"{invalid.sum()} values marked invalid"
                    recording.notes.append(f"channel {channel.name} has {marked}: read as missing")

            if joined_to is None and time.size > 1 and len(recording.columns) > 1:
                recordings[name] = recording
                clocks[name] = time
    return found_recordings.chosen(
        recordings, variable, "group", "no channel group of the file holds rows of numbers"
    )


READER = LogReader(
    suffixes=(".mf4", ".mdf"),
    claims=lambda head: head[:8] in (b"MDF     ", b"UnFinMF "),
    **reader_in_child.in_child("mdf", "asammdf"),
    tells_damage="not seen: MDF has no checksums; packed blocks (.mf4 with compression) have",
)
