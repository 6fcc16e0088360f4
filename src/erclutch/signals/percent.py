"""A share in per cent, spelled the same in all texts: ``1.3 %``."""

from __future__ import annotations

#: A share: how far above it a figure lies says nothing, and may take a line of digits.
_MOST = 1000.0


def percent(share: float, places: int = 0, *, sign: bool = False) -> str:
    """A share as text, with a sign also where it is above zero if that is asked for."""
    if share > _MOST:
        return f"above {100.0 * _MOST:,.0f} %"
    plus = "+" if sign else ""
    return f"{100.0 * share:{plus}.{places}f} %"
