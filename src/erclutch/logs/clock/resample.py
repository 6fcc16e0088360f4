"""A recording is brought to another sampling rate, behind a filter against aliases that shifts nothing in time.

Each gapless stretch is filtered by itself, with one symmetric (zero-phase) low-pass for all signals. Where the filter
reaches beyond the ends of a stretch it would need samples that nobody took: these rows are left out.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from types import MappingProxyType

import numpy as np

from erclutch.errors import SettingError
from erclutch.logs.clock.timing import require_rows
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording

#: Begins the note of a recording that was brought to another rate.
RESAMPLED = "brought from"

_REACH = 16  # periods of the slower of both rates on either side
_KAISER = 7.86  # window whose stop band lies 80 dB down
_CUTOFF = 0.84  # of the slower rate's Nyquist frequency; the stop band begins at that frequency, the pass band ends at
PASSED = 0.68  # of it
_FINEST = 10_000  # numerator and denominator of the ratio of both rates, at most
_MOST_ROWS = 50_000_000  # of the new recording: half a gigabyte a signal
_EXACT = 1e-6  # share by which a rate may be off and still count as the wanted one


def resampled(log: Recording, rate: float) -> Recording:
    """The recording at another rate; itself where it has that rate already.

    Args:
        log: the recording. Stretches with unequal steps are first put on equal ones by straight lines.
        rate: in Hz.

    Raises:
        SettingError: a ratio of rates beyond 10,000, more than 50 million rows, or no stretch longer than the filter.
    """
    if log.uniform and abs(rate * log.period - 1.0) < _EXACT:
        return log
    ratio = Fraction(rate * log.period).limit_denominator(_FINEST)
    if not 1 / _FINEST <= rate * log.period <= _FINEST or not ratio:
        remedy = "Give a rate nearer to that of the log"
        raise SettingError(
            f"{rate:g} Hz for a log at {1 / log.period:g} Hz", where=log.name, remedy=remedy
        )
    rows = log.rows * rate * log.period
    if rows > _MOST_ROWS:
        remedy = f"Give {rate * _MOST_ROWS / rows:.3g} Hz or less: a higher rate than that of the log tells no more"
        raise SettingError(
            f"{rate:g} Hz makes {rows:,.0f} rows of {log.rows:,}", where=log.name, remedy=remedy
        )

    # A stretch becomes the rows of the new rate, counted from its first, whose filter lies inside the stretch.
    up = ratio.numerator
    down = ratio.denominator
    half = _REACH * max(up, down)  # reach of the filter, at the rate of up times the log's
    first = math.ceil(half / down)
    kept: list[tuple[int, int, range]] = []  # rows [start, stop) of a stretch, and its new rows
    for start, stop in log.segments:
        last = ((stop - start - 1) * up - half) // down
        if last > first:
            kept.append((start, stop, range(first, last + 1)))
    if not kept:
        reach = 2 * _REACH * max(down / up, 1.0)
        problem = f"no gapless stretch is longer than the {reach:.0f} rows that the filter to {rate:g} Hz reaches over"
        raise SettingError(problem, where=log.name, remedy="Give a higher rate, or a longer log")

    def moved(signals: Mapping[str, Array]) -> Mapping[str, Array]:
        at_new_rate: dict[str, Array] = {}
        for name, values in signals.items():
            stretches: list[Array] = []
            for start, stop, place in kept:
                samples = values[start:stop]
                if not log.uniform:
                    stamps = log.time[start:stop]
                    even = np.linspace(float(stamps[0]), float(stamps[-1]), stop - start)
                    samples = np.asarray(np.interp(even, stamps, samples), np.float64)
                stretches.append(_moved(samples, place, up, down))
            at_new_rate[name] = _joined(stretches)
        return MappingProxyType(at_new_rate)

    times: list[Array] = []  # [s], of each stretch
    for start, _, place in kept:
        times.append(log.time[start] + place.start / rate + np.arange(len(place)) / rate)
    time = _joined(times)
    require_rows(time.size)
    lengths = [len(place) for _, _, place in kept]
    ends = np.cumsum([0, *lengths]).tolist()

    # What was done, what it kept and what it cost.
    slower = min(rate, 1.0 / log.period)
    passed = PASSED * slower / 2
    stopped = slower / 2
    uneven = "" if log.uniform else "; unequal steps were joined by straight lines first"
    gone = ""
    dropped = len(log.segments) - len(kept)
    if dropped:
        stretches = f"{dropped} stretch{'es' if dropped > 1 else ''}"
        gone = f"; {stretches} too short for the filter left out"
    note = (
        f"{RESAMPLED} {1 / log.period:.6g} Hz to {rate:.6g} Hz by a zero-phase filter that passes {passed:.4g} Hz "
        f"and stops {stopped:.4g} Hz (a switched field rings there); {1e3 * _REACH / slower:.3g} ms left out at each "
        f"end of each stretch, where the filter would reach beyond it{uneven}{gone}"
    )
    return replace(
        log,
        signals=moved(log.signals),
        extras=moved(log.extras),
        spare=moved(log.spare),
        time=time,
        period=1.0 / rate,
        segments=tuple(itertools.pairwise(ends)),
        uniform=True,
        notes=(*log.notes, note),
    )


def _joined(stretches: Sequence[Array]) -> Array:
    whole = np.concatenate(stretches)
    whole.setflags(write=False)
    return whole


def _moved(values: Array, place: range, up: int, down: int) -> Array:
    """The samples at the places; a signal that does not change is not touched."""
    from scipy.signal import upfirdn

    if np.ptp(values) == 0.0:
        return np.full(len(place), values[0])
    taps = low_pass_taps(max(up, down))
    skip = len(taps) // 2  # the filter's delay, at the rate of up times the log's
    lead = -skip % down  # zeros in front make the delay a whole number of new rows
    delayed = np.concatenate([np.zeros(lead), taps])
    middle = float(np.mean(values))
    filtered = upfirdn(delayed, values - middle, up, down)
    weight = upfirdn(delayed, np.ones(values.size), up, down)
    first = (skip + lead) // down + place.start
    rows = slice(first, first + len(place))
    return np.asarray(filtered[rows] / weight[rows] + middle, np.float64)


@cache
def low_pass_taps(ratio: float) -> Array:
    """The low-pass to a rate so many times slower: symmetric, so that nothing moves in time; shape (2 k + 1,)."""
    from scipy.signal import firwin

    half = round(_REACH * ratio)
    taps = firwin(2 * half + 1, _CUTOFF / ratio, window=("kaiser", _KAISER))
    return np.asarray(taps, np.float64)
