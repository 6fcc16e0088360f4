"""A recalibration becomes a run: the base and the adapted model, ranked on the rows of the new log that neither saw."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from erclutch.errors import require
from erclutch.fit.choice.ranking import RankedModel, scored, with_bands
from erclutch.fit.comparison import Comparison, Settings
from erclutch.fit.laws.describe_law import paper_form
from erclutch.fit.recalibration import AS_IT_IS, GAIN, OFFSET, Recalibration, recalibrate
from erclutch.fit.solver.intervals import as_json
from erclutch.fit.solver.outcome import Estimate, FitOutcome
from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import constant_stretches
from erclutch.models.law_model import TorqueModel
from erclutch.models.parameter_units import in_user_units
from erclutch.runs.run_folder import Run, outcome_of
from erclutch.signals.array import Mask
from erclutch.signals.percent import percent

#: What an adapted model's name ends in, beside its base.
LABEL = "@recalibrated"


def recalibrated(
    run: Run,
    data: Dataset,
    *,
    model: str | None = None,
    share: float = 0.7,
    stretches: int = 1,
) -> Comparison:
    """Adapt a model of a run to a share of a new log's rows; the rest judges.

    Args:
        run: with the base.
        data: the new log.
        model: name of the base; None: the recommended model.
        share: of the rows of each log that the adaptation sees.
        stretches: into which the share is divided, spread over each log; 1: the first rows.

    Raises:
        SettingError: a share or a number of stretches that cannot be.
        ErclutchError: as `recalibrate`.
    """
    outcome = outcome_of(run, model)
    base = outcome.model
    seen = seen_rows(data, share, stretches)
    result = recalibrate(base, data, seen)
    outcomes = [outcome]
    if result.way != AS_IT_IS:
        outcomes.append(adapted_outcome(outcome, result))

    # Both are judged on the rows that neither saw.
    settings = Settings((base.name,), base.structure.dynamics, round(1.0 - share, 12))
    adapted_name = outcome.name + LABEL
    entries: list[RankedModel] = []
    for entry in scored(data, data.picked(seen), ~seen, outcomes, settings):
        if entry.outcome is outcome:
            entries.append(replace(entry, folds=result.folds[AS_IT_IS]))
        else:  # the base keeps its band, the adapted model gets one of the new rows
            (banded,) = with_bands(data, ~seen, [entry])
            entries.append(replace(banded, folds=result.folds[result.way], label=adapted_name))
    rmse = {entry.name: entry.test.rmse.value for entry in entries}
    base_rmse = rmse[outcome.name] or 1.0
    change = rmse.get(adapted_name, np.inf) / base_rmse - 1.0
    if result.way == AS_IT_IS:
        verdict = f"The base is kept: {result.reason}."
    elif change < 0.0:
        verdict = f"Recalibrated, {result.reason}. On the rows that neither saw it errs by {percent(-change, 1)} less."
    else:
        verdict = f"The base is kept: on the rows that neither saw, {adapted_name} errs by {percent(change, 1)} more."
    best = entries[0].name
    about = {
        "run": run.folder.name,
        "run_digest": run.body["digest"],
        "model": run.entry(model or run.recommended)["name"],
        "share": share,
        "stretches": stretches,
        "way": result.way,
        "numbers": _lists(result.numbers),
        "unseen_blocks_rmse": _lists(result.folds),
        "verdict": verdict,
    }
    settings = replace(settings, blocks=len(result.folds[AS_IT_IS]))
    return Comparison(data, ~seen, settings, (), tuple(entries), best, best, recalibration=about)


def _lists(numbers: Mapping[str, Sequence[float]]) -> dict[str, list[Any]]:
    """Numbers by name as JSON values."""
    lists: dict[str, list[Any]] = {}
    for name, several in numbers.items():
        lists[name] = [as_json(number) for number in several]
    return lists


def seen_rows(data: Dataset, share: float, stretches: int) -> Mask:
    """The rows that the adaptation sees: the first share of each part of each log."""
    require(1e-6, 0.9, share=share)
    require(1, 1000, stretches=stretches)
    seen = np.zeros(data.rows, np.bool_)
    for log in data.source_rows:
        for start, stop in constant_stretches(data, *log) or [log]:
            rows = max(1, round(share * (stop - start) / stretches))  # of a stretch
            for first in np.linspace(start, stop, stretches, endpoint=False).astype(int):
                seen[first : first + rows] = True
    return seen


def adapted_outcome(base: FitOutcome[Any], result: Recalibration) -> FitOutcome[Any]:
    """The outcome of the adapted model: numbers that did not move keep the base's intervals."""
    law: TorqueModel | None = result.model.law_part
    if law is None:  # weights have no estimates
        return replace(base, model=result.model)
    estimates = list(base.estimates)
    named = {estimate.name for estimate in estimates}
    if OFFSET in law.gains and OFFSET not in named:
        offset = Estimate(
            OFFSET,
            "constant effort",
            law.units.effort,
            value=0.0,
            low=0.0,
            high=0.0,
        )
        estimates.append(offset)
    moved = tuple(_moved(estimate, law, result.numbers) for estimate in estimates)
    return replace(
        base,
        model=result.model,
        estimates=moved,
        paper_form=paper_form(law, moved),
    )


def _moved(
    estimate: Estimate,
    law: TorqueModel,
    numbers: Mapping[str, tuple[float, float, float]],
) -> Estimate:
    """An estimate of the base with the adapted model's value and the interval that the new rows give."""
    name = estimate.name
    value = {**law.shape, **law.gains}[name]  # normalised
    common, lowest_common, highest_common = numbers.get(GAIN, (0.0, 0.0, 0.0))
    if name in numbers:
        _, low, high = numbers[name]
    elif name in law.gains and common:
        # All moved together: the base's doubt of each stays, beside that of the gain.
        moved = common * estimate.value
        low = moved - math.hypot(
            common * (estimate.value - estimate.low), estimate.value * (common - lowest_common)
        )
        high = moved + math.hypot(
            common * (estimate.high - estimate.value), estimate.value * (highest_common - common)
        )
        return replace(estimate, value=moved, low=low, high=high)
    else:
        return estimate

    # From normalised numbers to those of the user's units.
    of_law = (*law.structure.gains(), *law.structure.shapes(law.period))
    parameter = next(each for each in reversed(of_law) if each.name == name)
    extra: int | None = getattr(parameter, "extra", None)
    scale = 1.0 if extra is None else float(law.reference.extras[extra])
    times = in_user_units(1.0, parameter.dimension, law.reference)
    one_end = low * times / scale
    other_end = high * times / scale
    return replace(
        estimate,
        value=value * times / scale,
        low=min(one_end, other_end),
        high=max(one_end, other_end),
        at_bound=None,
    )
