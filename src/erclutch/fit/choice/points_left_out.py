"""Points of a table are left out of a fit in turn: all at a field where there are several, else points all over."""

from __future__ import annotations

import numpy as np

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
    if count < FEWEST_GROUPS or count * _FEWEST_AT_A_FIELD > points.rows:
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
    """Masks of points all over: neighbours by their slip go into different ones."""
    by_slip = np.lexsort([points.elements[0].field, points.elements[0].slip])
    turn = np.empty(points.rows, np.intp)
    turn[by_slip] = np.arange(points.rows) % _GROUPS
    return [turn == number for number in range(_GROUPS)]
