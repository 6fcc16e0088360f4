"""A band with gaps in its grid, for tests of what an export does with a band."""

from __future__ import annotations

from dataclasses import replace

from erclutch.models.band import Band
from erclutch.models.haste import Haste

WIDTHS = tuple(0.01 * 1.3**k for k in range(24))
BAND = Band(
    0.95,
    0.01,
    40.0,
    (0.0, 2000 / 3),
    (-30.1, 30.1),
    (100.0, 300.0, 500.0),
    (5.0, 20.0),
    WIDTHS,
    tuple(1.5 * w for w in WIDTHS),
)
#: The same, wider where the slip changes more quickly than in most rows of a test, and with a part that is asked for.
HASTY = replace(BAND, haste=Haste(0.02, 0.2, 2.0, 1.2, 0.5), part=0.02)
#: The same, with a slip that is smoothed first.
SMOOTH = replace(HASTY, haste=Haste(0.02, 0.2, 2.0, 1.2, 0.5, 0.01))
