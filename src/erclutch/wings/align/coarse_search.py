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
        """Fisher's z of the correlations: about normal, whatever the correlation."""
        size = np.minimum(np.abs(self.correlation), 0.99999)
        return np.where(self.independent > 0.0, np.arctanh(size), 0.0)

    @cached_property
    def errors(self) -> Array:
        """Standard error of each height."""
        return 1.0 / np.sqrt(np.maximum(self.independent, 4.0) - 3.0)

    @cached_property
    def scores(self) -> Array:
        """By how many standard errors each correlation stands from none."""
        return self.heights * np.sqrt(np.maximum(self.independent, 4.0) - 3.0)


def search_of_all(
    a: Track,
    b: Track,
    near: float | None,
    sign: float,
) -> tuple[ClockLine, float, float]:
    """The best line of all offsets and drifts, the width of its peak in s, and the independent samples it rests on.

    Raises:
        LogError: see `match_clocks`.
    """
    shorter = min(a.length, b.length)  # [s]
    period = max(a.period, b.period, shorter / 1e6)  # [s]
    narrower = min(width_of(a, period, shorter), width_of(b, period, shorter))  # [s]
    # A lively signal has a narrow peak and needs many drifts; the floor keeps them to `_DRIFTS`.
    width = max(narrower, MOST_DRIFT * shorter / _DRIFTS)  # [s]
    step = max(period, width / 8.0)  # [s], between rows of the grid

    x, x_there = _centred(a, step, shorter)
    y, y_there = _centred(b, step, shorter)
    # From one drift to the next, the end of the shorter log moves by the width of the peak.
    drifts = int(np.ceil(MOST_DRIFT * shorter / width))
    numbers = np.arange(-drifts, drifts + 1)
    shares: list[float] = (MOST_DRIFT * numbers / max(drifts, 1)).tolist()
    scans = [scanned(x, x_there, y, y_there, drift) for drift in shares]
    best = max(scans, key=lambda scan: float(scan.scores.max()))

    shift: Array = np.arange(best.scores.size, dtype=np.float64) - (x.size - 1)  # rows of the grid
    step_of_b = step * (1.0 + best.drift)  # [s]
    between_starts = b.ends[0] - a.ends[0]  # [s]
    lags: Array = shift * step_of_b + between_starts  # [s]
    place = _chosen(
        best,
        sign * lags,
        tried=len(scans) * lags.size * step / width,
        apart=1.5 * width,
        widths=shorter / width,
        near=near,
    )
    line = ClockLine(a.ends[0], float(lags[place]), best.drift)
    low, high = overlap_of(a, b, line)
    return line.about(0.5 * (low + high)), width, float(best.independent[place])


def _chosen(
    scan: _Scan,
    lags: Array,
    *,
    tried: float,
    apart: float,
    widths: float,
    near: float | None,
) -> int:
    """The lag with the best correlation, which neither may be chance nor one of several that are as good.

    Args:
        scan: correlations at the best drift.
        lags: in s, as the user would say them, shape (lags,).
        tried: independent offsets and drifts among which chance could find a correlation.
        apart: s beyond which another peak is another offset.
        widths: of the peak in the shorter log.
        near: what the user said, in s.

    Raises:
        LogError: it is.
    """
    from scipy.special import ndtri

    heights = scan.heights
    scores = scan.scores
    best = int(np.argmax(scores))
    correlation = scan.correlation[best]
    independent = scan.independent[best]

    inner = heights[1:-1]
    is_peak = (inner >= heights[:-2]) & (inner > heights[2:])
    peaks = 1 + np.flatnonzero(is_peak)
    as_good = peaks[heights[best] - heights[peaks] < _APART * scan.errors[best]]
    rivals = as_good[np.abs(lags[as_good] - lags[best]) > apart]

    by_chance = 0.5 * _CHANCE / max(tried, 1.0)
    needed = -float(ndtri(by_chance))  # standard errors
    strong = abs(correlation) > 0.8 or scores[best] >= needed
    if rivals.size and strong and near is not None:
        return nearest_of(np.append(rivals, best), lags, near)
    if scores[best] >= needed and independent >= _FEWEST and not rivals.size:
        return best

    longest = float(scan.independent.max())  # independent samples of the largest overlap
    short = longest < _FEWEST
    # In a log of a few widths any two humps look alike: there the log is to blame, not the signal.
    if rivals.size and strong and not (short and widths < 2.0 * _FEWEST):
        places = sorted(lags[[best, *rivals]], key=abs)
        listed = ", ".join(f"{1e3 * lag:.6g}" for lag in places[:4])
        sizes = np.abs(scan.correlation[rivals])
        of_rivals = float(np.median(sizes))
        fits = "about as"
        why = f"the signal changes so slowly that the overlap holds {independent:.0f} independent samples"
        if of_rivals > 0.9 * abs(correlation):
            fits = "equally"
            why = "the signal repeats itself"
        raise LogError(
            f"{rivals.size + 1} offsets fit {fits} well, such as {listed} ms: {why}",
            remedy="Say about where the offset is, such as --near 2.5s, or choose another signal with --on",
        )
    if short:
        worth = f"{longest:.0f} independent samples of this signal, {_FEWEST:.0f} are needed"
        raise LogError(
            f"the logs are too short: where they overlap they hold at most {worth}",
            remedy="Give longer logs, or choose a livelier signal with --on",
        )
    stands = f"the best of all offsets stands {scores[best]:.1f} standard errors from none"
    raise LogError(f"nothing correlates: {stands}, {needed:.1f} are needed", remedy=REMEDY)


def nearest_of(places: NDArray[np.intp], lags: Array, near: float) -> int:
    """The place whose lag is nearest to what the user said.

    Raises:
        LogError: the two nearest are about as near.
    """
    distance = np.abs(lags[places] - near)
    order = np.argsort(distance)
    nearest, second = order[:2]
    if distance[nearest] > 0.6 * distance[second]:
        listed = " and ".join(f"{1e3 * lags[place]:.6g} ms" for place in places[order[:2]])
        problem = (
            f"--near {1e3 * near:.6g} ms lies between two offsets that fit equally well, {listed}"
        )
        raise LogError(problem, remedy="Say more exactly where the offset is")
    return int(places[nearest])


def width_of(track: Track, period: float, shorter: float) -> float:
    """Where the autocorrelation of the signal falls to a half, in s."""
    values, _ = _centred(track, period, shorter)
    size = 2 * values.size
    power = np.abs(np.fft.rfft(values, size)) ** 2
    autocorrelation = np.fft.irfft(power, size)[: values.size]
    below = np.flatnonzero(autocorrelation < 0.5 * autocorrelation[0])
    rows = below[0] if below.size else values.size
    return period * float(rows)


def _centred(track: Track, step: float, shorter: float) -> tuple[Array, Mask]:
    """The signal on a grid, less its trend, and where it is."""
    from scipy.ndimage import uniform_filter1d

    count = max(int(track.length / step), 1)
    values, there = track.means(track.ends[0], step, count)
    # The trend is a running mean over the rows that are there: their sum over their share.
    size = max(int(shorter / _TRENDS / step), 3)
    share = uniform_filter1d(there.astype(np.float64), size, mode="constant")
    trend = uniform_filter1d(values, size, mode="constant") / np.maximum(share, 1e-9)
    return np.where(there, values - trend, 0.0), there


def scanned(
    x: Array,
    x_there: Mask,
    y: Array,
    y_there: Mask,
    drift: float,
) -> _Scan:
    """Correlations of x with y, which runs on a clock that drifts; lag k pairs x[i] with y[i + k - (x.size - 1)]."""
    # y as a clock without a drift would have sampled it
    rows = np.arange(y.size)
    rate = 1.0 + drift
    count = max(int(y.size / rate), 1)
    drifted = np.arange(count) * rate
    y_there = np.interp(drifted, rows, y_there) > 0.99
    y = np.where(y_there, np.interp(drifted, rows, y), 0.0)

    # All lags, so that no end meets the other log's beginning.
    size = 1 << (x.size + y.size - 1).bit_length()

    def spectrum(signal: Array | Mask) -> NDArray[np.complex128]:
        return np.fft.rfft(signal.astype(np.float64), size)

    def lagged(of_x: NDArray[np.complex128], of_y: NDArray[np.complex128]) -> Array:
        """Sum of the products of both signals at every lag."""
        circular = np.fft.irfft(np.conj(of_x) * of_y, size)
        return np.concatenate([circular[size - (x.size - 1) :], circular[: y.size]])

    x_spectrum = spectrum(x)
    x_mask = spectrum(x_there)
    y_spectrum = spectrum(y)
    y_mask = spectrum(y_there)
    overlap = np.maximum(np.rint(lagged(x_mask, y_mask)), 0.0)  # rows that both have
    # Power of each signal in the overlap. The floor is a tenth of its mean: a stretch at rest correlates by chance.
    x_floor = 0.1 * overlap * float(np.mean(x[x_there] ** 2))
    y_floor = 0.1 * overlap * float(np.mean(y[y_there] ** 2))
    x_power = np.maximum(lagged(spectrum(x * x), y_mask), x_floor)
    y_power = np.maximum(lagged(x_mask, spectrum(y * y)), y_floor)
    scale = np.sqrt(x_power * y_power)
    correlation = np.divide(
        lagged(x_spectrum, y_spectrum),
        scale,
        out=np.zeros(overlap.size),
        where=scale > 0.0,
    )

    # Rows that are worth one independent row: the sum of the product of both autocorrelations (Bartlett).
    x_density = (np.abs(x_spectrum) ** 2)[1:]
    y_density = (np.abs(y_spectrum) ** 2)[1:]
    product = float(np.sum(x_density * y_density))
    spread = product / float(np.sum(x_density)) / float(np.sum(y_density))
    independent = overlap / max(spread * (size // 2), 1.0)

    least = _LEAST_SHARE * min(x_there.sum(), y_there.sum())  # rows
    enough = (overlap >= least) & (overlap >= 8)
    return _Scan(
        drift,
        np.clip(correlation, -1.0, 1.0),
        np.where(enough, independent, 0.0),
    )
