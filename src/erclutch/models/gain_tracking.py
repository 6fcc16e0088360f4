"""A common gain and an offset of a model may follow a torque sensor, within bounds and within a budget of error.

A recursive least-squares estimate with forgetting runs beside the model. An account decides which effort is given out:
it earns what the adapted effort saves, (base error)^2 - (given error)^2, and 4.04 % of (base error)^2 in each row. The
adapted effort is given out only while the account is above the most that one row can cost. So the account is never
negative, and after every row of any stream, errors clipped at ``limit``::

    sum of (given error)^2 <= 1.02^2 * sum of (base error)^2

The RMSE is at most 2 % larger than that of the base. A row without a finite sensor changes nothing and is not counted.
The account has a cap: after a good time an estimate that goes wrong is left soon. Every function works on any operand,
so C and Python come from one record. Efforts and errors are counted in parts of the limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from erclutch.arithmetic.elementary import less_select
from erclutch.models.covered_cells import within

#: Of the squared error of the base that may be lost in all.
_SHARE = 1.02**2 - 1.0
#: The most that an account holds, in squares of the limit.
_CAP = 10.0
#: Share of the largest training effort from which an error is one of the sensor.
_ODD = 0.25
#: The gain stays within 1 +- reach, the offset within +- reach.
REACH = 0.3
#: Weight of the past from row to row; an error below this teaches nothing.
_FORGETTING, _DEAD = 0.9999, 0.001


class Tracked(NamedTuple):
    """The state between two rows: gain and offset, squared error that may be lost, covariance of gain and offset."""

    gain: Any
    offset: Any
    account: Any
    gain_spread: Any
    both_spread: Any
    offset_spread: Any


#: Of the model as it is.
BASE = Tracked(1.0, 0.0, 0.0, 0.1, 0.0, 0.1)


def tracking_of(largest: float, limits: tuple[float, float]) -> GainTracking:
    """The tracking for a model by the largest magnitude of its training effort and the limits of its effort."""
    return GainTracking(_ODD * largest, *limits)


@dataclass(frozen=True)
class GainTracking:
    """Numbers of the tracking.

    Attributes:
        limit: size from which an error is one of the sensor, in the effort's unit; errors are clipped there.
        lowest, highest: the adapted effort stays within.
    """

    limit: float
    lowest: float
    highest: float

    def moved(self, state: Tracked, effort: Any) -> tuple[Any, Any]:
        """The adapted effort for an effort of the model, and the most that the adapted effort can cost in a row."""
        raw = state.gain * effort + state.offset * self.limit
        moved = within(raw, self.lowest, self.highest)
        away = (moved - effort) * (2.0 / self.limit)
        # |a^2 - b^2| for errors a, b clipped at one, which differ by no more than the efforts do.
        return moved, within(less_select(away, 0.0, -away, away), 0.0, 1.0)

    def after(
        self,
        state: Tracked,
        effort: Any,
        given: Any,
        measured: Any,
    ) -> Tracked:
        """The state after a row with the model's effort, what was given out for it, and a finite measured effort."""
        base = self._part(measured - effort)
        own = self._part(measured - given)
        account = within(state.account + ((1.0 + _SHARE) * base * base - own * own), 0.0, _CAP)
        adapted = state.gain * effort + state.offset * self.limit
        missed = self._part(measured - adapted)
        _, _, _, gg, go, oo = state
        x = effort * (1.0 / self.limit)
        by_gain = gg * x + go
        by_offset = go * x + oo
        size = _FORGETTING + (by_gain * x + by_offset)
        per = 1.0 / less_select(_FORGETTING, size, size, _FORGETTING)
        step = missed * per
        gain_spread = gg - by_gain * by_gain * per
        both_spread = go - by_gain * by_offset * per
        offset_spread = oo - by_offset * by_offset * per
        # Forgetting must not let the spread grow for ever where nothing moves.
        scale = less_select(gain_spread + offset_spread, REACH**2, 1.0 / _FORGETTING, 1.0)
        learned = Tracked(
            gain=within(state.gain + by_gain * step, 1.0 - REACH, 1.0 + REACH),
            offset=within(state.offset + by_offset * step, -REACH, REACH),
            account=account,
            gain_spread=within(scale * gain_spread, 0.0, 1.0),
            both_spread=within(scale * both_spread, -1.0, 1.0),
            offset_spread=within(scale * offset_spread, 0.0, 1.0),
        )
        error = missed * missed
        kept: list[Any] = []
        for new, old in zip(learned, state, strict=True):
            kept.append(less_select(_DEAD**2, error, new, old))
        return Tracked(*kept)._replace(account=account)

    def _part(self, effort: Any) -> Any:
        """In parts of the limit, clipped at one."""
        return within(effort * (1.0 / self.limit), -1.0, 1.0)
