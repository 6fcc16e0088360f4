"""Alarms say on a target when its estimate is not to be trusted: the band is wide, or the residual has drifted.

The third alarm, an input far from all training rows, is `Range.far`; every model has it. The two here need a band.

Five tests look for a drift: measured efforts lie outside the band too often, lean to the side of the slip or to the
other side, or are larger or smaller than the estimate by a factor. Rows are gathered in blocks, because neighbouring
rows err together. A block has a share: that of its rows outside the band, or 1 if its residuals lean beyond a limit, or
are a part of the estimate beyond another (`part_of`), else 0. Residuals count in half widths of the band, held within
one. Each block multiplies the wealth of a test::

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
#: Blocks in which a residual is asked whether it is a part of the estimate: a slow motion has two sides.
LONG = 2
#: Share of the largest training effort above which a band is wide.
_WIDE = 0.25
#: How often the part that blocks of training rows seldom reach a new motion may reach, and the least that is told.
_BEYOND = 2.0
_LEAST_PART = 0.02  # of the estimate: errors that follow a smaller part of it are no drift
#: An estimate counts up to so many half widths: a part of a larger one would be outside the band.
_MOST_WIDTHS = 100.0


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
        part: part of the estimate above which the residuals of a long block follow it; None: nobody asks, for the
            training rows were too few to say how often they do.
        following: share of long blocks with such residuals of one sign that is tolerated.
        goal: wealth that raises the alarm; by chance one test of blocks of 1 s takes 23 days to it, or more.
    """

    band: Band
    wide: float
    block: int
    missing: float
    lean: float = 0.2
    leaning: float = 0.2
    part: float | None = None
    following: float = 0.1
    goal: float = 2e6

    @property
    def false_alarms(self) -> float:
        """Alarms by chance in a block, at most."""
        long = 0.0 if self.part is None else 2.0 / LONG
        return (3.0 + long) / self.goal

    def wealth(self, before: Any, share: Any, tolerated: float) -> Any:
        """The wealth after a block, elementwise on any operand; no number as it was before counts as 1."""
        known = within(before, 1.0, self.goal)
        factor = 0.5 + share * (0.5 / tolerated)
        return within(known * factor, 0.0, self.goal)


def alarms_of(band: Band, largest: float, period: float) -> Alarms:
    """The alarms for a band.

    Args:
        band: of a model.
        largest: largest magnitude of the training effort.
        period: sampling period in s.
    """
    part = None if band.part is None else max(_BEYOND * band.part, _LEAST_PART)
    return Alarms(
        band=band,
        wide=_WIDE * largest,
        block=block_rows(period),
        missing=min(2.0 * (1.0 - band.level), 0.5),
        part=part,
    )


def block_rows(period: float) -> int:
    """Rows of a block, from the sampling period in s."""
    return max(1, round(_BLOCK / period))


def in_half_widths(residual: Any, estimate: Any, half_width: Any) -> tuple[Any, Any]:
    """Residual and estimate in half widths of the band, on any operand: a residual counts as far as a band reaches."""
    off = within(residual / half_width, -1.0, 1.0)
    size = within(estimate / half_width, -_MOST_WIDTHS, _MOST_WIDTHS)
    return off, size


def part_of(along: Any, own: Any, rows: Any) -> Any:
    """Which part of the estimate the residuals of some rows are, on any operand; nearer to zero where rows say little.

    Args:
        along: sum of the products of residual and estimate, both in half widths of the band.
        own: sum of the squares of the estimate in half widths.
        rows: their number.
    """
    return along / (rows + own)
