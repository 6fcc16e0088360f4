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
from numpy.typing import NDArray

from erclutch.fit.log_groups import groups_of, quantile_over_logs
from erclutch.logs.dataset import Dataset
from erclutch.models.band import MOST_FIELD_EDGES, Band, leading
from erclutch.signals.array import Array, Mask

# Shares of the span of the fields of logs.
#: A field so near to that of a log is known.
_KNOWN = 0.06
#: A gap between two fields of logs that is narrower holds no field that is new.
_NARROW = 0.2
#: The band's grid goes so far beyond the largest field.
_BEYOND = 0.25


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


@dataclass(frozen=True)
class NewFieldErrors:
    """Errors on the training rows by fits without the field of a row.

    Attributes:
        usual: measured less estimated effort, shape (n,).
        in_doubt: the largest in size of all fits that the fields left cannot tell apart, shape (n,): two fields do not
            say whether the yield effort rises as the field or as its square.
    """

    usual: Array
    in_doubt: Array


def wider_at_new_fields(
    band: Band,
    data: Dataset,
    errors: Array,
    in_doubt: Array | None = None,
) -> Band:
    """A band with classes of its own for fields that no log has.

    Between fields of logs the half width is the largest error of fields that had others on both sides when they were
    left out. Where those others were further apart than the two fields here, the error is as much smaller. The half
    width is no less than the mean at the two fields. Below the lowest field and beyond the highest it is the largest
    error of all fields, at the slips where they err most. Below, the error of the lowest field counts in proportion
    where no field is further away from it than the next field.

    What fits leave in doubt counts between fields, and of the lowest field below. Beyond the highest it does not: a fit
    without that field says next to nothing there, but the fit for use has it.

    Such an error is a quantile of the magnitude over the rows of a field, all logs counting the same: with so few
    fields nobody can tell on which side of the estimate a new field errs most.

    Args:
        band: calibrated at the fields of the training rows.
        data: the training rows.
        errors: measured less estimated effort by fits without the field of a row, shape (n,).
        in_doubt: the largest in size of all fits that these fields cannot tell apart, shape (n,); None: they tell all.

    Returns:
        The same band where the logs have one field, fields that run into each other, or so many that the band cannot
        keep them apart.
    """
    in_doubt = errors if in_doubt is None else in_doubt
    fields = [element.field for element in data.elements]
    slips = [element.slip for element in data.elements]
    signed, slip = leading(fields, slips)
    field: Array = np.abs(signed)

    # The fields of the logs, and the classes that they make of all fields.
    logs = groups_of(data)
    means = [float(np.mean(field[start:stop])) for start, stop in logs.rows]
    span = max(means) - min(means)
    if not span > 0.0:
        return band
    levels = _levels_of(means, span)
    if len(levels) < 2:
        return band
    classes = list(_classes(levels, span, band.field_edges))
    if not 1 < len(classes) <= MOST_FIELD_EDGES + 1:
        return band

    # Of each row: the place of its field among the levels, the class of its slip, its log.
    distances = [np.abs(field - each) for each in levels]
    level = np.argmin(distances, axis=0)
    sizes = np.asarray(np.abs(slip), np.float64)
    slip_class = np.searchsorted(band.slip_edges, sizes)
    log = logs.log_of_row(data.rows)

    # Errors beyond all fields: the largest of any field, at the slips where it errs most; below, what the lowest field
    # leaves in doubt, and more where no field is further away than the next field.
    outermost = 0.0
    for place in range(len(levels)):
        of_level = _at_the_worst_slips(errors, level == place, slip_class, log, band.level)
        outermost = max(outermost, of_level)
    further = levels[0] / (levels[1] - levels[0])
    lowest = _at_the_worst_slips(in_doubt, level == 0, slip_class, log, band.level)
    below = max(outermost, lowest * max(further, 1.0))
    inner = _between_levels(in_doubt, level, levels, log, band.level)

    # Half widths, by direction, switching, field and slip.
    halves = np.reshape([band.behind, band.ahead], (2, *band.shape))
    middles = [0.5 * (own.low + own.high) for own in classes]
    # Of each class, its class of field in the band.
    before = np.searchsorted(band.field_edges, middles).tolist()
    widths: list[Array] = []  # of each class, by direction, switching and slip
    for k, own in enumerate(classes):
        if not own.new:
            widths.append(halves[:, :, before[k]])
        elif inner and 0 < k < len(classes) - 1:
            apart = own.high - own.low + 2.0 * _KNOWN * span
            between = max(size * min(apart / of_error, 1.0) for size, of_error in inner)
            both_sides = [before[k - 1], before[k + 1]]
            beside = halves[:, :, both_sides].mean(axis=2)
            widths.append(np.maximum(between, beside))
        else:
            widest = below if k < len(classes) - 1 else outermost
            widths.append(np.maximum(widest, halves.max(axis=2)))
    behind, ahead = np.stack(widths, axis=2)

    # Classes cover magnitudes from zero on; the grid reaches below zero only where fields of the logs do.
    low, high = band.field
    beyond = _BEYOND * span
    return replace(
        band,
        field=(low - beyond if low < 0.0 else 0.0, high + beyond),
        field_edges=tuple(own.high for own in classes[:-1]),
        behind=tuple(behind.ravel().tolist()),
        ahead=tuple(ahead.ravel().tolist()),
    )


def _between_levels(
    errors: Array,
    level: NDArray[np.intp],
    levels: Sequence[float],
    log: NDArray[np.intp],
    share: float,
) -> list[tuple[float, float]]:
    """What most rows of each field with others on both sides erred by, and how far apart those others are."""
    inner: list[tuple[float, float]] = []
    for place in range(1, len(levels) - 1):
        rows = level == place
        if rows.any():  # a field that changes within a log may never be at its mean
            size = quantile_over_logs(np.abs(errors[rows]), log[rows], share)
            inner.append((size, levels[place + 1] - levels[place - 1]))
    return inner


def _levels_of(means: Sequence[float], span: float) -> list[float]:
    """The fields of logs, ascending: a measured field differs a little from stretch to stretch, and is one level."""
    ascending = sorted(means)
    alike: list[list[float]] = [[ascending[0]]]
    for lower, mean in pairwise(ascending):
        if mean - lower > _KNOWN * span:
            alike.append([])
        alike[-1].append(mean)
    return [sum(each) / len(each) for each in alike]


def _at_the_worst_slips(
    errors: Array,
    rows: Mask,
    slip_class: NDArray[np.intp],
    log: NDArray[np.intp],
    share: float,
) -> float:
    """What most of some rows erred by when their field was left out, in the class of slips where that is most."""
    largest = 0.0
    for number in np.unique(slip_class[rows]):
        own = rows & (slip_class == number)
        largest = max(largest, quantile_over_logs(np.abs(errors[own]), log[own], share))
    return largest


def _classes(
    levels: Sequence[float],
    span: float,
    edges: Sequence[float],
) -> Iterator[_Class]:
    """All fields from zero on, in classes: those of logs parted as they were, and the new ones between and beyond."""
    known = _KNOWN * span
    narrow = _NARROW * span
    gaps: list[_Class] = []
    if levels[0] > narrow:
        gaps.append(_Class(0.0, levels[0] - known, new=True))
    for low, high in pairwise(levels):
        if high - low > narrow:
            gaps.append(_Class(low + known, high - known, new=True))
    gaps.append(_Class(levels[-1] + known, np.inf, new=True))

    reached = 0.0
    for gap in gaps:
        if gap.low > reached:
            parted = [edge for edge in edges if reached < edge < gap.low]
            for low, high in pairwise([reached, *parted, gap.low]):
                yield _Class(low, high, new=False)
        yield gap
        reached = gap.high
