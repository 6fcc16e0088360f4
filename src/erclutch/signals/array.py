"""The types of arrays that all rooms share: `Array` of float64 numbers and `Mask` of truth values, of any shape."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
