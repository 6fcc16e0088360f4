"""A tidy table has a signal's name and its value in each row: the values of each name become a column of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError
from erclutch.logs.columns.labels import name_columns, split_label
from erclutch.logs.columns.names import plain, spoken_name
from erclutch.logs.columns.seen_columns import unit_fits
from erclutch.logs.readers.found_recordings import Found, joined_by_time
from erclutch.logs.table import Table, WordColumn
from erclutch.signals import units
from erclutch.signals.array import Array

_NAMES = {
    *(
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
        "tag",
        "tagname",
        "tagid",
        "pointname",
        "variablename",
        "parametername",
        "sensorname",
        "datapoint",
        "nodeid",
    ),
    *("field", "grosse", "messgrosse", "kanal", "signalname", "channelname"),
    *(
        "segnale",
        "grandezza",
        "canale",
        "variabile",
        "grandeur",
        "mesure",
        "voie",
        "senal",
        "magnitud",
    ),
    *("canal", "medida", "grandeza", "sinal", "sygnał", "kanał", "сигнал", "канал", "величина"),
    *("信号", "信号名", "通道", "参数", "変量", "チャンネル", "신호"),
}
_VALUES = {
    "value",
    "val",
    "values",
    "payload",
    "reading",
    "data",
    "measurement",
    "wert",
    "valeur",
    "valor",
    "valore",
    "waarde",
    "wartosc",
    "значение",
} | {*("messwert", "数值", "值", "値", "測定値", "값")}
_UNITS = {
    "unit",
    "units",
    "einheit",
    "unite",
    "unidad",
    "unita",
    "eenheid",
    "jednostka",
    "unidade",
    "engunits",
    "engunit",
    "engineeringunits",
    "uom",
} | {*("единица", "单位", "単位", "단위")}
_MOST_SIGNALS = 64
_CLOCK = "time"  # no name of a signal


def untidied(table: Table) -> Table:
    """The table with a column for each name, at the times of the effort where each has its own; else as it is."""
    values = [name for name in table.columns if plain(name) in _VALUES]
    named = [name for name in table.words if plain(name) in _NAMES]
    of_units = [words for name, words in table.words.items() if plain(name) in _UNITS]
    column_of_units = of_units[0] if of_units else None
    if not named:  # a tag, a Messstelle: whatever the column is called, its words name signals
        named = [
            name
            for name, parting in table.words.items()
            if parting is not column_of_units and _are_signals(parting, column_of_units)
        ]
    if len(values) != 1 or len(named) != 1:
        return table
    others = [name for name in table.columns if name not in values]
    times = [name for name in others if spoken_name(name).is_time]
    clocks = len(times) + (table.clock is not None)
    signals = table.words[named[0]]
    numbers = range(len(signals.words))
    parts = [np.flatnonzero(signals.of_row == number) for number in numbers]  # rows of each
    # A number that all values of a signal share is one of its message, such as its id on a bus.
    of_messages: list[str] = []
    for name in others:
        logged = table.columns[name]
        is_shared = all(part.size and np.all(logged[part] == logged[part[0]]) for part in parts)
        if name not in times and is_shared:
            of_messages.append(name)
    if clocks != 1 or len(others) != len(times) + len(of_messages):
        return table

    all_are_named = sum(part.size for part in parts) == table.rows
    if not 2 <= len(parts) <= _MOST_SIGNALS or not all_are_named:
        return table
    stamps: Array = table.columns[times[0]] if times else np.asarray(table.clock)
    in_units = _in_one_unit(table.columns[values[0]], column_of_units, parts)
    if in_units is None:
        return table
    all_values, units_of = in_units
    joined_notes: list[str] = []
    of_signals = [all_values[part] for part in parts]
    at = stamps[parts[0]]
    if any(not np.array_equal(stamps[part], at) for part in parts):
        # Signals with times of their own are taken at the times of the effort, where one of them is the effort.
        rows_of = dict(zip(signals.words, parts, strict=True))
        efforts = [
            label
            for label, unit in zip(signals.words, units_of, strict=True)
            if _is_effort(label, unit)
        ]
        if len(efforts) != 1:
            return table
        recordings: dict[str, Found] = {}
        for label in dict.fromkeys([*efforts, *rows_of]):
            clock = stamps[rows_of[label]]
            if clock.size < 2 or not bool(np.all(np.diff(clock) > 0.0)):
                return table
            recordings[label] = Found({_CLOCK: clock, label: all_values[rows_of[label]]})
        try:
            together = joined_by_time(recordings, "signal")
        except LogError:
            return table
        at = together.columns[_CLOCK]
        of_signals = [together.columns[label] for label in rows_of]
        joined_notes = together.notes

    labels = [*times, *signals.words]
    all_units = [*(table.units.get(name) for name in times), *units_of]
    names, own_units, renamed = name_columns(labels, all_units)
    columns = [*([at] * len(times)), *of_signals]
    note = f"column {named[0]} names the signal of each value: {len(parts)} signals are taken as columns"
    notes = [each for each in table.notes if "parts the rows by" not in each]
    if of_messages:
        left_out = (
            f"column {', '.join(of_messages)} is the same in all values of a signal: left out"
        )
        joined_notes.insert(0, left_out)
    return replace(
        table,
        columns=dict(zip(names, columns, strict=True)),
        units=dict(zip(names, own_units, strict=True)),
        numbers={},
        clock=None if table.clock is None else at,
        breaks=(),
        words={},
        unreadable={},
        notes=(*notes, note, *joined_notes, *renamed),
    )


def _are_signals(parting: WordColumn, of_units: WordColumn | None) -> bool:
    """Whether words name one effort and other signals, by themselves or by the units beside them."""
    units_of: list[str | None] = [None] * len(parting.words)
    if of_units is not None:
        for number in range(len(parting.words)):
            rows = np.flatnonzero(parting.of_row == number)
            place = int(of_units.of_row[rows[0]]) if rows.size else -1
            units_of[number] = of_units.words[place] if place >= 0 else None
    with_units = [*zip(parting.words, units_of, strict=True)]
    efforts = [label for label, unit in with_units if _is_effort(label, unit)]
    others = [
        label
        for label, unit in with_units
        if label not in efforts and (unit or spoken_name(split_label(label)[0]).may_be)
    ]
    return len(efforts) == 1 and len(others) > 0


def _is_effort(label: str, unit: str | None) -> bool:
    """Whether a signal of this label, with the unit beside it or its own, is an effort."""
    name, own_unit = split_label(label)
    said = "effort" in spoken_name(name).may_be
    return said or bool(unit_fits(name, unit or own_unit, ("N*m", "N")))


def _in_one_unit(
    values: Array,
    of_units: WordColumn | None,
    parts: Sequence[NDArray[np.int64]],
) -> tuple[Array, list[str | None]] | None:
    """The values, those of each part in one unit, and these units; None where a part has units of two quantities.

    A meter that changes its range writes several units for one signal.

    Args:
        values: of all rows.
        of_units: the column that holds the unit of each value, if there is one.
        parts: rows of each signal.
    """
    if of_units is None:
        return values, [None] * len(parts)
    values = values.copy()
    units_of: list[str | None] = []
    for part in parts:
        numbers: list[int] = [int(number) for number in np.unique(of_units.of_row[part])]
        written = [of_units.words[number] if number >= 0 else "" for number in numbers]
        if len(written) > 1:
            if not all(unit and units.is_unit(unit) for unit in written):
                return None
            meant = [units.parse(unit) for unit in written]
            if len({unit.dimension for unit in meant}) > 1:
                return None
            for number, unit in zip(numbers, meant, strict=True):
                values[part[of_units.of_row[part] == number]] *= unit.factor / meant[-1].factor
        units_of.append(written[-1] or None)
    return values, units_of
