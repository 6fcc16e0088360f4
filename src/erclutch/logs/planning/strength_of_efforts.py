"""A column whose name says nothing may be the field: where it is stronger, the effort at the same slip is larger."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from erclutch.logs.field_between_logs import efforts_of_two_words
from erclutch.signals.array import Array

_RANGES = 4  # of the column, from its weakest rows to its strongest
_OUTLYING = 5.0  # per cent of the rows at either end, which are in the first or the last range
_OTHER_SIGN = 0.1  # of the sum of sizes: a supply that overshoots is still of one sign
#: Times the effort, from the weakest rows of the column to the strongest: it is proposed, and the user decides.
_STRONGER = 1.2
_ALIKE = 0.99  # correlation of a column with what it is made of; at large slips a field is nearly so near to the effort
_A_RATE = 0.9  # correlation of a position's rate with a slip that is measured on its own


def strengths_of_efforts(
    columns: Mapping[str, Array], slip: Array, effort: Array, least: float = _STRONGER
) -> list[str]:
    """The only one of these columns with which the effort at the same slip goes; none where several do.

    A field is of one sign, and neither the effort itself nor what the motion makes of it, such as a power, a position
    or an acceleration.

    Args:
        columns: of a table, by their names, (n,) each.
        slip: of each row, (n,), as the effort.
        effort: of each row.
        least: how many times the effort of the column's weakest rows the effort of its strongest is to be.
    """
    if slip.size < 2:  # one row has no rate
        return []
    strengths: list[str] = []
    for name, column in columns.items():
        if not np.isfinite(column).all():
            continue
        size = np.abs(column)
        total = float(size.sum())
        below = float(-np.minimum(column, 0.0).sum())
        is_of_one_sign = total > 0.0 and min(below, total - below) < _OTHER_SIGN * total
        if not is_of_one_sign:
            continue
        # The effort itself, a speed or a power; or a position, whose rate is the slip.
        others = (np.abs(effort), np.abs(slip), np.abs(effort * slip))
        if any(_correlation(column, other) > _ALIKE for other in others):
            continue
        if abs(_correlation(np.gradient(column), slip)) > _A_RATE:
            continue
        weakest, strongest = np.percentile(size, (_OUTLYING, 100.0 - _OUTLYING)).tolist()
        if weakest == strongest:
            continue
        width = (strongest - weakest) / _RANGES
        edges = weakest + width * np.arange(1.0, _RANGES)
        # A field that switches has rows in some of the ranges alone.
        _, of_row = np.unique(np.digitize(size, edges), return_inverse=True)
        apart = efforts_of_two_words(slip, effort, of_row.astype(np.int32), least)
        if apart is not None and apart.more > apart.less:
            strengths.append(name)
    return strengths if len(strengths) == 1 else []


def _correlation(first: Array, second: Array) -> float:
    """Of two courses, shape (n,) each; 0 where one of them stands still."""
    a = first - first.mean()
    b = second - second.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0.0 else 0.0
