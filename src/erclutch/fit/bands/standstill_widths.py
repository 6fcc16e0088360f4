"""A band is as wide as errors are next to a standstill wherever the slip is among the smallest.

A class of the slip has one width, and the class of the smallest slips reaches from zero to where a quarter of the rows
lie. The sines of a bench are next to zero for few of these rows, and a memory errs most there. A motion that is unlike
the logs, as an earthquake, may stay next to zero for most of its time. So the half widths of that class are no less
than the errors at the smaller half of its slips. They are errors of a fit without a row's motion, for a band that is
made for further logs (`left_out_logs`); one log promises nothing of another motion.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.fit.log_groups import groups_of, quantile_over_logs
from erclutch.logs.dataset import Dataset
from erclutch.models.band import Band, leading
from erclutch.signals.array import Array, Mask

#: Share of the slips of the first class that are next to a standstill.
_NEXT_TO = 0.5
#: Rows of a cell that tell an error there.
_FEWEST_ROWS = 20


def wide_next_to_standstill(band: Band, data: Dataset, errors: Array) -> Band:
    """A band whose cells of the smallest slips hold what is next to a standstill.

    Args:
        band: calibrated on the errors.
        data: the training rows.
        errors: measured less estimated effort by fits without the motion of a row, shape (n,).
    """
    if not band.slip_edges:
        return band
    fields = [element.field for element in data.elements]
    slips = [element.slip for element in data.elements]
    _, slip = leading(fields, slips)
    is_near: Mask = np.abs(slip) < _NEXT_TO * band.slip_edges[0]
    cell = band.cells(data.elements, data.clock)
    log = groups_of(data).log_of_row(data.rows)

    *_, classes = band.shape
    behind = list(band.behind)
    ahead = list(band.ahead)
    for slowest in range(0, len(behind), classes):  # a cell for each class of field and switching
        rows = is_near & (cell == slowest)
        if np.count_nonzero(rows) < _FEWEST_ROWS:
            continue
        needed = quantile_over_logs(np.abs(errors[rows]), log[rows], band.level)
        behind[slowest] = max(behind[slowest], needed)
        ahead[slowest] = max(ahead[slowest], needed)
    return replace(band, behind=tuple(behind), ahead=tuple(ahead))
