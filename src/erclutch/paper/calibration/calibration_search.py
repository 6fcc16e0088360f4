"""The two searches of a calibration: wide (CMA-ES, for figures that jitter) and local (Levenberg-Marquardt)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import RunError, SettingError
from erclutch.fit.lm import Linearisation, Problem, minimise

Array = NDArray[np.float64]
Residuals = Callable[[Sequence[Array]], list[Array]]
#: Called with the evaluations done and the best sum of squares so far.
Progress = Callable[[int, float], None]

_POPULATION = 16
_FIRST_WIDTH = 0.08  # standard deviation of the first generation, as a share of the range


def wide(
    residuals: Residuals,
    start: Array,
    seed: int,
    evaluations: int,
    journal: Path | None,
    settings: Mapping[str, Any],
    progress: Progress,
) -> tuple[Array, int]:
    """Covariance matrix adaptation (CMA-ES) over the unit cube; resumes from the costs in its journal.

    Returns:
        The best point evaluated and how many were.

    Raises:
        SettingError: the package cma is missing.
        RunError: the journal is of another search, or cannot be written.
    """
    try:
        cma: Any = import_module("cma")
    except ImportError as error:
        raise SettingError("the wide search needs the package cma", remedy="pip install erclutch[calibrate]") from error
    options = {"bounds": [0.0, 1.0], "popsize": _POPULATION, "seed": seed + 1, "verbose": -9, "verb_log": 0}
    strategy = cma.CMAEvolutionStrategy(start.tolist(), _FIRST_WIDTH, options)
    known = _Journal(journal, settings)
    best, best_cost, done = start, np.inf, 0
    while done < evaluations:
        points = [np.asarray(p, np.float64) for p in strategy.ask()]
        costs = known.next()
        if costs is None:
            costs = [_cost(r) for r in residuals(points)]
            known.keep(costs)
        strategy.tell(points, costs)
        done += len(points)
        if min(costs) < best_cost:
            best, best_cost = points[int(np.argmin(costs))], min(costs)
        progress(done, best_cost)
    return best, done


def _cost(r: Array) -> float:
    return float(r @ r) if np.all(np.isfinite(r)) else 1e9


class _Journal:
    """Costs of each generation. The points follow from seed and costs, so these are all that a resumed search needs."""

    def __init__(self, path: Path | None, settings: Mapping[str, Any]) -> None:
        self.path = path
        self.digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()
        self.left: list[list[float]] = []
        if path is None or not path.exists():
            return
        try:
            text = path.read_text(encoding="utf-8")
            whole = text[: text.rfind("\n") + 1]
            if whole != text:  # a last line that a power cut tore
                path.write_text(whole, encoding="utf-8")
            lines = [json.loads(line) for line in whole.splitlines()]
            kept = [[float(c) for c in line["costs"]] for line in lines if line["search"] == self.digest]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise RunError(f"no journal of a calibration: {error}", where=str(path), remedy="Delete it") from error
        if len(kept) != len(lines) or any(len(costs) != _POPULATION for costs in kept):
            raise RunError(
                "the journal is of a calibration with other settings", where=str(path), remedy="Delete it, or move it"
            )
        self.left = kept

    def next(self) -> list[float] | None:
        """Costs of the next generation, if they are known."""
        return self.left.pop(0) if self.left else None

    def keep(self, costs: list[float]) -> None:
        """Append the costs of a generation."""
        if self.path is None:
            return
        try:
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"search": self.digest, "costs": costs}) + "\n")
        except OSError as error:
            raise RunError(
                f"the journal cannot be written: {error.strerror}", where=str(self.path), remedy="Give another place"
            ) from error


def local(residuals: Residuals, start: Array, step: float, progress: Progress) -> tuple[Array, int]:
    """Levenberg-Marquardt in the unit cube with slopes by differences.

    Returns:
        The point found and how many were evaluated.
    """
    from erclutch.calibrate import difference_quotients

    count, best = 0, np.inf

    def cost(u: Array) -> float:
        nonlocal count, best
        count += 1
        found = _cost(residuals([u])[0])
        best = min(best, found)
        progress(count, best)
        return found

    def linearise(u: Array) -> Linearisation:
        nonlocal count
        count += 1 + 2 * u.size
        r = residuals([u])[0]
        q, triangle = np.linalg.qr(difference_quotients(residuals, u, 0.25 * step))
        return Linearisation(_cost(r), triangle, -(q.T @ r))

    problem = Problem(cost, linearise, np.zeros(start.size), np.ones(start.size))
    return minimise(problem, start, tolerance=1e-6, max_iterations=30, reach=0.3).point, count
