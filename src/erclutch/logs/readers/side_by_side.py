"""Tables of the same columns may stand side by side, a heading over each: each of them is a recording.

Rheologists write a flow curve at each current so, test benches a run at each, and loggers a channel with a time of its
own. A heading that is a quantity, such as ``0.5 A``, becomes a column of the field.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from erclutch.errors import LogError, UnitError
from erclutch.logs.columns.labels import is_given_by_place
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers.dialect import SAMPLE, sniff
from erclutch.logs.readers.found_recordings import Found, chosen
from erclutch.logs.readers.header_lines import HEADED
from erclutch.logs.readers.text_bytes import decode
from erclutch.logs.readers.text_table import read_text
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

_FIELD = "field"


def read_side_by_side(source: LogSource) -> Table | None:
    """The table that is wanted of several side by side, or several joined by time; None where a text holds no such.

    Raises:
        LogError: several without a choice, or none of that name; see `read_text`.
    """
    head = decode(source.data[: 4 * SAMPLE])  # bytes of more letters than are looked at
    try:
        names = sniff(head, source.decimal).names
    except LogError:
        return None  # whoever reads the text says what is wrong
    # The same columns stand below each of several headings, and nothing beside them but empty columns: a time, say,
    # that all columns share makes one table of them.
    beside = [name for name in names if HEADED not in name]
    below = _by_heading(names)
    kinds = {tuple(own) for own in below.values()}
    if len(below) < 2 or len(kinds) > 1 or not all(map(is_given_by_place, beside)):
        return None

    whole = read_text(replace(source, variable=None))
    first = whole.columns.get(beside[0]) if beside and beside[0] == names[0] else None
    if first is not None and bool(np.all(np.isfinite(first))):
        return None  # a time without a name, which all tables share
    of_field = SIGNALS[_FIELD].si_units
    tables: dict[str, Found] = {}
    for heading, own in _by_heading(whole.columns).items():
        # Rows below the end of a shorter table are empty.
        filled = np.zeros(whole.rows, np.bool_)
        for name in own.values():
            filled |= np.isfinite(whole.columns[name])
        columns = {name: whole.columns[whole_name][filled] for name, whole_name in own.items()}
        units_below = {name: whole.units.get(whole_name) for name, whole_name in own.items()}
        # A heading such as ``0.5 A`` or ``B = 100 mT`` states the field.
        _, _, quantity = heading.rpartition("=")
        try:
            number, unit = units.quantity(quantity)
        except UnitError:
            number, unit = np.nan, None
        is_free = _FIELD not in columns
        if is_free and unit is not None and units.is_unit(unit) and units.fits(unit, of_field):
            columns[_FIELD] = np.full(np.count_nonzero(filled), number)
            units_below[_FIELD] = unit
        tables[heading] = Found(columns, units_below)
    table = chosen(tables, source.variable, "table", "the text holds one table")
    return replace(
        table,
        name=whole.name,
        digest=whole.digest,
        metadata=whole.metadata,
        notes=(*table.notes, *whole.notes),
        unreadable=whole.unreadable,
    )


def _by_heading(names: Iterable[str]) -> dict[str, dict[str, str]]:
    """For each heading the names below it, with the whole name of each."""
    below: dict[str, dict[str, str]] = {}
    for whole in names:
        heading, parted, name = whole.partition(HEADED)
        if parted:
            below.setdefault(heading, {})[name] = whole
    return below
