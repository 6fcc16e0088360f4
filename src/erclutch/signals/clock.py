"""A clock says when the rows of a data set were sampled: time stamps, and the stretches between gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from erclutch.signals.array import Array


@dataclass(frozen=True)
class Span:
    """Rows [start, stop) without a gap; ``period`` in s, or None where the steps differ."""

    start: int
    stop: int
    period: float | None


@dataclass(frozen=True)
class Clock:
    """When the rows of a data set were sampled.

    Attributes:
        time: time stamps in s, shape (n,), increasing inside each span.
        spans: gapless stretches that cover all rows in order.
    """

    time: Array
    spans: tuple[Span, ...]


def cut_spans(spans: Sequence[Span], start: int, stop: int) -> tuple[Span, ...]:
    """The parts of ``spans`` inside rows [start, stop), counted from start."""
    kept = ((max(s.start, start), min(s.stop, stop), s.period) for s in spans)
    return tuple(Span(a - start, b - start, period) for a, b, period in kept if b - a >= 2)
