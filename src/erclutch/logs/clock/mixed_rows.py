"""Rows of a log that were mixed up, as for the training of a network: their stamps tell in which order they belong."""

from __future__ import annotations

import numpy as np

from erclutch.logs.clock.time_stamps import DISORDER
from erclutch.signals.array import Array

#: Rows: fewer may be points of an instrument, each with the time at which it was taken.
_FEWEST = 100
_EVEN = 1e-3  # of a step
_PRESENT = 0.5  # of the rows between the first and the last: the others may be those of a test


def are_mixed_up(stamps: Array) -> bool:
    """Whether stamps run back every few rows, and sorted are those of a steady clock, each there once.

    Args:
        stamps: in the order of the rows, shape (n,); what is not finite is passed over.
    """
    known = stamps[np.isfinite(stamps)]
    back = np.count_nonzero(np.diff(known) < 0.0)
    if known.size < _FEWEST or back <= DISORDER * known.size or back == known.size - 1:
        return False
    steps = np.diff(np.sort(known))
    shortest = float(steps.min())
    if shortest <= 0.0:
        return False
    periods = steps / shortest
    is_steady = np.abs(periods - np.rint(periods)).max() <= _EVEN * periods.max()
    return bool(is_steady and known.size >= _PRESENT * periods.sum())
