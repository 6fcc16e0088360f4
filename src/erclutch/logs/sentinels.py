"""Values that loggers and instruments write where nothing was measured are told from measurements.

Such a value is one of few codes (-999, 65535, ...), the same to the last digit each time, and stands apart from all
other values of its column. The largest value of a saturated sensor does not stand apart, and a spike is no code.
"""

from __future__ import annotations

import numpy as np

from erclutch.signals.array import Array, Mask

#: Of tables and spreadsheets; ends of whole numbers of 16 and 32 bits; of instruments.
CODES = (
    *(sign * code for code in (99.0, 999.0, 9999.0, 99999.0, 999999.0, 999.9, 9999.9) for sign in (-1.0, 1.0)),
    *(65535.0, 32767.0, -32768.0, 4294967295.0, 2147483647.0, -2147483648.0),
    *(sign * code for code in (1e30, 9.9e37, 9.91e37, 1e35, 1e38) for sign in (-1.0, 1.0)),
)
_FAR = 2.0  # ranges of all other values, by which a code stands apart
_APART = 0.5  # ranges, where the step to the code is larger than all other steps
_MOST = 0.5  # share of the rows: a code in more of them may be the signal


def sentinels(values: Array) -> dict[float, Mask]:
    """Rows that hold a code in place of a measurement, by the code.

    Args:
        values: a column as logged, shape (n,); NaN where a cell was empty.

    Returns:
        code -> mask, shape (n,); empty for none.
    """
    with np.errstate(invalid="ignore"):
        least, most = np.fmin.reduce(values, initial=np.inf), np.fmax.reduce(values, initial=-np.inf)
    held = {code: np.equal(values, code) for code in CODES if least <= code <= most}
    held = {code: rows for code, rows in held.items() if rows.any()}
    if not held:
        return {}
    doubtful = np.logical_or.reduce(list(held.values()))
    measured = values[~doubtful & np.isfinite(values)]
    if measured.size < max(10, (1.0 - _MOST) * values.size):
        return {}
    low, high = float(measured.min()), float(measured.max())
    spread = max(high - low, 1e-12 * max(abs(low), abs(high)), np.finfo(float).tiny)
    largest_step = float(np.abs(np.diff(measured)).max())
    found: dict[float, Mask] = {}
    for code, rows in held.items():
        beyond = max(code - high, low - code)
        jumps = beyond > _APART * spread and beyond > 3.0 * largest_step
        if beyond > _FAR * spread or jumps:
            found[code] = rows
    return found
