"""Two clocks are matched: offset and drift between two logs, found from a signal that both of them have.

A coarse search correlates both signals at all offsets and drifts on one grid, by FFT. Newton steps on finer and finer
grids then weigh each frequency by how well both signals agree there (Hannan and Thomson 1973). The last step is a
straight line through the offsets of some twenty windows; their scatter about the line gives the intervals, so noise
that is correlated over less than a window does not make them too narrow.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError
from erclutch.logs.resample import low_pass_taps
from erclutch.signals.array import Array, Mask

#: Drifts that are searched, as shares: quartz clocks differ by less than a fifth of this.
MOST_DRIFT = 500e-6
_ASTRAY = 10.0 * MOST_DRIFT  # what no step on the way may reach
_DRIFTS = 33  # on either side of zero, at most
_TRENDS = 5.0  # what is slower than this part of the shorter log is taken for a trend
_FEWEST = 16.0  # independent samples of the overlap
_LEAST_SHARE = 0.1  # of the shorter log that the other one overlaps
_CHANCE = 1e-4  # that the best of all offsets is as good by chance
_APART = 3.0  # standard errors between the best offset and the next that is as good
_BRIDGED = 5  # periods of a gap
_WINDOWS = 20
_COARSEST = 200  # rows of the overlap on the coarsest grid: those that are needed, and a filter's reach at both ends
_MOST_STEPS, _SETTLED = 25, 1e-6  # Newton steps; a step that ends them, in periods
_SEGMENT = 128  # rows of a spectrum, at most
_REMEDY = "Choose another signal with --on, and check that both logs are of one experiment"


@dataclass(frozen=True)
class ClockMatch:
    """The clock of log B against that of log A: ``t_B = t_A + offset + drift * (t_A - origin)``.

    Attributes:
        origin: first time of A that B has too, in s on A's clock.
        offset: what B's clock shows more than A's at the origin, in s.
        offset_interval: 95 % interval of it.
        drift: by which share B's clock runs faster (1e-6 is 1 ppm).
        drift_interval: 95 % interval of it.
        overlap: first and last time in s on A's clock that both logs have.
        gain: signal of B over signal of A.
        correlation: of both signals after matching, over the frequencies at which they agree.
        independent: how many independent samples the overlap is worth.
        centres: middle of each window in s on A's clock, shape (windows,).
        residuals: offset of each window less the line, in s, shape (windows,).
    """

    origin: float
    offset: float
    offset_interval: tuple[float, float]
    drift: float
    drift_interval: tuple[float, float]
    overlap: tuple[float, float]
    gain: float
    correlation: float
    independent: float
    centres: Array
    residuals: Array

    def on_b(self, time: Array) -> Array:
        """Times of A, in s, as B's clock shows them."""
        return time + self.offset + self.drift * (time - self.origin)

    def on_a(self, time: Array) -> Array:
        """Times of B, in s, as A's clock shows them."""
        return self.origin + (time - self.offset - self.origin) / (1.0 + self.drift)


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


def match_clocks(a: Track, b: Track, *, near: float | None = None) -> ClockMatch:
    """Find offset and drift of B's clock against A's.

    Args:
        a: the signal by log A.
        b: the signal by log B.
        near: about the offset in s, where several offsets fit equally well (a periodic signal).

    Raises:
        LogError: nothing correlates, too little overlaps, or several offsets fit equally well.
    """
    for track, name in ((a, "A"), (b, "B")):
        if not np.ptp(track.values) > 0.0:
            raise LogError(f"the signal never changes in log {name}", remedy=_REMEDY)
    if b.period > 1.01 * a.period:  # the slower log is taken at its own times, so that it is not interpolated
        return _turned(_matched(b, a, near, -1.0))
    return _matched(a, b, near, 1.0)


@dataclass(frozen=True)
class _Line:
    """``t_B = t_A + middle + drift * (t_A - at)``, with the covariance of (middle, drift)."""

    at: float
    middle: float
    drift: float
    covariance: Array | None = None

    def __call__(self, time: Array) -> Array:
        return time + self.middle + self.drift * (time - self.at)

    def back(self, time: Array) -> Array:
        return self.at + (time - self.at - self.middle) / (1.0 + self.drift)


def _matched(a: Track, b: Track, near: float | None, sign: float) -> ClockMatch:
    """The match of two logs; the user's offset is the one found here times the sign."""
    line, width, independent = _search(a, b, near, sign)
    period = a.period
    low, high = _overlap(a, b, line)
    width = min(width, 4.0 * (high - low) / _COARSEST)
    while width > 2.0 * period:
        line = _stepped(a, b, line, width / 4.0, _flat)[0]
        width /= 2.0
    for weigh in (_flat, _by_agreement, _by_agreement):
        line, found = _stepped(a, b, line, period, weigh)
    return _described(a, b, line, found, independent)


@dataclass(frozen=True)
class _Scan:
    """Correlations at one drift, over all lags of the grid.

    Attributes:
        drift: as a share.
        correlation: shape (lags,).
        independent: independent samples of the overlap at each lag, shape (lags,); 0 where too little overlaps.
    """

    drift: float
    correlation: Array
    independent: Array

    @cached_property
    def heights(self) -> Array:
        """Fisher's z of the correlations."""
        return np.where(self.independent > 0.0, np.arctanh(np.minimum(np.abs(self.correlation), 0.99999)), 0.0)

    @cached_property
    def scores(self) -> Array:
        """By how many standard errors each correlation stands from none."""
        return self.heights * np.sqrt(np.maximum(self.independent, 4.0) - 3.0)


def _search(a: Track, b: Track, near: float | None, sign: float) -> tuple[_Line, float, float]:
    """The best line of all offsets and drifts, the width of its peak in s, and the independent samples it rests on.

    Raises:
        LogError: see `match_clocks`.
    """
    shorter = min(track.ends[1] - track.ends[0] for track in (a, b))
    period = max(a.period, b.period, shorter / 1e6)
    width = max(min(_width(track, period, shorter) for track in (a, b)), MOST_DRIFT * shorter / _DRIFTS)
    step = max(period, width / 8.0)
    grids = [_centred(track, step, shorter) for track in (a, b)]
    drifts = int(np.ceil(MOST_DRIFT * shorter / width))
    shares: list[float] = (MOST_DRIFT * np.arange(-drifts, drifts + 1) / max(drifts, 1)).tolist()
    scans = [_scanned(*grids[0], *grids[1], drift) for drift in shares]
    best = max(scans, key=lambda scan: float(scan.scores.max()))
    shift: Array = np.arange(best.scores.size, dtype=np.float64) - (grids[0][0].size - 1)
    lags: Array = shift * (step * (1.0 + best.drift)) + (b.ends[0] - a.ends[0])
    place = _chosen(best, sign * lags, len(scans) * lags.size * step / width, 1.5 * width, shorter / width, near)
    line = _Line(a.ends[0], float(lags[place]), best.drift)
    low, high = _overlap(a, b, line)
    middle = 0.5 * (low + high)
    return _Line(middle, float(line(np.array(middle))) - middle, best.drift), width, float(best.independent[place])


def _overlap(a: Track, b: Track, line: _Line) -> tuple[float, float]:
    """First and last time on A's clock that both logs have."""
    low, high = line.back(np.array(b.ends)).tolist()
    return max(a.ends[0], low), min(a.ends[1], high)


def _chosen(scan: _Scan, lags: Array, tried: float, apart: float, widths: float, near: float | None) -> int:
    """The lag with the best correlation, which neither may be chance nor one of several that are as good.

    Raises:
        LogError: it is.
    """
    from scipy.special import ndtri

    scores, heights = scan.scores, scan.heights
    best = int(np.argmax(scores))
    errors = 1.0 / np.sqrt(np.maximum(scan.independent, 4.0) - 3.0)
    peaks = 1 + np.flatnonzero((heights[1:-1] >= heights[:-2]) & (heights[1:-1] > heights[2:]))
    as_good = peaks[heights[best] - heights[peaks] < _APART * errors[best]]
    others = as_good[np.abs(lags[as_good] - lags[best]) > apart]
    needed = -float(ndtri(0.5 * _CHANCE / max(tried, 1.0)))
    strong = abs(scan.correlation[best]) > 0.8 or scores[best] >= needed
    if others.size and strong and near is not None:
        return _nearest(np.append(others, best), lags, near)
    if scores[best] >= needed and scan.independent[best] >= _FEWEST and not others.size:
        return best
    short = scan.independent.max() < _FEWEST
    if others.size and strong and not (short and widths < 2.0 * _FEWEST):
        listed = ", ".join(f"{1e3 * lag:.6g}" for lag in sorted(lags[[best, *others]], key=abs)[:4])
        alike = float(np.median(np.abs(scan.correlation[others]))) > 0.9 * abs(scan.correlation[best])
        slow = f"the signal changes so slowly that the overlap holds {scan.independent[best]:.0f} independent samples"
        raise LogError(
            f"{others.size + 1} offsets fit {'equally' if alike else 'about as'} well, such as {listed} ms: "
            f"{'the signal repeats itself' if alike else slow}",
            remedy="Say about where the offset is, such as --near 2.5s, or choose another signal with --on",
        )
    if short:
        raise _too_short(float(scan.independent.max()))
    stands = f"the best of all offsets stands {scores[best]:.1f} standard errors from none, {needed:.1f} are needed"
    raise LogError(f"nothing correlates: {stands}", remedy=_REMEDY)


def _too_short(independent: float) -> LogError:
    worth = f"{independent:.0f} independent samples of this signal, {_FEWEST:.0f} are needed"
    problem = f"the logs are too short: where they overlap they hold at most {worth}"
    return LogError(problem, remedy="Give longer logs, or choose a livelier signal with --on")


def _nearest(places: NDArray[np.intp], lags: Array, near: float) -> int:
    """The place whose lag is nearest to what the user said."""
    distance = np.abs(lags[places] - near)
    order = np.argsort(distance)
    if distance[order[0]] > 0.6 * distance[order[1]]:
        listed = " and ".join(f"{1e3 * lags[place]:.6g} ms" for place in places[order[:2]])
        problem = f"--near {1e3 * near:.6g} ms lies between two offsets that fit equally well, {listed}"
        raise LogError(problem, remedy="Say more exactly where the offset is")
    return int(places[order[0]])


def _width(track: Track, period: float, shorter: float) -> float:
    """Where the autocorrelation of the signal falls to a half, in s."""
    values, there = _centred(track, period, shorter)
    size = 2 * values.size
    r = np.fft.irfft(np.abs(np.fft.rfft(values, size)) ** 2, size)[: values.size]
    below = np.flatnonzero(r < 0.5 * r[0])
    return period * float(below[0] if below.size else there.size)


def _centred(track: Track, step: float, shorter: float) -> tuple[Array, Mask]:
    """The signal on a grid, less its trend, and where it is."""
    from scipy.ndimage import uniform_filter1d

    count = max(int((track.ends[1] - track.ends[0]) / step), 1)
    values, there = track.means(track.ends[0], step, count)
    size = max(int(shorter / _TRENDS / step), 3)
    share = uniform_filter1d(there.astype(np.float64), size, mode="constant")
    trend = uniform_filter1d(values, size, mode="constant") / np.maximum(share, 1e-9)
    return np.where(there, values - trend, 0.0), there


def _scanned(x: Array, x_there: Mask, y: Array, y_there: Mask, drift: float) -> _Scan:
    """Correlations of x with y, which runs on a clock that drifts; lag k pairs x[i] with y[i + k - (x.size - 1)]."""
    at = np.arange(max(int(y.size / (1.0 + drift)), 1)) * (1.0 + drift)
    there = np.interp(at, np.arange(y.size), y_there) > 0.99
    y = np.where(there, np.interp(at, np.arange(y.size), y), 0.0)
    size = 1 << (x.size + y.size - 1).bit_length()
    transform = np.fft.rfft
    xs, ys = (
        [transform(v, size) for v in (signal, signal * signal, mask.astype(np.float64))]
        for signal, mask in ((x, x_there), (y, there))
    )

    def lagged(i: int, j: int) -> Array:
        whole = np.fft.irfft(np.conj(xs[i]) * ys[j], size)
        return np.concatenate([whole[size - (x.size - 1) :], whole[: y.size]])

    rows = np.maximum(np.rint(lagged(2, 2)), 0.0)
    powers = [
        np.maximum(lagged(i, j), 0.1 * rows * float(np.mean(v[mask] ** 2)))
        for i, j, v, mask in ((1, 2, x, x_there), (2, 1, y, there))
    ]
    both = np.sqrt(powers[0] * powers[1])
    r = np.divide(lagged(0, 0), both, out=np.zeros(rows.size), where=both > 0.0)
    spectra = [np.abs(each[0]) ** 2 for each in (xs, ys)]
    # Rows that are worth one independent row: the sum of the product of both autocorrelations (Bartlett).
    spread = (
        float(np.sum(spectra[0][1:] * spectra[1][1:])) / float(np.sum(spectra[0][1:])) / float(np.sum(spectra[1][1:]))
    )
    worth = rows / max(spread * (size // 2), 1.0)
    enough = (rows >= _LEAST_SHARE * min(x_there.sum(), there.sum())) & (rows >= 8)
    return _Scan(drift, np.clip(r, -1.0, 1.0), np.where(enough, worth, 0.0))


@dataclass(frozen=True)
class _Step:
    """What a Newton step saw, row by row of the rows that count.

    Attributes:
        time: s on A's clock, shape (n,).
        score: how much each row asks for a later B, shape (n,).
        slope: what one second more would add to it, shape (n,).
        gain, correlation: of both filtered signals.
    """

    time: Array
    score: Array
    slope: Array
    gain: float
    correlation: float


_Weights = Callable[[Array, Array, Mask], Array]


def _stepped(a: Track, b: Track, line: _Line, period: float, weigh: _Weights) -> tuple[_Line, _Step]:
    """The line after Newton steps on rows of one period, and what the last step saw.

    Raises:
        LogError: too few rows without a gap are left, or the steps lead to no such drift as clocks have.
    """
    low, high = _overlap(a, b, line)
    grid = a.ends[0] + period * np.arange(np.ceil((low - a.ends[0]) / period), (high - a.ends[0]) / period)
    sample = b.sampler(period)
    x, x_there = a.sampler(period)(grid)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    line = _Line(middle, float(line(np.array(middle))) - middle, line.drift)
    y, y_there = sample(line(grid))
    taps = _taps(weigh(x, y, x_there & y_there))
    for _ in range(_MOST_STEPS):
        seen = _seen(grid, (x, y), x_there & y_there, taps)
        design = np.vstack([np.ones(seen.time.size), (seen.time - middle) / half])
        move = np.linalg.lstsq((design * seen.slope) @ design.T, design @ seen.score, rcond=1e-9)[0]
        size = float(np.abs(move).sum())
        if size < _SETTLED * period:
            return line, seen
        move *= min(1.0, period / size)
        line = replace(line, middle=line.middle + float(move[0]), drift=line.drift + float(move[1]) / half)
        if abs(line.drift) > _ASTRAY:
            problem = f"the fine search goes astray, to a drift of {1e6 * abs(line.drift):.0f} ppm"
            remedy = "Say where else the offset may be with --near, or choose another signal with --on"
            raise LogError(f"{problem}, {1e6 * _ASTRAY:.0f} at most", remedy=remedy)
        y, y_there = sample(line(grid))
    return line, _seen(grid, (x, y), x_there & y_there, taps)


def _seen(grid: Array, signals: tuple[Array, Array], there: Mask, taps: tuple[Array, Array]) -> _Step:
    """What a Newton step sees of both signals on one grid, filtered.

    Raises:
        LogError: too few rows without a gap are left.
    """
    from scipy.signal import fftconvolve

    rows = _far_from_gaps(there, taps[0].size // 2)
    if rows.sum() < 4 * _WINDOWS:
        lie = f"{int(rows.sum())} rows of the overlap lie far enough from its ends and from gaps"
        raise LogError(f"{lie}, {4 * _WINDOWS} are needed", remedy="Give longer logs, or logs with fewer gaps")
    period = float(grid[1] - grid[0])

    def filtered(signal: Array, by: Array) -> Array:
        whole: Array = fftconvolve(np.where(there, signal, 0.0), by, "same")
        return whole[rows]

    (fx, fy), (dx, dy) = ([filtered(signal, by) for signal in signals] for by in taps)
    fx, fy = fx - fx.mean(), fy - fy.mean()  # each log has a mean of its own, which the filter lets through in part
    gain = float(fx @ fy) / (float(fy @ fy) or 1.0)
    correlation = float(fx @ fy) / (float(np.sqrt(float(fx @ fx) * float(fy @ fy))) or 1.0)
    score, slope = gain * dy * (fx - gain * fy) / period, gain * dy * dx / period**2
    return _Step(grid[rows], score, slope, gain, correlation)


def _far_from_gaps(there: Mask, reach: int) -> Mask:
    """Rows that a filter of such a reach can have without touching a gap."""
    total = np.concatenate([np.zeros(reach + 1), np.cumsum(there), np.full(reach, there.sum())])
    return np.asarray(total[2 * reach + 1 :] - total[: there.size] == 2 * reach + 1)


def _taps(weights: Array) -> tuple[Array, Array]:
    """A symmetric filter of such weights, shape (m / 2 + 1,), and the same with a derivative after the row."""
    size = 2 * (weights.size - 1)
    even = np.roll(np.fft.irfft(weights, size), size // 2) * np.hanning(size + 1)[:size]
    padded = np.concatenate([np.zeros(size), even, np.zeros(size)])
    turn = 1j * np.linspace(0.0, np.pi, padded.size // 2 + 1)
    turn[-1] = 0.0
    odd = np.fft.irfft(np.fft.rfft(padded) * turn, padded.size)
    kept = slice(size - size // 8, 2 * size + size // 8 + 1)
    return padded[kept], odd[kept]


def _flat(x: Array, y: Array, there: Mask) -> Array:
    """All frequencies below 0.7 of the highest, without the mean."""
    frequency = np.linspace(0.0, 1.0, 33)
    return np.where(frequency > 0.0, np.clip((0.9 - frequency) / 0.2, 0.0, 1.0), 0.0)


def _by_agreement(x: Array, y: Array, there: Mask) -> Array:
    """Square root of the weights of Hannan and Thomson: coherence over what is not coherent, each frequency alike."""
    size = int(2 ** np.clip(np.floor(np.log2(max(there.sum() / 24, 1))), 5, np.log2(_SEGMENT)))
    starts = np.arange(0, max(there.size - size, 0) + 1, size // 2)
    total = np.concatenate([[0], np.cumsum(there)])
    starts = starts[total[starts + size] - total[starts] == size]
    if starts.size < 8:
        return _flat(x, y, there)
    window = np.hanning(size)
    rows = starts[:, None] + np.arange(size)
    fx, fy = (np.fft.rfft((s[rows] - s[rows].mean(axis=1, keepdims=True)) * window) for s in (x, y))
    cross = np.abs(np.mean(np.conj(fx) * fy, axis=0))
    powers = np.mean(np.abs(fx) ** 2, axis=0) * np.mean(np.abs(fy) ** 2, axis=0)
    agreed = np.minimum(cross**2 / np.maximum(powers, 1e-300), 0.9999)
    # Noise that agrees by chance would hold the line where it is: its coherence exceeds this once in ten thousand.
    agreed[agreed < 10.0 / starts.size] = 0.0
    weights = np.sqrt(agreed / (1.0 - agreed) / np.maximum(cross, 1e-300))
    weights[0] = 0.0
    return weights / weights.max() if weights.max() > 0.0 else _flat(x, y, there)


def _turned(found: ClockMatch) -> ClockMatch:
    """The match of A's clock against B's, of that of B's against A's."""
    rate = 1.0 + found.drift
    origin, stop = (float(t) for t in found.on_b(np.array(found.overlap)))
    (least, most), (slowest, fastest) = found.offset_interval, found.drift_interval
    return replace(
        found,
        origin=origin,
        offset=-found.offset,
        offset_interval=(-most, -least),
        drift=-found.drift / rate,
        drift_interval=(-fastest / rate, -slowest / rate),
        overlap=(origin, stop),
        gain=1.0 / found.gain,
        centres=found.on_b(found.centres),
        residuals=-found.residuals,
    )


def _described(a: Track, b: Track, line: _Line, step: _Step, independent: float) -> ClockMatch:
    """The match with its intervals, by the scatter of the windows' scores.

    A window pulls the line towards itself: its score is that against the line of all other windows (jackknife, CR3 of
    MacKinnon and White 1985). A window at an end says most of the drift, so the degrees of freedom are fewer than
    windows (Satterthwaite; Bell and McCaffrey 2002).
    """
    from scipy.special import stdtrit

    share = 0.5 * (step.slope.clip(0.0).cumsum() / step.slope.clip(0.0).sum() + np.linspace(0.0, 1.0, step.time.size))
    window = np.minimum((share * _WINDOWS).astype(np.int64), _WINDOWS - 1)
    scale = 0.5 * (step.time[-1] - step.time[0])
    design = np.vstack([np.ones(step.time.size), (step.time - line.at) / scale])
    scores = np.array([np.bincount(window, row * step.score, _WINDOWS) for row in design])
    constant, linear, square = (
        np.bincount(window, row * step.slope, _WINDOWS) for row in (design[0], design[1], design[1] ** 2)
    )
    each = np.array([[constant, linear], [linear, square]]).transpose(2, 0, 1)
    inverse = np.asarray(np.linalg.pinv(each.sum(axis=0)), np.float64)
    against = np.asarray(np.linalg.solve(np.eye(2) - each @ inverse, scores.T[:, :, None]), np.float64)
    others = inverse @ against[:, :, 0].T

    def half(of: Array) -> float:
        shares = np.einsum("i,gij,j->g", inverse @ of, each, inverse @ of)
        freedom = float(shares.sum() ** 2 / (shares @ shares))
        return float(stdtrit(freedom, 0.975) * np.sqrt((1.0 - 1.0 / _WINDOWS) * np.sum((of @ others) ** 2)))

    overlap = _overlap(a, b, line)
    back = np.array([1.0, (overlap[0] - line.at) / scale])
    offset = float(line.middle + line.drift * (overlap[0] - line.at))
    error, wide = half(back), half(np.array([0.0, 1.0 / scale]))
    lively = constant > 0.1 * np.median(constant)
    counts = np.maximum(np.bincount(window, minlength=_WINDOWS), 1)
    centres = np.bincount(window, step.time, _WINDOWS) / counts
    return ClockMatch(
        overlap[0],
        offset,
        (offset - error, offset + error),
        line.drift,
        (line.drift - wide, line.drift + wide),
        overlap,
        step.gain * float(np.std(b.values)) / float(np.std(a.values)),
        step.correlation,
        independent,
        centres[lively],
        (scores[0] / np.where(lively, constant, 1.0))[lively],
    )
