"""Signals that were scaled for a network are doubted: nobody knows any more where they were zero.

A column that was scaled to a range ends at exactly 0 and 1, or at -1 and 1. A standardised column has a mean of 0 and a
standard deviation of 1. One signal may have such numbers by chance; a motion and its effort together do not.
"""

from __future__ import annotations

import numpy as np

from erclutch.logs.columns.vocabulary import set_of
from erclutch.logs.planning.draft import Draft
from erclutch.signals.array import Array

_FEWEST = 30  # different numbers of a motion or an effort: a few of them are levels or switches
_ROUNDING = 1e-12  # of the arithmetic; samples of a sine of size 1 do not come as near
_STANDARD = 0.01  # of a mean and a standard deviation: rows may have been left out since
_TO_ONE = "numbers from exactly 0 to exactly 1"
_ABOUT_ZERO = "numbers from exactly -1 to exactly 1"
_CALLED_SO = set_of("norm normalized normalised scaled standardized standardised zscore")


def doubt_signals_scaled_for_a_network(draft: Draft) -> None:
    """Doubt a guessed effort that was scaled in the same way as the motion, by their numbers or their names."""
    effort = draft.guessed("effort")
    motion = draft.signals.get("slip") or draft.signals.get("position")
    if effort is None or motion is None or not motion.column:
        return
    columns = [draft.seen.columns[each.column] for each in (motion, effort)]
    has_few_numbers = any(np.unique(column.values).size < _FEWEST for column in columns)
    ways = {_way_of_scaling(column.values) for column in columns}
    way = ways.pop() if len(ways) == 1 and not has_few_numbers else ""
    field = draft.signals.get("field")
    way_of_field = ""
    if field is not None and field.column:
        way_of_field = _way_of_scaling(draft.seen.columns[field.column].values)
    if way == _ABOUT_ZERO and way_of_field != way:
        way = ""  # sines of size 1, as people make them up
    if way:
        doubt = f"which has {way}, as {motion.column} has"
    elif all(column.spoken.says(_CALLED_SO) for column in columns):
        doubt = f"which is called scaled, as {motion.column} is"
    else:
        return
    draft.doubt("effort", f"{doubt}: where it is zero is lost. Give a log as it was measured")


def _way_of_scaling(values: Array) -> str:
    """What tells that numbers were scaled, in words; "" for others."""
    known = values[np.isfinite(values)]
    if not known.size:
        return ""
    ends = np.array([known.min(), known.max()])
    for low, way in ((0.0, _TO_ONE), (-1.0, _ABOUT_ZERO)):
        if np.allclose(ends, (low, 1.0), rtol=0.0, atol=_ROUNDING):
            return way
    is_standard = abs(known.mean()) < _STANDARD and abs(known.std() - 1.0) < _STANDARD
    return "a mean of 0 and a standard deviation of 1" if is_standard else ""
