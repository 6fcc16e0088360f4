"""Speed is derived from position by a filter of choice; causal filters run live as they run here.

A 13-bit encoder differenced at 1 kHz moves in steps of 0.77 rad/s, so the filter decides on the slip's noise and delay.

central     (x[k+1] - x[k-1]) / 2 dt; no delay, not causal
savgol      Savitzky-Golay, quadratic over a window; no delay, not causal
difference  (x[k] - x[k-1]) / dt; causal, half a sample late, noisy
lowpass     difference through a first-order low-pass at a cutoff; causal
kalman      steady-state Kalman filter of position and speed with white acceleration; causal
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from erclutch.errors import SettingError
from erclutch.signals.array import Array, largest_size
from erclutch.signals.clock import Clock

DerivativeName = Literal["central", "savgol", "difference", "lowpass", "kalman"]
DERIVATIVES: tuple[DerivativeName, ...] = ("central", "savgol", "difference", "lowpass", "kalman")
CAUSAL: tuple[DerivativeName, ...] = ("difference", "lowpass", "kalman")
_USUAL_CUTOFF = 150.0  # Hz
#: Of the sampling rate: a filter needs a cutoff below half of it.
_LARGEST_CUTOFF = 0.4


def usual_cutoff(period: float) -> float:
    """The bandwidth in Hz of a causal filter that is told none: 150 Hz, or what the sampling carries."""
    if _USUAL_CUTOFF * period <= _LARGEST_CUTOFF:
        return _USUAL_CUTOFF
    return _LARGEST_CUTOFF / period


@dataclass(frozen=True)
class Derivative:
    """A choice of filter. The default is the nearest to the true speed on the TWIN, of those tried.

    Attributes:
        name: which one.
        cutoff: bandwidth in Hz of lowpass and kalman.
        window: rows of the Savitzky-Golay window, odd, at least 5.
    """

    name: DerivativeName = "savgol"
    cutoff: float = _USUAL_CUTOFF
    window: int = 5

    def __post_init__(self) -> None:
        if self.name not in DERIVATIVES:
            raise SettingError(
                f"unknown derivative {self.name!r}",
                remedy=f"Choose one of {', '.join(DERIVATIVES)}",
            )
        if not (np.isfinite(self.cutoff) and self.cutoff > 0):
            raise SettingError(
                f"a cutoff of {self.cutoff} Hz", remedy="Give a frequency above 0 Hz"
            )
        if self.window < 5 or self.window % 2 == 0:
            raise SettingError(
                f"a window of {self.window} rows", remedy="Give an odd number, 5 or more"
            )


@dataclass
class LiveDerivative:
    """A causal filter, one sample at a time: two states, two numbers; the recursion that the loop in C repeats.

    position' = position + dt speed, corrected by the innovation with gains (g, h / dt). With g = 1 and h = 1 this is
    the plain difference; with g = 1 and h = 1 - exp(-2 pi fc dt) the low-passed one; the Kalman gains are in between.
    """

    period: float
    g: float
    h: float
    position: float | None = None
    speed: float = 0.0

    def step(self, measured: float) -> float:
        """Take one position, return the speed."""
        if self.position is None:
            self.position = measured
            return 0.0
        predicted = self.position + self.period * self.speed
        innovation = measured - predicted
        self.position = predicted + self.g * innovation
        self.speed += self.h * innovation / self.period
        return self.speed


def live(derivative: Derivative, period: float) -> LiveDerivative:
    """The causal filter as it runs sample by sample.

    Raises:
        SettingError: a filter that looks ahead.
    """
    if derivative.name not in CAUSAL:
        remedy = f"Choose one of {', '.join(CAUSAL)} for live use"
        raise SettingError(f"{derivative.name} needs samples of the future", remedy=remedy)
    return LiveDerivative(period, *_gains(derivative, period))


def _gains(derivative: Derivative, period: float) -> tuple[float, float]:
    if derivative.name == "difference":
        return 1.0, 1.0
    if derivative.cutoff * period >= 0.5:
        problem = f"a cutoff of {derivative.cutoff:g} Hz at a sampling rate of {1 / period:g} Hz"
        raise SettingError(
            problem, remedy="Give a cutoff below half of the sampling rate, or use difference"
        )
    if derivative.name == "lowpass":
        return 1.0, -float(np.expm1(-2.0 * np.pi * derivative.cutoff * period))
    # Steady-state gains of the position-speed Kalman filter follow from one number, the ratio of acceleration to
    # measurement noise (Kalata's tracking index); it is set so that the estimator's natural frequency is the cutoff.
    index = (2.0 * np.pi * derivative.cutoff * period) ** 2
    rest = (np.sqrt(8.0 * index + index**2) - index) / 4.0  # 1 - r; g = 1 - r^2, h = 2 (1 - r)^2
    return float(rest * (2.0 - rest)), float(2.0 * rest**2)


def reach(derivative: Derivative, period: float) -> int:
    """Rows on either side that a speed depends on; for filters that never forget, until 1e-15 of a change is left."""
    if derivative.name in ("central", "difference"):
        return 1
    if derivative.name == "savgol":
        return derivative.window
    g, h = _gains(derivative, period)
    poles = np.roots([1.0, g + h - 2.0, 1.0 - g])
    slowest = largest_size(poles)
    if not slowest > 0:  # it forgets at once
        return 2
    return 1 + int(np.ceil(np.log(1e-15) / np.log(slowest)))


def differentiate(x: Array, clock: Clock, derivative: Derivative) -> Array:
    """Speed of a position.

    Args:
        x: positions, shape (n,).
        clock: the rows' clock; segments are differentiated one by one.
        derivative: the filter.

    Returns:
        Speeds, shape (n,), in units of x per second.

    Raises:
        SettingError: a window longer than a segment, or a filter that needs equal steps on a log that has none.
    """
    speed = np.empty_like(x)
    for span in clock.spans:
        rows = slice(span.start, span.stop)
        position = x[rows]
        period = span.period
        if position.size < 2:
            speed[rows] = 0.0
            continue
        if derivative.name == "central":
            speed[rows] = np.gradient(position, clock.time[rows] if period is None else period)
            continue
        if period is None:
            problem = f"{derivative.name} needs equal time steps, this log has none"
            raise SettingError(problem, remedy="Use --derivative central, or resample the log")
        if derivative.name == "savgol":
            from scipy.signal import savgol_filter

            window = derivative.window
            if position.size < window:
                problem = f"a window of {window} rows on a segment of {position.size}"
                raise SettingError(problem, remedy="Give a shorter --window")
            speed[rows] = savgol_filter(position, window, 2, deriv=1, delta=period)
            continue
        from scipy.linalg.blas import dtbsv  # SciPy's own filters take a second to import

        # `LiveDerivative` over a whole segment, as the second-order filter that it is. Speed over measured position:
        # V / X = (h / dt) (1 - q) / (1 + (g + h - 2) q + (1 - g) q^2), q one sample of delay.
        g, h = _gains(derivative, period)
        drive = (h / period) * (position - position[0])
        drive[1:] -= drive[:-1].copy()
        column = [[1.0], [g + h - 2.0], [1.0 - g]]  # of the matrix, below its diagonal
        band = np.asfortranarray(np.tile(column, position.size))
        speed[rows] = dtbsv(2, band, drive, lower=1, diag=1, overwrite_x=1)
    return speed
