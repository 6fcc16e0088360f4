"""Two motions with an effort each are of two devices, or of the two sides of one: the numbers may tell.

The sides of a gear turn in a fixed ratio. The sides of a clutch turn by themselves, and carry the same torque; where a
motor's inertia hides it on one side, the torque on the other has the sign of the slip. Joints of a robot do neither. A
side that hardly carries a torque tells nothing: it may belong to an open clutch.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.shapes import known_rows
from erclutch.logs.columns.two_courses import correlation_of
from erclutch.signals.array import Array

_FOLLOWS = 0.5  # correlation of two efforts, from which on they may be one torque
_IN_A_RATIO = 0.9  # correlation of two speeds, from which on a gear may join them
_JOINED = 0.95  # correlation of both, from which on a shaft or a gear joins them
_RUNS_ON = 0.8  # correlation of a measured course with itself a row later; noise has none
_SWINGS = 0.2  # of the largest speed, which a joint that turns back reaches the other way
_KEEPS_THE_SIGN = 0.8  # share of the rows in which the torque of a clutch has the sign of its slip
_BETTER = 0.02  # share of the rows, by which the sign of the slip is kept in more of them than that of the speed
_LARGE = 0.05  # of the largest speed and effort, from which on their signs tell
_ONE_TORQUE = 0.95  # correlation of efforts of three and more shafts that one gear joins


def turn_apart(speeds: Sequence[SeenColumn], efforts: Sequence[SeenColumn]) -> bool:
    """Whether two efforts, and two speeds, go their own ways, so that no gear and no clutch joins them.

    Args:
        speeds: of the first and of the second.
        efforts: in the same order.
    """
    first, second = (each.values for each in efforts)
    if not _runs_on(first) or not _runs_on(second):
        return False
    if abs(correlation_of(first, second)) > _FOLLOWS:
        return False
    if abs(correlation_of(speeds[0].values, speeds[1].values)) > _IN_A_RATIO:
        return False
    # What a clutch carries has the sign of its slip, whatever the inertia of a motor adds on the other side.
    slip = speeds[0].values - speeds[1].values
    for speed, effort in zip(speeds, efforts, strict=True):
        of_slip = along(effort.values, slip)
        of_speed = along(effort.values, speed.values)
        if of_slip >= _KEEPS_THE_SIGN and of_slip > of_speed + _BETTER:
            return False
    return True


def are_joined(speeds: Sequence[SeenColumn], efforts: Sequence[SeenColumn]) -> bool:
    """Whether two speeds keep a ratio and two efforts as well, as two machines on one shaft or at one gear do.

    Args:
        speeds: of the first and of the second.
        efforts: in the same order.
    """
    v = correlation_of(speeds[0].values, speeds[1].values)
    f = correlation_of(efforts[0].values, efforts[1].values)
    return abs(v) > _JOINED and abs(f) > _JOINED


def turns_back(speed: SeenColumn) -> bool:
    """Whether a speed swings to both sides, as that of a joint does."""
    (v,) = known_rows(speed.values)
    if not v.size:
        return False
    forth = max(float(v.max()), 0.0)
    back = max(-float(v.min()), 0.0)
    return min(forth, back) > _SWINGS * max(forth, back)


def carry_one_torque(efforts: Sequence[SeenColumn]) -> bool:
    """Whether all efforts follow the first that changes, as the shafts of one gear carry shares of one torque."""
    moving = [each.values for each in efforts if not each.shape.constant]
    return len(moving) > 1 and all(
        abs(correlation_of(moving[0], other)) > _ONE_TORQUE for other in moving[1:]
    )


def _runs_on(values: Array) -> bool:
    """Whether a course goes on from row to row: it was measured of something that acts, and is no noise."""
    (f,) = known_rows(values)
    if not f.size or np.ptp(f) == 0.0:
        return False
    return correlation_of(f[:-1], f[1:]) > _RUNS_ON


def along(effort: Array, speed: Array) -> float:
    """The share of the rows in which an effort has the sign of a speed, or all the other sign, where both are large."""
    known = np.isfinite(effort) & np.isfinite(speed)
    f = effort[known]
    v = speed[known]
    if not f.size:
        return 0.0
    is_large = (np.abs(f) > _LARGE * np.abs(f).max()) & (np.abs(v) > _LARGE * np.abs(v).max())
    rows = np.count_nonzero(is_large)
    if not rows:
        return 0.0
    have_one_sign = np.count_nonzero(np.sign(f[is_large]) == np.sign(v[is_large])) / rows
    return max(have_one_sign, 1.0 - have_one_sign)
