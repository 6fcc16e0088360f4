"""Scopes and LabVIEW write each channel as a pair of columns, ``Force X (s)`` and ``Force Y (N)``: a time and a value.

The columns get the names of a time and of the channel, so that `erclutch.logs.clock.channel_times` joins them by time.
Components of a vector and curves that were read off a picture are called so too; their X is no time.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.seen_columns import EVEN
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array

_TIME = "time"
_AXIS = r"{}(?:[ _-]?(?:values?|axis|data))?"
_BEHIND = r"(?P<stem>.*?[^\s._:/(-])(?:[\s._:/-]+\(?|\(){}\)?"  # Force X, Force_X, Force (X)
_IN_FRONT = r"{}[\s._:/-]*[\s._:/(-](?P<stem>[^()]+)\)?"  # X_Value (Force), X: Force
_PATTERNS = {
    letter: [
        re.compile(each.format(_AXIS.format(letter)), re.IGNORECASE)
        for each in (_BEHIND, _IN_FRONT)
    ]
    for letter in "XY"
}


def with_pairs_named(table: Table) -> Table:
    """The table with each pair of columns called time and by the name of its channel, where all columns are such."""
    names = [*table.columns]
    over_times = names[::2]
    values = names[1::2]
    if table.clock is not None or len(values) < 2 or len(over_times) != len(values):
        return table
    channels: list[str] = []
    for time, value in zip(over_times, values, strict=True):
        of_time = _stem(time, "X")
        channel = _stem(value, "Y") or value
        if not of_time or of_time != channel:
            return table
        channels.append(channel)
    stamps: list[Array] = []
    for name in over_times:
        times = table.columns[name]
        stamps.append(times[np.isfinite(times)])
    if len({*channels}) < len(channels) or not all(np.all(np.diff(each) > 0.0) for each in stamps):
        return table
    if not _are_times([table.units.get(name) for name in over_times], stamps, channels):
        return table

    columns: dict[str, Array] = {}
    units_of: dict[str, str | None] = {}
    numbers: dict[str, int] = {}
    for place, (time, value) in enumerate(zip(over_times, values, strict=True), start=1):
        name_of_time = _TIME if place == 1 else f"{_TIME} ({place})"
        for old, new in ((time, name_of_time), (value, channels[place - 1])):
            columns[new] = table.columns[old]
            units_of[new] = table.units.get(old)
            if old in table.numbers:
                numbers[new] = table.numbers[old]
    note = f"pairs of columns such as {over_times[0]} and {values[0]} are a time and a channel"
    return replace(
        table, columns=columns, units=units_of, numbers=numbers, notes=(*table.notes, note)
    )


def _stem(name: str, letter: str) -> str:
    """The name of the channel of which a column is the X or the Y; "" for another name."""
    for pattern in _PATTERNS[letter]:
        match = pattern.fullmatch(name.strip())
        if match:
            return match["stem"].strip()
    return ""


def _are_times(
    written: Sequence[str | None], stamps: Sequence[Array], channels: Sequence[str]
) -> bool:
    """Whether the X of all channels is a time: by its unit, or by equal steps beside a motion and an effort.

    Args:
        written: unit of the X of each channel.
        stamps: its numbers.
        channels: what they are called.
    """
    (unit, *others) = {*written}
    if others:
        return False
    if unit is not None:
        return units.is_unit(unit) and units.fits(unit, ("s",)) is not None
    may_be = [spoken_name(channel).may_be for channel in channels]
    has_a_motion = any(not each.isdisjoint(("slip", "position")) for each in may_be)
    has_an_effort = any("effort" in each for each in may_be)
    if not has_a_motion or not has_an_effort:
        return False
    steps = [np.diff(each) for each in stamps]
    return all(each.size > 1 and np.ptp(each) <= EVEN * np.median(each) for each in steps)
