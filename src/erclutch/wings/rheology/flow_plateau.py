"""Whether a flow curve levels off at its lowest rates, and so shows a yield stress."""

from __future__ import annotations

import numpy as np

from erclutch.signals.array import Array

_FLAT = 0.15  # slope of ln(stress) over ln(rate) on a plateau
_FEWEST = 4  # points of a plateau


def plateau_of(rate: Array, stress: Array) -> tuple[float, float] | None:
    """Between which stresses in Pa a curve levels off at its lowest rates; None where it does not.

    A curve shows a yield stress where the stress hardly falls with the rate: over the lowest decade of rates, and over
    four points at least, by a slope of ln(stress) over ln(rate) below 0.15. The stress at rest is then below the lowest
    stress there by no more than the fall over two more decades.

    Args:
        rate: shear rate in 1/s, shape (n,).
        stress: shear stress in Pa, shape (n,).
    """
    order = np.argsort(rate, kind="stable")
    rate = rate[order]
    stress = stress[order]
    lowest = rate <= 10.0 * rate[0]
    if lowest.sum() < _FEWEST:
        lowest = np.arange(rate.size) < _FEWEST

    log_rate = np.log(rate[lowest])
    log_stress = np.log(stress[lowest])
    if np.ptp(log_rate) == 0.0:
        return None
    slope = float(np.polyfit(log_rate, log_stress, 1)[0])
    if slope > _FLAT:
        return None
    fall_over_two_decades = float(np.exp(-2.0 * np.log(10.0) * max(slope, 0.0)))
    return float(stress[lowest].min()) * fall_over_two_decades, float(stress[lowest].max())
