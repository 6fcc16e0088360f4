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
from erclutch.fit.solver.intervals import uncertainty
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

__all__ = [
    "Calibrated",
    "Calibration",
    "CalibrationTarget",
    "calibrate",
    "coordinate_of",
    "value_at",
]

#: Standard deviation of the prior, as a share of the range: the range is two of them to either side of its middle.
PRIOR = 0.25


class CalibrationTarget(Protocol):
    """What a rig is calibrated to."""

    @property
    def name(self) -> str:
        """For people: the log's name, or what the figures are of."""
        ...

    @property
    def digest(self) -> str:
        """What tells the target from another one of its name, such as the rows of a log."""
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
    from scipy.stats import norm

    space = _Space(rig, paths)
    # A journal goes on where all that its figures depend on is the same: what is not varied of the rig, too.
    settings = {
        "target": target.name,
        "digest": target.digest,
        "rig": rig.to_dict(),
        "ranges": {path: [entry.low, entry.high] for path, entry in space.entries.items()},
        "paths": list(paths),
        "seed": seed,
        "start": space.start.tolist(),
    }
    known = journal_of(journal, settings)
    with _side_by_side(space, target, workers, known) as all_residuals:
        before = target.residuals(space.rig_at(space.start))
        best = space.start
        wide_count = 0
        if evaluations:
            best, wide_count = wide(all_residuals, space.start, seed, evaluations, known, progress)

        def counted(done: int, cost: float) -> None:
            progress(wide_count + done, cost)

        if target.ordered or not evaluations + rounds:
            best, local_count = local(all_residuals, best, counted)
            slopes = difference_quotients(all_residuals, best)
        else:
            best, local_count = in_rounds(all_residuals, best, rounds, counted)
            slopes = one_sided_quotients(all_residuals, best)

    after = target.residuals(space.rig_at(best))
    # Half widths of 95 % intervals, linearised; the last rows of the slopes are the prior's.
    quantile = float(norm.ppf(0.975))
    if target.ordered:
        # The samples and the prior are two measurements of one value.
        by_samples = uncertainty(slopes[: after.size], after, ordered=True)
        with np.errstate(divide="ignore"):
            of_samples = 1.0 / (by_samples.quantile * by_samples.errors)
            of_prior = 1.0 / (quantile * PRIOR)
            widths = 1.0 / np.sqrt(of_samples**2 + of_prior**2)
    else:
        # Each residual has a standard deviation of one, so the covariance is the inverse of the squared triangle.
        triangle = np.linalg.qr(slopes, mode="r")
        inverse = np.linalg.pinv(triangle)
        widths = quantile * np.sqrt(np.sum(inverse**2, axis=1))
    parameters = space.calibrated(best, widths)
    entries = {
        number.path: (number.value, number.start, number.low, number.high) for number in parameters
    }
    return Calibration(
        rig.calibrated(entries),
        tuple(parameters),
        target.name,
        before=float(before @ before),
        after=float(after @ after),
        evaluations=wide_count + local_count,
    )


@contextmanager
def _side_by_side(
    space: _Space,
    target: CalibrationTarget,
    workers: int,
    known: Points,
) -> Generator[Residuals, None, None]:
    """Residuals at several points: in processes of their own (small arrays would queue for the interpreter's lock).

    The figures of a point are kept as soon as they are there. The samples of a log are too many to keep.
    """
    with task_pool("processes" if workers > 1 else None, workers) as pool:

        def of_samples(points: Sequence[Array]) -> list[Array]:
            of_rig = partial(space.residuals, target=target)
            return list(in_order(pool, of_rig, points))

        def of_figures(points: Sequence[Array]) -> list[Array]:
            keys = [sha256(point.tobytes()).hexdigest()[:16] for point in points]
            # A point that is asked for twice is one task.
            tasks = dict(zip(keys, points, strict=True))
            residuals = partial(space.listed_residuals, target=target)
            figures = known.fill(pool, residuals, tasks, lambda done, key: None)
            by_key = dict(zip(tasks, figures, strict=True))
            return [np.array(by_key[key]) for key in keys]

        yield of_samples if target.ordered else of_figures


class _Space:
    """Coordinates of the chosen parameters."""

    def __init__(self, rig: RigParameters, paths: Sequence[str]) -> None:
        if not paths or len(set(paths)) != len(paths):
            named = ", ".join(paths) or "none"
            raise SettingError(
                f"parameters to calibrate: {named}", remedy="Name at least one, each once"
            )
        self.rig = rig
        self.entries = {path: rig.entry(path) for path in paths}
        start: list[float] = []
        for path, entry in self.entries.items():
            value = entry.value if entry.start is None else entry.start
            if not entry.low <= value <= entry.high:
                problem = f"{path} starts at {value:g} {entry.unit}, outside its range {entry.low:g} to {entry.high:g}"
                raise SettingError(problem, remedy="Correct the value or the range", where=rig.name)
            start.append(coordinate_of(entry, value))
        self.start = np.array(start)

    def rig_at(self, point: Array) -> RigParameters:
        """The rig at a point."""
        values: dict[str, float] = {}
        coordinates = zip(self.entries.items(), point.tolist(), strict=True)
        for (path, entry), coordinate in coordinates:
            values[path] = value_at(entry, coordinate)
        return self.rig.changed(values)

    def residuals(self, point: Array, target: CalibrationTarget) -> Array:
        """Residuals of the target and of the prior."""
        of_target = target.residuals(self.rig_at(point))
        of_prior = (point - self.start) / PRIOR
        return np.concatenate([of_target, of_prior])

    def listed_residuals(self, point: Array, target: CalibrationTarget) -> list[float]:
        """Residuals as a journal keeps them."""
        return [float(residual) for residual in self.residuals(point, target)]

    def calibrated(self, point: Array, widths: Array) -> list[Calibrated]:
        """Values with intervals, clipped to the ranges."""
        parameters: list[Calibrated] = []
        rows = zip(self.entries.items(), point, widths, self.start, strict=True)
        for (path, entry), coordinate, width, start in rows:
            low = float(np.clip(coordinate - width, 0.0, 1.0))
            high = float(np.clip(coordinate + width, 0.0, 1.0))
            at_bound = None
            if coordinate <= 1e-6:
                at_bound = "lower"
            elif coordinate >= 1.0 - 1e-6:
                at_bound = "upper"
            parameter = Calibrated(
                path,
                value=value_at(entry, float(coordinate)),
                low=value_at(entry, low),
                high=value_at(entry, high),
                start=value_at(entry, float(start)),
                learnt=max(0.0, 1.0 - float(width) / (1.96 * PRIOR)),
                at_bound=at_bound,
            )
            parameters.append(parameter)
        return parameters


def coordinate_of(entry: ParameterEntry, value: float) -> float:
    """The coordinate from 0 to 1 of a value: `value_at` the other way round."""
    if entry.low > 0:
        along = np.log(value / entry.low)
        whole = np.log(entry.high / entry.low)
        return float(along / whole)
    return (value - entry.low) / (entry.high - entry.low)


def value_at(entry: ParameterEntry, u: float) -> float:
    """The value of a parameter at a coordinate from 0 to 1 over its range."""
    if entry.low > 0:
        value: Any = entry.low * (entry.high / entry.low) ** u
    else:
        value = entry.low + u * (entry.high - entry.low)
    return float(f"{value:.6g}")  # what the file will hold is what was simulated
