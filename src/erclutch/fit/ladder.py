"""The ladder of memory: stages are added to the best law as long as blocked validation on the training rows says so.

The training rows are cut into windows. Every candidate is fitted to every other window and scored on those between,
then the other way round. The best candidate is taken if it lowers the error on rows that it was not fitted to by at
least `WORTH`; the rows held out for the test are never seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from erclutch import registry
from erclutch.fit.laws.fit_law import reference_of, separable
from erclutch.fit.laws.law_starts import thinned
from erclutch.fit.laws.variable_projection import coordinates, outer_problem, parameters, project
from erclutch.fit.levenberg_marquardt import minimise
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import Structure
from erclutch.models.laws import ShapeParameter
from erclutch.models.stages import GROUP, NONE, stage_named
from erclutch.models.stages.stage import StageFamily
from erclutch.signals.array import Mask
from erclutch.signals.recording import TEMPERATURE

#: Share of the error that a stage must take off.
WORTH = 0.01
_WINDOWS, _MOST_ROWS, _FITTED_ROWS = 24, 20_000, 3000
_STEPS = 15
_PLACES = (0.15, 0.5, 0.85)  # of a new constant's usual range, where its search starts


@dataclass(frozen=True)
class Rung:
    """A structure on the ladder.

    Attributes:
        structure: the law with its stages.
        error: RMSE on rows that it was not fitted to.
        numbers: its nonlinear parameters by name, in normalised units, as found on part of the rows.
    """

    structure: Structure
    error: float
    numbers: dict[str, float]


def grown(train: Dataset, base: Structure, extras: Sequence[str] = ()) -> list[Rung]:
    """The rungs that validation asks for, from the base to the richest.

    Args:
        train: the training rows.
        base: the law to begin with, with its stages on the command.
        extras: further inputs that may get a gain, and the temperature, of which stages may make factors.
    """
    folds = _folds(train)
    rungs = [_rung(folds, base, {})]
    stages = [name for family in families() for name in family if _feels(base, name, extras)]
    left = [*stages, *(f"={name}" for name in extras if name != TEMPERATURE)]
    while left:
        here = rungs[-1]
        tried = [(name, _rung(folds, _with(here.structure, name), here.numbers)) for name in left if _next(left, name)]
        name, best = min(tried, key=lambda pair: pair[1].error)
        if not best.error < (1.0 - WORTH) * here.error:
            return rungs
        rungs.append(best)
        left.remove(name)
    return rungs


def helpful(train: Dataset, rung: Rung) -> dict[str, float]:
    """The spare columns of the log that would lower the error of a rung, as a share of it, most helpful first."""
    if not train.spare:
        return {}
    folds = _folds(replace(train, extras={**train.extras, **train.spare}))
    tried = {
        name: 1.0 - _rung(folds, _with(rung.structure, f"={name}"), rung.numbers).error / rung.error
        for name in train.spare
    }
    return {name: gain for name, gain in sorted(tried.items(), key=lambda item: -item[1]) if gain >= WORTH}


def families() -> list[tuple[str, ...]]:
    """Names of the stages that users can add, a family each, from the simplest to the richest."""
    values = (plugin.value for plugin in registry.plugins(GROUP) if plugin.own)
    return [value.ladder for value in values if isinstance(value, StageFamily) and value.ladder]


def _feels(base: Structure, name: str, extras: Sequence[str]) -> bool:
    """Whether a stage can do anything: one on the temperature needs it, and a law whose effort it knows apart."""
    if stage_named(name).place != "temperature":
        return True
    return TEMPERATURE in extras and set(base.law.parts) >= {"yield", "viscous"}


def _next(left: Sequence[str], name: str) -> bool:
    """Whether no simpler stage of the same family is left."""
    family = next((family for family in families() if name in family), (name,))
    return next(each for each in family if each in left) == name


def _with(structure: Structure, name: str) -> Structure:
    """The structure with a stage, in place of a simpler one of its family; or with a further input."""
    if name.startswith("="):
        return replace(structure, extras=(*structure.extras, name[1:]))
    return replace(structure, dynamics=with_stage(structure.dynamics, name))


def with_stage(dynamics: str, name: str) -> str:
    """The stages with one more, in place of a simpler one of its family."""
    family = next(family for family in families() if name in family)
    kept = [each for each in dynamics.split("+") if each not in (*family, NONE)]
    return "+".join([*kept, name])


def _folds(train: Dataset) -> list[tuple[Dataset, Dataset]]:
    """Rows to fit and rows to score: windows of neighbouring rows, or whole logs where there are many."""
    windows = list(_windows(train))
    parts = [train.take(np.logical_or.reduce(windows[first::2])) for first in (0, 1)]
    return [(parts[0], parts[1]), (parts[1], parts[0])]


def _windows(train: Dataset) -> Iterator[Mask]:
    if len(train.source_rows) >= _WINDOWS // 2:
        places = list(train.source_rows)
    else:
        length = min(_MOST_ROWS, train.rows) // _WINDOWS
        starts = np.linspace(0, train.rows - length, _WINDOWS).round().astype(int)
        places = [(int(start), int(start) + length) for start in starts]
    for start, stop in places:
        mask = np.zeros(train.rows, np.bool_)
        mask[start:stop] = True
        yield mask


def _rung(folds: Sequence[tuple[Dataset, Dataset]], structure: Structure, known: dict[str, float]) -> Rung:
    squares, rows, numbers = 0.0, 0, known
    for fitted, scored in folds:
        reference = reference_of(fitted, structure.extras)
        shapes = structure.shapes(reference.period)
        problem = separable(fitted, structure, reference, shapes, thinned(fitted.rows, _FITTED_ROWS))
        starts = [coordinates(shapes, q) for q in _starts(shapes, numbers)]
        minima = [minimise(outer_problem(problem), u, tolerance=1e-4, max_iterations=_STEPS) for u in starts]
        q = parameters(shapes, min(minima, key=lambda minimum: minimum.cost).point)
        columns = structure.columns(scored.elements, scored.clock, reference, q, extras=scored.extras)
        residual = scored.effort - np.column_stack(columns) @ project(problem, q).gains
        squares, rows = squares + float(residual @ residual), rows + scored.rows
        numbers = dict(zip((shape.name for shape in shapes), q, strict=True))
    return Rung(structure, (squares / rows) ** 0.5, numbers)


def _starts(shapes: Sequence[ShapeParameter], known: dict[str, float]) -> list[list[float]]:
    """Where the search starts: the numbers that are known, and several places for the new ones."""
    starts = [
        [known.get(s.name, _between(*s.scanned, place, log=s.scale == "log")) for s in shapes] for place in _PLACES
    ]
    return starts if any(s.name not in known for s in shapes) else starts[:1]


def _between(low: float, high: float, place: float, *, log: bool) -> float:
    return float(low * (high / low) ** place) if log else low + place * (high - low)
