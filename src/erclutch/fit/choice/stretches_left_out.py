"""A log that goes once through its fields and speeds has stretches all over it left out too, beside blocks in time.

Each quarter of such a log has what no other quarter has, so a fit without it is asked to go beyond what it knows. A
next log may ask for that, or go through the same once more. The second is what stretches between others that are fitted
ask for. As where an end is held out (`checks.usual_hold_out`), field and slip decide; the effort has no say.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.fit.checks.usual_hold_out import BEYOND, WORTH
from erclutch.fit.training_range import share_beyond
from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import FEWEST_ROWS_OF_A_BLOCK
from erclutch.signals.array import Mask

_WINDOWS = 20  # of all rows, at most


def stretches_left_out(data: Dataset, blocks: Sequence[Mask]) -> list[Mask]:
    """As many sets of stretches as there are blocks in time; none where the blocks do not go beyond one another.

    Args:
        data: the rows of one log.
        blocks: its blocks in time, each a mask of shape (n,).
    """
    beyond = _share_beyond_of_all(data, blocks)
    windows = min(_WINDOWS, data.rows // FEWEST_ROWS_OF_A_BLOCK)
    if beyond < BEYOND or windows < 2 * len(blocks):
        return []
    window = np.arange(data.rows) * windows // data.rows  # of each row
    # The first window and the last one border on nothing: the blocks ask for what lies beyond.
    inner = (window > 0) & (window < windows - 1)
    sets = [inner & (window % len(blocks) == number) for number in range(len(blocks))]
    if _share_beyond_of_all(data, sets) > WORTH * beyond:
        return []
    return sets


def _share_beyond_of_all(data: Dataset, parts: Sequence[Mask]) -> float:
    """Share of all rows that lie in a part and that no row outside of it comes near."""
    return sum(share_beyond(data, part) * float(part.mean()) for part in parts)
