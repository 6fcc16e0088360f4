"""A made-up kind of model in one file: the effort of the k nearest training rows, as another package would bring it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from erclutch.fit.candidate import Candidate, Fitted, Kind, asked
from erclutch.fit.fit_settings import Settings
from erclutch.fit.outcome import AnyOutcome, FitOutcome
from erclutch.fit.training_range import range_of
from erclutch.logs.dataset import Dataset
from erclutch.models.band import Band
from erclutch.models.model import Range
from erclutch.models.model_file import SCHEMA, read_model, sealed, table_of, units_of
from erclutch.models.model_file import range_of as range_in
from erclutch.models.shared_answers import ModelBase
from erclutch.signals.array import Array, Mask
from erclutch.signals.clock import Clock
from erclutch.signals.device import DeviceName, Element, Units

_MOST_ROWS = 400


@dataclass(frozen=True)
class Nearest:
    """So many neighbours."""

    device: DeviceName
    specification: str
    dynamics: str = "none"

    @property
    def name(self) -> str:
        return self.specification

    def fit(self, train: Dataset, fitted: Sequence[Fitted], workers: int) -> AnyOutcome:
        assert {each.candidate.name for each in fitted} == {"bingham"}  # kinds of a lower place come first
        few = train.thinned(_MOST_ROWS)
        rows = np.column_stack([few.elements[0].field, few.elements[0].slip, few.effort])
        model: Any = NearestModel(self, rows, train.units, range_of(train))
        cost = float(np.sum((train.effort - model.predict(train)) ** 2))
        return FitOutcome(model, "converged", 1, (), {}, 1, 1, 1.0, 1, cost, train.rows, weights=rows.size)

    def refit(self, train: Dataset, kept: Mask, outcome: AnyOutcome, fitted: Sequence[Fitted]) -> AnyOutcome:
        return self.fit(train.take(kept), fitted, 1)


@dataclass(frozen=True, repr=False)
class NearestModel(ModelBase):
    """The mean effort of the nearest rows, distances over the spread of each column."""

    structure: Nearest
    rows: Array
    units: Units
    trained_on: Range
    band: Band | None = None
    title = "nearest neighbours"
    times = extras = numbers = MappingProxyType({})
    past = plugins = ()
    period = correction = None
    signed = True

    def effort_of_rows(
        self, elements: Sequence[Element], clock: Clock, extras: Mapping[str, Array], *, exactly: bool
    ) -> Array:
        known, count = self.rows[:, :2], int(self.structure.specification.partition("-")[2])
        asked_for = np.column_stack([elements[0].field, elements[0].slip])
        away = np.linalg.norm((asked_for[:, None] - known) / np.std(known, axis=0), axis=2)
        return self.rows[np.argsort(away, axis=1)[:, :count], 2].mean(axis=1)

    def command(self, field: Any) -> Any:
        return field

    def equation(self) -> list[str]:
        return ["effort = mean of the nearest training rows"]

    def to_dict(self) -> dict[str, Any]:
        units = {name: getattr(self.units, name) for name in ("effort", "field", "slip")}
        body = {"kind": "nearest", "schema": SCHEMA, "device": self.structure.device, "units": units}
        about = {"trained_on": self.trained_on.to_dict(), "specification": self.structure.specification}
        return sealed({**body, **about, "rows": self.rows.tolist()}, self.band)


def read(body: Mapping[str, Any], where: str) -> NearestModel:
    def made(content: Mapping[str, Any]) -> NearestModel:
        rows = table_of(content["rows"], "rows", len(content["rows"]), 3)
        structure = Nearest(content["device"], content["specification"])
        return NearestModel(structure, rows, units_of(content), range_in(content))

    return read_model(body, "nearest", where, made)


class NearestRows(Kind):
    place = 3
    readers = MappingProxyType[str, Any]({"nearest": read})

    def means(self, model: str) -> bool:
        return model.startswith("nearest-")

    def candidates(self, settings: Settings, train: Dataset) -> Sequence[Candidate]:
        return [Nearest(train.device, name) for name, _ in asked(replace(settings, lag="none"), train, self)]


KIND = NearestRows()
