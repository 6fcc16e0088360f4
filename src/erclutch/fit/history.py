"""Does an error depend on where the slip came from? Memories are tried on it, on rows that they were not fitted to.

What slip and field explain by themselves is taken out first, by a function that is bent at will (piecewise linear in
both). A memory then has to lower the error on windows of rows between those that it was fitted to. The memories are
the stages on the slip that `ladder` tries, so whatever is found has a name on the command line.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.checks.finding import Finding
from erclutch.fit.choice.stage_families import families, with_stage
from erclutch.fit.laws.fit_law import reference_of
from erclutch.logs.dataset import Dataset
from erclutch.models.stages import NONE, needs_time, slip_stages, stage_named, stages_of
from erclutch.models.stages.stage import SlipAndStrength
from erclutch.signals.array import Array, Mask, rms
from erclutch.signals.device import WAYS_OF
from erclutch.signals.percent import percent

#: A LuGre state is a Dahl state with two more numbers, and what is counted from the start of a log, a travel or a heat,
#: is no friction: neither is told of here.
_BRISTLES = "lugre"
Rows = NDArray[np.intp]

#: Subject of the finding.
HISTORY = "memory"
#: Share of the error that a memory must take off before it is worth a word, and how sure that must be.
_WORTH = 0.05
_SURE = 2.5  # standard errors over windows
_WINDOWS = 32
_MOST_ROWS = 20_000
_FEWEST_ROWS = 1000
_SLIPS = 16  # knots
_FIELDS = 4  # knots
_PLACES = (0.05, 0.25, 0.45, 0.65, 0.85)  # of a memory's constants in their usual ranges
#: Share of all rows: in a corner with fewer rows the function stays near zero.
_RIDGE = 3e-4


@dataclass(frozen=True)
class History:
    """What the memories of one stage would take off an error.

    Attributes:
        stage: name of the stage.
        share: of the error (RMSE) that it takes off, on windows that it was not fitted to.
        sure: mean over windows of what it takes off the squared error, in standard errors.
    """

    stage: str
    share: float
    sure: float


def history(data: Dataset, error: Array | None = None, dynamics: str = NONE) -> History | None:
    """The stage on the slip that explains most of an error; None where none explains enough of it for sure.

    Args:
        data: the rows.
        error: measured less estimated effort, shape (n,); None: of a function of field and slip, bent at will.
        dynamics: stages that the model has already.
    """
    y = data.effort if error is None else error
    if data.rows < _FEWEST_ROWS or data.in_no_time or not np.all(np.isfinite(y)):
        return None
    if not any(np.ptp(element.slip) > 0.0 for element in data.elements):
        return None  # the slip came from nowhere
    reference = reference_of(data)
    count = min(data.rows, _MOST_ROWS)
    places = np.linspace(0, data.rows - 1, count)
    rows = places.round().astype(np.intp)
    window = np.arange(rows.size) * _WINDOWS // rows.size

    # The straight part first: beside a large viscous effort the ridge below would bend more than a memory does.
    slips = [element.slip[rows] for element in data.elements]
    straight = np.column_stack([np.ones(rows.size), *slips])
    given = y[rows]
    gains, *_ = np.linalg.lstsq(straight, given, rcond=None)
    y = given - straight @ gains

    # What needs no memory: piecewise linear functions of field and slip of each element.
    memoryless: list[Array] = []
    for element, slip in zip(data.elements, slips, strict=True):
        field = np.abs(element.field[rows])
        knots_of_slip = np.quantile(slip, np.linspace(0.0, 1.0, _SLIPS))
        of_slip = _hats(slip, knots_of_slip)
        of_field = _hats(field, np.linspace(0.0, reference.field, _FIELDS))
        products = of_slip[:, :, None] * of_field[:, None, :]  # each hat with each of the others
        memoryless.append(products.reshape(rows.size, -1))
    plain = _TwoFolds(np.column_stack(memoryless), y, window)
    left = plain.unexplained()

    # Over the whole error of a model: the function may gain what no memory does.
    whole = rms(left)
    if error is not None:
        whole = max(whole, rms(given))
    whole = whole or 1.0
    helpful: list[History] = []
    for name in _candidates(dynamics):
        # Columns of the stage, its constants at several places of their usual ranges.
        (stage,) = slip_stages(name)
        shapes = stage.parameters(reference.period)
        columns: list[Array] = []
        for way, element in zip(WAYS_OF[data.device], data.elements, strict=True):
            strength = np.abs(element.field) / reference.field
            if not strength.any():  # no field at all: the memory is as strong everywhere
                strength = np.ones(data.rows)
            moved = SlipAndStrength(way * element.slip / reference.slip, strength)
            for place in _PLACES if shapes else _PLACES[:1]:
                constants = [shape.at(place) for shape in shapes]
                outputs = stage.respond(moved, data.clock, constants, slice(None))
                for column in stage.columns(outputs, moved.strength):
                    columns.append(way * np.asarray(column)[rows])
        better = plain.unexplained(np.column_stack(columns))
        taken_off = np.bincount(window, left**2 - better**2)  # of each window
        standard_error = float(np.std(taken_off, ddof=1)) / taken_off.size**0.5 or 1.0
        sure = float(np.mean(taken_off)) / standard_error
        share = (rms(left) - rms(better)) / whole
        if share >= _WORTH and sure >= _SURE:
            helpful.append(History(name, share, sure))
    return max(helpful, key=lambda memory: memory.share, default=None)


def history_finding(
    data: Dataset,
    error: Array,
    name: str,
    dynamics: str,
) -> Finding | None:
    """A warning where the error of a model depends on where the slip came from, with the option that helps.

    Args:
        data: the rows.
        error: measured less estimated effort, shape (n,).
        name: what the model is called.
        dynamics: its stages.
    """
    memory = history(data, error, dynamics)
    if memory is None:
        return None
    message = (
        f"the error of {name} depends on where the slip came from, not only on field and slip: a memory of the slip "
        f"({memory.stage}) would take about {percent(memory.share)} off"
    )
    return Finding(
        "warning", HISTORY, message, f"Fit with --lag {with_stage(dynamics, memory.stage)}"
    )


def effort_finding(data: Dataset) -> Finding | None:
    """A note before any fit where the effort depends on where the slip came from, beyond field and slip of the row."""
    memory = history(data)
    if memory is None:
        return None
    message = (
        f"the effort depends on where the slip came from: a memory of the slip ({memory.stage}) would take about "
        f"{percent(memory.share)} off the error of any model of field and slip alone"
    )
    return Finding(
        "note", HISTORY, message, "erclutch fit tries memories by itself (--lag auto, the default)"
    )


def _candidates(dynamics: str) -> Iterator[str]:
    """Of each family the first stage that is richer than what the model has; only stages that keep a state."""
    own = {stage.name for stage in stages_of(dynamics)}
    for ladder in families():
        lowest = ladder[0]
        stage = stage_named(lowest)
        if (
            stage.place != "slip"
            or lowest.startswith(_BRISTLES)
            or getattr(stage, "from_the_start", "")
        ):
            continue
        rungs = [rung for rung, name in enumerate(ladder) if stage_named(name).name in own]
        without_form, _, _ = lowest.partition("/")
        stem, _, _ = without_form.partition("-")
        has_another_form = any(name.startswith((stem, _BRISTLES)) for name in own)
        if not rungs and has_another_form:
            continue
        above = max(rungs, default=-1) + 1
        if above < len(ladder) and needs_time(stage_named(ladder[above])):
            yield ladder[above]


def _hats(values: Array, knots: Array) -> Array:
    """Hat functions on knots, shape (n, knots)."""
    knots = np.unique(knots)
    hats = [np.interp(values, knots, row) for row in np.eye(knots.size)]
    return np.column_stack(hats)


class _TwoFolds:
    """Columns of a linear fit, with what is fitted of them to every other window kept for wider fits.

    The products of the many columns of field and slip take the time; each memory adds a few columns.
    """

    def __init__(self, columns: Array, y: Array, window: Rows) -> None:
        self.columns = columns
        self.y = y
        self.folds: list[Mask] = [window % 2 == fold for fold in (0, 1)]
        self.grams: list[Array] = []
        self.moments: list[Array] = []
        for fitted in self.folds:
            part = columns[fitted]
            self.grams.append(part.T @ part)
            self.moments.append(part.T @ y[fitted])

    def unexplained(self, more: Array | None = None) -> Array:
        """What is left of y in each window by gains that were fitted to every other window, shape (n,).

        Args:
            more: further columns, shape (n, k).
        """
        wider = np.empty((self.y.size, 0)) if more is None else more
        left = np.empty(self.y.size)
        for fitted, gram, moment in zip(self.folds, self.grams, self.moments, strict=True):
            # Normal equations of all columns: the blocks of the many are known, those of the few are made here.
            own = self.columns[fitted]
            added = wider[fitted]
            between = own.T @ added
            whole = np.block([[gram, between], [between.T, added.T @ added]])
            whole[np.diag_indices_from(whole)] += _RIDGE * float(np.count_nonzero(fitted))
            right = np.concatenate([moment, added.T @ self.y[fitted]])
            gains = np.linalg.solve(whole, right)
            of_own = gains[: moment.size]
            of_added = gains[moment.size :]
            rest = ~fitted
            estimated = self.columns[rest] @ of_own + wider[rest] @ of_added
            left[rest] = self.y[rest] - estimated
        return left
