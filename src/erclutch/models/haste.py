"""Haste: how quickly the slip has changed of late, and how much wider a band is where training rows had less of it.

A first-order lag follows the slip. Haste is the running mean of how far the slip is from its lag: in a quick motion the
lag stays behind. Noise of the slip is as far from the lag in any motion, so a first lag may smooth the slip ahead of
it. Rows at the turning points and at the peaks of one motion so have about the same haste. The mean needs a time to
learn of a motion, as at the start of a log; until then haste is 2 / pi of the distance itself, which is what the mean
of a sine is of its peak. Where haste is beyond that of all training rows, the half widths of a band are multiplied by::

    quickest * (1 + growth * (haste / known - 1))

Haste begins at zero, as for a slip that has long been the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.arithmetic.elementary import absolute, less_select
from erclutch.models.stages.effort_lag import EffortLag
from erclutch.signals.array import Array, Mask
from erclutch.signals.clock import Clock

#: What follows the field, the slip, and the distance of the slip from its lag.
FOLLOWER = EffortLag()
#: Mean of a sine's magnitude over its peak.
_MEAN_OF_PEAK = 2.0 / np.pi


@dataclass(frozen=True)
class Haste:
    """What half widths of a band are multiplied by where the slip changes quickly.

    Attributes:
        lag_s: time constant in s of the lag that follows the slip.
        mean_s: time constant in s of the running mean.
        known: largest haste of the training rows, in the slip's unit.
        quickest: how much wider the band is for the quickest motion of training; 1 or more.
        growth: how much wider the band is for each `known` that the haste is beyond it, as a share.
        smooth_s: time constant in s of the lag that smooths the slip first; 0: none.
    """

    lag_s: float
    mean_s: float
    known: float
    quickest: float
    growth: float
    smooth_s: float = 0.0

    def of_rows(self, slip: Array, clock: Clock) -> Array:
        """Haste of each row, shape (n,); it begins at zero in each span."""
        every = slice(None)
        if self.smooth_s > 0.0:
            slip = FOLLOWER.respond(slip, clock, [self.smooth_s], every)
        followed = FOLLOWER.respond(slip, clock, [self.lag_s], every)
        away = np.abs(slip - followed)
        mean = FOLLOWER.respond(away, clock, [self.mean_s], every)
        return np.asarray(_larger(mean, _MEAN_OF_PEAK * away), np.float64)

    def beyond(self, slip: Array, clock: Clock) -> Mask:
        """Rows with more haste than any training row, shape (n,)."""
        return self.of_rows(slip, clock) > self.known

    def factors(self, slip: Array, clock: Clock) -> Array:
        """What the half widths of each row are multiplied by, shape (n,)."""
        return np.asarray(self.factor(self.of_rows(slip, clock)), np.float64)

    def factor_of_step(self, slip: Any, follow: Callable[[float, Any, str], Any]) -> Any:
        """What the half widths of one row are multiplied by, on any operand.

        Args:
            slip: of the row.
            follow: a first-order lag, from its time constant in s, its signal and its name.
        """
        if self.smooth_s > 0.0:
            slip = follow(self.smooth_s, slip, "_smooth")
        away = absolute(slip - follow(self.lag_s, slip, "_slip"))
        mean = follow(self.mean_s, away, "_haste")
        return self.factor(_larger(mean, _MEAN_OF_PEAK * away))

    def factor(self, haste: Any) -> Any:
        """What half widths are multiplied by at some haste, on any operand."""
        beyond = haste * (1.0 / self.known) - 1.0
        return less_select(0.0, beyond, self.quickest * (1.0 + self.growth * beyond), 1.0)


def _larger(one: Any, other: Any) -> Any:
    """The larger of two, elementwise on any operand."""
    return less_select(one, other, other, one)
