"""A track is one signal of a log with its time, sampled at any times or averaged in the cells of a grid."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError
from erclutch.logs.resample import low_pass_taps
from erclutch.signals.array import Array, Mask

_BRIDGED = 5  # periods of a gap


@dataclass(frozen=True, eq=False)
class Track:
    """One signal of a log with its time.

    Attributes:
        time: in s, shape (n,), increasing.
        values: shape (n,), finite.
        period: sampling period in s.
        stretches: rows [start, stop) without a gap.
    """

    time: Array
    values: Array
    period: float
    stretches: tuple[tuple[int, int], ...]

    @property
    def ends(self) -> tuple[float, float]:
        """First and last time in s."""
        return float(self.time[0]), float(self.time[-1])

    @cached_property
    def scaled(self) -> Array:
        """The values around zero with a standard deviation of one."""
        return (self.values - np.mean(self.values)) / (float(np.std(self.values)) or 1.0)

    def sampler(self, period: float, *, plain: bool = False) -> Callable[[Array], tuple[Array, Mask]]:
        """What samples the signal at given times, behind a low-pass where it is to be sampled more slowly.

        Args:
            period: of the samples that are wanted, in s.
            plain: the values as they are, by curves that never overshoot; else the scaled ones, by smooth curves.

        Returns:
            A function of times, shape (m,), that gives values (zero where there are none) and where there are.
        """
        from scipy.interpolate import PchipInterpolator, make_interp_spline

        values = self.values if plain else self.scaled
        curve_of: Callable[..., Any] = PchipInterpolator if plain else make_interp_spline
        taps = low_pass_taps(period / self.period) if period > 1.2 * self.period else np.ones(1)
        reach = len(taps) // 2
        curves: list[tuple[float, float, Callable[[Array], Array]]] = []
        for start, stop in self.stretches:
            if stop - start > 2 * reach + 4:
                even: Array = np.asarray(np.convolve(values[start:stop], taps / taps.sum(), "valid"), np.float64)
                time = self.time[start + reach : stop - reach]
                curves.append((float(time[0]), float(time[-1]), curve_of(time, even)))

        def sample(times: Array) -> tuple[Array, Mask]:
            found, there = np.zeros(times.size), np.zeros(times.size, np.bool_)
            for first, last, curve in curves:
                rows = slice(*np.searchsorted(times, [first, last + 1e-9 * period]))
                found[rows], there[rows] = curve(times[rows]), True
            return found, there

        return sample

    def means(self, first: float, period: float, count: int) -> tuple[Array, Mask]:
        """Mean in each cell of a grid that begins at a time, and which cells the log fills by half at least."""
        edges = first + period * np.arange(count + 1)
        total: Array = np.zeros(count)
        filled: Array = np.zeros(count)
        for start, stop in self.stretches:
            time, values = self.time[start:stop], self.scaled[start:stop]
            steps = np.diff(time)
            area = np.concatenate([[0.0], np.cumsum(steps * 0.5 * (values[1:] + values[:-1]))])
            # The area under straight lines, exact at the samples; between them straight too: cells hold some samples.
            total = total + np.diff(np.interp(edges, time, area))
            filled = filled + np.diff(np.clip(edges, time[0], time[-1]))
        there: Mask = filled >= 0.5 * period
        return np.divide(total, filled, out=np.zeros(count), where=there), there


def track_of(time: Array, values: Array, period: float) -> Track:
    """The finite samples of a column; straight lines bridge gaps of a few rows.

    Args:
        time: in s, shape (n,), increasing.
        values: shape (n,); NaN where there is none.
        period: sampling period in s.

    Raises:
        LogError: fewer than two samples.
    """
    fine = np.isfinite(values)
    time, values = time[fine], values[fine]
    if time.size < 2:
        raise LogError(f"the column has {time.size} finite samples", remedy="Choose another column with --on")
    steps = np.maximum(np.rint(np.diff(time) / period), 1.0).astype(np.int64)
    gaps = steps > _BRIDGED
    place: NDArray[np.int64] = np.concatenate([[0], np.cumsum(np.where(gaps, 1, steps))]).astype(np.int64)
    every: Array = np.arange(int(place[-1]) + 1, dtype=np.float64)
    bounds: list[int] = [0, *place[1:][gaps].tolist(), every.size]
    stretches = tuple((a, b) for a, b in itertools.pairwise(bounds) if b - a > 1)
    return Track(np.interp(every, place, time), np.interp(every, place, values), period, stretches)
