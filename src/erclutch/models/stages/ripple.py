"""Ripple over the position: gears, poles and bearings push and pull once in each period of the position.

::

    z = x / lambda_p,   columns cos(2 pi k z) and sin(2 pi k z),   k = 1, ..., the number of the stage

The position x is logged beside the slip, as a further input. It has no state, so a model knows where it stands from its
first row on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial, pi
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import value_of
from erclutch.arithmetic.elementary import whole_number_near
from erclutch.models.laws.law import EFFORT, Gain, ShapeParameter
from erclutch.models.stages.slip_memory import TRAVEL
from erclutch.models.stages.stage import Place, RowByRow, StageFamily, numbered
from erclutch.signals.array import Array

# Of sin and cos of half the angle, which is at most pi / 2: the first power that is left out is worth 7e-10.
_SINE = [(-1) ** k * pi ** (2 * k + 1) / factorial(2 * k + 1) for k in range(7)]
_COSINE = [(-1) ** k * pi ** (2 * k) / factorial(2 * k) for k in range(8)]
_BINS, _FEWEST_PERIODS = 8192, 2.0
#: Periods that are tried between two: with half a period more or less over the way, a wave is lost.
_PERIODS = 33


@dataclass(frozen=True)
class Ripple(RowByRow):
    """The ripple as a stage on the position.

    Attributes:
        count: how many multiples of the frequency it has.
        stem: its name without the count.
        of_period, of_cosine, of_sine: symbols of its period and of its gains.
    """

    count: int = 1
    stem: str = "ripple"
    of_period: str = "lambda_p"
    of_cosine: str = "T_rc"
    of_sine: str = "T_rs"
    source: str = "a Fourier series over the position"
    place: Place = "position"
    switches: bool = False

    @property
    def name(self) -> str:
        """Identifier."""
        return numbered(self.stem, self.count)

    @property
    def title(self) -> str:
        """Name for people."""
        words = self.stem.replace("-", " ")
        return f"{words} over the position, {self.count} {'wave' if self.count == 1 else 'waves'} in a period"

    @property
    def equation(self) -> str:
        """See `Stage`."""
        angle = f"2 pi k x / {self.of_period}"
        return f"T = T_fluid + sum of {self.of_cosine}k cos({angle}) + {self.of_sine}k sin({angle})"

    @property
    def gains(self) -> tuple[Gain, ...]:
        """Two a wave, of either sign."""
        gains: list[Gain] = []
        for k in range(1, self.count + 1):
            for symbol, wave in ((self.of_cosine, "cosine"), (self.of_sine, "sine")):
                meaning = f"{self.stem.replace('-', ' ')}, {wave} of wave {k}"
                gains.append(Gain(f"{symbol}{k}", meaning, EFFORT, nonnegative=False))
        return tuple(gains)

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The period over the position, over the way in a second at the reference slip."""
        meaning = f"period of the {self.stem.replace('-', ' ')} over the position"
        return (ShapeParameter(self.of_period, meaning, 1e-6, 1e6, TRAVEL, "log", (1e-2, 10.0)),)

    def outputs_at(self, signal: Any, *numbers: Any) -> tuple[Any, ...]:
        """Cosine and sine of each wave, elementwise on any operand; of the C's bits, for they are sums and products."""
        z = signal / numbers[0]  # in periods
        z = z - whole_number_near(value_of(z))
        square = z * z
        half_sine = z * _power_series(square, _SINE)
        half_cosine = _power_series(square, _COSINE)
        cosine = 1.0 - 2.0 * half_sine * half_sine
        sine = 2.0 * half_sine * half_cosine
        waves: list[Any] = [cosine, sine]
        for _ in range(1, self.count):
            # The next multiple of the angle by the sum of two angles.
            c, s = waves[-2:]
            waves.append(c * cosine - s * sine)
            waves.append(s * cosine + c * sine)
        return tuple(waves)

    def usual(self, position: Array, effort: Array) -> tuple[float, float] | None:
        """Where to look for the period: around the strongest wave over the position that an effort has.

        Args:
            position: shape (n,).
            effort: without its smooth part, shape (n,).

        Returns:
            None where the position does not move, or the effort has no wave.
        """
        start = float(position.min())
        span = float(np.ptp(position))
        bins = min(_BINS, position.size // 2)
        if span <= 0.0 or bins < 8:
            return None
        # The mean effort over the position, in bins, and its spectrum; four times as fine as the bins would give.
        places = ((position - start) / span * bins).astype(np.intp)
        at = np.minimum(places, bins - 1)
        rows = np.maximum(np.bincount(at, minlength=bins), 1)
        means = np.bincount(at, weights=effort, minlength=bins) / rows
        windowed = means * np.hanning(bins)
        strength = np.abs(np.fft.rfft(windowed, 4 * bins))
        periods = np.arange(strength.size) / 4.0  # within the span of the position
        unlikely = (periods < _FEWEST_PERIODS) | (periods > bins / 4.0)
        strength[unlikely] = 0.0
        if not strength.any():
            return None
        count = float(periods[np.argmax(strength)])
        return span / (count + 0.5), span / (count - 0.5)

    def without(self, position: Array, effort: Array, low: float, high: float) -> Array:
        """An effort without the waves that its rows show best with a period between two, shape (n,)."""
        left = effort
        for period in np.linspace(low, high, _PERIODS):
            waves = np.column_stack(self.outputs_at(position, period))
            gains, *_ = np.linalg.lstsq(waves, effort, rcond=None)
            without_waves = effort - waves @ gains
            if without_waves @ without_waves < left @ left:
                left = without_waves
        return left


def _power_series(x: Any, coefficients: Sequence[float]) -> Any:
    """Horner's rule, lowest power first."""
    total: Any = coefficients[-1]
    for each in reversed(coefficients[:-1]):
        total = total * x + each
    return total


STAGE = StageFamily(
    lambda count, forms: Ripple(count), count=1, ladder=("ripple", "ripple-2", "ripple-3")
)
