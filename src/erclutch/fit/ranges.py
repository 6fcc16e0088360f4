"""What training data covered."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from erclutch.dataset import Dataset
from erclutch.model import Range

Array = NDArray[np.float64]


def range_of(data: Dataset) -> Range:
    """Smallest and largest field, slip and effort of a data set."""

    def span(arrays: Sequence[Array]) -> tuple[float, float]:
        return min(float(a.min()) for a in arrays), max(float(a.max()) for a in arrays)

    return Range(span([e.field for e in data.elements]), span([e.slip for e in data.elements]), span([data.effort]))


def period_of(data: Dataset) -> float:
    """Sampling period of a data set in s: the median of its spans', or of its steps."""
    steps = [s.period for s in data.clock.spans if s.period is not None]
    return float(np.median(steps)) if steps else float(np.median(np.diff(data.clock.time)))
