"""A table of tests by amplitude and frequency gets the peak speed of each test, for laws ask for a speed."""

from __future__ import annotations

from dataclasses import replace
from math import tau

import numpy as np

from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.sums_of_tests import MOST_TESTS, amplitude_and_frequency, sums_of
from erclutch.logs.table import Table

PEAK_SPEED = "peak speed"


def with_peak_speeds(table: Table) -> Table:
    """The table with a column of 2 pi times frequency times amplitude, where a row sums up a test.

    The table stays as it is where a time or a speed stands in it, or where no effort is summed up.
    """
    pair = amplitude_and_frequency({name: table.units.get(name) for name in table.columns})
    if pair is None or table.rows > MOST_TESTS or PEAK_SPEED in table.columns:
        return table
    said = {name: spoken_name(name) for name in table.columns}
    has_time = table.clock is not None or any(each.is_time for each in said.values())
    speeds = sums_of(table.columns, "slip")
    has_speed = speeds or any("slip" in each.may_be for each in said.values())
    if has_time or has_speed or not sums_of(table.columns, "effort"):
        return table
    amplitude, frequency = pair
    speed = tau * table.columns[frequency] * table.columns[amplitude]
    if not np.isfinite(speed).any():
        return table
    unit = table.units.get(amplitude) or said[amplitude].end
    note = f"{PEAK_SPEED} is 2 pi times {frequency} times {amplitude}, as of a sine"
    return replace(
        table,
        columns={**table.columns, PEAK_SPEED: speed},
        units={**table.units, PEAK_SPEED: f"{unit}/s" if unit else None},
        notes=(*table.notes, note),
    )
