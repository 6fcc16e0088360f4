"""The speed is made of a logged position, also where steps are unequal or a sensor starts again after a full turn."""

from __future__ import annotations

import numpy as np

from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.speed import Derivative, differentiate

_TURN = 2.0 * np.pi * (1.0 + 1e-6)  # that the angles of a sensor that starts again lie within


def speed_of(position: Array, clock: Clock, derivative: Derivative) -> tuple[Array, str]:
    """The speed of a position, and by which derivative.

    The usual filter needs equal steps and five rows between gaps; where a log has less, and nobody chose a filter,
    central differences take its place.
    """
    how = f"{derivative.name} derivative"
    fit_for_filter: list[Span] = []
    others: list[Span] = []
    for span in clock.spans:
        has_equal_steps = span.period is not None
        if has_equal_steps and span.stop - span.start >= derivative.window:
            fit_for_filter.append(span)
        else:
            others.append(span)
    was_chosen = derivative != Derivative()
    if was_chosen or not others:
        return differentiate(position, clock, derivative), how

    speed = differentiate(position, Clock(clock.time, tuple(others)), Derivative("central"))
    if not fit_for_filter:
        why = "the steps are unequal" if others[0].period is None else "few rows stand between gaps"
        return speed, f"central derivative, since {why}"
    filtered = differentiate(position, Clock(clock.time, tuple(fit_for_filter)), derivative)
    for span in fit_for_filter:
        speed[span.start : span.stop] = filtered[span.start : span.stop]
    return (
        speed,
        f"{how}, in {len(others)} of {len(clock.spans)} segments by the central one: few rows stand there",
    )


def drawn_out(angle: Array, clock: Clock) -> tuple[Array, int]:
    """An angle without the jumps of a sensor that starts again after a full turn, and how many there were."""
    if np.ptp(angle) > _TURN:
        return angle, 0
    parts = [angle[span.start : span.stop] for span in clock.spans]
    turns = 0
    for part in parts:
        jumps = np.abs(np.diff(part)) > np.pi
        turns += int(np.count_nonzero(jumps))
    if not turns:
        return angle, 0
    return np.concatenate([np.unwrap(part) for part in parts]), turns
