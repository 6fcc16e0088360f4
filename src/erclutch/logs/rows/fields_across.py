"""A bench sheet may have a column for each field, such as ``Torque @ 0.5 A``: each field gets rows of its own.

So are force over speed of a damper at some currents, and torque over speed of a brake.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from erclutch.errors import listed
from erclutch.logs.columns.fields_in_names import StatedField, stated_in, without_field
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.rheometer_names import said_by_name
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_FIELD = "field"
_VALUE = "value"  # what is called by its field alone
_A_FIELD_ALONE = frozenset({_FIELD})
_MOTIONS = frozenset({"slip", "position"})
_AT_ITS_END = re.compile(r"[\s@,;:_(\[=-]+(?:at|for|bei|a|@)?[\s@)\]_-]*$", re.IGNORECASE)
_COUNTED = re.compile(r"[1-9]\d?[AVT]")  # the first specimen of batch A, or 1 A


def with_a_row_for_each_field(table: Table) -> Table:
    """The table with rows for each field that the names of its columns tell, one after another; else as it is.

    Several efforts in one time stay columns: each of them is a log, and the user is asked.
    """
    by_quantity: dict[str, dict[StatedField, str]] = {}  # column of each field
    for name in table.columns:
        field = stated_in(name)
        if field is not None:
            of_quantity = by_quantity.setdefault(without_field(name), {})
            of_quantity[field._replace(name="")] = name
    shared = [name for name in table.columns if stated_in(name) is None]
    if not by_quantity or not _is_a_sheet_of_fields(table, by_quantity, shared):
        return table

    fields, *_ = (list(columns) for columns in by_quantity.values())
    columns: dict[str, list[Array]] = {}
    rows_of_fields: list[int] = []
    units = {name: table.units.get(name) for name in shared}
    for field in fields:
        of_field = {name: table.columns[name] for name in shared}
        filled = np.zeros(table.rows, np.bool_)
        for bare, by_field in by_quantity.items():
            values = table.columns[by_field[field]]
            filled |= np.isfinite(values)
            quantity, unit = _quantity(bare)
            of_field[quantity] = values
            units[quantity] = table.units.get(by_field[field]) or unit
        of_field[_FIELD] = np.full(table.rows, field.number)
        rows_of_fields.append(int(np.count_nonzero(filled)))
        for name, values in of_field.items():
            columns.setdefault(name, []).append(values[filled])
    units[_FIELD] = fields[0].unit
    said = listed([f"{field.number:g} {field.unit}" for field in fields])
    note = f"the names of the columns tell the field: the rows at {said} stand one after another"
    return replace(
        table,
        columns={name: np.concatenate(parts) for name, parts in columns.items()},
        units=units,
        numbers={},
        row_names=(),
        breaks=(),
        sweeps=np.repeat(np.arange(len(fields)), rows_of_fields),
        notes=(*table.notes, note),
    )


def _is_a_sheet_of_fields(
    table: Table, by_quantity: dict[str, dict[StatedField, str]], shared: list[str]
) -> bool:
    """Whether each quantity has a column at each of the same fields, and nothing else of the table may be a field."""
    fields = [set(columns) for columns in by_quantity.values()]
    quantities = [_quantity(bare)[0] for bare in by_quantity]
    are_alike = all(own == fields[0] for own in fields) and len(set(quantities)) == len(quantities)
    if len(fields[0]) < 2 or len({field.unit for field in fields[0]}) > 1 or not are_alike:
        return False
    if not any(spoken_name(name).may_be & _MOTIONS for name in (*shared, *quantities)):
        return False
    names = [name for columns in by_quantity.values() for name in columns.values()]
    for columns in by_quantity.values():
        if len({table.units.get(name) for name in columns.values()}) > 1:
            return False
    if all(_COUNTED.search(name) for name in names):
        return False
    if any(spoken_name(name).may_be == _A_FIELD_ALONE or name in quantities for name in shared):
        return False
    # `erclutch flowcurve` takes the curves of a rheometer as they stand.
    if any(
        said_by_name(name) in ("rate", "stress", "viscosity") for name in (*shared, *quantities)
    ):
        return False
    has_time = table.clock is not None or table.sample_period is not None
    has_time = has_time or any(spoken_name(name).is_time for name in shared)
    if table.clock is not None or table.words or (has_time and len(by_quantity) < 2):
        return False
    return not any(spoken_name(name).may_be == _A_FIELD_ALONE for name in quantities)


def _quantity(bare: str) -> tuple[str, str | None]:
    """Name and unit of a quantity, of its name without the field: ``Torque (Nm) at`` is a torque in N m.

    A name that was the field alone says nothing.
    """
    stem = _AT_ITS_END.sub("", bare).strip(" _-@")
    name, unit = split_label(stem)
    is_the_field = bool(name) and spoken_name(name).may_be == _A_FIELD_ALONE
    return (_VALUE, None) if is_the_field or not name else (name, unit)
