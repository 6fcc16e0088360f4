"""Rows in which a sensor measured nothing are told: codes that loggers write, and what a fault alone writes.

A code that stands where nothing was measured (-999, 65535, ...) is the same to the last digit each time, and stands
apart from all other values of its column. The largest value of a saturated sensor does not stand apart, and a spike
is no code.
"""

from __future__ import annotations

import numpy as np

from erclutch.logs.plan import Plan
from erclutch.logs.rows.sensor_faults import FAULTS, Measured
from erclutch.logs.table import Table
from erclutch.signals.array import Array, Mask
from erclutch.signals.recording import CUT_THERE

#: Of tables and spreadsheets; ends of whole numbers of 16 and 32 bits; of instruments.
CODES = (
    *(
        sign * code
        for code in (99.0, 999.0, 9999.0, 99999.0, 999999.0, 999.9, 9999.9)
        for sign in (-1.0, 1.0)
    ),
    *(65535.0, 32767.0, -32768.0, 4294967295.0, 2147483647.0, -2147483648.0),
    *(sign * code for code in (1e30, 9.9e37, 9.91e37, 1e35, 1e38) for sign in (-1.0, 1.0)),
)
_FAR = 2.0  # ranges of all other values, by which a code stands apart
_APART = 0.5  # ranges, where the step to the code is larger than all other steps
_MOST = 0.5  # share of the rows: a code in more of them may be the signal


def unmeasured_rows(plan: Plan, table: Table, notes: list[str]) -> Mask:
    """Rows that are left out since a signal holds no measurement there, shape (rows of the table,).

    ``notes`` gets what was seen, the column and the number of rows; a user may ask to keep them.
    """
    keep = plan.told.values == "keep"
    unmeasured = np.zeros(table.rows, dtype=np.bool_)
    columns: dict[str, None] = {}
    for each in (*plan.signals, *plan.inputs):
        if each.column:  # of a difference both columns: that of two codes is 0
            columns |= dict.fromkeys(table.parts_of(each.column) or (each.column,))
    for name in columns:
        for code, rows in sentinels(table.planned(name)).items():
            held = f"column {name} holds {code:g} in {_counted(rows)}, far from all other values"
            if keep:
                notes.append(f"{held}: kept, as asked")
            else:
                why = f"what loggers write for no measurement, left out and {CUT_THERE}"
                notes.append(f"{held}: {why} (--keep-values keeps it)")
                unmeasured |= rows

    columns_of = {each.signal: each.column for each in plan.signals if each.column}
    logged = {name: table.planned(name) for name in columns_of.values()}
    motion = columns_of.get("slip") or columns_of.get("position")
    measured = Measured(
        columns_of,
        {name: np.where(unmeasured, np.nan, values) for name, values in logged.items()},
        logged[motion] if motion else None,
    )
    for fault in FAULTS:
        for seen in fault.rule(measured):
            for name in seen.columns:
                measured.values[name][seen.rows] = np.nan
            many = "s" if len(seen.columns) > 1 else ""
            first = table.first_row + int(np.argmax(seen.rows)) + 1
            done = "kept, as asked"
            if not keep:
                done = f"left out and {CUT_THERE} (--keep-values keeps them)"
            notes.append(
                f"column{many} {', '.join(seen.columns)} {seen.what} in {_counted(seen.rows)}, the first in data row "
                f"{first}: {done}"
            )
            if not keep:
                unmeasured |= seen.rows
    return unmeasured


def sentinels(values: Array) -> dict[float, Mask]:
    """Rows that hold a code in place of a measurement, by the code.

    Args:
        values: a column as logged, shape (n,); NaN where a cell was empty.

    Returns:
        code -> mask, shape (n,); empty for none.
    """
    with np.errstate(invalid="ignore"):
        least = np.fmin.reduce(values, initial=np.inf)
        most = np.fmax.reduce(values, initial=-np.inf)
    held: dict[float, Mask] = {}
    for code in CODES:
        if least <= code <= most:
            rows = np.equal(values, code)
            if rows.any():
                held[code] = rows
    if not held:
        return {}

    doubtful = np.logical_or.reduce(list(held.values()))
    measured = values[~doubtful & np.isfinite(values)]
    if measured.size < max(10, (1.0 - _MOST) * values.size):
        return {}
    low = float(measured.min())
    high = float(measured.max())
    largest = max(abs(low), abs(high))
    spread = max(high - low, 1e-12 * largest, np.finfo(float).tiny)
    largest_step = float(np.abs(np.diff(measured)).max())
    codes: dict[float, Mask] = {}
    for code, rows in held.items():
        beyond = max(code - high, low - code)
        jumps = beyond > _APART * spread and beyond > 3.0 * largest_step
        if beyond > _FAR * spread or jumps:
            codes[code] = rows
    return codes


def _counted(rows: Mask) -> str:
    many = int(rows.sum())
    return f"{many} row{'s' if many > 1 else ''}"
