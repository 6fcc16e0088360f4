"""The unit of a speed may stand right behind its name; of ``Speeddeg_per_s`` the end alone is that of a shear rate."""

from __future__ import annotations

import re

_GLUED = re.compile(
    r"(speed|velocity|vel|omega|geschwindigkeit|drehzahl)([^\W\d_]+)_(?:per|1)_s(?:ec)?",
    re.IGNORECASE,
)
_COUNTED = ("mrad", "rad", "deg", "mm", "cm", "m")


def is_glued_speed(name: str) -> bool:
    """Whether a name is a word for a speed with a unit right behind it."""
    return _GLUED.fullmatch(name) is not None


def split_glued_speed(name: str) -> tuple[str, str | None]:
    """``Speed`` and ``deg/s`` of ``Speeddeg_per_s``; the whole name and None where nobody knows what is counted."""
    parts = _GLUED.fullmatch(name)
    if parts is None or parts[2] not in _COUNTED:
        return name, None
    return parts[1], f"{parts[2]}/s"
