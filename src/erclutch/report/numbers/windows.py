"""Sections of a log deserve a close look: where most happens, where the model does as usual, where it does worst."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.report.numbers.correlation import held_out_spans
from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import Array, largest_size

_PARTS = 50  # of a section, of which means are taken
_LEAST = 0.05  # share of the range below which a change is noise


@dataclass(frozen=True)
class Windows:
    """Rows [start, stop) of sections of the rows held out.

    Attributes:
        typical: a section with the median error of all sections of that length in motion: the RMS of the slip is at
            least half of its upper quartile.
        worst: the one with the largest.
        lively: the one with the largest sum of two shares: its change of field over that of the section in which the
            field changes most, and its reversals of slip over those of the section with the most. The rule looks at
            inputs alone, so it favours no model.
    """

    typical: tuple[int, int]
    worst: tuple[int, int]
    lively: tuple[int, int]


def windows(rows: RunRows, model: str) -> Windows:
    """Sections of a tenth of the rows held out, 300 to 2500 rows, that do not cross a gap.

    Of points in no time those held out lie between others: there sections of the whole table are taken.
    """
    spans = rows.data.clock.spans if rows.data.in_no_time else held_out_spans(rows)
    longest = max(span.stop - span.start for span in spans)
    share = np.count_nonzero(rows.test) // 10
    tenth = int(np.clip(share, 300, 2500))
    width = min(tenth, longest)

    # Sections overlap by three quarters, and each lies inside one span.
    quarter = max(1, width // 4)
    of_spans: list[NDArray[np.int64]] = []
    for span in spans:
        if span.stop - span.start >= width:
            behind = span.stop - width + 1
            of_spans.append(np.arange(span.start, behind, quarter))
    starts = np.concatenate(of_spans)

    squared_residual = rows.residual(model) ** 2
    squares = [element.slip**2 for element in rows.data.elements]
    squared_slip: Array = np.sum(squares, axis=0)
    errors = _sums(squared_residual, starts, width)
    motion = np.sqrt(_sums(squared_slip, starts, width))

    by_error = np.argsort(errors, kind="stable")
    worst = int(starts[by_error[-1]])

    # A log may rest for most of its time. A section at rest is no typical one.
    moves = motion >= np.quantile(motion, 0.75) / 2.0
    moving_by_error = by_error[moves[by_error]]
    typical = int(starts[moving_by_error[moving_by_error.size // 2]])

    events = np.array([_events(rows, start, width) for start in starts])  # (sections, 2)
    shares = events / np.maximum(events.max(axis=0), 1e-300)
    lively = int(starts[np.argmax(shares.sum(axis=1))])

    return Windows(
        typical=(typical, typical + width),
        worst=(worst, worst + width),
        lively=(lively, lively + width),
    )


def _sums(values: Array, starts: NDArray[np.int64], width: int) -> Array:
    """The sum of each section: a difference of sums from the first row on."""
    from_first = np.concatenate([[0.0], np.cumsum(values)])
    return from_first[starts + width] - from_first[starts]


def _events(rows: RunRows, start: int, width: int) -> tuple[float, float]:
    """Change of field and reversals of slip in a section.

    Both are counted in means of a fiftieth of the section. What is below a twentieth of the log's range is noise.
    """
    stop = start + width
    edges = np.linspace(start, stop, _PARTS + 1).astype(np.int64)
    firsts = edges[:-1]  # of each part

    def means(signal: Array) -> Array:
        sums = np.add.reduceat(signal[:stop], firsts)
        return sums / (width / _PARTS)

    change = 0.0
    reversals = 0.0
    for element in rows.data.elements:
        steps = np.abs(np.diff(means(element.field)))
        least_step = _LEAST * float(np.ptp(element.field))
        change += float(steps[steps > least_step].sum())

        slip = means(element.slip)
        least_slip = _LEAST * largest_size(element.slip)
        signs = np.sign(slip[np.abs(slip) > least_slip])
        reversals += float(np.count_nonzero(np.diff(signs)))
    return change, reversals
