"""Rows below the points that sum them up, such as their mean and standard deviation, told by their numbers alone.

A word in such a row tells the reader of texts. A workbook or a bare line has none; fitted as points, a mean and a
deviation would be two points that nobody measured.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.logs.table import Table
from erclutch.signals.array import Array

_MOST_ROWS = 6  # such as mean, deviation, least, largest, median and sum
_FEWEST_POINTS = 4
_FEWEST_COLUMNS = 2  # that a row must sum up: one number may be near a mean by chance
_ROUNDING = 2e-3  # of a number of three digits or more


def without_summary_rows(table: Table) -> Table:
    """A table without the rows at its end that are statistics of the rows above, if a mean and a deviation are there.

    A point may lie at the mean of all others by chance; that the next row has their deviation too is none.
    """
    values = np.column_stack([*table.columns.values()]) if table.columns else np.zeros((0, 0))  # shape (rows, columns)
    for count in range(min(_MOST_ROWS, table.rows - _FEWEST_POINTS), 1, -1):
        points = values[:-count]
        said = [_statistic(row, points) for row in values[-count:]]
        if all(said) and "mean" in said and "standard deviation" in said:
            note = f"the last {count} rows are {', '.join(said)} of the rows above: left out"
            kept = slice(0, table.rows - count)
            return replace(
                table,
                columns={name: column[kept] for name, column in table.columns.items()},
                clock=None if table.clock is None else table.clock[kept],
                breaks=tuple(row for row in table.breaks if row < table.rows - count),
                words={name: replace(column, of_row=column.of_row[kept]) for name, column in table.words.items()},
                notes=(*table.notes, note),
            )
    return table


def _statistic(row: Array, points: Array) -> str:
    """Which statistic of the columns of points all numbers of a row are; "" for none."""
    filled = [column for column in range(row.size) if np.isfinite(row[column])]
    measured = [points[np.isfinite(points[:, column]), column] for column in filled]
    # A column of one number has it for its mean, its least and its largest: it tells nothing.
    telling = [place for place, column in enumerate(measured) if column.size > 1 and np.ptp(column) > 0.0]
    if len(telling) < _FEWEST_COLUMNS:
        return ""
    numbers = np.array([row[filled[place]] for place in telling])
    columns = [measured[place] for place in telling]
    statistics = {
        "mean": [column.mean() for column in columns],
        "standard deviation": [column.std(ddof=1) for column in columns],
        "deviation": [column.std() for column in columns],
        "median": [np.median(column) for column in columns],
        "least": [column.min() for column in columns],
        "largest": [column.max() for column in columns],
        "sum": [column.sum() for column in columns],
    }
    for name, expected in statistics.items():
        if np.allclose(numbers, expected, rtol=_ROUNDING, atol=0.0):
            return "standard deviation" if name == "deviation" else name
    return ""
