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
from erclutch.logs.clock.resample import low_pass_taps
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

    @property
    def length(self) -> float:
        """From the first to the last time, in s."""
        first, last = self.ends
        return last - first

    @cached_property
    def scaled(self) -> Array:
        """The values around zero with a standard deviation of one."""
        deviation = float(np.std(self.values)) or 1.0
        return (self.values - np.mean(self.values)) / deviation

    def sampler(
        self, period: float, *, plain: bool = False
    ) -> Callable[[Array], tuple[Array, Mask]]:
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
        slower = period > 1.2 * self.period
        taps = low_pass_taps(period / self.period) if slower else np.ones(1)
        reach = len(taps) // 2  # rows that the filter takes from either end of a stretch

        # First and last time, and the curve.
        curves: list[tuple[float, float, Callable[[Array], Array]]] = []
        for start, stop in self.stretches:
            if stop - start <= 2 * reach + 4:
                continue  # too short for a curve
            filtered: Array = np.asarray(
                np.convolve(values[start:stop], taps / taps.sum(), "valid"),
                np.float64,
            )
            time = self.time[start + reach : stop - reach]
            first = float(time[0])
            last = float(time[-1])
            curves.append((first, last, curve_of(time, filtered)))

        def sample(times: Array) -> tuple[Array, Mask]:
            sampled = np.zeros(times.size)
            there = np.zeros(times.size, np.bool_)
            for first, last, curve in curves:
                rows = slice(*np.searchsorted(times, [first, last + 1e-9 * period]))
                sampled[rows] = curve(times[rows])
                there[rows] = True
            return sampled, there

        return sample

    def means(self, first: float, period: float, count: int) -> tuple[Array, Mask]:
        """Mean in each cell of a grid that begins at a time, and which cells the log fills by half at least."""
        edges = first + period * np.arange(count + 1)
        area: Array = np.zeros(count)  # under the signal, in each cell
        filled: Array = np.zeros(count)  # [s], of each cell
        for start, stop in self.stretches:
            time = self.time[start:stop]
            values = self.scaled[start:stop]
            trapezoids = np.diff(time) * 0.5 * (values[1:] + values[:-1])
            so_far = np.concatenate([[0.0], np.cumsum(trapezoids)])
            # The area under straight lines, exact at the samples; between them straight too: cells hold some samples.
            area = area + np.diff(np.interp(edges, time, so_far))
            filled = filled + np.diff(np.clip(edges, time[0], time[-1]))
        there: Mask = filled >= 0.5 * period
        mean = np.divide(area, filled, out=np.zeros(count), where=there)
        return mean, there


def track_of(time: Array, values: Array, period: float) -> Track:
    """The finite samples of a column; straight lines bridge gaps of a few rows.

    Args:
        time: in s, shape (n,), increasing.
        values: shape (n,); NaN where there is none.
        period: sampling period in s.

    Raises:
        LogError: fewer than two samples.
    """
    finite = np.isfinite(values)
    time = time[finite]
    values = values[finite]
    if time.size < 2:
        raise LogError(
            f"the column has {time.size} finite samples", remedy="Choose another column with --on"
        )

    # Each sample's row: a short gap keeps its rows, a long gap none, since a stretch ends there.
    whole = np.rint(np.diff(time) / period)
    periods = np.maximum(whole, 1.0).astype(np.int64)
    gaps = periods > _BRIDGED
    steps = np.where(gaps, 1, periods)
    rows_before = np.concatenate([[0], np.cumsum(steps)])
    row: NDArray[np.int64] = rows_before.astype(np.int64)
    every: Array = np.arange(int(row[-1]) + 1, dtype=np.float64)

    bounds: list[int] = [0, *row[1:][gaps].tolist(), every.size]
    stretches = tuple(
        (start, stop) for start, stop in itertools.pairwise(bounds) if stop - start > 1
    )
    return Track(
        np.interp(every, row, time),
        np.interp(every, row, values),
        period,
        stretches,
    )
