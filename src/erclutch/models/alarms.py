"""Alarms say on a target when its estimate is not to be trusted: the band is wide, or the residual has drifted.

The third alarm, an input far from all training rows, is `Range.far`; every model has it. The two here need a band.

The residual has drifted where measured efforts lie outside the band more often than they may. Rows are gathered in
blocks, because neighbouring rows miss together. Each block multiplies a wealth::

    wealth = max(wealth, 1)(1 + bet(misses / rows - tolerated))

While at most the tolerated share of each block is expected to miss, whatever the blocks before did, the wealth reaches
the goal once in as many blocks as the goal says, on average or more rarely (an e-detector: Shin, Ramdas and Rinaldo,
doi:10.51387/23-NEJSDS51). The rows of a block may depend on each other in any way. Rows without a measured effort, bad
rows and rows outside what was trained on do not count.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from erclutch.models.band import Band
from erclutch.models.covered_cells import within

#: A block's length in s: longer than residuals of a motion at some hertz are alike.
_BLOCK = 1.0
#: Share of the largest training effort above which a band is wide.
_WIDE = 0.25
#: Blocks to a false alarm: eleven days.
_GOAL = 1e6


@dataclass(frozen=True)
class Alarms:
    """Numbers of the alarms of a model.

    Attributes:
        band: of the model.
        wide: width above which the band counts as wide, in the effort's unit.
        block: rows of a block.
        tolerated: share of misses that a block may have for ever: twice what the band promises.
        bet: what a miss more or less than tolerated is worth; a block without a miss halves the wealth.
        goal: wealth that raises the alarm.
    """

    band: Band
    wide: float
    block: int
    tolerated: float
    bet: float
    goal: float = _GOAL

    def wealth(self, before: Any, misses: Any) -> Any:
        """The wealth after a block, elementwise on any operand; no number as it was before counts as 1."""
        factor = (1.0 - self.bet * self.tolerated) + misses * (self.bet / self.block)
        return within(within(before, 1.0, self.goal) * factor, 0.0, self.goal)


def alarms_of(band: Band, largest: float, period: float) -> Alarms:
    """The alarms for a band.

    Args:
        band: of a model.
        largest: largest magnitude of the training effort.
        period: sampling period in s.
    """
    tolerated = min(2.0 * (1.0 - band.level), 0.5)
    return Alarms(band, _WIDE * largest, max(1, round(_BLOCK / period)), tolerated, 0.5 / tolerated)
