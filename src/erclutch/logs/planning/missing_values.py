"""Rows that lack a number of a signal: a few of them are dropped without a word of the user, many are asked about."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from erclutch.logs.clock.timing import MINIMUM_ROWS
from erclutch.logs.columns.seen_columns import SeenColumns
from erclutch.logs.planning.draft import Draft
from erclutch.signals.array import Array, Mask

_MOST_HOLES = 0.1  # share of the rows that lack a number


def drop_few_missing_values(draft: Draft) -> None:
    """Drop rows that lack a number of a signal where they are not many: without them the others are what they were.

    A log is cut at such rows, so its stretches between them must be worth having. An infinite value was measured by
    nothing, but it was written by something: that is asked about.
    """
    if draft.invalid is not None or draft.clock is None:
        return
    columns = [draft.table.columns[each.column] for each in draft.signals.values() if each.column]
    hole = _holes(draft.table.rows, columns)
    if hole is None or not hole.any():
        return
    if _are_few(hole, points=draft.clock.kind == "points"):
        draft.invalid = "drop"


def must_be_said(seen: SeenColumns, needed: Iterable[str]) -> bool:
    """Whether the user has to say that the log is cut at missing values: they are many, or some are infinite."""
    columns = [seen.columns[name].values for name in needed]
    hole = _holes(seen.table.rows, columns)
    return hole is None or (bool(hole.any()) and not _are_few(hole, points=False))


def _holes(rows: int, columns: Iterable[Array]) -> Mask | None:
    """Rows that lack a number of a column; None where one is infinite."""
    hole = np.zeros(rows, dtype=np.bool_)
    for values in columns:
        if np.isinf(values).any():
            return None
        hole |= np.isnan(values)
    return hole


def _are_few(hole: Mask, *, points: bool) -> bool:
    """Whether the rows without a hole are many, and stand in stretches that are worth having."""
    missing = int(np.count_nonzero(hole))
    if missing > _MOST_HOLES * hole.size:
        return False
    if points:
        return True
    ends = np.diff(hole.astype(np.int8)) == -1  # of holes: a stretch begins behind each
    stretches = int(np.count_nonzero(ends)) + int(not hole[0])
    return hole.size - missing >= MINIMUM_ROWS * stretches
