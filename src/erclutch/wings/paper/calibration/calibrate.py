"""A calibration fits chosen parameters of a rig, within their ranges, to a log or to the paper's summary figures.

Coordinates run from 0 to 1 over the logarithm of a parameter's plausible range (over the range itself where it may be
zero). A target gives weighted residuals for a rig; the plausible range enters as a wide prior round the start.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any, ClassVar, Protocol

import numpy as np

from erclutch.errors import SettingError
from erclutch.fit.intervals import uncertainty
from erclutch.runs.cluster import in_order, task_pool
from erclutch.signals.array import Array
from erclutch.wings.paper.calibration.calibration_search import (
    Residuals,
    SearchProgress,
    difference_quotients,
    in_rounds,
    journal_of,
    local,
    one_sided_quotients,
    wide,
)
from erclutch.wings.paper.sweep_points import Points
from erclutch.wings.rig.twin.parameters import ParameterEntry, RigParameters

__all__ = ["Calibrated", "Calibration", "CalibrationTarget", "calibrate", "value_at"]

#: Standard deviation of the prior, as a share of the range: the range is two of them to either side of its middle.
PRIOR = 0.25


class CalibrationTarget(Protocol):
    """What a rig is calibrated to."""

    @property
    def name(self) -> str:
        """For people: the log's name, or what the figures are of."""
        ...

    ordered: ClassVar[bool]
    """Whether residuals are samples in time: then their spread and correlation give the intervals. Otherwise their
    standard deviation is one by what the target asks for."""

    def residuals(self, rig: RigParameters) -> Array:
        """Weighted differences between the rig and the target, shape (n,)."""
        ...


@dataclass(frozen=True)
class Calibrated:
    """One parameter that was calibrated.

    Attributes:
        path: section.name.
        value, low, high: estimate and 95 % interval.
        start: where the search and the prior started.
        learnt: 1 less the width of the interval over that of the prior: what the target told about it.
        at_bound: "lower", "upper" or None.
    """

    path: str
    value: float
    low: float
    high: float
    start: float
    learnt: float
    at_bound: str | None


@dataclass(frozen=True)
class Calibration:
    """Outcome of a calibration.

    Attributes:
        rig: the start with the new values.
        parameters: what was calibrated.
        target: its name.
        before, after: sum of squared residuals at the start and at the end, without the prior.
        evaluations: how often the rig was simulated.
    """

    rig: RigParameters
    parameters: tuple[Calibrated, ...]
    target: str
    before: float
    after: float
    evaluations: int


def calibrate(
    rig: RigParameters,
    paths: Sequence[str],
    target: CalibrationTarget,
    *,
    seed: int = 1,
    evaluations: int = 0,
    rounds: int = 0,
    workers: int = 2,
    journal: Path | None = None,
    progress: SearchProgress = lambda done, cost: None,
) -> Calibration:
    """Calibrate parameters of a rig.

    Args:
        rig: where to start; a value that was calibrated before starts where that calibration did.
        paths: parameters as section.name.
        target: what to come near.
        seed: of the wide search.
        evaluations: of the wide search (CMA-ES); 0 leaves it out. A log, whose residuals are smooth, is then searched
            locally (Levenberg-Marquardt) from what it found.
        rounds: of the local search of figures, each with an evaluation a parameter; 0 leaves it to the wide search.
        workers: simulations side by side; changes no figure.
        journal: file that keeps each evaluation of figures, and each generation of the wide search: what was
            interrupted goes on from it.
        progress: called with the evaluations done and the best cost so far.

    Raises:
        SettingError: an unknown parameter, one given twice, or none.
    """
    space = _Space(rig, paths)
    settings = {"target": target.name, "paths": list(paths), "seed": seed, "start": space.start.tolist()}
    known = journal_of(journal, settings)
    with _side_by_side(space, target, workers, known) as all_residuals:
        before = target.residuals(space.rig_at(space.start))
        found, count = space.start, 0
        if evaluations:
            found, count = wide(all_residuals, space.start, seed, evaluations, known, progress)
        wide_count = count

        def counted(done: int, cost: float) -> None:
            progress(wide_count + done, cost)

        if target.ordered or not evaluations + rounds:
            found, more = local(all_residuals, found, counted)
            slopes = difference_quotients(all_residuals, found)
        else:
            found, more = in_rounds(all_residuals, found, rounds, counted)
            slopes = one_sided_quotients(all_residuals, found)
    count += more
    after = target.residuals(space.rig_at(found))
    widths = _widths(slopes, after, target.ordered)
    return space.outcome(found, widths, target.name, float(before @ before), float(after @ after), count)


def _widths(slopes: Array, residual: Array, ordered: bool) -> Array:
    """Half widths of 95 % intervals, linearised; the last rows of the slopes are the prior's."""
    from scipy.stats import norm

    quantile = float(norm.ppf(0.975))
    if not ordered:
        return quantile * np.sqrt(np.sum(np.linalg.pinv(np.linalg.qr(slopes, mode="r")) ** 2, axis=1))
    spread = uncertainty(slopes[: residual.size], residual, ordered=True)
    with np.errstate(divide="ignore"):
        return 1.0 / np.sqrt((1.0 / (spread.quantile * spread.errors)) ** 2 + (1.0 / (quantile * PRIOR)) ** 2)


@contextmanager
def _side_by_side(
    space: _Space, target: CalibrationTarget, workers: int, known: Points
) -> Generator[Residuals, None, None]:
    """Residuals at several points: in processes of their own (small arrays would queue for the interpreter's lock).

    The figures of a point are kept as soon as they are there. The samples of a log are too many to keep.
    """
    with task_pool("processes" if workers > 1 else None, workers) as pool:
        if target.ordered:
            yield lambda points: list(in_order(pool, partial(space.residuals, target=target), points))
            return

        def kept(points: Sequence[Array]) -> list[Array]:
            tasks = {sha256(point.tobytes()).hexdigest()[:16]: point for point in points}
            found = known.fill(pool, partial(_numbers, space, target), tasks, lambda done, key: None)
            figures = dict(zip(tasks, found, strict=True))
            return [np.array(figures[sha256(point.tobytes()).hexdigest()[:16]]) for point in points]

        yield kept


def _numbers(space: _Space, target: CalibrationTarget, point: Array) -> list[float]:
    """Residuals at a point as a journal keeps them."""
    return [float(value) for value in space.residuals(point, target)]


class _Space:
    """Coordinates of the chosen parameters."""

    def __init__(self, rig: RigParameters, paths: Sequence[str]) -> None:
        if not paths or len(set(paths)) != len(paths):
            raise SettingError(
                f"parameters to calibrate: {', '.join(paths) or 'none'}", remedy="Name at least one, each once"
            )
        self.rig, self.paths = rig, tuple(paths)
        self.entries = [rig.entry(path) for path in paths]
        starts = [e.value if e.start is None else e.start for e in self.entries]
        for path, entry, value in zip(paths, self.entries, starts, strict=True):
            if not entry.low <= value <= entry.high:
                problem = f"{path} starts at {value:g} {entry.unit}, outside its range {entry.low:g} to {entry.high:g}"
                raise SettingError(problem, remedy="Correct the value or the range", where=rig.name)
        self.start = np.array([_coordinate(e, v) for e, v in zip(self.entries, starts, strict=True)])

    def rig_at(self, u: Array) -> RigParameters:
        """The rig at a point."""
        values = {p: value_at(e, float(x)) for p, e, x in zip(self.paths, self.entries, u, strict=True)}
        return self.rig.changed(values)

    def residuals(self, u: Array, target: CalibrationTarget) -> Array:
        """Residuals of the target and of the prior."""
        return np.concatenate([target.residuals(self.rig_at(u)), (u - self.start) / PRIOR])

    def outcome(
        self, u: Array, widths: Array, target: str, before: float, after: float, evaluations: int
    ) -> Calibration:
        """Values with intervals, clipped to the ranges."""
        found: list[Calibrated] = []
        for i, (path, entry) in enumerate(zip(self.paths, self.entries, strict=True)):
            low, high = (float(np.clip(u[i] + s * widths[i], 0.0, 1.0)) for s in (-1.0, 1.0))
            bound = "lower" if u[i] <= 1e-6 else "upper" if u[i] >= 1.0 - 1e-6 else None
            value, start = value_at(entry, float(u[i])), value_at(entry, float(self.start[i]))
            learnt = max(0.0, 1.0 - float(widths[i]) / (1.96 * PRIOR))
            found.append(Calibrated(path, value, value_at(entry, low), value_at(entry, high), start, learnt, bound))
        values = {c.path: (c.value, c.start, c.low, c.high) for c in found}
        return Calibration(self.rig.calibrated(values), tuple(found), target, before, after, evaluations)


def _coordinate(entry: ParameterEntry, value: float) -> float:
    if entry.low > 0:
        return float(np.log(value / entry.low) / np.log(entry.high / entry.low))
    return (value - entry.low) / (entry.high - entry.low)


def value_at(entry: ParameterEntry, u: float) -> float:
    """The value of a parameter at a coordinate from 0 to 1 over its range."""
    if entry.low > 0:
        value: Any = entry.low * (entry.high / entry.low) ** u
    else:
        value = entry.low + u * (entry.high - entry.low)
    return float(f"{value:.6g}")  # what the file will hold is what was simulated
