"""A share in per cent, spelled the same in all texts: ``1.3 %``."""

from __future__ import annotations


def percent(share: float, places: int = 0, *, sign: bool = False) -> str:
    """A share as text, with a sign also where it is above zero if that is asked for."""
    plus = "+" if sign else ""
    return f"{100.0 * share:{plus}.{places}f} %"
