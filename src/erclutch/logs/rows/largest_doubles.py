"""A logger may write the largest double, 1.797693e+308, where it has no number; so may one that counts in floats."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.logs.table import Table
from erclutch.signals.array import Array

_LARGEST = (float(np.finfo(np.float64).max), float(np.finfo(np.float32).max))


def without_largest_doubles(table: Table) -> Table:
    """The table without a number where one of the largest stands; the same table where none does."""
    missing: dict[str, Array] = {}
    notes: list[str] = []
    for name, column in table.columns.items():
        if not np.any(np.abs(column) >= _LARGEST[1]):
            continue
        is_largest = np.isin(np.abs(column), _LARGEST)
        count = int(np.count_nonzero(is_largest))
        if count:
            missing[name] = np.where(is_largest, np.nan, column)
            rows = "1 row" if count == 1 else f"{count} rows"
            notes.append(
                f"column {name} holds the largest number that there is in {rows}: read as no number"
            )
    if not missing:
        return table
    return replace(table, columns={**table.columns, **missing}, notes=(*table.notes, *notes))
