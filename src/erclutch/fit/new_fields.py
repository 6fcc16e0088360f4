"""A band gets widths of its own at fields that no training log has: between the fields of the logs and beyond them.

Where logs have fields of their own, validation leaves whole fields out of the fits. The errors on these rows say what
to expect at a field that was never seen. They become classes of the field in the band, so that `predict`, the live loop
and the exported C have them without further arithmetic.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from erclutch.fit.log_groups import groups_of, quantile_over_logs
from erclutch.logs.dataset import Dataset
from erclutch.models.band import MOST_FIELD_EDGES, Band, leading
from erclutch.signals.array import Array, Mask

#: Shares of the span of the fields: a field so near to that of a log is known; a gap between two fields of logs that is
#: narrower holds no field that is new; and the band's grid goes so far beyond the largest field.
_KNOWN, _NARROW, _BEYOND = 0.06, 0.2, 0.25


@dataclass(frozen=True)
class _Class:
    """Fields of one class of a band.

    Attributes:
        low, high: magnitudes between which they lie.
        new: whether no log has such a field.
    """

    low: float
    high: float
    new: bool


def wider_at_new_fields(band: Band, data: Dataset, errors: Array) -> Band:
    """A band with classes of its own for fields that no log has.

    Between fields of logs the half width is the largest error of fields that had others on both sides when they were
    left out. Where those others were further apart than the two fields here, the error is as much smaller. The half
    width is no less than the mean at the two fields. Below the lowest field and beyond the highest it is the largest
    error of all fields, at the slips where they err most.

    Such an error is a quantile of the magnitude over the rows of a field, all logs counting the same: with so few
    fields nobody can tell on which side of the estimate a new field errs most.

    Args:
        band: calibrated at the fields of the training rows.
        data: the training rows.
        errors: measured less estimated effort by fits without the field of a row, shape (n,).

    Returns:
        The same band where the logs have one field, or so many that the band cannot keep them apart.
    """
    field, slip = leading([e.field for e in data.elements], [e.slip for e in data.elements])
    field, speed = np.abs(field), np.asarray(np.abs(slip), np.float64)
    levels = _levels(data, field)
    span = max(levels) - min(levels)
    classes = list(_classes(levels, span, band.field_edges)) if span > 0.0 else []
    if not 1 < len(classes) <= MOST_FIELD_EDGES + 1:
        return band
    level: Array = np.argmin([np.abs(field - each) for each in levels], axis=0).astype(np.float64)
    slips = np.searchsorted(np.array(band.slip_edges), speed)
    log = np.digitize(np.arange(data.rows), np.array([stop for _, stop in groups_of(data).rows]))

    def error(rows: Mask) -> float:
        """What most of some rows erred by when their field was left out."""
        return quantile_over_logs(np.abs(errors[rows]), log[rows], band.level)

    wholes = [[(level == k) & (slips == at) for at in range(band.shape[2])] for k in range(len(levels))]
    outermost = max(error(rows) for whole in wholes for rows in whole if rows.any())
    # Of each field with others on both sides: its error, and how far apart those others are.
    inner = [(error(level == k), levels[k + 1] - levels[k - 1]) for k in range(1, len(levels) - 1)]
    halves = np.reshape([band.behind, band.ahead], (2, *band.shape))
    places = np.searchsorted(band.field_edges, [0.5 * (own.low + own.high) for own in classes]).tolist()

    def widths(k: int) -> Array:
        """Half widths of a class, by direction, switching and slip."""
        if not classes[k].new:
            return halves[:, :, places[k]]
        if inner and 0 < k < len(classes) - 1:
            apart = classes[k].high - classes[k].low + 2.0 * _KNOWN * span
            between = max(size * min(apart / of_error, 1.0) for size, of_error in inner)
            return np.maximum(between, halves[:, :, [places[k - 1], places[k + 1]]].mean(axis=2))
        return np.maximum(outermost, halves.max(axis=2))

    made = [widths(k) for k in range(len(classes))]
    behind, ahead = np.stack(made, axis=2)
    low, high = band.field
    beyond = _BEYOND * span
    return replace(
        band,
        field=(min(low - beyond, 0.0) if low < 0.0 else 0.0, high + beyond),
        field_edges=tuple(own.high for own in classes[:-1]),
        behind=tuple(behind.ravel().tolist()),
        ahead=tuple(ahead.ravel().tolist()),
    )


def _levels(data: Dataset, field: Array) -> list[float]:
    """Magnitudes of the fields of the logs, ascending."""
    logs = groups_of(data)
    return sorted({round(float(np.mean(field[start:stop])), 12) for start, stop in logs.rows})


def _classes(levels: Sequence[float], span: float, edges: Sequence[float]) -> Iterator[_Class]:
    """All fields from zero on, in classes: those of logs parted as they were, and the new ones between and beyond."""
    known = _KNOWN * span
    gaps = [_Class(a + known, b - known, new=True) for a, b in pairwise(levels) if b - a > _NARROW * span]
    if levels[0] > _NARROW * span:
        gaps.insert(0, _Class(0.0, levels[0] - known, new=True))
    gaps.append(_Class(levels[-1] + known, np.inf, new=True))
    at = 0.0
    for gap in gaps:
        if gap.low > at:
            inner = [edge for edge in edges if at < edge < gap.low]
            yield from (_Class(a, b, new=False) for a, b in pairwise([at, *inner, gap.low]))
        yield gap
        at = gap.high
