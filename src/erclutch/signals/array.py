"""The types of arrays that all rooms share: `Array` of float64 numbers and `Mask` of truth values; and their size."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
#: Standard deviation of normal noise over the median of its absolute deviations.
SIGMA_OF_MAD = 1.4826


def largest_size(values: ArrayLike) -> float:
    """The largest absolute value of an array of any shape."""
    return float(np.abs(np.asarray(values)).max())


def rms(values: Array) -> float:
    """The root mean square of an array of any shape."""
    return float(np.sqrt(np.mean(values**2)))


def noise_of(values: Array) -> float:
    """Standard deviation of a signal's noise, from the median of its second differences; 0 where most rows repeat.

    So a signal that stands still or goes along a straight line has none, and one that swings slowly next to none.
    """
    apart = np.abs(np.diff(values, 2))
    if not apart.size:
        return 0.0
    deviation = SIGMA_OF_MAD * float(np.median(apart))  # of normal noise, from its median
    return deviation / 6.0**0.5  # x - 2 y + z has six times the variance


def largest_of_windows(values: Array, rows: int) -> Array:
    """The largest of so many rows from each row on, where that many follow, shape (n - rows + 1,).

    Each pass doubles the rows that have been looked at. SciPy's filter takes a third of a second to import.
    """
    largest, seen = values, 1
    while seen < rows:
        further = min(seen, rows - seen)
        largest = np.maximum(largest[:-further], largest[further:])
        seen += further
    return largest
