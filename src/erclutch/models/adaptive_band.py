"""A band that learns from a torque sensor: past measured efforts shift it and set its width.

Adaptive conformal inference (Gibbs and Candes 2021, doi 10.48550/arXiv.2106.00543) in the form that tracks the width
itself (Angelopoulos, Candes and Tibshirani 2023, doi 10.48550/arXiv.2307.16895): each row outside widens the band,
each row inside narrows it a little, so that in the long run the wanted share of rows is inside, whatever the device
does. A running mean of the error shifts the band.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from erclutch.arithmetic.elementary import less_select
from erclutch.models.band import Band
from erclutch.models.covered_cells import within
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock

#: Time constant in s of the running mean of the error; time in s in which a band that holds all rows shrinks by e.
OFFSET_S, SCALE_S = 0.05, 0.5
#: Least and most that the widths of a band are multiplied by.
NARROWEST, WIDEST = 0.1, 10.0


class Adapted(NamedTuple):
    """State after the rows so far: what is added to the effort, and what the half widths are multiplied by."""

    offset: Any
    scale: Any


SETTLED = Adapted(0.0, 1.0)


def after(state: Adapted, error: Any, below: Any, above: Any, level: float, period: float) -> Adapted:
    """The state after one row; elementwise on any operand.

    Args:
        state: before the row; the row's own band came from it.
        error: measured less estimated effort.
        below: half width of the row's band under the effort, without a sensor.
        above: the same over the effort.
        level: share of rows that the band is to hold.
        period: time to the next row in s.
    """
    low, high = state.offset - state.scale * below, state.offset + state.scale * above
    share, gain = -float(np.expm1(-period / OFFSET_S)), min(period / SCALE_S / (1.0 - level), 1.0)
    # The logarithm of the scale is what adds up: its steps balance where the wanted share of rows is inside.
    wider, narrower = float(np.exp(gain * level)), float(np.exp(-gain * (1.0 - level)))
    scale = state.scale * less_select(error, low, wider, less_select(high, error, wider, narrower))
    return Adapted(state.offset + share * (error - state.offset), within(scale, NARROWEST, WIDEST))


def adapted(band: Band, ends: tuple[Array, Array], effort: Array, measured: Array, clock: Clock) -> tuple[Array, Array]:
    """Low and high end at each row from the measured effort of the rows before it, each (n,); anew in each span.

    Args:
        band: of the model.
        ends: low and high end of the band without a sensor, each (n,).
        effort: estimated effort, shape (n,).
        measured: measured effort, shape (n,).
        clock: when the rows were sampled.
    """
    below, above = effort - ends[0], ends[1] - effort
    error, steps = (measured - effort).tolist(), np.diff(clock.time, prepend=clock.time[:1]).tolist()
    states: list[Adapted] = []
    for span in clock.spans:
        state = SETTLED
        widths = zip(below[span.start : span.stop].tolist(), above[span.start : span.stop].tolist(), strict=True)
        for k, (under, over) in enumerate(widths, start=span.start):
            states.append(state)
            state = after(state, error[k], under, over, band.level, steps[min(k + 1, span.stop - 1)])
    offset, scale = np.array(states, np.float64).reshape(-1, 2).T
    return effort + offset - scale * below, effort + offset + scale * above
