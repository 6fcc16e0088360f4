"""Points of a table are left out of a fit in turn: all at a field where there are several, else points all over."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.log_groups import FEWEST_GROUPS, STEADY
from erclutch.logs.covering_stretches import field_levels
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Mask, largest_size

_GROUPS = 4  # of fields, or of points all over
_FEWEST_AT_A_FIELD = 3  # points, on average: of fewer, the field was not set but swept


def fields_left_out(points: Dataset) -> tuple[list[Mask], int]:
    """Masks of the points at some fields, and how many of them, the first ones, are at no field.

    Returns:
        No masks where the points have too few fields, or where hardly two points share a field.
    """
    level = field_levels(points.elements)
    count = int(level.max()) + 1
    if count < FEWEST_GROUPS or _is_swept(points, level):
        return [], 0
    at_no_field = np.ones(points.rows, np.bool_)
    largest = max(largest_size(element.field) for element in points.elements)
    for element in points.elements:
        at_no_field &= np.abs(element.field) <= STEADY * largest
    masks: list[Mask] = []
    for kind in (at_no_field, ~at_no_field):
        levels = np.unique(level[kind])
        for neighbours in np.array_split(levels, min(levels.size, _GROUPS)) if levels.size else ():
            masks.append(np.isin(level, neighbours))
    return masks, int(at_no_field.any())


def points_left_out(points: Dataset) -> list[Mask]:
    """Masks of points all over: neighbours at a field, or over the fields, go into different ones.

    The ends of a field's sweep, either way of the slip, are left out by none where there are enough others: nothing
    lies beyond them that could tell of them.
    """
    level = field_levels(points.elements)
    if _is_swept(points, level):
        level = np.zeros_like(level)
    field = points.elements[0].field
    slip = points.elements[0].slip
    turn = level.copy()
    inner = np.ones(points.rows, np.bool_)
    for number in range(int(level.max()) + 1):
        at_level = np.flatnonzero(level == number)
        by_slip = at_level[np.lexsort([field[at_level], slip[at_level]])]
        turn[by_slip] += np.arange(by_slip.size)
        for way in (by_slip[slip[by_slip] < 0.0], by_slip[slip[by_slip] >= 0.0]):
            inner[way[:1]] = inner[way[-1:]] = False
    if 2 * np.count_nonzero(inner) < points.rows:
        inner[:] = True
    return [inner & (turn % _GROUPS == number) for number in range(_GROUPS)]


def _is_swept(points: Dataset, level: NDArray[np.intp]) -> bool:
    """Whether hardly two points share a level of the field: the field was swept, not set."""
    return (int(level.max()) + 1) * _FEWEST_AT_A_FIELD > points.rows
