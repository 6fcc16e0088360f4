"""The line that a match looks for: what B's clock shows at each time of A's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from erclutch.signals.array import Array
from erclutch.wings.align.track import Track


@dataclass(frozen=True)
class ClockLine:
    """``t_B = t_A + middle + drift * (t_A - at)``, in s."""

    at: float
    middle: float
    drift: float

    def __call__(self, time: Array) -> Array:
        """Times of A, in s, as B's clock shows them."""
        return time + self.middle + self.drift * (time - self.at)

    def back(self, time: Array) -> Array:
        """Times of B, in s, as A's clock shows them."""
        return self.at + (time - self.at - self.middle) / (1.0 + self.drift)

    def about(self, time: float) -> ClockLine:
        """The same line with its offset given at another time of A, in s."""
        shown = self(np.array(time))
        offset = float(shown) - time
        return ClockLine(time, offset, self.drift)


def overlap_of(a: Track, b: Track, line: ClockLine) -> tuple[float, float]:
    """First and last time on A's clock that both logs have."""
    ends_of_b = np.array(b.ends)
    low, high = line.back(ends_of_b).tolist()
    return max(a.ends[0], low), min(a.ends[1], high)
