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
