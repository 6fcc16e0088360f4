"""A band that learns from a torque sensor: past measured efforts shift it and set its width.

Adaptive conformal inference (Gibbs and Candes 2021, doi 10.48550/arXiv.2106.00543) in the form that tracks the width
itself (Angelopoulos, Candes and Tibshirani 2023, doi 10.48550/arXiv.2307.16895): each row outside widens the band,
each row inside narrows it a little, so that in the long run the wanted share of rows is inside, whatever the device
does. A running mean of the error shifts the band.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from erclutch.arithmetic.elementary import less_select
from erclutch.models.band import Band
from erclutch.models.covered_cells import within
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock

#: Time constant in s of the running mean of the error.
OFFSET_S = 0.05
#: Time in s in which a band that holds all rows shrinks by e.
SCALE_S = 0.5
#: Least that the widths of a band are multiplied by.
NARROWEST = 0.1
#: Most that they are multiplied by.
WIDEST = 10.0


class Adapted(NamedTuple):
    """State after the rows so far: what is added to the effort, and what the half widths are multiplied by."""

    offset: Any
    scale: Any


SETTLED = Adapted(0.0, 1.0)


def after(
    state: Adapted,
    error: Any,
    below: Any,
    above: Any,
    level: float,
    period: float,
) -> Adapted:
    """The state after one row; elementwise on any operand.

    Args:
        state: before the row; the row's own band came from it.
        error: measured less estimated effort.
        below: half width of the row's band under the effort, without a sensor.
        above: the same over the effort.
        level: share of rows that the band is to hold.
        period: time to the next row in s.
    """
    low = state.offset - state.scale * below
    high = state.offset + state.scale * above

    wider, narrower, share = _steps(level, period)
    factor = less_select(error, low, wider, less_select(high, error, wider, narrower))
    scale = state.scale * factor
    offset = state.offset + share * (error - state.offset)
    return Adapted(offset, within(scale, NARROWEST, WIDEST))


@lru_cache(maxsize=16)
def _steps(level: float, period: float) -> tuple[float, float, float]:
    """Factors of the scale after a row outside and after a row inside, and the share that the offset goes in a row."""
    # The logarithm of the scale is what adds up: its steps balance where the wanted share of rows is inside.
    gain = min(period / SCALE_S / (1.0 - level), 1.0)
    wider = float(np.exp(gain * level))
    narrower = float(np.exp(-gain * (1.0 - level)))
    share = -float(np.expm1(-period / OFFSET_S))
    return wider, narrower, share


def adapted(
    band: Band,
    ends: tuple[Array, Array],
    effort: Array,
    measured: Array,
    clock: Clock,
) -> tuple[Array, Array]:
    """Low and high end at each row from the measured effort of the rows before it, each (n,); anew in each span.

    Args:
        band: of the model.
        ends: low and high end of the band without a sensor, each (n,).
        effort: estimated effort, shape (n,).
        measured: measured effort, shape (n,).
        clock: when the rows were sampled.
    """
    low, high = ends
    below = effort - low
    above = high - effort

    # Lists, since numbers of Python are quicker than those of NumPy, one at a time.
    errors = (measured - effort).tolist()
    half_below = below.tolist()
    half_above = above.tolist()
    step = np.diff(clock.time, prepend=clock.time[:1]).tolist()  # [s], from the row before
    offsets: list[float] = []  # before each row
    scales: list[float] = []
    for span in clock.spans:
        offset, scale = SETTLED
        for row in range(span.start, span.stop):
            offsets.append(offset)
            scales.append(scale)
            # `after`, said in numbers of Python: the same bits in a fifth of the time.
            error = errors[row]
            wider, narrower, share = _steps(band.level, step[min(row + 1, span.stop - 1)])
            is_outside = (
                error < offset - scale * half_below[row] or offset + scale * half_above[row] < error
            )
            scale = scale * (wider if is_outside else narrower)
            scale = scale if scale > NARROWEST else NARROWEST  # also where it is not a number
            scale = scale if scale < WIDEST else WIDEST
            offset = offset + share * (error - offset)
    offset_of_row = np.array(offsets, np.float64)
    scale_of_row = np.array(scales, np.float64)
    return (
        effort + offset_of_row - scale_of_row * below,
        effort + offset_of_row + scale_of_row * above,
    )
