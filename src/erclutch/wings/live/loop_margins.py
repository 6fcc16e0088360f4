"""Torque and motion control as linear loops: margins, steps, and the largest bandwidth that a device allows.

A device is what a step of the asked torque does, sample by sample. Loops are ratios of polynomials in 1/z.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array
from erclutch.signals.speed import LiveDerivative

#: A loop is taken where its sensitivity stays below this: then gain may double, and phase fall by 29 degrees.
MOST_SENSITIVE = 2.0
#: Samples that a period of the bandwidth has at least.
LEAST_SAMPLES = 10
_STEP = 1.0  # s
_POINTS = 2000


@dataclass(frozen=True)
class TorquePath:
    """From the asked torque to the torque.

    Attributes:
        period: in s.
        pulse: torque k samples after the sample at which a unit was asked for once, shape (n,); the first is 0.
        estimated: the same of the estimate that the loop compares with the torque, shape (n,).
    """

    period: float
    pulse: Array
    estimated: Array

    @property
    def lag(self) -> float:
        """Mean time in s by which the torque is later than what is asked."""
        return self.period * float(np.sum(1.0 - np.cumsum(self.pulse)))

    @property
    def estimate_lag(self) -> float:
        """The same of the estimate."""
        return self.period * float(np.sum(1.0 - np.cumsum(self.estimated)))


@dataclass(frozen=True)
class LinearLoop:
    """An open loop, and what a unit step of its input does.

    Attributes:
        period: in s.
        over, under: open loop, polynomials in 1/z.
        forward: of the input, over the same denominator as the closed loop.
    """

    period: float
    over: Array
    under: Array
    forward: Array

    @property
    def closed(self) -> Array:
        """Characteristic polynomial of the closed loop in 1/z."""
        return _sum(self.over, self.under)

    def response(self) -> tuple[Array, NDArray[np.complex128]]:
        """Frequencies in Hz up to the highest that the samples carry, and the open loop there."""
        frequency: Array = np.geomspace(0.05, 0.5 / self.period, _POINTS)
        z_inverse: NDArray[np.complex128] = np.exp(-2j * np.pi * frequency * self.period)
        over = np.polyval(self.over[::-1].astype(np.complex128), z_inverse)
        under = np.polyval(self.under[::-1].astype(np.complex128), z_inverse)
        return frequency, over / under

    def step(self) -> Array:
        """What follows a unit step, for one second, shape (n,)."""
        from scipy.signal import lfilter

        unit_step = np.ones(round(_STEP / self.period))
        return np.asarray(lfilter(self.forward, self.closed, unit_step), np.float64)


@dataclass(frozen=True)
class LoopMargins:
    """How far a loop is from swinging.

    Attributes:
        gain: by which the loop's gain may grow.
        least: to which share of it the gain may fall; 0: as far as it likes.
        phase: in degrees.
        delay: further dead time in s that the loop bears.
        sensitivity: largest |1 / (1 + L)|.
        stable: whether all poles of the closed loop lie inside the unit circle.
    """

    gain: float
    least: float
    phase: float
    delay: float
    sensitivity: float
    stable: bool

    @property
    def gains(self) -> str:
        """Both margins of the gain in words."""
        if self.least:
            return f"{self.least:.2g} to {self.gain:.2f}"
        return f"{self.gain:.2f}"


@dataclass(frozen=True)
class TunedLoop:
    """One loop as it was tuned.

    Attributes:
        name: for people.
        bandwidth, largest: in Hz, asked for and allowed. limit: what does not allow more.
        loop, margins: of the loop at its bandwidth.
    """

    name: str
    bandwidth: float
    largest: float
    limit: str
    loop: LinearLoop
    margins: LoopMargins


def _sum(one: Array, other: Array) -> Array:
    """Of two polynomials in 1/z."""
    total = np.zeros(max(one.size, other.size))
    total[: one.size] += one
    total[: other.size] += other
    return total


def margins_of(loop: LinearLoop) -> LoopMargins:
    """Margins of a loop, read from its response at 2000 frequencies."""
    frequency, response = loop.response()
    # The gain wherever the open loop crosses the negative real axis, by straight lines between its frequencies.
    real = response.real
    imaginary = response.imag
    before = np.flatnonzero(imaginary[1:] * imaginary[:-1] <= 0.0)
    after = before + 1
    fall = imaginary[before] - imaginary[after]
    share = imaginary[before] / np.where(fall == 0.0, 1.0, fall)
    crossings = real[before] + share * (real[after] - real[before])
    crossings = np.append(crossings, real[-1])  # at the highest frequency the response is real
    gains = -crossings[crossings < 0.0]
    below_one = gains[gains < 1.0]
    above_one = gains[gains > 1.0]

    # Where the gain passes 1: the phase left until the loop feeds itself, and the delay that would take it.
    gain = np.abs(response)
    above = gain[1:] - 1.0
    above_before = gain[:-1] - 1.0
    passes = np.flatnonzero(above * above_before <= 0.0)
    degrees = np.degrees(np.angle(response[passes]))
    phases = np.mod(degrees + 180.0, 360.0)
    delays = phases / 360.0 / frequency[passes]

    poles = np.roots(loop.closed)
    return LoopMargins(
        gain=1.0 / float(below_one.max()) if below_one.size else math.inf,
        least=1.0 / float(above_one.min()) if above_one.size else 0.0,
        phase=float(phases.min()) if passes.size else math.inf,
        delay=float(delays.min()) if passes.size else math.inf,
        sensitivity=float(np.max(1.0 / np.abs(1.0 + response))),
        stable=bool(np.all(np.abs(poles) < 1.0 - 1e-9)),
    )


def torque_loop(
    path: TorquePath,
    bandwidth: float,
    integral_rate: float,
    torque_lag: float,
) -> LinearLoop:
    """The observer by a sensor with integral action; its step is a torque beyond the model, and what is left of it.

    Args:
        path: from asked to given torque.
        bandwidth: of the observer in Hz.
        integral_rate: in 1/s.
        torque_lag: by which the estimate is made later before it is compared, in s.
    """
    from scipy.signal import lfilter

    def share(rate: float) -> float:
        return 1.0 - math.exp(-rate * path.period)

    # The estimate behind its lag, until the lag is over.
    late = share(1.0 / torque_lag) if torque_lag > 0.0 else 1.0
    padding = math.ceil(12.0 * torque_lag / path.period)
    padded = np.pad(path.estimated, (0, padding))
    modelled = np.asarray(lfilter([late], [1.0, late - 1.0], padded))

    fast = share(2.0 * math.pi * bandwidth)
    filtered = np.array([1.0, fast - 1.0])
    over = np.array([fast])
    under = _sum(filtered, -fast / modelled.sum() * modelled)
    integral = share(integral_rate)
    if integral > 0.0:
        over = _sum(fast * np.array([1.0, -1.0]), integral * np.append(0.0, filtered))
        under = np.convolve(under, [1.0, -1.0])
    return LinearLoop(path.period, np.convolve(path.pulse, over), under, under)


def motion_loop(
    path: TorquePath,
    bandwidth: float,
    integral: float,
    speed: LiveDerivative,
) -> LinearLoop:
    """A mass on a critically damped spring, as computed torque and impedance make it; its step is the reference's.

    Args:
        path: from asked to given torque.
        bandwidth: in Hz.
        integral: in 1/s; 0 for none.
        speed: the filter of the speed.
    """
    stiff = 2.0 * math.pi * bandwidth
    dt = path.period
    g = speed.g
    h = speed.h
    slow = np.array([1.0, g + h - 2.0, 1.0 - g])
    rate = h / dt * np.array([1.0, -1.0])
    # Torque turns linearly from sample to sample: a unit of it moves the mass by dt^2 / 6 (q^2 + 4 q + 1) / (q - 1)^2.
    mass = dt * dt / 6.0 * np.convolve(path.pulse, [1.0, 4.0, 1.0])
    spring = stiff * stiff * slow
    damper = 2.0 * stiff * rate
    under = np.convolve([1.0, -2.0, 1.0], slow)
    if integral > 0.0:
        spring = np.convolve(spring, [1.0, integral * dt - 1.0])
        damper = np.convolve(damper, [1.0, -1.0])
        under = np.convolve(under, [1.0, -1.0])
    over = np.convolve(mass, _sum(spring, damper))
    return LinearLoop(dt, over, under, np.convolve(mass, spring))


def largest_bandwidth(loop: Callable[[float], LinearLoop], most: float) -> float:
    """The largest bandwidth in Hz, up to ``most``, whose loop is stable and below `MOST_SENSITIVE`; 0 if none is."""

    def bears(bandwidth: float) -> bool:
        margins = margins_of(loop(bandwidth))
        return margins.stable and margins.sensitivity <= MOST_SENSITIVE

    tried: Array = np.geomspace(0.1, most, 40)
    good = [value for value in tried.tolist() if bears(value)]
    if not good or good[-1] == tried[-1]:
        return good[-1] if good else 0.0
    low = good[-1]
    high = good[-1] * tried[1] / tried[0]
    for _ in range(12):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if bears(middle) else (low, middle)
    return low
