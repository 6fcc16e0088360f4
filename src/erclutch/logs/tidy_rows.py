"""A tidy table has a signal's name and its value in each row: the values of each name become a column of their own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.logs.labels import name_columns
from erclutch.logs.names import plain, spoken_name
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


def untidied(table: Table) -> Table:
    """The table with a column for each name; as it is where it is not tidy, or the signals have times of their own."""
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
    rows = parts[0].size
    if (
        not 2 <= len(parts) <= _MOST_SIGNALS
        or any(part.size != rows for part in parts)
        or sum(part.size for part in parts) != table.rows
    ):
        return table
    stamps: Array = table.columns[times[0]] if times else np.asarray(table.clock)
    at = stamps[parts[0]]
    if any(not np.array_equal(stamps[part], at) for part in parts):
        return table

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
    columns = [at] * len(times) + [table.columns[values[0]][part] for part in parts]
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
        notes=(*notes, note, *renamed),
    )
