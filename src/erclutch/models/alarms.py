"""Alarms say on a target when its estimate is not to be trusted: the band is wide, or the residual has drifted.

The third alarm, an input far from all training rows, is `Range.far`; every model has it. The two here need a band.

Three tests look for a drift: measured efforts lie outside the band too often, or lean to the side of the slip, or to
the other side. Rows are gathered in blocks, because neighbouring rows err together. A block has a share: that of its
rows outside the band, or 1 if the mean of its residuals, in half widths of the band and held within one, is beyond a
limit. Each block multiplies the wealth of a test::

    wealth = max(wealth, 1)(1 + (share / tolerated - 1) / 2)

While the tolerated share is expected of each block at most, whatever the blocks before did, the wealth reaches the goal
once in as many blocks as the goal says, on average or more rarely (an e-detector: Shin, Ramdas and Rinaldo,
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


@dataclass(frozen=True)
class Alarms:
    """Numbers of the alarms of a model.

    Attributes:
        band: of the model.
        wide: width above which the band counts as wide, in the effort's unit.
        block: rows of a block.
        missing: share of rows outside the band that is tolerated: twice what the band promises.
        lean: mean residual in half widths above which a block leans.
        leaning: share of blocks leaning to one side that is tolerated.
        goal: wealth that raises the alarm; blocks of 1 s take eleven days to it by chance, each of three tests.
    """

    band: Band
    wide: float
    block: int
    missing: float
    lean: float = 0.2
    leaning: float = 0.2
    goal: float = 1e6

    def wealth(self, before: Any, share: Any, tolerated: float) -> Any:
        """The wealth after a block, elementwise on any operand; no number as it was before counts as 1."""
        return within(within(before, 1.0, self.goal) * (0.5 + share * (0.5 / tolerated)), 0.0, self.goal)


def alarms_of(band: Band, largest: float, period: float) -> Alarms:
    """The alarms for a band.

    Args:
        band: of a model.
        largest: largest magnitude of the training effort.
        period: sampling period in s.
    """
    return Alarms(band, _WIDE * largest, max(1, round(_BLOCK / period)), min(2.0 * (1.0 - band.level), 0.5))
