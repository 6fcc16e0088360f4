"""The speed is made of a logged position, also where steps are unequal."""

from __future__ import annotations

from collections.abc import Iterable

from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import SPEED_OF
from erclutch.signals.speed import Derivative, differentiate


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


def note_of(speed: str, position: str, how: str) -> str:
    """What the user is told of a speed that was made of a position."""
    return f"{speed} <- {position} by the {how}"


def is_of_position(notes: Iterable[str]) -> bool:
    """Whether the notes of a log say that a speed was made of a position."""
    begins = tuple(note_of(speed, position, "") for position, speed in SPEED_OF.items())
    return any(note.startswith(begins) for note in notes)
