"""Newton steps move the line until both filtered signals lie on each other; each frequency is weighed by agreement.

The weights are those of Hannan and Thomson (1973).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError
from erclutch.signals.array import Array, Mask
from erclutch.wings.align.clock_line import ClockLine, overlap_of
from erclutch.wings.align.coarse_search import MOST_DRIFT
from erclutch.wings.align.track import Track

#: Windows whose offsets scatter about the line.
WINDOWS = 20
_ASTRAY = 10.0 * MOST_DRIFT  # what no step on the way may reach
_MOST_STEPS = 25
_SETTLED = 1e-6  # periods: a Newton step that ends them
_SEGMENT = 128  # rows of a spectrum, at most


@dataclass(frozen=True)
class StepSeen:
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


def stepped(
    a: Track,
    b: Track,
    line: ClockLine,
    period: float,
    weigh: _Weights,
) -> tuple[ClockLine, StepSeen]:
    """The line after Newton steps on rows of one period, and what the last step saw.

    Raises:
        LogError: too few rows without a gap are left, or the steps lead to no such drift as clocks have.
    """
    low, high = overlap_of(a, b, line)  # [s]
    middle = 0.5 * (low + high)
    half = 0.5 * (high - low)
    # A's rows stay where they are, so that they are filtered and interpolated once.
    first, _ = a.ends
    rows = np.arange(np.ceil((low - first) / period), (high - first) / period)
    grid = first + period * rows  # [s], on A's clock
    x, x_there = a.sampler(period)(grid)
    sample_b = b.sampler(period)
    line = line.about(middle)
    y, y_there = sample_b(line(grid))
    taps = taps_of(weigh(x, y, x_there & y_there))

    for _ in range(_MOST_STEPS):
        seen = _seen(grid, x, y, x_there & y_there, taps)
        # Offset and drift alike in s: the drift counts as what it moves the end of the overlap.
        design = np.vstack([np.ones(seen.time.size), (seen.time - middle) / half])
        curvature = (design * seen.slope) @ design.T
        move = np.linalg.lstsq(curvature, design @ seen.score, rcond=1e-9)[0]
        size = float(np.abs(move).sum())
        if size < _SETTLED * period:
            return line, seen
        # Beyond one row the signals' slopes say nothing of what comes.
        move *= min(1.0, period / size)
        offset = float(move[0])
        drift = float(move[1]) / half
        line = replace(line, middle=line.middle + offset, drift=line.drift + drift)
        if abs(line.drift) > _ASTRAY:
            problem = f"the fine search goes astray, to a drift of {1e6 * abs(line.drift):.0f} ppm"
            raise LogError(
                f"{problem}, {1e6 * _ASTRAY:.0f} at most",
                remedy="Say where else the offset may be with --near, or choose another signal with --on",
            )
        y, y_there = sample_b(line(grid))
    return line, _seen(grid, x, y, x_there & y_there, taps)


def _seen(
    grid: Array,
    x: Array,
    y: Array,
    there: Mask,
    taps: tuple[Array, Array],
) -> StepSeen:
    """What a Newton step sees of both signals on one grid, filtered.

    Raises:
        LogError: too few rows without a gap are left.
    """
    from scipy.signal import fftconvolve

    smooth, slope = taps
    rows = rows_far_from_gaps(there, smooth.size // 2)
    count = int(rows.sum())
    if count < 4 * WINDOWS:
        raise LogError(
            f"{count} rows of the overlap lie far enough from its ends and from gaps, {4 * WINDOWS} are needed",
            remedy="Give longer logs, or logs with fewer gaps",
        )

    def filtered(signal: Array, by: Array) -> Array:
        whole: Array = fftconvolve(np.where(there, signal, 0.0), by, "same")
        return whole[rows]

    fx = filtered(x, smooth)
    fy = filtered(y, smooth)
    dx = filtered(x, slope)  # a row
    dy = filtered(y, slope)
    # Each log has a mean of its own, which the filter lets through in part.
    fx = fx - fx.mean()
    fy = fy - fy.mean()

    xx = float(fx @ fx)
    xy = float(fx @ fy)
    yy = float(fy @ fy)
    gain = xy / (yy or 1.0)
    correlation = xy / (float(np.sqrt(xx * yy)) or 1.0)
    period = float(grid[1] - grid[0])  # [s]
    return StepSeen(
        time=grid[rows],
        score=gain * dy * (fx - gain * fy) / period,
        slope=gain * dy * dx / period**2,
        gain=gain,
        correlation=correlation,
    )


def rows_far_from_gaps(there: Mask, reach: int) -> Mask:
    """Rows that a filter of such a reach can have without touching a gap."""
    before = np.zeros(reach + 1)
    behind = np.full(reach, there.sum())
    so_far = np.concatenate([before, np.cumsum(there), behind])  # rows that are there
    window = 2 * reach + 1
    return np.asarray(so_far[window:] - so_far[: there.size] == window)


def taps_of(weights: Array) -> tuple[Array, Array]:
    """A symmetric filter of such weights, shape (m / 2 + 1,), and the same with a derivative after the row."""
    size = 2 * (weights.size - 1)
    symmetric = np.roll(np.fft.irfft(weights, size), size // 2)
    even = symmetric * np.hanning(size + 1)[:size]
    # The derivative rings beyond the filter's ends: it is taken in a wider room, and an eighth more is kept.
    padded = np.concatenate([np.zeros(size), even, np.zeros(size)])
    turn = 1j * np.linspace(0.0, np.pi, padded.size // 2 + 1)
    turn[-1] = 0.0
    odd = np.fft.irfft(np.fft.rfft(padded) * turn, padded.size)
    kept = slice(size - size // 8, 2 * size + size // 8 + 1)
    return padded[kept], odd[kept]


def flat(x: Array, y: Array, there: Mask) -> Array:
    """All frequencies below 0.7 of the highest, without the mean."""
    frequency = np.linspace(0.0, 1.0, 33)
    weights = np.clip((0.9 - frequency) / 0.2, 0.0, 1.0)
    weights[0] = 0.0
    return weights


def by_agreement(x: Array, y: Array, there: Mask) -> Array:
    """Square root of the weights of Hannan and Thomson: coherence over what is not coherent, each frequency alike."""
    # Segments of a length that leaves about two dozen of them, as a power of two.
    most_rows = max(there.sum() / 24, 1)
    wished = np.floor(np.log2(most_rows))
    power_of_two = np.clip(wished, 5, np.log2(_SEGMENT))
    size = int(2**power_of_two)
    starts = np.arange(0, max(there.size - size, 0) + 1, size // 2)
    so_far = np.concatenate([[0], np.cumsum(there)])
    whole = so_far[starts + size] - so_far[starts] == size
    starts = starts[whole]
    if starts.size < 8:
        return flat(x, y, there)

    rows = starts[:, None] + np.arange(size)  # shape (segments, size)
    taper = np.hanning(size)

    def spectra(signal: Array) -> NDArray[np.complex128]:
        segments = signal[rows]
        centred = segments - segments.mean(axis=1, keepdims=True)
        return np.fft.rfft(centred * taper)

    fx = spectra(x)
    fy = spectra(y)
    cross = np.abs(np.mean(np.conj(fx) * fy, axis=0))
    x_power = np.mean(np.abs(fx) ** 2, axis=0)
    y_power = np.mean(np.abs(fy) ** 2, axis=0)
    powers = x_power * y_power
    coherence = np.minimum(cross**2 / np.maximum(powers, 1e-300), 0.9999)
    # Noise that agrees by chance would hold the line where it is: its coherence exceeds this once in ten thousand.
    coherence[coherence < 10.0 / starts.size] = 0.0
    weights = np.sqrt(coherence / (1.0 - coherence) / np.maximum(cross, 1e-300))
    weights[0] = 0.0
    highest = weights.max()
    return weights / highest if highest > 0.0 else flat(x, y, there)
