"""Rows below the points that sum them up, such as their mean and standard deviation, told by their numbers alone.

A word in such a row tells the reader of texts. A workbook or a bare line has none; fitted as points, a mean and a
deviation would be two points that nobody measured.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import takewhile

import numpy as np

from erclutch.logs.table import Table
from erclutch.signals.array import Array

_MOST_ROWS = 6  # such as mean, deviation, least, largest, median and sum
_FEWEST_POINTS = 4
_FEWEST_COLUMNS = 2  # that a row must sum up: one number may be near a mean by chance
_ROUNDING = 2e-3  # of a number of three digits or more
_STATISTICS: Mapping[str, Callable[[Array], float]] = {
    "mean": lambda column: float(column.mean()),
    "standard deviation": lambda column: float(column.std(ddof=1)),
    "deviation": lambda column: float(column.std()),
    "median": lambda column: float(np.median(column)),
    "least": lambda column: float(column.min()),
    "largest": lambda column: float(column.max()),
    "sum": lambda column: float(column.sum()),
}


def without_summary_rows(table: Table) -> Table:
    """A table without the rows at its end that are statistics of the rows above, if a mean and a deviation are there.

    A point may lie at the mean of all others by chance; that the next row has their deviation too is none.
    """
    if not table.columns:
        return table
    values = np.column_stack([*table.columns.values()])  # shape (rows, columns)
    most = min(_MOST_ROWS, table.rows - _FEWEST_POINTS)
    for count in range(most, 1, -1):
        points = values[:-count]
        of_rows = (_statistic(row, points) for row in values[-count:])
        # Most rows are points: the first of them ends the search.
        statistics = [*takewhile(bool, of_rows)]
        if len(statistics) < count or not {"mean", "standard deviation"} <= {*statistics}:
            continue
        left = table.rows - count
        note = f"the last {count} rows are {', '.join(statistics)} of the rows above: left out"
        return replace(
            table,
            columns={name: column[:left] for name, column in table.columns.items()},
            clock=None if table.clock is None else table.clock[:left],
            breaks=tuple(row for row in table.breaks if row < left),
            words={
                name: replace(column, of_row=column.of_row[:left])
                for name, column in table.words.items()
            },
            notes=(*table.notes, note),
        )
    return table


def _statistic(row: Array, points: Array) -> str:
    """Which statistic of the columns of points all numbers of a row are; "" for none."""
    numbers: list[float] = []
    columns: list[Array] = []  # of the points, above these numbers
    for number, column in zip(row, points.T, strict=True):
        measured = column[np.isfinite(column)]
        # A column of one number has it for its mean, its least and its largest: it tells nothing.
        tells = measured.size > 1 and np.ptp(measured) > 0.0
        if np.isfinite(number) and tells:
            numbers.append(float(number))
            columns.append(measured)
    if len(numbers) < _FEWEST_COLUMNS:
        return ""
    for name, statistic in _STATISTICS.items():
        if all(map(_is_near, numbers, map(statistic, columns))):
            return "standard deviation" if name == "deviation" else name
    return ""


def _is_near(number: float, expected: float) -> bool:
    """Whether a number of the file is a statistic but for its rounding; a sum beyond double precision is none."""
    return math.isfinite(expected) and abs(number - expected) <= _ROUNDING * abs(expected)
