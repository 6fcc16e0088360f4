"""A tidy table has a signal's name and its value in each row: the values of each name become a column of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError
from erclutch.logs.columns.labels import name_columns, split_label
from erclutch.logs.columns.names import plain, spoken_name
from erclutch.logs.readers.found_recordings import Found, joined_by_time
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_NAMES = {
    "name",
    "signal",
    "variable",
    "channel",
    "sensor",
    "quantity",
    "parameter",
    "metric",
    "measure",
    "key",
    "topic",
}
_VALUES = {"value", "val", "values", "reading", "data", "measurement", "wert", "valeur", "valor"}
_UNITS = {"unit", "units", "einheit", "unite", "unidad"}
_MOST_SIGNALS = 64
_CLOCK = "time"  # no name of a signal


def untidied(table: Table) -> Table:
    """The table with a column for each name, at the times of the effort where each has its own; else as it is."""
    values = [name for name in table.columns if plain(name) in _VALUES]
    named = [name for name in table.words if plain(name) in _NAMES]
    if len(values) != 1 or len(named) != 1:
        return table
    others = [name for name in table.columns if name not in values]
    times = [name for name in others if spoken_name(name).is_time]
    if len(others) != len(times) or len(times) + (table.clock is not None) != 1:
        return table

    signals = table.words[named[0]]
    parts = [np.flatnonzero(signals.of_row == number) for number in range(len(signals.words))]
    if not 2 <= len(parts) <= _MOST_SIGNALS or sum(part.size for part in parts) != table.rows:
        return table
    stamps: Array = table.columns[times[0]] if times else np.asarray(table.clock)
    told: list[str] = []
    of_name = [table.columns[values[0]][part] for part in parts]
    at = stamps[parts[0]]
    if any(not np.array_equal(stamps[part], at) for part in parts):
        joined = _joined(dict(zip(signals.words, parts, strict=True)), stamps, table.columns[values[0]])
        if joined is None:
            return table
        at, of_name, told = joined

    units: list[str | None] = []
    said = next((words for name, words in table.words.items() if plain(name) in _UNITS), None)
    for part in parts:
        written: set[str] = set()
        if said is not None:
            written = {word for number, word in enumerate(said.words) if bool(np.any(said.of_row[part] == number))}
        units.append(written.pop() if len(written) == 1 else None)
    names, own_units, renamed = name_columns(
        [*times, *signals.words], [*(table.units.get(name) for name in times), *units]
    )
    columns = [at] * len(times) + of_name
    note = f"column {named[0]} names the signal of each value: {len(parts)} signals are taken as columns"
    notes = [each for each in table.notes if "parts the rows by" not in each]
    return replace(
        table,
        columns=dict(zip(names, columns, strict=True)),
        units=dict(zip(names, own_units, strict=True)),
        numbers={},
        clock=None if table.clock is None else at,
        breaks=(),
        words={},
        unreadable={},
        notes=(*notes, note, *told, *renamed),
    )


def _joined(
    parts: Mapping[str, NDArray[np.int64]], stamps: Array, values: Array
) -> tuple[Array, list[Array], list[str]] | None:
    """Times, the values of each name at these, and what to say; None where no name is an effort, or times fall back."""
    efforts = [name for name in parts if "effort" in spoken_name(split_label(name)[0]).may_be]
    if len(efforts) != 1:
        return None
    found: dict[str, Found] = {}
    for name in [*efforts, *(other for other in parts if other not in efforts)]:
        clock = stamps[parts[name]]
        if clock.size < 2 or not bool(np.all(np.diff(clock) > 0.0)):
            return None
        found[name] = Found({_CLOCK: clock, name: values[parts[name]]})
    try:
        together = joined_by_time(found, "signal")
    except LogError:
        return None
    return together.columns[_CLOCK], [together.columns[name] for name in parts], together.notes
