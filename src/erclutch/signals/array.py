"""The types of arrays that all rooms share: `Array` of float64 numbers and `Mask` of truth values, of any shape."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def of_arrow(column: Any) -> NDArray[Any]:
    """Numbers of an Arrow column without missing values, shape (n,).

    Arrow's own `to_numpy` imports pandas, takes a third of a second for it, and loses a Ctrl-C meanwhile.
    """
    numbers: NDArray[Any] = np.from_dlpack(column.combine_chunks())
    return numbers.copy()
