"""A run says what to log next: its law, what its rows know of the law's numbers, and what the rig did in them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from erclutch.errors import SettingError
from erclutch.fit.solver.intervals import as_json
from erclutch.fit.solver.outcome import Estimate
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel
from erclutch.runs.run_folder import outcome_of, read_run
from erclutch.runs.run_rows import read_rows
from erclutch.signals.array import Array, Mask
from erclutch.signals.device import speeds_of
from erclutch.wings.design.courses import Bounds, Commands
from erclutch.wings.design.fill import CellCounts, chosen_sequence
from erclutch.wings.design.information import QUANTILE, Criterion, Knowledge, Region, Sensitivity
from erclutch.wings.design.limits import RigLimits, limits_of_log

_USE_SECONDS = 10.0  # of the filling sequence whose rows stand for the use
_CANDIDATES = 16
_MORE_CANDIDATES = 32  # where cells are counted, which takes less time than to ask the law


@dataclass(frozen=True)
class LawOfRun:
    """A law of a run and the rows that it was fitted to.

    Attributes:
        name: of the model in the run.
        model: the law.
        estimates: its numbers with their intervals.
        rows: the training rows.
    """

    name: str
    model: TorqueModel
    estimates: Sequence[Estimate]
    rows: Dataset

    @property
    def limits(self) -> Mapping[str, float]:
        """What the rig did in the rows."""
        return limits_of_log(self.rows)

    @property
    def rate(self) -> float:
        """Rows a second."""
        return 1.0 / self.rows.period

    @property
    def pair(self) -> bool:
        """Whether the device is a pair."""
        return self.model.structure.device == "coaxial"


def law_of_run(folder: Path, name: str | None) -> LawOfRun:
    """The law of a run that is named, else the recommended model, else the run's best law over field and slip.

    Raises:
        RunError: no run, or no such model.
        SettingError: the run has no such law, or the model that is named is none.
    """
    run = read_run(folder)
    names = [name] if name is not None else [run.recommended, *run.names]
    laws = [each for each in names if run.entry(each)["fit"]["weights"] == 0]
    if not laws:
        what = "no model of the run is a law" if name is None else f"{name} is no law"
        problem = f"{what}: only a law has numbers with intervals"
        raise SettingError(problem, where=str(folder), remedy="Fit a law too, or name one")
    for chosen in laws:
        model = cast(TorqueModel, run.model(chosen))  # what has no weights is a law
        if not model.structure.extras:
            break
    else:
        problem = f"{laws[0]} has further inputs, and a sequence sets fields and motions alone"
        raise SettingError(
            problem, where=str(folder), remedy="Name a law without them with --model"
        )
    kept = read_rows(run)
    rows = kept.data.take(~kept.test)
    return LawOfRun(chosen, model, outcome_of(run, chosen).estimates, rows)


@dataclass(frozen=True)
class Expectation:
    """What a sequence is expected to teach.

    Attributes:
        before, after: standard error of each number.
        band_before, band_after: half width of the effort's 95 % interval over the rows of use, without noise.
        noise: standard deviation of the residual.
        alike: how many rows of the log count as one.
        by_noise: half width of each number's interval, in its unit, if only the size of the residual made it; nan where
            that is not known.
    """

    before: Array
    after: Array
    band_before: float
    band_after: float
    noise: float
    alike: float
    by_noise: Array

    def half_widths(self, estimates: Sequence[Estimate]) -> list[tuple[float, float]]:
        """Half width of each number's interval in its unit, as the run has it, and as expected; nan where unknown.

        The run's interval comes from its residual where the number matters, which may be few rows: then chance makes it
        narrow or wide, and new rows do so anew. Where neighbours are alike, new rows keep more of it.
        """
        kept = 1.0 - 1.0 / self.alike
        pairs: list[tuple[float, float]] = []
        shrinks: list[float] = (self.after / self.before).tolist()
        for estimate, shrink, by_noise in zip(
            estimates, shrinks, self.by_noise.tolist(), strict=True
        ):
            half = 0.5 * (estimate.high - estimate.low)
            if not math.isfinite(half):
                pairs.append((math.inf, math.nan))
                continue
            odd = 1.0  # by how much chance made it wider than the residual's size would
            if by_noise > 0.0 and half > 0.0:
                odd = half / by_noise
            old_rows = shrink**2  # their share of what is known then
            new_rows = (1.0 - old_rows) * odd ** (2.0 * (kept - 1.0))
            expected = half * shrink * math.sqrt(old_rows + new_rows)
            pairs.append((half, expected))
        return pairs

    def to_dict(self, estimates: Sequence[Estimate]) -> dict[str, Any]:
        """As JSON values; what is not identified is null."""
        numbers: dict[str, Any] = {}
        for estimate, (now, after) in zip(estimates, self.half_widths(estimates), strict=True):
            numbers[estimate.name] = {
                "unit": estimate.unit,
                "value": estimate.value,
                "now": as_json(now),
                "after": as_json(after),
            }
        band = {"now": self.band_before, "after": self.band_after}
        return {"half_widths": numbers, "open_effort": band, "noise": self.noise}


def designed_for(
    law: LawOfRun,
    limits: RigLimits,
    rate: float,
    seconds: float,
    seed: int,
    *,
    criterion: Criterion = "I",
    where: Region | None = None,
    one_way: bool = False,
) -> tuple[Commands, Expectation]:
    """The sequence that teaches most, and what it is expected to teach.

    Args:
        law: what is known.
        limits: of the rig.
        rate: rows a second.
        seconds: length.
        seed: of the stretches that are drawn.
        criterion: D, A, I, or fill: what the rows of the run leave empty.
        where: the region of use; None: all that the limits allow.
        one_way: whether the motion has one direction.

    Raises:
        SettingError: limits that leave no sequence, or a region that they do not reach.
    """
    pair = law.pair
    # A sequence that fills all that the limits allow stands for the use.
    everywhere = chosen_sequence(
        limits,
        rate,
        max(_USE_SECONDS, seconds),
        np.random.default_rng(seed),
        signed=pair,
        one_way=one_way,
    )
    use = Sensitivity(law.model).of_commands([(everywhere.field, everywhere.speed)], 1.0 / rate)
    wanted: Mask = np.ones(use.rows, np.bool_)
    if where is not None:
        wanted = where.rows(use)
    if not wanted.any():
        raise SettingError(
            "--where is a region that the limits do not reach", remedy="Give a nearer region"
        )
    # What fills cells is chosen without knowledge, which then only says what the sequence teaches.
    of_knowledge = "I" if criterion == "fill" else criterion
    knowledge = Knowledge(law.model, law.rows, rate, of_knowledge, use, wanted)
    known = knowledge.information, knowledge.doubt
    before = knowledge.errors()
    band_before = knowledge.band()
    worth: CellCounts | Knowledge = knowledge
    if criterion == "fill":
        worth = cells_of_run(law, limits, rate, seconds, one_way=one_way)
    commands = chosen_sequence(
        limits,
        rate,
        seconds,
        np.random.default_rng(seed),
        worth,
        signed=pair,
        one_way=one_way,
        candidates=_MORE_CANDIDATES if criterion == "fill" else _CANDIDATES,
        of_paper=criterion == "fill",
    )
    # Anew from what was known: now the whole sequence, with its rests.
    knowledge.information, knowledge.doubt = known
    knowledge.learn(commands)

    # By how much of its unit each number of the law moves with its coordinate of the fit.
    model = law.model
    shapes = model.structure.shapes(model.reference.period)
    moved: list[float] = []
    for estimate, shape in zip(law.estimates, shapes, strict=False):
        by_one = abs(estimate.value)
        if shape.scale != "log":
            by_one /= abs(model.shape[shape.name]) or math.nan
        moved.append(by_one)
    of_gains = law.estimates[len(shapes) :]
    for estimate, gain in zip(of_gains, model.gains.values(), strict=True):
        moved.append(abs(estimate.value) / (abs(gain) or math.nan))
    expected = Expectation(
        before=before,
        after=knowledge.errors(),
        band_before=band_before,
        band_after=knowledge.band(),
        noise=knowledge.noise,
        alike=knowledge.alike,
        by_noise=QUANTILE * before * np.array(moved),
    )
    return commands, expected


def cells_of_run(
    law: LawOfRun, limits: RigLimits, rate: float, seconds: float, *, one_way: bool
) -> CellCounts:
    """The cells that the rows of the run visit, within the limits: so counted, stretches are worth what is new."""
    cells = CellCounts(Bounds.of(limits, rate, seconds), rate, signed=law.pair, one_way=one_way)
    elements = law.rows.elements
    field = elements[0].field
    if law.pair:  # the commands' field is signed, positive for the first clutch
        field = field - elements[1].field
    speeds = speeds_of(law.rows.device, [element.slip for element in elements])
    cells.known(field, speeds[0])
    return cells
