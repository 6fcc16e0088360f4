"""What pinned tests keep of arrays, and of what raises."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from erclutch.errors import ErclutchError

Pinned = Callable[..., None]


def summed(values: Any) -> list[float]:
    """How large numbers are, and a sum that knows their order."""
    flat = np.asarray(values, np.float64).ravel()
    return [
        flat.size,
        float(np.nansum(np.abs(flat))),
        float(np.nansum(flat * np.cos(np.arange(flat.size)))),
    ]


def told(of: Callable[[], Any]) -> Any:
    """What comes of it, or the words of the error."""
    try:
        return of()
    except ErclutchError as error:
        return f"{type(error).__name__}: {error}"
