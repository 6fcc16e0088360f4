"""MDF logs (.mf4, .mdf, .dat) are read by asammdf: a channel group is a recording, groups of one time are one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.budget import budget_of
from erclutch.logs.readers.found_recordings import Found
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array


def _group(mdf: Any, index: int, into: Found, time: Array, mark: str) -> None:
    """The channels of a group that hold plain numbers; values marked invalid become NaN, and this is said."""
    for place, channel in enumerate(mdf.groups[index].channels):
        if place == mdf.masters_db.get(index):
            continue
        signal = mdf.get(group=index, index=place, ignore_invalidation_bits=True)
        if signal.samples.dtype.kind not in "biuf" or signal.samples.ndim != 1:
            into.notes.append(f"channel {channel.name} holds no plain numbers (text or bus frames): left out")
            continue
        if len(signal.samples) != len(time):
            raise LogError(f"channel {channel.name} is cut off", remedy="Copy the file again")
        marks = ("", f" ({mark})", f" ({mark}, channel {place})")
        label = next(name for each in marks if (name := channel.name + each) not in into.columns)
        into.columns[label], into.units[label] = signal.samples.astype(np.float64), signal.unit or None
        bits = signal.invalidation_bits
        if bits is not None and (bad := np.asarray(bits, dtype=bool)).any():
            into.columns[label][bad] = np.nan
            into.notes.append(f"channel {channel.name} has {bad.sum()} values marked invalid: read as missing")


def find(path: str, variable: str | None) -> Table:
    """The child's work."""
    from asammdf import MDF

    budget = budget_of(Path(path))
    found: dict[str, tuple[Array, Found]] = {}
    with MDF(path) as mdf:
        for index, group in enumerate(mdf.groups):
            budget.take_names(len(group.channels))
            budget.take_cells(group.channel_group.cycles_nr * len(group.channels))
            said = getattr(group.channel_group, "acq_name", "") or getattr(group.channel_group, "comment", "")
            name = said if 0 < len(said) < 60 and said.isprintable() and said not in found else f"group {index + 1}"
            time, master = np.asarray(mdf.get_master(index), dtype=np.float64), mdf.masters_db.get(index)
            into = next((f for t, f in found.values() if master is not None and np.array_equal(t, time)), Found({}))
            if master is not None and not into.columns:
                label = group.channels[master].name or "time"
                into.columns[label], into.units[label] = time, group.channels[master].unit or "s"
            _group(mdf, index, into, time, f"group {name}" if units.is_unit(name) else name)  # "(A)" is a unit
            if time.size > 1 and len(into.columns) > 1 and all(into is not each for _, each in found.values()):
                found[name] = time, into
    recordings = {name: each for name, (_, each) in found.items()}
    return found_recordings.chosen(recordings, variable, "group", "no channel group of the file holds rows of numbers")


_DAMAGE = "not seen: MDF has no checksums; packed blocks (.mf4 with compression) have"
READER = LogReader(
    (".mf4", ".mdf"),
    lambda head: head[:8] in (b"MDF     ", b"UnFinMF "),
    **found_recordings.in_child("mdf", "asammdf"),
    tells_damage=_DAMAGE,
)
