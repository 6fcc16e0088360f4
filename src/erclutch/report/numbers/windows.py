"""Two sections of a log deserve a close look: where the model does as well as usual, and where it does worst."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from erclutch.report.numbers.correlation import held_out_spans
from erclutch.runs.run_rows import RunRows


@dataclass(frozen=True)
class Windows:
    """Rows [start, stop) of two sections of the rows held out.

    Attributes:
        typical: a section with the median error of all sections of that length.
        worst: the one with the largest.
    """

    typical: tuple[int, int]
    worst: tuple[int, int]


def windows(rows: RunRows, model: str) -> Windows:
    """Sections of a tenth of the rows held out, 300 to 2500 rows, that do not cross a gap."""
    residual = rows.residual(model)
    squares = np.concatenate([[0.0], np.cumsum(residual * residual)])
    spans = held_out_spans(rows)
    width = int(np.clip(np.count_nonzero(rows.test) // 10, 300, 2500))
    width = min(width, max(s.stop - s.start for s in spans))
    starts = np.concatenate(
        [np.arange(s.start, s.stop - width + 1, max(1, width // 4)) for s in spans if s.stop - s.start >= width]
    )
    errors = squares[starts + width] - squares[starts]
    order = np.argsort(errors, kind="stable")
    typical, worst = int(starts[order[order.size // 2]]), int(starts[order[-1]])
    return Windows((typical, typical + width), (worst, worst + width))
