"""The ladder of memory: stages are added to the best law as long as blocked validation on the training rows says so.

The training rows are cut into windows, over which all states run through. Every candidate is fitted to every other
window and scored on those between, then the other way round. The best candidate is taken if it lowers the error on
rows that it was not fitted to by at least `WORTH`; the rows held out for the test are never seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from erclutch import registry
from erclutch.fit.checks.data_check import steady_command
from erclutch.fit.choice.scoring import independent_rows
from erclutch.fit.laws.fit_law import reference_of
from erclutch.fit.laws.law_problem import separable
from erclutch.fit.laws.shapes_told import shapes_told
from erclutch.fit.log_groups import chessboard, groups_of
from erclutch.fit.solver.levenberg_marquardt import minimise
from erclutch.fit.solver.variable_projection import coordinates, outer_problem, parameters, project
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import ShapeParameter
from erclutch.models.laws.yield_stress import POWER, TANH
from erclutch.models.stages import GROUP, NONE, stage_named
from erclutch.models.stages.stage import StageFamily
from erclutch.models.structure import Structure
from erclutch.signals.array import Array, Mask, rms
from erclutch.signals.recording import POSITION, TEMPERATURE

#: Share of the error that a stage must take off.
WORTH = 0.01
#: The same of a stage that sums up the slip: a sensor's zero makes its travel drift, so it must be worth that.
DRIFTING_WORTH = 0.1
#: Such a stage is tried only where its columns, at some of its numbers, take that share off the error of the rows that
#: they are fitted to, beside the law's columns as they are.
_SHOWING = 0.05
_SHOWING_PLACES = (0.1, 0.3, 0.5, 0.7, 0.9)
#: Windows of a log: many, so that either half has all of its fields, but each with so many rows.
_WINDOWS = 24
_FEWEST_WINDOWS = 4
_FEWEST_ROWS = 50
#: Rows over which states run through: that many, in so many long stretches; of them that many are fitted.
_MOST_ROWS = 24_000
#: The same of a whole log, where a stage that counts from its start shows.
_MOST_WHOLE_ROWS = 100_000
_STRETCHES = 4
_FITTED_ROWS = 3000
#: Logs from which on each log is a window.
_MANY_LOGS = 12
#: Training rows for each number of a fit, below which no stage is added: a hundred rows would get seven stages.
_ROWS_A_NUMBER = 10
#: Steps of a solver from each start, and where in the usual range of a new constant its searches start.
_STEPS = 15
_PLACES = (0.15, 0.5, 0.85)
#: Widest edge of plays, over the noise of the field, from which on they tell more than that noise is smoothed.
_EDGE_OVER_NOISE = 4.0
#: Standard deviation of white noise over the median size of its second differences.
_DEVIATION_OF_BEND = 1.0 / (0.6745 * 6.0**0.5)
#: Correlation from which a column is the effort, or the power that the effort makes, in other numbers.
_OF_THE_EFFORT = 0.999


@dataclass(frozen=True)
class Rung:
    """A structure on the ladder.

    Attributes:
        structure: the law with its stages.
        error: RMSE on rows that it was not fitted to.
        numbers: its nonlinear parameters by name, in normalised units, as found on part of the rows.
        independent: how many independent rows the error is known by; without end where each log is a window.
    """

    structure: Structure
    error: float
    numbers: dict[str, float]
    independent: float

    @property
    def numbers_of_fit(self) -> int:
        """How many numbers a fit of the structure has."""
        return _numbers_of_fit(self.structure)


def grown(
    train: Dataset,
    base: Structure,
    extras: Sequence[str] = (),
    among: Sequence[str] | None = None,
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
    known = among
    if known is None:
        known = [name for family in families() for name in family]
    # What may still be added: stages by their names, and further inputs as ``=NAME``.
    left = [name for name in known if _feels(train, base, name, extras)]
    left += [f"={name}" for name in extras if name != TEMPERATURE]
    while left:
        here = rungs[-1]
        left = [name for name in left if name.removeprefix("=") not in here.structure.extras]
        tried = [name for name in left if _next(left, name) and _has_company(here.structure, name)]
        counting = [name for name in tried if _counts_from_the_start(name)]
        showing = [name for name in counting if _shows(train, here, _with(here.structure, name))]
        if showing and folds[0].data.rows < min(train.rows, _MOST_WHOLE_ROWS):
            # From here on the whole log counts: in a stretch that is cut out of it such a stage would begin anew.
            folds = _folds(train, whole=True)
            here = _rung(folds, here.structure, here.numbers)
            rungs[-1] = here
        worthy: dict[str, Rung] = {}
        for name in tried:
            if name in counting and name not in showing:
                continue
            richer = _with(here.structure, name)
            if _numbers_of_fit(richer) * _ROWS_A_NUMBER > train.rows:
                continue
            rung = _rung_above(folds, here, richer)
            drifts = name in counting
            if _edge_in_noise(train, rung, name):
                continue
            worth = max(DRIFTING_WORTH if drifts else WORTH, _by_chance(here, rung))
            if rung.error < (1.0 - worth) * here.error:
                worthy[name] = rung
        if not worthy:
            break

        # Of those that take off as much, the one with the fewest numbers: a LuGre state is a Dahl state with two more.
        best = min(worthy.values(), key=lambda rung: rung.error)
        alike = [
            name
            for name, rung in worthy.items()
            if rung.error <= (1.0 + WORTH) * best.error or best.error >= (1.0 - _by_chance(rung, best)) * rung.error
        ]
        taken = min(alike, key=lambda name: (worthy[name].numbers_of_fit, worthy[name].error))
        rungs.append(worthy[taken])
        left.remove(taken)
    rungs[-1] = _without_idle(folds, rungs[-1], base)
    return rungs


def _without_idle(folds: Sequence[_Fold], rung: Rung, base: Structure) -> Rung:
    """The rung without the stages of the base, where unseen rows do not miss them.

    Before anything told of a spring, say, a lag took some of its effort for its own. Now that the rung has the spring,
    the lag may have nothing left to say.
    """
    if base.dynamics == NONE or rung.structure == base:
        return rung
    of_base = base.dynamics.split("+")
    kept = [name for name in rung.structure.dynamics.split("+") if name not in of_base]
    fewer = replace(rung.structure, dynamics="+".join(kept) or NONE)
    leaner = _rung(folds, fewer, rung.numbers)
    worth = max(WORTH, _by_chance(leaner, rung))
    return leaner if rung.error >= (1.0 - worth) * leaner.error else rung


def _counts_from_the_start(name: str) -> bool:
    """Whether a name on the ladder is a stage that does."""
    return not name.startswith("=") and bool(getattr(stage_named(name), "from_the_start", ""))


def _rung_above(folds: Sequence[_Fold], here: Rung, richer: Structure) -> Rung:
    """The rung of a richer structure, from the numbers of the rung here on.

    Iron that keeps a field saturates too, and either shows little without the other. So where the iron is new, a yield
    effort that saturates is tried beside a power of the field.
    """
    rung = _rung(folds, richer, here.numbers)
    if of_iron(richer) and not of_iron(here.structure) and richer.law.yield_form is POWER:
        bent = _rung(folds, richer.with_yield_form(TANH), here.numbers)
        if bent.error < (1.0 - WORTH) * rung.error:
            return bent
    return rung


def of_iron(structure: Structure) -> bool:
    """Whether a stage keeps the field as iron does."""
    return any(getattr(stage, "of_iron", False) for stage in structure.stages)


def _shows(train: Dataset, here: Rung, richer: Structure) -> bool:
    """Whether a further stage may take a share of the error off, by its columns beside those of the rung as they are.

    No search is made: one of a stage that counts from the start runs over the whole log, and few logs need the stage.
    """
    reference = reference_of(train, richer.extras)
    shapes = shapes_told(train, richer, reference)
    every = -(-train.rows // _FITTED_ROWS)  # rounded up
    effort = train.effort[::every]
    errors: list[float] = []
    for structure in (here.structure, richer):
        names = [shape.name for shape in structure.shapes(reference.period)]
        own = [shape for shape in shapes if shape.name in names]
        for q in _starts(own, here.numbers, _SHOWING_PLACES):
            columns = structure.columns(
                train.elements, train.clock, reference, q, slice(None, None, every), extras=train.extras
            )
            beside = np.column_stack(columns)
            if not np.isfinite(beside).all():
                errors.append(np.inf)
                continue
            gains, *_ = np.linalg.lstsq(beside, effort, rcond=None)
            errors.append(rms(effort - beside @ gains))
    return min(errors) < (1.0 - _SHOWING) * errors[0]


def _by_chance(simpler: Rung, richer: Rung) -> float:
    """The share of the error that further numbers take off by chance.

    A number takes the squares of one independent row off the rows that it is fitted to. Noise that swings over more
    rows than a window has is the same in the rows between, so such numbers seem to help there too.
    """
    more = max(richer.numbers_of_fit - simpler.numbers_of_fit, 0)
    return 1.0 - max(1.0 - more / richer.independent, 0.0) ** 0.5


def _numbers_of_fit(structure: Structure) -> int:
    """How many numbers a fit has, nonlinear ones and gains."""
    shapes = structure.shapes(1.0)
    gains = structure.gains()
    return len(shapes) + len(gains)


def of_law(train: Dataset, rung: Rung, law: Structure) -> Rung:
    """The stages and further inputs of a rung with another law; it saturates where the iron of the rung does."""
    other = replace(law, dynamics=rung.structure.dynamics, extras=rung.structure.extras)
    if of_iron(other) and rung.structure.law.yield_form is TANH and other.law.yield_form is POWER:
        other = other.with_yield_form(TANH)
    folds = _folds(train, whole=rung.structure.counts_from_the_start)
    return _rung(folds, other, rung.numbers)


def helpful(train: Dataset, rung: Rung) -> dict[str, float]:
    """The spare columns of the log that would lower the error of a rung, as a share of it, most helpful first.

    Left out is a column that was made of the effort itself, such as a power: no controller has it before the effort.
    """
    spare = {name: column for name, column in train.spare.items() if not _holds_the_effort(train, column)}
    if not spare:
        return {}
    wide = replace(train, extras={**train.extras, **spare})
    folds = _folds(wide, whole=rung.structure.counts_from_the_start)
    gains: dict[str, float] = {}  # share of the error that each column takes off
    for name in spare:
        wider = _rung(folds, _with(rung.structure, f"={name}"), rung.numbers)
        gains[name] = 1.0 - wider.error / rung.error
    most_helpful_first = sorted(gains.items(), key=lambda item: -item[1])
    return {name: gain for name, gain in most_helpful_first if gain >= WORTH}


def _holds_the_effort(train: Dataset, column: Array) -> bool:
    """Whether a column goes straight with the effort, or with the power that the effort makes with a slip."""
    powers = [train.effort * element.slip for element in train.elements]
    for made in (train.effort, *powers):
        both_change = np.ptp(made) > 0.0 and np.ptp(column) > 0.0
        if both_change and abs(np.corrcoef(column, made)[0, 1]) > _OF_THE_EFFORT:
            return True
    return False


def families() -> list[tuple[str, ...]]:
    """Names of the stages that users can add, a family each, from the simplest to the richest."""
    return [family.ladder for family in _families()]


def _families() -> Iterator[StageFamily]:
    """The families of stages that the ladder tries."""
    for plugin in registry.plugins(GROUP):
        # Installing a package changes no figure: another package's stages are asked for by name.
        if plugin.own and isinstance(plugin.value, StageFamily) and plugin.value.ladder:
            yield plugin.value


def _feels(
    train: Dataset,
    base: Structure,
    name: str,
    extras: Sequence[str],
) -> bool:
    """Whether a stage can do anything: one on the temperature needs it, and a law whose effort it knows apart."""
    place = stage_named(name).place
    if place == "command":
        return not steady_command(train)
    if place == "position":
        return POSITION in extras
    if place != "temperature":
        return True
    return TEMPERATURE in extras and set(base.law.parts) >= {"yield", "viscous"}


def _next(left: Sequence[str], name: str) -> bool:
    """Whether no simpler stage of the same family is left; a further input is a family of its own."""
    family = next((family for family in families() if name in family), (name,))
    simplest = next(each for each in family if each in left)
    return simplest == name


def _edge_in_noise(train: Dataset, rung: Rung, name: str) -> bool:
    """Whether the edge of a stage lies in the noise of a measured field: it smooths the noise, and no iron is told."""
    edge = next((family.edge for family in _families() if name in family.ladder), "")
    if not edge:
        return False
    noise = max(_noise(element.field) for element in train.elements)
    reference = reference_of(train)
    return rung.numbers[edge] * reference.field < _EDGE_OVER_NOISE * noise


def _noise(signal: Array) -> float:
    """The standard deviation of noise from row to row, by the bends; none of a command that stands still or ramps."""
    bends = np.abs(np.diff(signal, 2))
    return float(np.median(bends)) * _DEVIATION_OF_BEND if bends.size else 0.0


def _has_company(structure: Structure, name: str) -> bool:
    """Whether the structure has what the stage stands beside: a second ripple is what the first leaves."""
    beside = next((family.beside for family in _families() if name in family.ladder), "")
    if not beside:
        return True
    stages = structure.dynamics.split("+")
    company = next((family for family in families() if family[0] == beside), ())
    return any(stage in stages for stage in company)


def _with(structure: Structure, name: str) -> Structure:
    """The structure with a stage, in place of a simpler one of its family; or with a further input."""
    if name.startswith("="):
        return replace(structure, extras=(*structure.extras, name[1:]))
    return replace(structure, dynamics=with_stage(structure.dynamics, name))


def with_stage(dynamics: str, name: str) -> str:
    """The stages with one more, in place of a simpler one of its family."""
    family = next(family for family in families() if name in family)
    kept = [each for each in dynamics.split("+") if each not in (*family, NONE)]
    if stage_named(name).place == "command":
        # Ahead of the lag: what stays behind the command itself does not move with the lag's numbers, so that a solver
        # meets no corners where these change.
        return "+".join([name, *kept])
    return "+".join([*kept, name])


@dataclass(frozen=True)
class _Fold:
    """Rows to fit and rows to score, of stretches over which all states run through.

    Attributes:
        data: the stretches, of n rows.
        fitted: places of the rows to fit, few.
        scored: mask of the rows to score, shape (n,).
    """

    data: Dataset
    fitted: NDArray[np.intp]
    scored: Mask


def _folds(train: Dataset, *, whole: bool = False) -> list[_Fold]:
    """Every other window is fitted and those between are scored, then the other way round.

    States run through: a window that began at rest would hide a memory that is longer than it. Of many logs each is a
    window, fields and motions like the squares of a chessboard: both folds have all of either, but no pair twice.
    """
    many = len(train.source_rows) >= _MANY_LOGS
    data = train
    most = _MOST_WHOLE_ROWS if whole else _MOST_ROWS
    if not many and train.rows > most:
        # A few long stretches, spread evenly over the rows.
        length = most // _STRETCHES
        starts = np.linspace(0, train.rows - length, _STRETCHES)
        kept = np.zeros(train.rows, np.bool_)
        for start in starts.round().astype(int).tolist():
            kept[start : start + length] = True
        data = train.take(kept)

    window = np.zeros(data.rows, np.intp)  # number of each row's window
    if many:
        logs = groups_of(data)
        for (start, stop), number in zip(logs.rows, chessboard(logs), strict=True):
            window[start:stop] = number
    else:
        filled = [(start, stop) for start, stop in data.source_rows if stop > start]
        for number, (start, stop) in enumerate(filled):
            rows = stop - start
            count = int(np.clip(rows // _FEWEST_ROWS, _FEWEST_WINDOWS, _WINDOWS))
            window[start:stop] = number + np.arange(rows) * count // rows

    odd: Mask = window % 2 == 1
    folds: list[_Fold] = []
    for fitted in (odd, ~odd):
        places = np.flatnonzero(fitted)
        every = max(1, -(-places.size // _FITTED_ROWS))  # rounded up
        folds.append(_Fold(data, places[::every], ~fitted))
    return folds


def _rung(folds: Sequence[_Fold], structure: Structure, known: dict[str, float]) -> Rung:
    """A structure fitted to each fold and scored on the rows between, from the numbers that are known on."""
    numbers = known
    data = folds[0].data  # of all folds
    residual = np.empty(data.rows)  # of each row by the fit that did not score it
    reference = reference_of(data, structure.extras)
    shapes = shapes_told(data, structure, reference)
    for fold in folds:
        problem = separable(data, structure, reference, shapes, fold.fitted)
        points = [coordinates(shapes, start) for start in _starts(shapes, numbers)]
        ended = [minimise(outer_problem(problem), u, tolerance=1e-4, max_iterations=_STEPS) for u in points]
        best = min(ended, key=lambda minimum: minimum.cost)
        q = parameters(shapes, best.point)
        gains = project(problem, q).gains

        # Over all rows of the fold, so that states run through; then those that were not fitted.
        columns = structure.columns(data.elements, data.clock, reference, q, extras=data.extras)
        estimated = np.column_stack(columns) @ gains
        residual[fold.scored] = (data.effort - estimated)[fold.scored]
        # The next fold starts where this one ended.
        numbers = dict(zip((shape.name for shape in shapes), q, strict=True))
    error = rms(residual)
    neighbours = len(data.source_rows) < _MANY_LOGS and np.isfinite(error)
    independent = independent_rows(residual) if neighbours else np.inf
    return Rung(structure, error, numbers, independent)


def _starts(
    shapes: Sequence[ShapeParameter], known: dict[str, float], places: Sequence[float] = _PLACES
) -> list[list[float]]:
    """Where the search starts: the numbers that are known, and several places for the new ones."""
    starts: list[list[float]] = []
    for place in places:
        start: list[float] = []
        for shape in shapes:
            low, high = shape.scanned
            within = low + place * (high - low)
            if shape.scale == "log":  # a constant that spans decades starts by its logarithm
                within = float(low * (high / low) ** place)
            start.append(known.get(shape.name, within))
        starts.append(start)
    all_known = all(shape.name in known for shape in shapes)
    return starts[:1] if all_known else starts
