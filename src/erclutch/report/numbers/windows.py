"""Sections of a log deserve a close look: where most happens, where the model does as usual, where it does worst."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from erclutch.report.numbers.correlation import held_out_spans
from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import Array

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
    """Sections of a tenth of the rows held out, 300 to 2500 rows, that do not cross a gap."""
    spans = held_out_spans(rows)
    width = int(np.clip(np.count_nonzero(rows.test) // 10, 300, 2500))
    width = min(width, max(span.stop - span.start for span in spans))
    long_enough = [span for span in spans if span.stop - span.start >= width]
    step = max(1, width // 4)
    starts = np.concatenate([np.arange(span.start, span.stop - width + 1, step) for span in long_enough])

    # Sums over a section are differences of sums from the first row on.
    squares = np.concatenate([[0.0], np.cumsum(rows.residual(model) ** 2)])
    power = np.concatenate([[0.0], np.cumsum(sum(element.slip**2 for element in rows.data.elements))])
    errors = squares[starts + width] - squares[starts]
    motion = np.sqrt(power[starts + width] - power[starts])
    order = np.argsort(errors, kind="stable")
    moves = motion >= np.quantile(motion, 0.75) / 2.0
    moving = order[moves[order]]
    typical, worst = int(starts[moving[moving.size // 2]]), int(starts[order[-1]])

    happens = np.array([_happens(rows, start, width) for start in starts])  # (sections, 2)
    shares = happens / np.maximum(happens.max(axis=0), 1e-300)
    lively = int(starts[np.argmax(shares.sum(axis=1))])
    return Windows((typical, typical + width), (worst, worst + width), (lively, lively + width))


def _happens(rows: RunRows, start: int, width: int) -> tuple[float, float]:
    """Change of field and reversals of slip, in means of a fiftieth; below a twentieth of the range is noise."""
    edges = np.linspace(start, start + width, _PARTS + 1).astype(np.int64)[:-1]

    def means(signal: Array) -> Array:
        return np.add.reduceat(signal[: start + width], edges) / (width / _PARTS)

    changes, reversals = 0.0, 0.0
    for element in rows.data.elements:
        steps = np.abs(np.diff(means(element.field)))
        changes += float(steps[steps > _LEAST * float(np.ptp(element.field))].sum())
        slip = means(element.slip)
        signs = np.sign(slip[np.abs(slip) > _LEAST * float(np.abs(element.slip).max())])
        reversals += float(np.count_nonzero(np.diff(signs)))
    return changes, reversals
