"""A band is told how errors grow with haste, so that a motion quicker than all logs gets a wider one.

Errors are those of fits without a row's motion (`left_out_logs`), in half widths of the band. Beyond the quickest
motion the band begins as wide as that motion needs. How it grows has two answers, and the larger one counts. The first
lets each motion stand for a quicker one that nobody had logged: how much wider would the band of all slower motions
have had to be, for how much more haste? The second is the exponent by which errors of logs grow with their haste, by
least squares, and a standard error more, since the logs are few.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.log_groups import FEWEST_GROUPS, groups_of, motion_of, quantile_over_logs
from erclutch.logs.dataset import Dataset
from erclutch.models.band import Band, leading
from erclutch.models.haste import Haste
from erclutch.signals.array import Array

#: Time constants of the lag and of the running mean, in times in which the phase of the quickest motion turns by 1 rad:
#: such a lag tells motions ten times as quick still, and such a mean bridges half a turn.
_LAG, _MEAN = 0.1, 3.0
#: Of a motion's haste over that of the next slower one: where it is less, their errors differ for other reasons too.
_APART = 0.25


def with_haste(band: Band, data: Dataset, errors: Array) -> Band:
    """A band that grows where the slip changes more quickly than in any log.

    Args:
        band: calibrated on the errors.
        data: the training rows.
        errors: measured less estimated effort by fits without the motion of a row, shape (n,).

    Returns:
        The same band where the logs have fewer than three motions.
    """
    logs = groups_of(data)
    low, high = band.around(np.zeros(data.rows), data.elements, data.clock)
    half = np.where(errors < 0.0, -low, high)
    if len(set(logs.motion)) < FEWEST_GROUPS or not half.max() > 0.0:
        return band
    # Of each log [rad/s]: of its quickest element, root mean square of the slip's rate over that of the slip.
    turns = [
        max(np.exp(rate - size) for size, rate in zip(sizes[::2], sizes[1::2], strict=True))
        for sizes in (motion_of(data, slice(*rows)) for rows in logs.rows)
    ]
    lag_s = max(_LAG / float(max(turns)), 2.0 * data.period)
    _, slip = leading([e.field for e in data.elements], [e.slip for e in data.elements])
    haste = Haste(lag_s, _MEAN / _LAG * lag_s, 1.0, 1.0, 0.0).of_rows(slip, data.clock)
    if not haste.max() > 0.0:
        return band

    size = np.abs(errors) / np.maximum(half, 1e-3 * float(half.max()))
    log = np.digitize(np.arange(data.rows), np.array([stop for _, stop in logs.rows]))
    motion = np.asarray(logs.motion)[log]
    hastes = {  # the largest of a log, mean over the logs of a motion
        each: float(np.mean([haste[log == k].max() for k in np.unique(log[motion == each])])) for each in logs.motion
    }
    slowest, *others = sorted(hastes, key=lambda each: hastes[each])
    own = motion == others[-1]
    quickest = max(1.0, quantile_over_logs(size[own], log[own], band.level))
    # Each motion stands for a quicker one: the growth that would have held it by the errors of all slower ones.
    growths = [0.0, _by_logs(haste, size, log, band.level)]
    slower = [slowest]
    for each in others:
        before, own = np.isin(motion, slower), motion == each
        known = quantile_over_logs(size[before], log[before], band.level)
        needed = quantile_over_logs(size[own], log[own], band.level)
        if known > 0.0 and hastes[slower[-1]] > 0.0:
            growths.append((needed / known - 1.0) / max(hastes[each] / hastes[slower[-1]] - 1.0, _APART))
        slower.append(each)
    return replace(band, haste=Haste(lag_s, _MEAN / _LAG * lag_s, float(haste.max()), quickest, max(growths)))


def _by_logs(haste: Array, size: Array, log: NDArray[np.intp], level: float) -> float:
    """The exponent by which the errors of logs grow with their haste, and a standard error more."""
    rows = [own for own in (log == k for k in np.unique(log)) if haste[own].any() and size[own].any()]
    x = np.log([float(np.sqrt(np.mean(haste[own] ** 2))) for own in rows])
    y = np.log([max(float(np.quantile(size[own], level)), 1e-9) for own in rows])
    away = x - x.mean()
    spread = float(away @ away)
    if not spread > 0.0:
        return 0.0
    slope = float(away @ y) / spread
    left = y - y.mean() - slope * away
    return slope + float(np.sqrt(left @ left / max(len(rows) - 2, 1) / spread))
