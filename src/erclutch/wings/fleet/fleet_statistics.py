"""Parameters of many devices are compared: what stands out, what drifts, and what leaves a control chart's limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import SIGMA_OF_MAD, Array

OUTLYING = 3.5  # robust standard deviations from the median
RMSE = "rmse"
FEWEST = 5  # devices for any of these figures
_SIGMA_OF_RANGE = 1.128  # mean moving range of two, over the standard deviation
_NORMAL_95 = 1.96  # standard deviations on either side that hold 95 % of a normal distribution


@dataclass(frozen=True)
class Trend:
    """A straight line over time or order.

    Attributes:
        slope, low, high: Theil and Sen's slope and its 95 % interval, in the unit of y over that of x.
        chance: probability of such an order without a trend (Mann and Kendall's test, two-sided).
    """

    slope: float
    low: float
    high: float
    chance: float


@dataclass(frozen=True)
class ControlChart:
    """Individuals and moving range.

    Attributes:
        centre, lower, upper: mean and limits at three standard deviations, from the mean moving range.
        out: which values lie outside, shape (n,).
    """

    centre: float
    lower: float
    upper: float
    out: NDArray[np.bool_]


def outlier_scores(values: Array, low: Array, high: Array) -> Array:
    """Distance of each value from the median, in standard deviations of the spread and of its own interval together.

    Args:
        values: of each device, shape (n,).
        low: lower ends of their 95 % intervals, shape (n,).
        high: upper ends; an interval that is not finite counts as none.

    Returns:
        Scores, shape (n,); nan where there are fewer than five values, 0 where nothing spreads.
    """
    if values.size < FEWEST:
        return np.full(values.size, np.nan)
    with np.errstate(invalid="ignore"):
        # Standard deviation that a device's own interval says.
        own = (high - low) / (2.0 * _NORMAL_95)
    own = np.where(np.isfinite(own), own, 0.0)
    away = values - np.median(values)
    of_all = SIGMA_OF_MAD * np.median(np.abs(away))
    spread = np.hypot(of_all, own)
    # Where nothing spreads, a value at the median is usual and any other one stands out without limit.
    scores = np.where(away == 0.0, 0.0, np.copysign(np.inf, away))
    return np.divide(away, spread, out=scores, where=spread > 0.0)


def trend(x: Array, y: Array) -> Trend | None:
    """The trend of y over x, both of shape (n,); None for fewer than five values, or where x is the same everywhere."""
    from scipy.stats import kendalltau, theilslopes

    if y.size < FEWEST or np.ptp(x) == 0.0:
        return None
    slope, _, low, high = theilslopes(y, x, 0.95)
    constant = np.ptp(y) == 0.0
    chance = 1.0 if constant else float(kendalltau(x, y).pvalue)
    return Trend(float(slope), float(low), float(high), chance)


def control_chart(values: Array, baseline: int = 0) -> ControlChart | None:
    """Limits from the first values of a row; None for fewer than five.

    Args:
        values: in their order, shape (n,).
        baseline: how many of the first values give the limits; 0 for all.
    """
    first = values[: baseline or None]
    if first.size < FEWEST:
        return None
    centre = float(first.mean())
    moves = np.abs(np.diff(first))
    moving_range = float(moves.mean())
    reach = 3.0 * moving_range / _SIGMA_OF_RANGE
    outside = np.abs(values - centre) > reach
    return ControlChart(centre, centre - reach, centre + reach, outside)


@dataclass(frozen=True)
class FleetSeries:
    """One number of one model over the devices that have it, in their order.

    Attributes:
        model, parameter, unit: what it is; the parameter "rmse" is the error on rows held out.
        devices: names.
        x: place in the order, or what the fleet is ordered by, shape (n,).
        value, low, high: with 95 % intervals, shape (n,).
        score: see `outlier_scores`, shape (n,).
        trend, chart: None for few devices.
        apart: devices whose number is of another reference field and is not compared, with that field.
    """

    model: str
    parameter: str
    unit: str
    devices: tuple[str, ...]
    x: Array
    value: Array
    low: Array
    high: Array
    score: Array
    trend: Trend | None
    chart: ControlChart | None
    apart: Mapping[str, float] = field(default_factory=dict[str, float])

    @property
    def outliers(self) -> tuple[str, ...]:
        """Devices that stand out."""
        return tuple(d for d, s in zip(self.devices, self.score, strict=True) if abs(s) > OUTLYING)
