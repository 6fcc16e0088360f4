"""Whether the field of a device may drag as eddy currents do: nothing at rest, and perhaps less at high slips.

A fluid with a yield stress has most of its effort at small slips already. So a law of a drag is left out where the
field's effort does the same: on such rows it would cost time, and stand in for a yield effort that turns slowly.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from erclutch.logs.dataset import Dataset

#: Rows of a strong field have that share of the largest field at least.
_STRONG = 0.5
#: Edges of bands of the slip, as shares of a slip that hardly any row exceeds; the first band is too near to rest.
_EDGES = (0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0)
_HARDLY_ANY = 0.98
_FEWEST_ROWS = 5  # of a band that counts
#: Share of the largest effort of all bands: what the slowest band of a drag has at most, or else the quickest.
_SLOW, _QUICK = 0.3, 0.9


def field_drags(data: Dataset) -> bool:
    """Whether the effort at strong fields vanishes towards rest, or falls at the highest slips."""
    if data.device != "single" or data.one_field:
        return False
    element = data.elements[0]
    size = np.abs(element.field)
    strong = ~data.at_rest & (size >= _STRONG * size.max())
    slip = np.abs(element.slip[strong])
    against = (np.sign(element.slip) * data.effort)[strong]  # that of a passive device is positive
    if slip.size < _FEWEST_ROWS:
        return False

    high = float(np.quantile(slip, _HARDLY_ANY))
    levels: list[float] = []  # mean effort of each band; nan where no rows tell it
    for low_edge, high_edge in pairwise(_EDGES):
        of_band = against[(slip >= low_edge * high) & (slip <= high_edge * high)]
        levels.append(float(of_band.mean()) if of_band.size >= _FEWEST_ROWS else np.nan)
    known = [level for level in levels if not np.isnan(level)]
    if not known or max(known) <= 0.0:
        return False
    unknown_at_rest = np.isnan(levels[0])
    vanishes = unknown_at_rest or levels[0] <= _SLOW * max(known)
    falls = known[-1] <= _QUICK * max(known)
    return bool(vanishes or falls)
