"""Fitted models are scored on rows held out, get bands, and are ranked; what to worry about is noted beside each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.bands.haste_widths import with_haste
from erclutch.fit.bands.new_fields import NewFieldErrors, wider_at_new_fields
from erclutch.fit.bands.prediction_bands import HeldBand, calibrated, judged
from erclutch.fit.bands.standstill_widths import wide_next_to_standstill
from erclutch.fit.choice.scoring import (
    TOLERATED,
    BandedFigure,
    Score,
    excess,
    independent_rows,
    information_criteria,
    score,
)
from erclutch.fit.choice.turned_down import NOT_IDENTIFIED
from erclutch.fit.fit_settings import Settings
from erclutch.fit.solver.outcome import MEANINGLESS, AnyOutcome
from erclutch.logs.dataset import Dataset
from erclutch.models.model import Model
from erclutch.models.stages import slip_stages
from erclutch.models.stages.slip_memory import TRAVEL
from erclutch.signals.array import Array, rms
from erclutch.signals.percent import percent
from erclutch.signals.shown import Shown, one_line
from erclutch.signals.units import amount

#: Travels after which a state of memory has forgotten where it started, to 5 %.
_FORGOTTEN = 3.0
#: Ranges of the training effort from its mean, from which on a prediction is wild.
_WILD = 3.0
#: Of a step from 0 to 1: what is neither off nor on; and the share of the rows that a ramp of the field may leave so.
_ON_THE_STEP = 0.05
_FEW_ON_A_STEP = 0.1


@dataclass(frozen=True, repr=False)
class RankedModel(Shown):
    """One model of a comparison.

    Attributes:
        outcome: the fit on the training rows.
        train, test: figures on the rows it was fitted to and on those held out.
        criteria: AIC and BIC on the training rows.
        folds: RMSE on each block of the cross-validation, each by a fit on the others; empty for none.
        predicted: effort on all rows, shape (n,).
        excess: how much larger the test RMSE is than the best model's, as a share, both on the same blocks.
        sound: whether it converged and the data identify all that it says; only such a model is recommended.
        notes: what to worry about with this model.
        band: how the model's band does on the rows held out; None where it has none.
        by_log: smallest and largest RMSE over the logs with rows held out, and their number; None for one log.
        validation: RMSE on parts of the training rows by fits to the others; None: it was not in question.
        label: its name here, where two entries are of one model.
        turned_down: why it is not recommended though it errs by less than the recommended model on the rows held out,
            the end of a sentence; empty: it is recommended, or does not err by clearly less.
    """

    outcome: AnyOutcome
    train: Score
    test: Score
    criteria: dict[str, float]
    folds: tuple[float, ...]
    predicted: Array
    excess: BandedFigure
    sound: bool
    notes: tuple[str, ...]
    band: HeldBand | None = None
    by_log: tuple[float, float, int] | None = None
    validation: BandedFigure | None = None
    label: str = ""
    turned_down: str = ""

    @property
    def name(self) -> str:
        """The model's name."""
        return self.label or self.outcome.name

    def __repr__(self) -> str:
        rmse = self.test.rmse
        unit = self.outcome.model.units.effort
        band = f"95 % band {rmse.low:.4g} to {rmse.high:.4g}"
        error = (
            f"RMSE {amount(f'{rmse.value:.4g}', unit)} on {self.test.rows} rows held out ({band})"
        )
        share = f"{percent(self.test.share.value, 1)} of the standard deviation"
        return one_line(self, self.name, f"{self.outcome.parameters} parameters", error, share)


def scored(
    data: Dataset,
    train: Dataset,
    test: NDArray[np.bool_],
    outcomes: Sequence[AnyOutcome],
    settings: Settings,
    folds: Sequence[tuple[float, ...]] | None = None,
) -> list[RankedModel]:
    """Outcomes with their figures, best test error first.

    Args:
        data: all rows.
        train: the rows that the models were fitted to.
        test: mask of the rows held out, shape (n,).
        outcomes: the fits.
        settings: the seed of the bands.
        folds: of each model the RMSE on each block of a cross-validation; None: there was none.
    """
    predictions = [outcome.model.predict(data) for outcome in outcomes]
    errors = [data.effort - predicted for predicted in predictions]
    finite = [error for error in errors if np.all(np.isfinite(error))] or [data.effort]
    # All models count with the same number of rows: of the model whose errors are the most alike in time.
    independent = min(independent_rows(error[~test]) for error in finite)
    held_out = [error[test] for error in finite]
    best = min(held_out, key=lambda error: float(error @ error))

    entries: list[RankedModel] = []
    folds = folds or [()] * len(outcomes)
    for outcome, predicted, error, validated in zip(
        outcomes, predictions, errors, folds, strict=True
    ):
        cost = float(np.sum(error[~test] ** 2))
        entries.append(
            RankedModel(
                outcome=outcome,
                train=score(data.effort[~test], predicted[~test], seed=settings.seed),
                test=score(data.effort[test], predicted[test], seed=settings.seed),
                criteria=information_criteria(cost, train.rows, independent, outcome.parameters),
                folds=validated,
                predicted=predicted,
                excess=excess(error[test], best, seed=settings.seed),
                sound=outcome.sound
                and not _wild(data, predicted, test)
                and not _steps_within_a_field(outcome, train),
                notes=(*notes_on(outcome, data, predicted, test), *outcome.notes),
            )
        )
    return sorted(entries, key=lambda e: e.test.rmse.value)


def with_bands(
    data: Dataset,
    test: NDArray[np.bool_],
    entries: Sequence[RankedModel],
    at_new_fields: Mapping[str, NewFieldErrors] = MappingProxyType({}),
    growth: Mapping[str, float] = MappingProxyType({}),
) -> list[RankedModel]:
    """The models with bands that are calibrated on the training rows and judged on those held out.

    Args:
        data: all rows.
        test: mask of the rows held out, shape (n,).
        entries: the models.
        at_new_fields: by name, errors on the training rows by fits without the field of a row; the bands of
            these models then have widths of their own at fields between and beyond those of the training rows.
        growth: by name, how many times larger the errors are on rows that a fit has not seen.
    """
    errors = [data.effort - entry.predicted for entry in entries]
    parameters = [entry.outcome.parameters for entry in entries]
    unseen = [entry.outcome.unseen for entry in entries]
    larger = [growth.get(entry.name, 1.0) for entry in entries]
    bands = calibrated(data, ~test, errors, parameters, unseen, larger)
    train = data.take(~test)
    held_out: list[NDArray[np.intp]] = []  # of each log
    for start, stop in data.source_rows:
        rows = np.arange(start, stop)
        held_out.append(rows[test[rows]])
    banded: list[RankedModel] = []
    for entry, error, pair in zip(entries, errors, bands, strict=True):
        if pair is None:  # too few rows for a band
            banded.append(entry)
            continue
        band, plain = pair
        if entry.outcome.unseen is not None:
            band = with_haste(band, train, entry.outcome.unseen)
            band = wide_next_to_standstill(band, train, entry.outcome.unseen)
        if entry.name in at_new_fields:
            new = at_new_fields[entry.name]
            band = wider_at_new_fields(band, train, new.usual, new.in_doubt)
        outcome: Any = entry.outcome
        outcome = replace(outcome, model=replace(outcome.model, band=band))
        figures = judged(data, test, entry.predicted, band, plain)
        rmse = [rms(error[rows]) for rows in held_out if rows.size]
        by_log = (min(rmse), max(rmse), len(rmse)) if len(rmse) > 1 else None
        banded.append(replace(entry, outcome=outcome, band=figures, by_log=by_log))
    return banded


def with_sensor(data: Dataset, test: NDArray[np.bool_], entry: RankedModel) -> RankedModel:
    """The model with what its band holds if a sensor teaches it; no point of a table teaches the next one."""
    band = entry.outcome.model.band
    if band is None or entry.band is None or data.in_no_time:
        return entry
    with_its_sensor = judged(data, test, entry.predicted, band, entry.band.plain, sensor=True)
    return replace(entry, band=with_its_sensor)


def with_reasons(
    entries: Sequence[RankedModel], recommended: str, against: Mapping[str, str]
) -> list[RankedModel]:
    """The models, each that errs by less on the rows held out than the recommended one with why it is turned down.

    Args:
        entries: the models.
        recommended: name of that model.
        against: by name, what the training rows say against the others that could have been recommended.
    """
    chosen = next(entry for entry in entries if entry.name == recommended)
    least_told = chosen.test.rmse.value / (1.0 + TOLERATED)
    with_reason: list[RankedModel] = []
    for entry in entries:
        why = ""
        if entry.test.rmse.value < least_told:
            why = against.get(entry.name, "") if entry.sound else NOT_IDENTIFIED
        with_reason.append(replace(entry, turned_down=why))
    return with_reason


def judged_by_training(entries: Sequence[RankedModel]) -> list[RankedModel]:
    """Laws that miss the fields of the training rows, where the rows held out have but one, are not recommended."""
    laws = [e for e in entries if e.sound and not e.outcome.weights]
    if not laws:
        return list(entries)
    best = min(laws, key=lambda e: e.train.rmse.value)

    judged_anew: list[RankedModel] = []
    for entry in entries:
        own = entry.train.rmse.value
        least = best.train.rmse.value
        if entry.outcome.weights or not own > (1.0 + TOLERATED) * least:
            judged_anew.append(entry)
            continue
        more = f" by {percent(own / least - 1.0)} more than" if least > 0.0 else ", unlike"
        note = f"errs on the training rows{more} {best.name}, which rows held out at one field hide"
        notes = (*entry.notes, note)
        judged_anew.append(replace(entry, sound=False, notes=notes))
    return judged_anew


def _wild(data: Dataset, predicted: Array, test: NDArray[np.bool_]) -> int:
    """Test rows that are predicted far outside all efforts seen in training; those that are no number count too."""
    seen = data.effort[~test]
    away = np.abs(predicted[test] - seen.mean())
    wild = _WILD * float(np.ptp(seen))
    near = away < wild
    return int(np.count_nonzero(~near))


def _steps_within_a_field(outcome: AnyOutcome, train: Dataset) -> bool:
    """Whether many rows lie on the step of a law that is on or off: it stands in for a level between both.

    A step is as narrow as it is to have a slope. On a field of the log it is a yield effort of that field alone.
    """
    law = outcome.model.law_part
    if law is None or not law.structure.law.stimulus_shape:
        return False
    structure = law.structure
    reference = law.reference
    numbers: list[float] = []
    for shape in structure.law.stimulus_shape:
        numbers.append(law.shape[shape.name])
    between = np.zeros(train.rows, np.bool_)
    for element in train.elements:
        share = structure.command(element.field, reference, numbers)
        between |= (share > _ON_THE_STEP) & (share < 1.0 - _ON_THE_STEP)
    return float(between.mean()) > _FEW_ON_A_STEP


def too_short(outcome: AnyOutcome, data: Dataset) -> list[str]:
    """Which travels of the memory are so long that stretches of the log end before their start is forgotten."""
    # Other numbers of the stages are times, which a stretch outlasts, or of the field.
    names: set[str] = set()
    for stage in slip_stages(outcome.model.structure.dynamics):
        for number in stage.parameters(data.period):
            if number.dimension == TRAVEL:
                names.add(number.name)
    lengths = {
        estimate.name: estimate.value for estimate in outcome.estimates if estimate.name in names
    }
    if not lengths:
        return []
    steps = np.diff(data.clock.time, prepend=data.clock.time[0])  # [s], from the row before
    # Of each stretch the travel of the element that moves least, in the unit of the slip times s.
    travels: list[float] = []
    for span in data.clock.spans:
        rows = slice(span.start + 1, span.stop)
        of_elements: list[float] = []
        for element in data.elements:
            of_rows = np.abs(element.slip[rows]) * steps[rows]
            of_elements.append(float(np.sum(of_rows)))
        travels.append(min(of_elements))
    notes: list[str] = []
    for name, length in lengths.items():
        short = sum(travel < _FORGOTTEN * length for travel in travels)
        if short:
            notes.append(
                f"{short} of {len(travels)} stretches are too short to forget the start of {name} = {length:.3g}"
            )
    return notes


def unknown_start(model: Model, data: Dataset) -> str:
    """What to know where a stage counts from the start of a log that is too short to forget the start; else empty.

    The rows of a fit cannot show it: their own travel or heat began where they begin. Another log begins elsewhere.
    """
    time = data.clock.time
    lasting: list[float] = []  # s, of each stretch
    for span in data.clock.spans:
        lasting.append(float(time[span.stop - 1] - time[span.start]))
    shortest = min(lasting, default=0.0)
    for stage in slip_stages(model.structure.dynamics):
        words = getattr(stage, "from_the_start", "")
        if not words:
            continue
        fading = stage.parameters(data.period)[0]
        forgotten = _FORGOTTEN * model.times[fading.name]  # [s]
        if forgotten > shortest:
            return f"its {stage.name} {words}"
    return ""


def what_the_network_adds(
    model: Model,
    data: Dataset,
    predicted: Array,
    test: NDArray[np.bool_],
) -> str:
    """What the network of a law with one adds, on the rows held out."""
    assert model.correction is not None
    law: Array = model.law_part.predict(data)
    alone = rms((data.effort - law)[test])
    both = rms((data.effort - predicted)[test])
    change = "no less"
    if alone > 0:
        share = abs(1.0 - both / alone)
        change = f"{percent(share, 1)} less" if both <= alone else f"{percent(share, 1)} more"
    unit = data.units.effort
    of_law = amount(f"{alone:.4g}", unit)
    of_both = amount(f"{both:.4g}", unit)
    most = amount(f"{model.correction.limit:.4g}", unit)
    return (
        f"test RMSE {of_law} of the law alone, {of_both} with the network ({change}); "
        f"the network moves the effort by at most {most}"
    )


def notes_on(
    outcome: AnyOutcome,
    data: Dataset,
    predicted: Array,
    test: NDArray[np.bool_],
) -> tuple[str, ...]:
    """What to worry about with a fit; sentences for people."""
    notes: list[str] = []
    if outcome.model.correction is not None:
        notes.append(what_the_network_adds(outcome.model, data, predicted, test))
    if not outcome.converged and not outcome.weights:
        notes.append(
            f"solver stopped before its tolerance ({outcome.stop} after {outcome.iterations} steps)"
        )
    if outcome.at_bounds:
        notes.append(f"at a bound: {', '.join(outcome.at_bounds)}")
    if outcome.idle:
        notes.append(
            f"without effect, since the terms that they shape are zero: {', '.join(outcome.idle)}"
        )
    unknown = outcome.unidentified
    if unknown:
        notes.append(f"not identified by these data: {', '.join(unknown)}")
    elif outcome.rank + len(outcome.idle) < outcome.unknowns:
        notes.append(f"rank {outcome.rank} of {outcome.unknowns}: parameters trade off")
    elif outcome.condition > MEANINGLESS and not outcome.idle:
        notes.append(f"condition {outcome.condition:.0e}: its parameters mean nothing one by one")
    notes += too_short(outcome, data)
    start = unknown_start(outcome.model, data)
    if start:
        notes.append(start)
    wild = _wild(data, predicted, test)
    if wild:
        notes.append(
            f"{wild} test rows are predicted far outside all efforts seen: do not extrapolate this model"
        )
    return tuple(notes)
