"""The coarse search correlates two signals at all offsets and drifts on one grid, by FFT.

The best peak must be no chance, and no other offset may be as good.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError
from erclutch.signals.array import Array, Mask
from erclutch.wings.align.clock_line import ClockLine, overlap_of
from erclutch.wings.align.track import Track

#: Drifts that are searched, as shares: quartz clocks differ by less than a fifth of this.
MOST_DRIFT = 500e-6
#: What a user can do where nothing correlates.
REMEDY = "Choose another signal with --on, and check that both logs are of one experiment"
_DRIFTS = 33  # on either side of zero, at most
_TRENDS = 5.0  # what is slower than this part of the shorter log is taken for a trend
_FEWEST = 16.0  # independent samples of the overlap
_LEAST_SHARE = 0.1  # of the shorter log that the other one overlaps
_CHANCE = 1e-4  # that the best of all offsets is as good by chance
_APART = 3.0  # standard errors between the best offset and the next that is as good


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


def search_of_all(a: Track, b: Track, near: float | None, sign: float) -> tuple[ClockLine, float, float]:
    """The best line of all offsets and drifts, the width of its peak in s, and the independent samples it rests on.

    Raises:
        LogError: see `match_clocks`.
    """
    shorter = min(track.ends[1] - track.ends[0] for track in (a, b))
    period = max(a.period, b.period, shorter / 1e6)
    width = max(min(width_of(track, period, shorter) for track in (a, b)), MOST_DRIFT * shorter / _DRIFTS)
    step = max(period, width / 8.0)
    grids = [_centred(track, step, shorter) for track in (a, b)]
    drifts = int(np.ceil(MOST_DRIFT * shorter / width))
    shares: list[float] = (MOST_DRIFT * np.arange(-drifts, drifts + 1) / max(drifts, 1)).tolist()
    scans = [_scanned(*grids[0], *grids[1], drift) for drift in shares]
    best = max(scans, key=lambda scan: float(scan.scores.max()))
    shift: Array = np.arange(best.scores.size, dtype=np.float64) - (grids[0][0].size - 1)
    lags: Array = shift * (step * (1.0 + best.drift)) + (b.ends[0] - a.ends[0])
    place = _chosen(best, sign * lags, len(scans) * lags.size * step / width, 1.5 * width, shorter / width, near)
    line = ClockLine(a.ends[0], float(lags[place]), best.drift)
    low, high = overlap_of(a, b, line)
    middle = 0.5 * (low + high)
    return ClockLine(middle, float(line(np.array(middle))) - middle, best.drift), width, float(best.independent[place])


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
    raise LogError(f"nothing correlates: {stands}", remedy=REMEDY)


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


def width_of(track: Track, period: float, shorter: float) -> float:
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
