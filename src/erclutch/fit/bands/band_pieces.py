"""What a band holds of each log, and of one log of each second: or of a longer stretch, where a second has few rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Mask

#: Rows that a stretch has at least: of fewer no share as large as a band's is told.
_FEWEST_ROWS = 20
#: Of a period, as a share: a log at 20 Hz whose stamps are rounded has seconds.
_ROUNDING = 1e-3


def log_of(data: Dataset, rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """Number of the log of some rows."""
    return np.searchsorted([stop for _, stop in data.source_rows], rows, side="right")


def kind_of_pieces(data: Dataset) -> str:
    """What a piece of these rows is called: a log, a second or a longer stretch; "": points have no pieces."""
    if len(data.sources) > 1:
        return "log"
    if data.in_no_time:
        return ""
    length_s = _length_s(data)
    return "second" if length_s == 1 else f"{length_s} s"


def pieces(data: Dataset, rows: Mask) -> list[tuple[str, NDArray[np.intp]]]:
    """Logs, or stretches where the rows are of one log, with the places of their rows; points have no stretches.

    Stretches with less than half as many rows as usual are left out: they begin or end a segment.
    """
    places = np.flatnonzero(rows)
    log = log_of(data, places)
    if np.ptp(log):
        logs: list[tuple[str, NDArray[np.intp]]] = []
        for number in np.unique(log):
            logs.append((str(data.sources[int(number)]), places[log == number]))
        return logs

    if data.in_no_time:
        return [(f"{places.size} points", places)]
    called = kind_of_pieces(data)
    stretch = (np.arange(places.size) * data.period / _length_s(data)).astype(np.intp)
    stretches: list[tuple[str, NDArray[np.intp]]] = []
    for number in np.unique(stretch):
        own = places[stretch == number]
        stretches.append((f"the {called} from {data.clock.moment(int(own[0]))} on", own))
    few = 0.5 * float(np.median([own.size for _, own in stretches]))
    return [(name, own) for name, own in stretches if own.size >= few]


def _length_s(data: Dataset) -> int:
    """Seconds of a stretch: one, or the fewest of 2, 5, 10, 20, 50 ... that have rows enough."""
    wanted_s = _FEWEST_ROWS * data.period * (1.0 - _ROUNDING)
    scale = 1
    while True:
        for step in (1, 2, 5):
            if step * scale >= wanted_s:
                return step * scale
        scale *= 10
