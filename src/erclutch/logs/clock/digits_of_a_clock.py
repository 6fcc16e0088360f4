"""Some loggers write the clock as one number: 140712.5 is 14:07:12.5, and 20240503140712 is a date with it.

Read as seconds such a number jumps by 40 at each full minute, and a log falls into pieces there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from erclutch.logs.columns.names import plain, spoken_name
from erclutch.logs.columns.vocabulary import set_of
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_DAY = 86_400.0  # s
_CALLED = set_of(
    "hhmmss hhmmssms hms utc utctime gpstime datetime timestamp localtime clock uhrzeit heure hora"
)
#: Names that say how the digits are put together.
_NAMED = frozenset({"hhmmss", "hms", "hhmmssms"})
_FIRST = 1000  # rows of which a minute has sixty seconds, if all have
_NEAR = 3.0  # steps that a minute takes at most where it is crossed
_MOST = 0.9  # share of the minutes that are crossed so, at least
_A_JUMP = 1.0  # s between what the digits say and what the number says


@dataclass(frozen=True)
class _Form:
    """How digits are put together.

    Attributes:
        example: of it, and what it means.
        least: the numbers lie from here
        most: to here.
        parts: of a second in one.
        dated: whether a date stands in front.
        century: that is added to the year.
        is_plain: whether the range alone tells the form: no number of seconds is so large.
    """

    example: str
    least: float
    most: float
    parts: float = 1.0
    dated: bool = False
    century: int = 0
    is_plain: bool = False


_FORMS = (
    _Form("140712.5 is 14:07:12.5", 0.0, 240_000.0),
    _Form("140712500 is 14:07:12.5", 0.0, 240_000_000.0, parts=1000.0),
    _Form("240503140712 is 2024-05-03 14:07:12", 1e10, 1e12, dated=True, century=2000),
    _Form("20240503140712 is 2024-05-03 14:07:12", 1.97e13, 2.1e13, dated=True, is_plain=True),
)


def with_clock_of_digits(table: Table) -> Table:
    """The table with a clock, where a column holds one in its digits; else as it is."""
    if table.clock is not None:
        return table
    for name, values in table.columns.items():
        is_called_so = plain(name) in _CALLED or spoken_name(name).is_time
        if (
            table.units.get(name)
            or not is_called_so
            or values.size < 2
            or not np.isfinite(values).all()
        ):
            continue
        for form in _FORMS:
            if values[0] == values[-1] or _seconds(values[:_FIRST], form) is None:
                continue  # most columns, without the memory that all rows take
            seconds = _seconds(values, form)
            is_named_so = plain(name) in _NAMED
            if seconds is not None and _is_told(values, seconds, form, is_named_so=is_named_so):
                note = f"column {name} holds a clock in its digits: {form.example}"
                return replace(
                    table,
                    columns={key: each for key, each in table.columns.items() if key != name},
                    units={key: each for key, each in table.units.items() if key != name},
                    clock=seconds - seconds[0],
                    clock_name=name,
                    notes=(*table.notes, note),
                )
    return table


def _seconds(values: Array, form: _Form) -> Array | None:
    """Seconds since 1970, or since midnight without a date; None where the digits are none of a clock."""
    if values.size < 2 or values.min() < form.least or values.max() >= form.most:
        return None
    whole = np.floor(values / form.parts)
    fraction = values / form.parts - whole
    second, minute, hour = whole % 100, whole // 100 % 100, whole // 10_000 % 100
    if max(second.max(), minute.max()) >= 60 or hour.max() >= 24:
        return None
    of_day = 3600.0 * hour + 60.0 * minute + second + fraction
    if not form.dated:
        # The clock begins anew at midnight.
        return of_day + _DAY * np.cumsum(np.diff(of_day, prepend=of_day[0]) < -_DAY / 2)
    dates, of_row = np.unique(whole // 1_000_000, return_inverse=True)
    days: list[float] = []
    for date in dates.astype(int).tolist():
        year, month, day = date // 10_000 + form.century, date // 100 % 100, date % 100
        try:
            days.append(float(np.datetime64(f"{year:04d}-{month:02d}-{day:02d}").astype(int)))
        except ValueError:
            return None
    return _DAY * np.array(days)[of_row] + of_day


def _is_told(values: Array, seconds: Array, form: _Form, *, is_named_so: bool) -> bool:
    """Whether the digits are sure to be a clock: it goes on where the number jumps, at each full minute."""
    steps = np.diff(seconds)
    if (steps < 0.0).any() or seconds[-1] == seconds[0]:
        return False
    if form.is_plain or is_named_so:
        return True
    usual = float(np.median(steps[steps > 0.0]))
    jumps = np.abs(np.diff(values / form.parts) - steps) > _A_JUMP
    goes_on = steps[jumps] <= _NEAR * usual
    return bool(jumps.any()) and bool(goes_on.mean() >= _MOST)
