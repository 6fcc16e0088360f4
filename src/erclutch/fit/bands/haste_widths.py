"""A band is told how errors grow with haste, so that a motion quicker than all logs gets a wider one.

Errors are those of fits without a row's motion (`left_out_logs`), in half widths of the band. Beyond the quickest
motion the band begins as wide as that motion needs. How it grows has two answers, and the larger one counts. The first
lets each motion stand for a quicker one that nobody had logged: how much wider would the band of all slower motions
have had to be, for how much more haste? The second is the exponent by which errors of logs grow with their haste, by
least squares, and a standard error more, since the logs are few. Where motions differ in their errors, the growth is
one at least: an error in proportion to the rate, of an inertia say, hides behind the other errors of slow motions. So
it is where motions are few. Each of two is as far from a fit to the other, so their errors are alike whether or not
errors grow.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.log_groups import groups_of, motion_of, quantile_over_logs
from erclutch.logs.dataset import Dataset
from erclutch.models.band import Band, leading
from erclutch.models.haste import Haste
from erclutch.signals.array import Array, Mask, rms

#: Time constant of the lag, in times in which the phase of the quickest motion turns by 1 rad: such a lag still tells
#: motions ten times as quick.
_LAG = 0.1
#: The same of the running mean: it bridges half a turn.
_MEAN = 3.0
#: Of a motion's haste over that of the next slower one: where it is less, their errors differ for other reasons too.
_APART = 0.25
#: Of the haste of a log over that of its smoothed slip: where it is more, noise is a part of it.
_NOISY = 1.25
#: Motions that tell how errors grow with haste.
_FEWEST = 2
#: Motions from which on errors that are alike say that errors do not grow.
_ENOUGH = 4
#: Errors of two motions are alike if the larger is less than so many times the other.
_ALIKE = 1.25


def with_haste(band: Band, data: Dataset, errors: Array) -> Band:
    """A band that grows where the slip changes more quickly than in any log.

    Args:
        band: calibrated on the errors.
        data: the training rows.
        errors: measured less estimated effort by fits without the motion of a row, shape (n,).

    Returns:
        The same band where the logs have a single motion.
    """
    logs = groups_of(data)
    around_zero = band.around(np.zeros(data.rows), data.elements, data.clock)
    low, high = around_zero
    half_width = np.where(errors < 0.0, -low, high)
    widest = float(half_width.max())
    if len(set(logs.motion)) < _FEWEST or not widest > 0.0:
        return band

    # The quickest motion says how long lag and mean are.
    # Of each element of each log, rate of the slip over slip, root mean squares.
    turns: list[float] = []  # [rad/s]
    for start, stop in logs.rows:
        logarithms = motion_of(data, slice(start, stop))
        for of_slip, of_rate in zip(logarithms[::2], logarithms[1::2], strict=True):
            turns.append(float(np.exp(of_rate - of_slip)))
    lag_s = max(_LAG / max(turns), 2.0 * data.period)
    mean_s = _MEAN / _LAG * lag_s
    fields = [element.field for element in data.elements]
    slips = [element.slip for element in data.elements]
    _, slip = leading(fields, slips)
    ungrown = Haste(lag_s, mean_s, known=1.0, quickest=1.0, growth=0.0)
    haste = ungrown.of_rows(slip, data.clock)
    if not haste.max() > 0.0:
        return band

    # Where the slip changes more quickly than its motion, as noise does, haste is that of a smoothed slip.
    log = logs.log_of_row(data.rows)
    smooth_s = 0.0
    smoothed = replace(ungrown, smooth_s=lag_s).of_rows(slip, data.clock)
    for number in np.unique(log):
        own = log == number
        if rms(haste[own]) > _NOISY * rms(smoothed[own]):
            smooth_s = lag_s
    if smooth_s > 0.0:
        haste = smoothed

    size = np.abs(errors) / np.maximum(half_width, 1e-3 * widest)
    motion = np.asarray(logs.motion)[log]

    def size_over_logs(rows: Mask) -> float:
        """How large errors are in some rows, in half widths."""
        return quantile_over_logs(size[rows], log[rows], band.level)

    haste_of: dict[int, float] = {}  # of each motion: the largest of a log, mean over its logs
    for number in logs.motion:
        its_logs = np.unique(log[motion == number])
        largest = [haste[log == each].max() for each in its_logs]
        haste_of[number] = float(np.mean(largest))
    slowest, *others = sorted(haste_of, key=lambda number: haste_of[number])
    quickest = max(1.0, size_over_logs(motion == others[-1]))

    # Each motion stands for a quicker one: the growth that would have held it by the errors of all slower ones.
    growths = [0.0, _by_logs(haste, size, log, band.level)]
    slower = [slowest]
    for number in others:
        known = size_over_logs(np.isin(motion, slower))
        needed = size_over_logs(motion == number)
        next_slower = haste_of[slower[-1]]
        if known > 0.0 and next_slower > 0.0:
            wider = needed / known - 1.0
            more_haste = max(haste_of[number] / next_slower - 1.0, _APART)
            growths.append(wider / more_haste)
        slower.append(number)
    of_motions = [size_over_logs(motion == number) for number in haste_of]
    if len(of_motions) < _ENOUGH or max(of_motions) > _ALIKE * min(of_motions):
        growths.append(1.0)

    known_haste = float(haste.max())
    grown = Haste(
        lag_s,
        mean_s,
        known=known_haste,
        quickest=quickest,
        growth=max(growths),
        smooth_s=smooth_s,
    )
    return replace(band, haste=grown)


def _by_logs(
    haste: Array,
    size: Array,
    log: NDArray[np.intp],
    level: float,
) -> float:
    """The exponent by which the errors of logs grow with their haste, and a standard error more."""
    hastes: list[float] = []  # of each log, root mean square
    sizes: list[float] = []
    for number in np.unique(log):
        own = log == number
        if haste[own].any() and size[own].any():
            hastes.append(rms(haste[own]))
            size_of_log = float(np.quantile(size[own], level))
            sizes.append(max(size_of_log, 1e-9))
    of_haste = np.log(hastes)
    of_error = np.log(sizes)

    away = of_haste - of_haste.mean()
    spread = float(away @ away)
    if not spread > 0.0:
        return 0.0
    slope = float(away @ of_error) / spread
    residual = of_error - of_error.mean() - slope * away
    variance = float(residual @ residual) / max(len(hastes) - 2, 1)
    return slope + float(np.sqrt(variance / spread))
