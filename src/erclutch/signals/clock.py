"""A clock says when the rows of a data set were sampled: time stamps, and the stretches between gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from erclutch.signals.array import Array, Mask

#: A clock that begins beyond so many seconds, which are twelve days, counts from a date.
_FROM_A_DATE = 1e6


@dataclass(frozen=True)
class Span:
    """Rows [start, stop) without a gap; ``period`` in s, or None where the steps differ."""

    start: int
    stop: int
    period: float | None


@dataclass
class Carry:
    """States that recursions hand on over a border inside a span, each in the order in which they run.

    Attributes:
        begin: the states in the first row, from the rows before; empty where the first row begins a span.
        at: the row whose states are handed on.
        end: the states in that row, as recursions run.
    """

    begin: list[Array]
    at: int
    end: list[Array] = field(default_factory=list["Array"])

    def into(self, first: Array) -> None:
        """Put what comes from the rows before in place of the states, shape (states,), of the first row."""
        if self.begin:
            first[:] = self.begin[len(self.end)]


@dataclass(frozen=True)
class Clock:
    """When the rows of a data set were sampled.

    Attributes:
        time: time stamps in s, shape (n,), increasing inside each span.
        spans: gapless stretches that cover all rows in order.
        joins: whether the first span goes on from rows before these.
        carry: states over the borders of a stretch; None where all spans are whole.
    """

    time: Array
    spans: tuple[Span, ...]
    joins: bool = False
    carry: Carry | None = None

    @cached_property
    def steps(self) -> Array:
        """Sampling step that ends at each row, in s; the first row of a span gets the following one's. Not to write to.

        A search for memory asks thousands of times, and a log of stamps may have hundreds of spans.
        """
        steps = np.empty(self.time.size)
        for span in self.spans:
            rows = slice(span.start, span.stop)
            if span.period is not None:
                steps[rows] = span.period
            elif span.stop - span.start > 1:
                time = self.time[rows]
                before = 2 * time[0] - time[1]  # as if the first step had been the second
                steps[rows] = np.diff(time, prepend=before)
            else:
                steps[rows] = 1.0  # a lone row is settled, whatever the step
        steps.flags.writeable = False
        return steps

    def moment(self, row: int) -> str:
        """The time of a row in words; since the start where the clock counts from a date, which hides all digits."""
        start = float(self.time[0])
        time = float(self.time[row])
        if start >= _FROM_A_DATE:
            return f"{time - start:.1f} s after the log's start"
        return f"{time:.4g} s" if time < 1e4 else f"{time:.1f} s"


def stretches(mask: Mask) -> list[tuple[int, int]]:
    """Rows [start, stop) of each stretch of a mask."""
    walled = np.concatenate(([False], mask, [False])).astype(np.int8)
    edges = np.flatnonzero(np.diff(walled)).tolist()
    starts = edges[::2]
    stops = edges[1::2]
    return list(zip(starts, stops, strict=True))


def within(spans: Sequence[Span], start: int, stop: int) -> tuple[Span, ...]:
    """The parts of ``spans`` inside rows [start, stop), lone rows too, counted from start."""
    parts: list[Span] = []
    for span in spans:
        first = max(span.start, start)
        last = min(span.stop, stop)
        if first < last:
            parts.append(Span(first - start, last - start, span.period))
    return tuple(parts)


def cut_spans(spans: Sequence[Span], start: int, stop: int) -> tuple[Span, ...]:
    """The parts of ``spans`` inside rows [start, stop), counted from start."""
    return tuple(span for span in within(spans, start, stop) if span.stop - span.start >= 2)
