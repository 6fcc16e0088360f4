"""Sections of a log deserve a close look: where most happens, where the model does as usual, where it does worst."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from erclutch.report.numbers.correlation import held_out_spans
from erclutch.runs.run_rows import RunRows

_PARTS, _LEAST = 50, 0.05


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
    residual = rows.residual(model)
    squares, power = (
        np.concatenate([[0.0], np.cumsum(v)]) for v in (residual**2, sum(e.slip**2 for e in rows.data.elements))
    )
    spans = held_out_spans(rows)
    width = int(np.clip(np.count_nonzero(rows.test) // 10, 300, 2500))
    width = min(width, max(s.stop - s.start for s in spans))
    starts = np.concatenate(
        [np.arange(s.start, s.stop - width + 1, max(1, width // 4)) for s in spans if s.stop - s.start >= width]
    )
    errors = squares[starts + width] - squares[starts]
    order = np.argsort(errors, kind="stable")
    motion = np.sqrt(power[starts + width] - power[starts])
    moving = order[(motion >= np.quantile(motion, 0.75) / 2.0)[order]]
    typical, worst = int(starts[moving[moving.size // 2]]), int(starts[order[-1]])
    happens = np.array([_happens(rows, start, width) for start in starts])
    lively = int(starts[np.argmax((happens / np.maximum(happens.max(axis=0), 1e-300)).sum(axis=1))])
    return Windows((typical, typical + width), (worst, worst + width), (lively, lively + width))


def _happens(rows: RunRows, start: int, width: int) -> tuple[float, float]:
    """Change of field and reversals of slip, in means of a fiftieth; below a twentieth of the range is noise."""
    changes, reversals = 0.0, 0.0
    edges = np.linspace(start, start + width, _PARTS + 1).astype(np.int64)[:-1]
    for element in rows.data.elements:
        field, slip = (
            np.add.reduceat(v[: start + width], edges) / (width / _PARTS) for v in (element.field, element.slip)
        )
        moves, least = np.abs(np.diff(field)), _LEAST * float(np.ptp(element.field))
        changes += float(moves[moves > least].sum())
        signs = np.sign(slip[np.abs(slip) > _LEAST * float(np.abs(element.slip).max())])
        reversals += float(np.count_nonzero(np.diff(signs)))
    return changes, reversals
