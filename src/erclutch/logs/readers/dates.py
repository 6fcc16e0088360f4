"""Columns of dates and times of day become seconds since the first row."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import datetime
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.logs.readers.stamp_signs import in_usual_signs
from erclutch.signals.array import Array

if TYPE_CHECKING:
    import pandas as pd

_DATES = (
    "%Y-%m-%d", "%Y/%m/%d", "%m/%d/%Y", "%d/%m/%Y", "%d.%m.%Y", "%d.%m.%y",
    "%m/%d/%y", "%d/%m/%y", "%d-%m-%Y", "%m-%d-%Y", "%d-%b-%Y",
)  # fmt: skip
_DAY = 86_400.0  # s
#: Times without a date, and the seconds after which each begins anew. Spreadsheets show minutes and seconds alone.
_TIMES = {"%H:%M:%S.%f": _DAY, "%I:%M:%S.%f %p": _DAY, "%H:%M": _DAY, "%M:%S.%f": 3600.0}
_LIKELY = re.compile(r".*\d:\d\d.*")
_WHOLE = re.compile(r"(:\d\d?:\d\d?)(?![.\d])")  # a time of day in whole seconds
#: What stands between a date and a time of day in place of a blank: 2024-05-01T10:00, 2024/05/01/10:00:00.
_JOINT = re.compile(r"\S*?\d(T(?=\d)|[/_-](?=\d{1,2}:\d\d:\d\d))")
#: What pandas writes for a time from a start: 0 days 00:00:00.010000, or P0DT0H0M0.01S.
_DURATION = r"-?\d+ days?(?: \+?\d\d:\d\d:\d\d(?:\.\d+)?)?|P\d+DT\d+H\d+M\d+(?:\.\d+)?S"
_FINER = re.compile(r"(\.\d{6})\d+")
#: Times of day with milliseconds behind a colon, or with points between their parts: 12:00:05:250, 12.00.05,250.
_BEHIND_A_COLON = r"(?P<day>.*\b\d\d?:\d\d?:\d\d?):(?P<milliseconds>\d{1,3})"
_BETWEEN_POINTS = r"(?P<hour>\d\d)\.(?P<minute>\d\d)\.(?P<second>\d\d\.\d+)"
_DIGITS_OF_A_MILLISECOND = 3
_FRACTION = re.compile(r"(?<=\.)\d{1,3}$")


def clock_of_dates(texts: Mapping[str, pd.Series[Any]]) -> tuple[str, Array | None]:
    """Name and seconds of the first column of dates with times, of a date with a time beside it, or of times of day.

    A column that holds one date in all rows, such as the start of the log, gives way to one that goes on.

    Args:
        texts: column name -> its cells, of the columns that hold text.
    """
    at_rest: tuple[str, Array] | None = None
    whole: dict[str, pd.Series[Any]] = {}  # columns with a cell in each row
    dates: dict[str, pd.Series[Any]] = {}  # those of them that begin with a date
    for name, cells in texts.items():
        if cells.isna().any():
            continue
        whole[name] = cells.astype(str).str.strip()
        first = str(cells.iloc[0]).strip()
        if any(_reads(first, pattern) for pattern in _DATES):
            dates[name] = whole[name]
    for name, cells in texts.items():
        for date, days in dates.items():
            if name not in whole or date == name:
                continue
            stamps = seconds(days + " " + whole[name])
            if stamps is not None:
                return f"{date} and {name}", stamps
        stamps = seconds(cells)
        if stamps is not None and (stamps.size < 2 or np.ptp(stamps) > 0.0):
            return name, stamps
        if stamps is not None and at_rest is None:
            at_rest = (name, stamps)
    return at_rest or ("", None)


def seconds(cells: pd.Series[Any]) -> Array | None:
    """Seconds since the first row of a column of date and time texts, shape (n,), or None if it is no such column.

    Where a month may be a day, the order is taken in which time never runs back, and the log is shorter.
    """
    import pandas as pd

    first = str(cells.iloc[0]).strip()
    is_duration = re.fullmatch(_DURATION, first) is not None
    if cells.isna().any() or len(first) > 40:
        return None
    texts = cells.astype(str).str.strip()
    if not is_duration:
        texts = _with_colons_and_a_point(in_usual_signs(texts))
        first = texts.iloc[0]
        if not _LIKELY.match(first):
            return None
    if is_duration:
        if not texts.str.fullmatch(_DURATION).all():
            return None
        lasted: Any = pd.to_timedelta(texts)
        return np.asarray((lasted - lasted.iloc[0]).dt.total_seconds(), dtype=np.float64)
    texts = texts.str.replace(_WHOLE, r"\1.0", regex=True)
    likeliest, runs_back = _likeliest(texts)
    if likeliest is not None and runs_back:
        # Some loggers write 7 milliseconds as ".7": as a share of a second they run back.
        in_milliseconds = texts.str.replace(
            _FRACTION,
            lambda fraction: fraction[0].zfill(_DIGITS_OF_A_MILLISECOND),
            regex=True,
        )
        padded, runs_back_too = _likeliest(in_milliseconds)
        if padded is not None and not runs_back_too:
            return padded
    return likeliest


def _with_colons_and_a_point(texts: pd.Series[Any]) -> pd.Series[Any]:
    """Times of day as 12:00:05.250, where all of them have other signs between their parts."""
    texts = texts.str.replace(",", ".", regex=False)
    parts = texts.str.extract(f"^{_BEHIND_A_COLON}$")
    milliseconds = parts["milliseconds"]
    # Two digits alone may be pictures or hundredths of a second.
    if not milliseconds.isna().any() and (milliseconds.str.len() == _DIGITS_OF_A_MILLISECOND).any():
        return parts["day"] + "." + milliseconds.str.zfill(_DIGITS_OF_A_MILLISECOND)
    parts = texts.str.extract(f"^{_BETWEEN_POINTS}$")
    if not parts["second"].isna().any():
        return parts["hour"] + ":" + parts["minute"] + ":" + parts["second"]
    return texts


def _likeliest(texts: pd.Series[Any]) -> tuple[Array | None, bool]:
    """Seconds since the first row by the likeliest pattern, None if no pattern reads all; whether they run back."""
    import pandas as pd

    first, last = texts.iloc[0], texts.iloc[-1]
    zone = "%z" if re.search(r"(?:Z|[+-]\d\d:?\d\d)$", first) else ""
    signs_between = _JOINT.match(first)
    joint = signs_between.group(1) if signs_between else " "
    # strptime reads no more than microseconds.
    ends = [_FINER.sub(r"\1", cell) for cell in (first, last)]
    days = [*(f"{date}{joint}" for date in _DATES), ""]  # "": a time of day alone
    likeliest: Array | None = None
    least_unlikely = (True, np.inf)  # whether time runs back, and how long the log lasts [s]
    for day, time in product(days, _TIMES):
        pattern = f"{day}{time}{zone}"
        is_date_with_part_of_a_day = bool(day) and _TIMES[time] < _DAY
        if is_date_with_part_of_a_day or not all(_reads(cell, pattern) for cell in ends):
            continue
        try:
            stamps: Any = pd.to_datetime(texts, format=pattern, utc="%z" in pattern)
            since = np.asarray((stamps - stamps.iloc[0]).dt.total_seconds(), dtype=np.float64)
        except (ValueError, TypeError, AttributeError, OverflowError):
            continue  # a row between them has another format
        begins_anew = _TIMES.get(pattern)
        if begins_anew is not None:
            # The clock has jumped back at midnight, or at a full hour.
            jumps = np.cumsum(np.diff(since, prepend=0.0) < -begins_anew / 2)
            since = since + begins_anew * jumps
        unlikely = (bool(np.any(np.diff(since) < 0)), float(np.ptp(since)))
        if likeliest is None or unlikely < least_unlikely:
            likeliest = since
            least_unlikely = unlikely
    return likeliest, least_unlikely[0]


def _reads(cell: str, pattern: str) -> bool:
    try:
        datetime.strptime(cell, pattern)
    except ValueError:
        return False
    return True
