"""Some devices hold by themselves and their field lets go: a brake with a magnet that a current cancels.

The setting of an eddy-current brake is such a field too where it is the distance of the magnet.
"""

from __future__ import annotations

import numpy as np

from erclutch.fit.checks.finding import Finding
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import largest_size, rms

#: Of the effort without a field: by how much it has to fall up to the largest field; and how far it may turn round by
#: a straight line over a curve. An effort that turns round more has a wrong sign.
_FALLS_BY = 0.2
_TURNS_ROUND_BY = 0.5
#: Share of the error of a line over the slip that the field has to take off.
_WORTH = 0.1


def releasing_field(data: Dataset) -> Finding | None:
    """What is good to know of a device that its field releases."""
    if not field_releases(data):
        return None
    message = (
        "the effort falls as the field grows, as that of a brake that a current releases: laws take a yield effort "
        "that falls"
    )
    remedy = "Check the field's column if a stronger field is to hold the device"
    return Finding("note", "releasing field", message, remedy)


def field_releases(data: Dataset) -> bool:
    """Whether the effort against the slip falls clearly as the field of a single device grows."""
    if data.device != "single" or data.one_field:
        return False
    element = data.elements[0]
    moving = ~data.at_rest
    slip = element.slip[moving]
    strength = np.abs(element.field[moving]) / largest_size(element.field)
    if slip.size <= 3 or np.ptp(strength) == 0.0:
        return False
    against = np.sign(slip) * data.effort[moving]  # that of a passive device is positive

    level = np.ones(slip.size)
    over_slip = np.column_stack([level, np.abs(slip)])
    over_both = np.column_stack([over_slip, strength])
    without_field, *_ = np.linalg.lstsq(over_slip, against, rcond=None)
    with_field, *_ = np.linalg.lstsq(over_both, against, rcond=None)
    fall = -float(with_field[-1])
    at_no_field = float(np.mean(over_slip @ with_field[:-1]))

    falls = fall >= _FALLS_BY * at_no_field > 0.0
    turns_round = at_no_field - fall < -_TURNS_ROUND_BY * at_no_field
    error = rms(against - over_both @ with_field)
    is_worth_it = error <= (1.0 - _WORTH) * rms(against - over_slip @ without_field)
    return falls and not turns_round and is_worth_it
