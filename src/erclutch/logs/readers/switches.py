"""A column of the words of a switch, such as ON and OFF, is a column of ones and zeros, whatever file it stands in."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.signals.array import Array

if TYPE_CHECKING:
    import pandas as pd

#: Texts that say on or off, in small letters.
_SWITCHES = {
    **dict.fromkeys(
        ("on", "true", "yes", "high", "enabled", "ein", "an", "ja", "oui", "vrai", "开", "オン"),
        1.0,
    ),
    **dict.fromkeys(
        ("off", "false", "no", "low", "disabled", "aus", "nein", "non", "faux", "关", "オフ"), 0.0
    ),
}
_MOST_WORDS = 4  # ON, on, OFF, off


def switched(label: str, cells: pd.Series[Any]) -> tuple[Array, str] | None:
    """The column as ones and zeros, NaN where a cell is empty, and what is said of it; None for other words."""
    words = cells.astype(str).str.strip().where(cells.notna())
    distinct = [str(word) for word in words.dropna().unique()[: _MOST_WORDS + 1]]
    if not 1 <= len(distinct) <= _MOST_WORDS or any(
        word.lower() not in _SWITCHES for word in distinct
    ):
        return None
    if {"low", "off"} <= {word.lower() for word in distinct}:
        return None  # levels of a supply: low is more than off
    numbers = np.asarray(words.str.lower().map(_SWITCHES), dtype=np.float64)
    meanings = [f"{word}, read as {_SWITCHES[word.lower()]:g}" for word in distinct]
    return numbers, f"column {label} holds {' and '.join(meanings)}"
