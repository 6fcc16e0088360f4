"""In which unit stamps are is told by the unit that somebody wrote, else by their size and their steps."""

from __future__ import annotations

import numpy as np

from erclutch.errors import UnitError, shell_word
from erclutch.logs.columns.names import plain
from erclutch.logs.columns.shapes import are_whole
from erclutch.signals import units
from erclutch.signals.array import Array

#: s between rows from which on stamps without a unit may be ms or counts.
SLOW = 0.5
_FEWEST_COUNTED = 200  # stamps
_SLOWEST_IN_MS = 1000.0  # ms a row: above it whole stamps are microseconds
_FASTEST = 1e-8  # s a row: 100 MHz
_SLOWEST_IN_US = 1e6  # us a row: from it on they are nanoseconds
#: Steps between stamps: in no more nothing of a rate is seen.
FEW_STEPS = 9
_SINCE_1970 = (1e9, 4.1e9)  # s: 2001 to 2100
#: Days as they are numbered since 1900, since the year 0 and since 4713 BC: 1954 to 2119, 1949 to 2100, 1949 to 2102.
_DAYS = {
    "spreadsheets": (20_000, 80_000),
    "MATLAB and Octave": (712_000, 767_000),
    "astronomers": (2_433_000, 2_489_000),
}
#: "temps" for short, or the sensor of a throttle's position.
_TEMPS_OR_THROTTLE = "tps"
_STEP_OF_DATES = 1.2e-5  # days: 1 Hz or faster
_SECONDS_PER_DAY = 86_400.0


def as_seconds(
    name: str,
    unit: str | None,
    stamps: Array,
) -> tuple[float, float, str]:
    """Factor from stamps to s, the stamp that is 0 s, and as what the stamps are taken.

    Stamps without a unit may be dates as numbers of days (at 1 Hz or faster) or a time since 1970 (2001 to 2100).

    Raises:
        UnitError: a unit that is none of time.
    """
    if unit is not None:
        seconds = units.fits(unit, ("s",)) if units.is_unit(unit) else None
        if seconds is None:
            problem = f"column '{name}' has the unit '{unit}', which is no unit of time"
            in_ms = f"--time {shell_word(f'{name} [ms]')}"
            raise UnitError(problem, remedy=f"Give its unit, such as {in_ms}", answers=[in_ms])
        if unit:
            factor, _ = seconds
            return factor, 0.0, "" if factor == 1.0 else f", converted from {unit}"

    counted = counts_days(stamps)
    if counted:
        how = f", no unit: dates as {counted} number them, taken as days"
        return _SECONDS_PER_DAY, float(np.floor(stamps[0])), how
    for short, factor in (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if stamps.size and _lie_within(stamps * factor, _SINCE_1970):
            return factor, float(stamps[0]), f", no unit: a time since 1970, taken as {short}"
    return 1.0, 0.0, ", no unit: taken as s"


def counts_days(stamps: Array) -> str:
    """Who numbers days as stamps do that are taken at 1 Hz or faster; "" where they are no dates."""
    who = _who_numbers_days(stamps)  # first, since the steps of a long log take memory
    if not who or stamps.size < 2:
        return ""
    return who if np.median(np.abs(np.diff(stamps))) < _STEP_OF_DATES else ""


def _who_numbers_days(stamps: Array) -> str:
    return next((who for who, ends in _DAYS.items() if _lie_within(stamps, ends)), "")


def _may_count_days(stamps: Array) -> str:
    """Who numbers days as stamps do that grow by whole seconds of a day, 2 or more; "" where nobody does.

    A round step (0.01) is one of a clock that counts s since it was switched on.
    """
    who = _who_numbers_days(stamps)
    if not who or stamps.size < 2:
        return ""
    step = float(np.median(np.abs(np.diff(stamps))))
    seconds = step * _SECONDS_PER_DAY
    if step < _STEP_OF_DATES or abs(seconds - round(seconds)) > 0.01:
        return ""
    is_round = abs(step - float(f"{step:.3g}")) <= 1e-5 * step
    return "" if is_round else who


def is_since_1970(stamps: Array) -> bool:
    """Whether stamps are a time since 1970, in s, ms, us or ns: no other number is as large and grows as little."""
    return any(_lie_within(stamps * factor, _SINCE_1970) for factor in (1.0, 1e-3, 1e-6, 1e-9))


def _lie_within(stamps: Array, ends: tuple[float, float]) -> bool:
    low, high = ends
    return bool(np.all((stamps > low) & (stamps < high)))


def doubt_of_seconds(name: str, stamps: Array) -> str:
    """Why stamps without a unit may be no seconds; "" where they look like seconds."""
    steps = np.abs(np.diff(stamps))
    if steps.size < FEW_STEPS or _lie_within(stamps, _SINCE_1970):
        return ""
    if plain(name) == _TEMPS_OR_THROTTLE:
        return f"time is column {name} in s, though the position of a throttle is called so too"
    step = float(np.median(steps))
    numbered = _may_count_days(stamps)
    if numbered:
        dates = f"dates as {numbered} number them, a row each {step * _SECONDS_PER_DAY:.4g} s"
        return f"time is column {name} in s, though it may be {dates}"
    if step < SLOW:
        return ""
    counted = likely_unit(stamps)
    small = counted if counted in ("us", "ns") else "ms"
    return f"time is column {name} in s, though it has no unit and grows by {step:.4g} a row, as {small} do"


def likely_unit(stamps: Array) -> str:
    """The unit that stamps without one have, by their steps: many whole numbers above 1 are counted by a controller.

    A few of them are the points of an instrument that waits for s. Many that count the rows tell no unit: "". Dates are
    counted in days.
    """
    if counts_days(stamps) or _may_count_days(stamps):
        return "d"
    steps = np.abs(np.diff(stamps))
    step = float(np.median(steps)) if steps.size else 0.0
    whole = are_whole(stamps)
    if not whole or step < 1.0 or stamps.size < _FEWEST_COUNTED:
        return "s"
    if step == 1.0:
        return "" if steps.max() == 1.0 else "s"
    if step <= _SLOWEST_IN_MS:
        return "ms"
    return "us" if step < _SLOWEST_IN_US else "ns"


def doubt_of_unit(name: str, unit: str, stamps: Array, factor: float) -> str:
    """Why stamps may not be in the unit that stands there; "" where they may.

    No logger takes rows that fast; or as many s lie behind 1970, with a fraction. A controller's counter of ms may have
    such numbers after 12 days, but whole ones.

    Args:
        name: of the column.
        unit: that stands there.
        stamps: those that are finite, shape (n,).
        factor: from the unit to s.
    """
    steps = np.abs(np.diff(stamps))
    step = float(np.median(steps)) * factor if steps.size >= FEW_STEPS else 0.0  # s
    if 0.0 < step < _FASTEST:
        return f"time is column {name} in {unit}, though it grows by {step:.3g} s a row then, as no logger is fast"
    is_smaller = factor < 1.0 and stamps.size > 0
    if not is_smaller or not _lie_within(stamps, _SINCE_1970) or are_whole(stamps):
        return ""
    year = 1970 + int(stamps[0] // 31_556_952)
    return f"time is column {name} in {unit}, though its numbers are a date in {year} if they are s since 1970"
