"""Which logs of a run teach, and which only repeat what the others have shown.

A log repeats the others if nothing is lost without it: no interval of the law's numbers grows by more than a tenth, and
almost all of its rows lie in cells over field and slip that the logs that stay visit too. So a law keeps its intervals,
and a network its rows. The effort is not looked at: a log of another day may repeat the motion of the first and still
show that the device has changed.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from erclutch.logs.dataset import Dataset
from erclutch.models.covered_cells import CELLS
from erclutch.models.law_model import TorqueModel
from erclutch.signals.array import Array
from erclutch.wings.design.information import Knowledge

#: By so much the interval of a number may grow without the logs that repeat others.
ALLOWED_GROWTH = 1.1
#: So many of a log's rows have to lie in cells that other logs visit.
_SEEN_ROWS = 0.99


@dataclass(frozen=True)
class Lessons:
    """What the logs of a run teach.

    Attributes:
        teach: logs without which something is lost, in the order of the run.
        repeat: logs without which, all together, nothing is lost.
        surer: of those that teach, logs whose field and motion the others have too: they only make numbers surer.
        growth: by this factor the interval that grows most is wider without the logs that repeat.
    """

    teach: tuple[str, ...]
    repeat: tuple[str, ...]
    surer: tuple[str, ...]
    growth: float

    def to_dict(self) -> dict[str, Any]:
        """As JSON values."""
        return asdict(self)


def lessons_of(model: TorqueModel, rows: Dataset) -> Lessons:
    """Tell the logs that teach from those that repeat.

    Logs are left out in turn, the log with the least loss first, as long as nothing is lost.

    Args:
        model: the law that was fitted to the rows.
        rows: the rows of all logs. Logs that have none are left out: they were held out whole.
    """
    knowledge = Knowledge(model, rows, 1.0 / rows.period)
    prior = knowledge.prior  # an information matrix, shape (numbers, numbers)
    derivatives = knowledge.sensitivity.rows(rows)
    of_logs: list[Array] = []
    for start, stop in rows.source_rows:
        of_log = derivatives[start:stop]
        of_logs.append(knowledge.weight * (of_log.T @ of_log))
    information = np.array(of_logs)  # shape (logs, numbers, numbers)
    with_all = _standard_errors(prior + information.sum(axis=0))

    # How many rows each log has in each cell over field and slip of each element.
    cells_of_one = CELLS * CELLS
    cells = len(rows.elements) * cells_of_one
    visits = np.zeros((len(rows.sources), cells), np.intp)
    for number, element in enumerate(rows.elements):
        field_cell, slip_cell = model.trained_on.cell(element.field, element.slip)
        cell = np.floor(field_cell) * CELLS + np.floor(slip_cell) + number * cells_of_one
        places = cell.astype(np.intp)
        for log, (start, stop) in enumerate(rows.source_rows):
            np.add.at(visits[log], places[start:stop], 1)

    fitted = [log for log, (start, stop) in enumerate(rows.source_rows) if stop > start]
    kept = list(fitted)
    growth = 1.0
    shown = list(fitted)  # between them they visit what all visit
    while len(shown) > 1:
        losses: list[float] = []
        for log in shown:
            others = [other for other in shown if other != log]
            without = _standard_errors(prior + information[others].sum(axis=0))
            visited = visits[others].any(axis=0)  # cells that the others visit
            own_visits = visits[log]
            share_seen = float(own_visits[visited].sum() / own_visits.sum())
            loss = np.inf
            if share_seen >= _SEEN_ROWS:
                loss = float(np.max(without / with_all))
            losses.append(loss)
        least = min(losses)
        if least == np.inf:
            break
        del shown[losses.index(least)]
        if least <= ALLOWED_GROWTH:
            growth = least
            kept = list(shown)

    names = rows.sources
    return Lessons(
        teach=tuple(names[log] for log in kept),
        repeat=tuple(names[log] for log in fitted if log not in kept),
        surer=tuple(names[log] for log in kept if log not in shown),
        growth=growth,
    )


def _standard_errors(information: Array) -> Array:
    """Standard error of each number, shape (numbers,)."""
    covariance: Any = np.linalg.inv(information)
    variances = np.diag(covariance)
    return np.asarray(np.sqrt(variances), np.float64)
