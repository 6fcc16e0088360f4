"""Fitted models are scored on rows held out, get bands, and are ranked; what to worry about is noted beside each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.fit_settings import Settings
from erclutch.fit.new_fields import wider_at_new_fields
from erclutch.fit.outcome import MEANINGLESS, AnyOutcome
from erclutch.fit.prediction_bands import HeldBand, calibrated, judged
from erclutch.fit.scoring import TOLERATED, BandedFigure, Score, excess, independent_rows, information_criteria, score
from erclutch.logs.dataset import Dataset
from erclutch.models.band import Band
from erclutch.signals.array import Array
from erclutch.signals.shown import Shown, one_line

#: Travels after which a state of memory has forgotten where it started, to 5 %.
_FORGOTTEN = 3.0


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

    @property
    def name(self) -> str:
        """The model's name."""
        return self.label or self.outcome.model.name

    def __repr__(self) -> str:
        rmse, unit = self.test.rmse, self.outcome.model.units.effort
        band = f"95 % band {rmse.low:.4g} to {rmse.high:.4g}"
        error = f"RMSE {rmse.value:.4g} {unit} on {self.test.rows} rows held out ({band})"
        share = f"{self.test.share.value:.1%} of the standard deviation"
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
    errors = [data.effort - p for p in predictions]
    sound = [e for e in errors if np.all(np.isfinite(e))] or [data.effort]
    independent = min(independent_rows(e[~test]) for e in sound)
    best = min((e[test] for e in sound), key=lambda e: float(e @ e))
    entries: list[RankedModel] = []
    for outcome, predicted, validated in zip(outcomes, predictions, folds or [()] * len(outcomes), strict=True):
        cost = float(np.sum((data.effort - predicted)[~test] ** 2))
        entries.append(
            RankedModel(
                outcome=outcome,
                train=score(data.effort[~test], predicted[~test], seed=settings.seed),
                test=score(data.effort[test], predicted[test], seed=settings.seed),
                criteria=information_criteria(cost, train.rows, independent, outcome.parameters),
                folds=validated,
                predicted=predicted,
                excess=excess((data.effort - predicted)[test], best, seed=settings.seed),
                sound=outcome.sound and not _wild(data, predicted, test),
                notes=(*_notes(outcome, data, predicted, test), *outcome.notes),
            )
        )
    return sorted(entries, key=lambda e: e.test.rmse.value)


def with_bands(
    data: Dataset,
    test: NDArray[np.bool_],
    entries: Sequence[RankedModel],
    at_new_fields: Mapping[str, Array] | None = None,
) -> list[RankedModel]:
    """The models with bands that are calibrated on the training rows and judged on those held out.

    Args:
        data: all rows.
        test: mask of the rows held out, shape (n,).
        entries: the models.
        at_new_fields: by name, errors on the training rows by fits without the field of a row, each (m,); the bands of
            these models then have widths of their own at fields between and beyond those of the training rows.
    """
    errors = [data.effort - entry.predicted for entry in entries]
    outcomes = [entry.outcome for entry in entries]
    found = calibrated(data, ~test, errors, [o.parameters for o in outcomes], [o.unseen for o in outcomes])
    train, new = data.take(~test), at_new_fields or {}
    banded: list[RankedModel] = []
    for entry, pair in zip(entries, found, strict=True):
        if pair is None:
            banded.append(entry)
            continue
        band, plain = pair
        if entry.name in new:
            band = wider_at_new_fields(band, train, new[entry.name])
        banded.append(_with_band(data, test, entry, band, judged(data, test, entry.predicted, band, plain)))
    return banded


def _with_band(
    data: Dataset, test: NDArray[np.bool_], entry: RankedModel, band: Band, figures: HeldBand
) -> RankedModel:
    outcome: Any = entry.outcome
    error = data.effort - entry.predicted
    logs = [rows[test[rows]] for rows in (np.arange(a, b) for a, b in data.source_rows)]
    errors = [float(np.sqrt(np.mean(error[rows] ** 2))) for rows in logs if rows.size]
    by_log = (min(errors), max(errors), len(errors)) if len(errors) > 1 else None
    banded = replace(outcome, model=replace(outcome.model, band=band))
    return replace(entry, outcome=banded, band=figures, by_log=by_log)


def with_sensor(data: Dataset, test: NDArray[np.bool_], entry: RankedModel) -> RankedModel:
    """The model with what its band holds if a sensor teaches it."""
    band = entry.outcome.model.band
    if band is None or entry.band is None:
        return entry
    return replace(entry, band=judged(data, test, entry.predicted, band, entry.band.plain, sensor=True))


def judged_by_training(entries: Sequence[RankedModel]) -> list[RankedModel]:
    """Laws that miss the fields of the training rows, where the rows held out have but one, are not recommended."""
    laws = [e for e in entries if e.sound and not e.outcome.weights]
    if not laws:
        return list(entries)
    best = min(laws, key=lambda e: e.train.rmse.value)

    def judged(entry: RankedModel) -> RankedModel:
        more = entry.train.rmse.value / best.train.rmse.value - 1.0
        if entry.outcome.weights or not more > TOLERATED:
            return entry
        note = f"errs on the training rows by {more:.0%} more than {best.name}, which rows held out at one field hide"
        return replace(entry, sound=False, notes=(*entry.notes, note))

    return [judged(entry) for entry in entries]


def _wild(data: Dataset, predicted: Array, test: NDArray[np.bool_]) -> int:
    """Test rows that are predicted far outside all efforts seen in training."""
    seen = data.effort[~test]
    return int(np.count_nonzero(~(np.abs(predicted[test] - seen.mean()) < 3.0 * float(np.ptp(seen)))))


def _too_short(outcome: AnyOutcome, data: Dataset) -> list[str]:
    """Which travels of the memory are so long that stretches of the log end before their start is forgotten."""
    lengths = {e.name: e.value for e in outcome.estimates if e.name in outcome.model.times and e.name.startswith("r_")}
    if not lengths:
        return []
    steps = np.diff(data.clock.time, prepend=data.clock.time[0])
    walked = [
        min(float(np.sum(np.abs(e.slip[s.start + 1 : s.stop]) * steps[s.start + 1 : s.stop])) for e in data.elements)
        for s in data.clock.spans
    ]
    return [
        f"{short} of {len(walked)} stretches are too short to forget the start of {name} = {length:.3g}"
        for name, length in lengths.items()
        if (short := sum(travel < _FORGOTTEN * length for travel in walked))
    ]


def _adds(model: Any, data: Dataset, predicted: Array, test: NDArray[np.bool_]) -> str:
    """What the network of a law with one adds, on the rows held out."""
    alone, both = (
        float(np.sqrt(np.mean((data.effort - effort)[test] ** 2))) for effort in (model.law.predict(data), predicted)
    )
    change = f"{abs(1.0 - both / alone):.1%} {'less' if both <= alone else 'more'}" if alone > 0 else "no less"
    unit, limit = data.units.effort or "", model.correction.limit
    return (
        f"test RMSE {alone:.4g} {unit} of the law alone, {both:.4g} {unit} with the network ({change}); "
        f"the network moves the effort by at most {limit:.4g} {unit}"
    )


def _notes(outcome: AnyOutcome, data: Dataset, predicted: Array, test: NDArray[np.bool_]) -> tuple[str, ...]:
    notes: list[str] = []
    if outcome.model.correction is not None:
        notes.append(_adds(outcome.model, data, predicted, test))
    if not outcome.converged and not outcome.weights:
        notes.append(f"solver stopped before its tolerance ({outcome.stop} after {outcome.iterations} steps)")
    if outcome.at_bounds:
        notes.append(f"at a bound: {', '.join(outcome.at_bounds)}")
    if outcome.idle:
        notes.append(f"without effect, since the terms that they shape are zero: {', '.join(outcome.idle)}")
    unknown = outcome.unidentified
    if unknown:
        notes.append(f"not identified by these data: {', '.join(unknown)}")
    elif outcome.rank + len(outcome.idle) < outcome.unknowns:
        notes.append(f"rank {outcome.rank} of {outcome.unknowns}: parameters trade off")
    elif outcome.condition > MEANINGLESS and not outcome.idle:
        notes.append(f"condition {outcome.condition:.0e}: its parameters mean nothing one by one")
    notes += _too_short(outcome, data)
    wild = _wild(data, predicted, test)
    if wild:
        notes.append(f"{wild} test rows are predicted far outside all efforts seen: do not extrapolate this model")
    return tuple(notes)
