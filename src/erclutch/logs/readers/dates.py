"""Columns of dates and times of day become seconds since the first row."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import datetime
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.signals.array import Array

if TYPE_CHECKING:
    import pandas as pd

_DATES = ("%Y-%m-%d", "%Y/%m/%d", "%m/%d/%Y", "%d/%m/%Y", "%d.%m.%Y", "%d.%m.%y", "%m/%d/%y", "%d-%m-%Y", "%d-%b-%Y")
_TIMES = ("%H:%M:%S.%f", "%H:%M:%S", "%I:%M:%S.%f %p", "%I:%M:%S %p", "%H:%M")
_DAY = 86_400.0  # s
_LIKELY = re.compile(r".*\d:\d\d.*")


def _format(first: str, last: str) -> str | None:
    """The strptime format that reads the first and the last cell, months before days where both would do."""
    zone = "%z" if re.search(r"(?:Z|[+-]\d\d:?\d\d)$", first) else ""
    joint = "T" if re.search(r"\dT\d", first) else " "
    for date, time in product((*(f"{date}{joint}" for date in _DATES), ""), _TIMES):
        if _reads(first, f"{date}{time}{zone}") and _reads(last, f"{date}{time}{zone}"):
            return f"{date}{time}{zone}"
    return None


def clock_of(texts: Mapping[str, pd.Series[Any]]) -> tuple[str, Array | None]:
    """Name and seconds of the first column of dates with times, of a date with a time beside it, or of times of day.

    Args:
        texts: column name -> its cells, of the columns that hold text.
    """
    whole = {name: str(cells.iloc[0]).strip() for name, cells in texts.items() if not cells.isna().any()}
    days = [name for name, first in whole.items() if any(_reads(first, pattern) for pattern in _DATES)]
    for name, cells in texts.items():
        for day in days:
            joined = texts[day].astype(str).str.strip() + " " + cells.astype(str).str.strip()
            if name != day and name in whole and (stamps := seconds(joined)) is not None:
                return f"{day} and {name}", stamps
        if (stamps := seconds(cells)) is not None:
            return name, stamps
    return "", None


def _reads(cell: str, pattern: str) -> bool:
    try:
        datetime.strptime(cell, pattern)
    except ValueError:
        return False
    return True


def seconds(cells: pd.Series[Any]) -> Array | None:
    """Seconds since the first row of a column of date and time texts, shape (n,), or None if it is no such column."""
    import pandas as pd

    if cells.isna().any():
        return None
    first, last = (str(cells.iloc[row]).strip().replace(",", ".") for row in (0, -1))
    pattern = _format(first, last) if len(first) <= 40 and _LIKELY.match(first) else None
    if pattern is None:
        return None
    texts = cells.astype(str).str.strip()
    if "," in str(cells.iloc[0]):
        texts = texts.str.replace(",", ".", regex=False)
    try:
        stamps: Any = pd.to_datetime(texts, format=pattern)
        since = np.asarray((stamps - stamps.iloc[0]).dt.total_seconds(), dtype=np.float64)
        midnights = np.diff(since, prepend=0.0) < -_DAY / 2 if pattern in _TIMES else np.zeros(since.size)
        return since + _DAY * np.cumsum(midnights)
    except (ValueError, TypeError, AttributeError, OverflowError):
        return None
