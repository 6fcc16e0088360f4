"""On the loop a common gain and an offset of a model may follow the sensor, within bounds and within a budget of error.

A recursive least-squares estimate with forgetting runs beside the model. An account decides which effort is given out:
it earns what the adapted effort saves, (base error)^2 - (given error)^2, and 4.04 % of (base error)^2 in each row. The
adapted effort is given out only while the account covers the most that one row can cost. So the account is never
negative, and after every row of any stream, errors clipped at ``limit``::

    sum of (given error)^2 <= 1.02^2 * sum of (base error)^2

The RMSE is at most 2 % larger than that of the base. A row without a finite sensor and effort changes nothing and is
not counted. The account has a cap: after a good time an estimate that goes wrong is left soon. The C loop does not have
this yet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

_SHARE = 1.02**2 - 1.0
_CAP = 10.0  # of the account, in squares of the limit


@dataclass(frozen=True)
class GainTracking:
    """The state between two rows, and the bounds.

    Attributes:
        limit: size from which an error is one of the sensor, in the effort's unit; errors are clipped there.
        gain, offset: the estimate; the offset in the effort's unit.
        account: squared error that may be lost.
        spread: covariance (gain, both, offset) of the estimate, the offset in parts of the limit.
        reach: the gain stays within 1 +- reach, the offset within +- reach * limit.
        forgetting: weight of the past from row to row.
        dead: an error below this part of the limit teaches nothing.
    """

    limit: float
    gain: float = 1.0
    offset: float = 0.0
    account: float = 0.0
    spread: tuple[float, float, float] = (0.1, 0.0, 0.1)
    reach: float = 0.3
    forgetting: float = 0.9999
    dead: float = 0.001

    def estimate(self, effort: float) -> float:
        """The effort to be given out for the model's effort, before the sensor is read."""
        moved = self.gain * effort + self.offset
        # |a^2 - b^2| for errors a, b clipped at the limit, which differ by no more than the efforts do.
        cost = min(2.0 * self.limit * abs(moved - effort), self.limit**2)
        return moved if self.account >= cost else effort

    def step(self, effort: float, sensor: float) -> GainTracking:
        """The state after a row with the model's effort and what the sensor says."""
        if not (math.isfinite(sensor) and math.isfinite(effort)):
            return self
        base, given = (self._clipped(sensor - value) for value in (effort, self.estimate(effort)))
        account = self.account + (1.0 + _SHARE) * base**2 - given**2
        return replace(self._learned(effort, sensor), account=min(account, _CAP * self.limit**2))

    def _clipped(self, value: float) -> float:
        return min(max(value, -self.limit), self.limit)

    def _learned(self, effort: float, sensor: float) -> GainTracking:
        """The estimate after a row, in parts of the limit and projected on the bounds."""
        missed = self._clipped(sensor - self.gain * effort - self.offset) / self.limit
        if abs(missed) <= self.dead:
            return self
        x, (gg, go, oo) = self._clipped(effort) / self.limit, self.spread
        by_gain, by_offset = gg * x + go, go * x + oo
        size = self.forgetting + by_gain * x + by_offset
        gain = self.gain + by_gain / size * missed
        offset = self.offset + by_offset / size * missed * self.limit
        left = (gg - by_gain**2 / size, go - by_gain * by_offset / size, oo - by_offset**2 / size)
        # Forgetting must not let the spread grow for ever where nothing moves.
        scale = 1.0 / self.forgetting if left[0] + left[2] < self.reach**2 else 1.0
        bound = self.reach * self.limit
        return replace(
            self,
            gain=min(max(gain, 1.0 - self.reach), 1.0 + self.reach),
            offset=min(max(offset, -bound), bound),
            spread=(scale * left[0], scale * left[1], scale * left[2]),
        )
