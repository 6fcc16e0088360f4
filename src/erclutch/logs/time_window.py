"""A window in time is taken out of a recording."""

from __future__ import annotations

from dataclasses import replace

from erclutch.errors import SettingError, UnitError
from erclutch.logs.dataset import only_segments
from erclutch.logs.timing import MINIMUM_ROWS
from erclutch.signals import units
from erclutch.signals.clock import stretches
from erclutch.signals.recording import Recording


def seconds_of(option: str, text: str) -> float:
    """A time in s from ``2``, ``2 s``, ``500ms`` or ``1 min``.

    Raises:
        SettingError: no such time.
    """
    try:
        number, unit = units.quantity(text)
        found = units.fits(unit or "s", ("s",))
    except UnitError:
        number, found = 0.0, None
    if found is None or not abs(number) < 1e12:
        raise SettingError(f"--{option} {text!r} is no time", remedy=f"Write it like --{option} 2s, or 500ms")
    return number * found[0]


def within(
    log: Recording, begin: float | None = None, end: float | None = None, skip: float | None = None
) -> Recording:
    """The rows of a recording with ``begin <= time <= end``, in s on its own clock; itself where all are None.

    Args:
        log: the recording.
        begin: first time that is taken.
        end: last time that is taken.
        skip: so much of the start is left out, in s since the first row; the later of both starts counts.

    Raises:
        SettingError: a negative skip, or fewer than 10 rows are left.
    """
    if begin is None and end is None and skip is None:
        return log
    if skip is not None and skip < 0:
        raise SettingError(f"--skip {skip:g} s", where=log.name, remedy="Give the time to leave out, 0 or more")
    first, last = float(log.time[0]), float(log.time[-1])
    start = max(first if begin is None else begin, first + (skip or 0.0))
    stop = last if end is None else end
    slack = 1e-6 * log.period  # a time that was typed is not the stamp to the last bit
    inside = (log.time >= start - slack) & (log.time <= stop + slack)
    kept = [(a + low, a + high) for a, b in log.segments for low, high in stretches(inside[a:b])]
    if int(inside.sum()) < MINIMUM_ROWS:
        until = f" and up to {stop:g} s" if end is not None else ""
        problem = f"{int(inside.sum())} rows lie from {start:g} s on{until}, {MINIMUM_ROWS} are needed"
        remedy = f"The log goes from {first:.6g} s to {last:.6g} s: widen --from, --to or --skip"
        raise SettingError(problem, where=log.name, remedy=remedy)
    note = f"taken from {start:.6g} s to {stop:.6g} s: {int(inside.sum()):,} of {log.rows:,} rows"
    return replace(only_segments(log, kept), notes=(*log.notes, note))
