"""The ladder of memory: stages are added to the best law as long as blocked validation on the training rows says so.

The training rows are cut into windows, over which all states run through. Every candidate is fitted to every other
window and scored on those between, then the other way round. The best candidate is taken if it lowers the error on
rows that it was not fitted to by at least `WORTH`; the rows held out for the test are never seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from erclutch import registry
from erclutch.fit.laws.fit_law import reference_of
from erclutch.fit.laws.law_problem import separable
from erclutch.fit.laws.shapes_told import shapes_told
from erclutch.fit.laws.variable_projection import coordinates, outer_problem, parameters, project
from erclutch.fit.levenberg_marquardt import minimise
from erclutch.fit.log_groups import chessboard, groups_of
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import ShapeParameter
from erclutch.models.stages import GROUP, NONE, stage_named
from erclutch.models.stages.stage import StageFamily
from erclutch.models.structure import Structure
from erclutch.signals.array import Mask
from erclutch.signals.recording import POSITION, TEMPERATURE

#: Share of the error that a stage must take off.
WORTH = 0.01
#: The same of a stage that sums up the slip: a sensor's zero makes its travel drift, so it must be worth that.
DRIFTING_WORTH = 0.1
_WINDOWS, _FEWEST_WINDOWS = 24, 4  # of a log
_FEWEST_ROWS = 50  # of a window
_MOST_ROWS, _STRETCHES, _FITTED_ROWS = 24_000, 4, 3000
_MANY_LOGS = 12
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


def grown(
    train: Dataset, base: Structure, extras: Sequence[str] = (), among: Sequence[str] | None = None
) -> list[Rung]:
    """The rungs that validation asks for, from the base to the richest.

    Args:
        train: the training rows.
        base: the law to begin with, with its stages on the command.
        extras: further inputs that may get a gain, and the temperature, of which stages may make factors.
        among: names of the stages to try, the simplest of a family first; None: all.
    """
    folds = _folds(train)
    rungs = [_rung(folds, base, {})]
    known = [name for family in families() for name in family] if among is None else among
    stages = [name for name in known if _feels(base, name, extras)]
    left = [*stages, *(f"={name}" for name in extras if name != TEMPERATURE)]
    while left:
        here = rungs[-1]
        left = [name for name in left if name.removeprefix("=") not in here.structure.extras]
        tried = [(name, _rung(folds, _with(here.structure, name), here.numbers)) for name in left if _next(left, name)]
        tried = [(name, rung) for name, rung in tried if rung.error < (1.0 - _worth(name)) * here.error]
        if not tried:
            return rungs
        least = min(rung.error for _, rung in tried)
        # Of those that take off as much, the one with the fewest numbers: a LuGre state is a Dahl state with two more.
        alike = [pair for pair in tried if pair[1].error <= (1.0 + WORTH) * least]
        name, best = min(alike, key=lambda pair: (_numbers(pair[1].structure), pair[1].error))
        rungs.append(best)
        left.remove(name)
    return rungs


def _worth(name: str) -> float:
    """Share of the error that a stage or an input must take off."""
    return DRIFTING_WORTH if not name.startswith("=") and getattr(stage_named(name), "from_the_start", False) else WORTH


def _numbers(structure: Structure) -> int:
    return len(structure.shapes(1.0)) + len(structure.gains())


def of_law(train: Dataset, rung: Rung, law: Structure) -> Rung:
    """The stages and further inputs of a rung with another law."""
    other = replace(law, dynamics=rung.structure.dynamics, extras=rung.structure.extras)
    return _rung(_folds(train), other, rung.numbers)


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
    place = stage_named(name).place
    if place == "position":
        return POSITION in extras
    if place != "temperature":
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


@dataclass(frozen=True)
class _Fold:
    """Rows to fit and rows to score, of stretches over which all states run through.

    Attributes:
        data: the stretches.
        fitted: places of the rows to fit, few.
        scored: mask of the rows to score.
    """

    data: Dataset
    fitted: NDArray[np.intp]
    scored: Mask


def _folds(train: Dataset) -> list[_Fold]:
    """Every other window is fitted and those between are scored, then the other way round.

    States run through: a window that began at rest would hide a memory that is longer than it. Of many logs each is a
    window, fields and motions like the squares of a chessboard: both folds have all of either, but no pair twice.
    """
    many = len(train.source_rows) >= _MANY_LOGS
    data = train if many or train.rows <= _MOST_ROWS else train.take(_stretches(train))
    window = np.zeros(data.rows, np.intp)
    if many:
        logs = groups_of(data)
        for (start, stop), number in zip(logs.rows, chessboard(logs), strict=True):
            window[start:stop] = number
    else:
        for number, (start, stop) in enumerate((a, b) for a, b in data.source_rows if b > a):
            count = _windows(stop - start)
            window[start:stop] = number + np.arange(stop - start) * count // (stop - start)
    odd: Mask = window % 2 == 1
    return [_Fold(data, _few(np.flatnonzero(fitted)), ~fitted) for fitted in (odd, ~odd)]


def _few(rows: NDArray[np.intp]) -> NDArray[np.intp]:
    return rows[:: max(1, -(-rows.size // _FITTED_ROWS))]


def _stretches(train: Dataset) -> Mask:
    """A few long stretches, spread evenly over the rows."""
    length = _MOST_ROWS // _STRETCHES
    mask = np.zeros(train.rows, np.bool_)
    for start in np.linspace(0, train.rows - length, _STRETCHES).round().astype(int).tolist():
        mask[start : start + length] = True
    return mask


def _windows(rows: int) -> int:
    """Number of windows of a log: many, so that either half has all its fields; each has so many rows."""
    return int(np.clip(rows // _FEWEST_ROWS, _FEWEST_WINDOWS, _WINDOWS))


def _rung(folds: Sequence[_Fold], structure: Structure, known: dict[str, float]) -> Rung:
    squares, rows, numbers = 0.0, 0, known
    for fold in folds:
        data = fold.data
        reference = reference_of(data, structure.extras)
        shapes = shapes_told(data, structure, reference)
        problem = separable(data, structure, reference, shapes, fold.fitted)
        starts = [coordinates(shapes, q) for q in _starts(shapes, numbers)]
        minima = [minimise(outer_problem(problem), u, tolerance=1e-4, max_iterations=_STEPS) for u in starts]
        q = parameters(shapes, min(minima, key=lambda minimum: minimum.cost).point)
        columns = structure.columns(data.elements, data.clock, reference, q, extras=data.extras)
        residual = (data.effort - np.column_stack(columns) @ project(problem, q).gains)[fold.scored]
        squares, rows = squares + float(residual @ residual), rows + residual.size
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
