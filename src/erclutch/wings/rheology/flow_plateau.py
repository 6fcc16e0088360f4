"""Whether a flow curve levels off at its lowest rates, and so shows a yield stress; to which digit its numbers tell."""

from __future__ import annotations

import numpy as np

from erclutch.signals.array import Array

_FLAT = 0.15  # slope of ln(stress) over ln(rate) on a plateau
_FEWEST = 4  # points of a plateau
_MOST_DIGITS = 12  # of a number that a file rounds; one with more was computed
_ENOUGH = 1000  # numbers that tell how a column is rounded


def plateau_of(rate: Array, stress: Array, rounding: float = 0.0) -> tuple[float, float] | None:
    """Between which stresses in Pa a curve levels off at its lowest rates; None where it does not.

    A curve shows a yield stress where the stress hardly falls with the rate: over the lowest decade of rates, and over
    four points at least, by a slope of ln(stress) over ln(rate) below 0.15. The stress at rest is then below the lowest
    stress there by no more than the fall over two more decades.

    The stresses are known to half a last digit, which may hide a fall by a whole digit over that decade. Without noise
    this counts: the interval of a yield stress then has hardly a width. Of 160 exact curves, rounded to 3 - 6 digits,
    8 had it beside the plateau by up to 0.8 of half a digit, and 1 of 72 others by as much again.

    Args:
        rate: shear rate in 1/s, shape (n,).
        stress: shear stress in Pa, shape (n,).
        rounding: half a last digit of the stress at the lowest rate, in Pa.
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
    lowest_stress = float(stress[lowest].min())
    highest_stress = float(stress[lowest].max())
    hidden_slope = 2.0 * rounding / lowest_stress / np.log(10.0)
    steepest = max(slope, 0.0) + hidden_slope
    fall_over_two_decades = float(np.exp(-2.0 * np.log(10.0) * steepest))
    return (lowest_stress - rounding) * fall_over_two_decades, highest_stress + rounding


def half_last_digit(number: float, column: Array) -> float:
    """Half a last digit of a number as a file writes it, told by those of its column with the most digits.

    A column is rounded to a number of digits or of decimals; zeros at the end leave no trace in a number, so the
    others tell. Of numbers that nobody rounded: 0.

    Args:
        number: one of the column.
        column: as read, shape (n,).
    """
    digits = 0
    decimals = -np.inf
    for each in column[np.isfinite(column) & (column != 0.0)][:_ENOUGH]:
        mantissa, _, exponent = np.format_float_scientific(abs(each), trim="-").partition("e")
        own_digits = len(mantissa.replace(".", ""))
        digits = max(digits, own_digits)
        decimals = max(decimals, own_digits - 1 - int(exponent))
    if not 0 < digits <= _MOST_DIGITS or number == 0.0:
        return 0.0
    by_digits = float(np.floor(np.log10(abs(number)))) - (digits - 1)
    return 0.5 * 10.0 ** max(by_digits, -float(decimals))
