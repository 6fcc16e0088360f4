"""A log may be taken at one field after another without a gap between: this finds where each field begins and ends.

A commanded field keeps its level to the last bit. A measured current has noise, and takes a while from level to level.
So levels are sought in a histogram of the field: narrow groups of values that hold nearly all rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array

_BINS = 100  # of the field's range
_RARE = 0.005  # share of the rows below which a bin belongs to a way from level to level
_WIDEST = 10  # bins of a level
_ON_LEVELS = 0.9  # share of the rows
_FEWEST_ROWS = 50  # of a plateau
_RETURNS = 2  # plateaus a level: up a staircase and down again


def plateaus(fields: Sequence[Array]) -> list[tuple[int, int]]:
    """Rows [start, stop) of each stretch of one field; none for a field that is constant, sweeps, or switches often.

    Args:
        fields: of each element, shape (n,).
    """
    rows = fields[0].size
    if not rows:
        return []
    changed = np.zeros(rows - 1, np.bool_)
    levels: list[NDArray[np.intp]] = []  # number of the level of each row, for each element
    for field in fields:
        low = float(field.min())
        high = float(field.max())
        if not high > low:
            levels.append(np.zeros(rows, np.intp))
            continue
        share = (field - low) / (high - low)
        bins = np.minimum((share * _BINS).astype(np.intp), _BINS - 1)
        often = np.bincount(bins, minlength=_BINS) >= max(_RARE * rows, 1)
        group_begins = np.flatnonzero(often & ~np.append(False, often[:-1]))
        group_ends = np.flatnonzero(often & ~np.append(often[1:], False))
        too_wide = bool(np.any(group_ends - group_begins >= _WIDEST))
        if too_wide or np.mean(often[bins]) < _ON_LEVELS:
            return []
        group = np.cumsum(np.isin(np.arange(_BINS), group_begins)) - 1  # of each bin often met

        # A row on the way takes the next row that is on a level; the last rows take the last level.
        on_level = np.flatnonzero(often[bins])
        place = np.searchsorted(on_level, np.arange(rows))
        following = on_level[np.minimum(place, on_level.size - 1)]
        level = group[bins[following]].astype(np.intp)
        changed |= np.diff(level) != 0
        levels.append(level)
    begins = np.flatnonzero(changed) + 1
    edges = [0, *begins.tolist(), rows]
    runs = list(pairwise(edges))
    levels_of_runs = np.array(levels)[:, edges[:-1]]  # shape (elements, runs)
    _, distinct = np.unique(levels_of_runs, axis=1).shape
    if not 1 < len(runs) <= _RETURNS * distinct:
        return []
    shortest = min(stop - start for start, stop in runs)
    return runs if shortest >= _FEWEST_ROWS else []
