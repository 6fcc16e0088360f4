"""A kind of model in one file: the effort is the mean of the k training rows that are nearest in field and slip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from erclutch.errors import SettingError
from erclutch.fit.candidate import Candidate, Fitted, Kind, asked
from erclutch.fit.fit_settings import Settings
from erclutch.fit.solver.outcome import AnyOutcome, FitOutcome
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

#: Rows that a model keeps: each prediction measures the distance to all of them.
_MOST_ROWS = 400


@dataclass(frozen=True)
class Nearest(Candidate):
    """So many neighbours; `nearest-5` has five."""

    device: DeviceName
    specification: str
    dynamics: str = "none"

    @property
    def name(self) -> str:
        """Identifier of the model."""
        return self.specification

    @property
    def neighbours(self) -> int:
        """How many rows have a say."""
        return int(self.specification.partition("-")[2])

    def fit(self, train: Dataset, fitted: Sequence[Fitted], workers: int) -> AnyOutcome:
        """Nothing is searched for: some of the rows are kept."""
        few = train.thinned(_MOST_ROWS)
        signals = [signal for element in few.elements for signal in (element.field, element.slip)]
        rows = np.column_stack([*signals, few.effort])
        model: Any = NearestModel(self, rows, train.units, range_of(train))
        missed = train.effort - model.predict(train)
        return FitOutcome(
            model=model,
            stop="converged",
            iterations=1,
            estimates=(),
            paper_form={},
            rank=1,
            unknowns=1,
            condition=1.0,
            bandwidth=1,
            train_cost=float(missed @ missed),
            train_rows=train.rows,
            weights=rows.size,  # numbers that mean nothing one by one
        )

    def refit(
        self, train: Dataset, kept: Mask, outcome: AnyOutcome, fitted: Sequence[Fitted]
    ) -> AnyOutcome:
        """Other rows are kept."""
        return self.fit(train.take(kept), fitted, 1)


@dataclass(frozen=True, repr=False)
class NearestModel(ModelBase):
    """The mean effort of the nearest rows; distances are over the spread of each signal.

    Attributes:
        structure: how many neighbours, of which device.
        rows: field and slip of each element, and effort, shape (n, 3) or (n, 5).
        gain: what multiplies the effort, and ``offset`` what is added: a recalibration moves them.
    """

    structure: Nearest
    rows: Array
    units: Units
    trained_on: Range
    gain: float = 1.0
    offset: float = 0.0
    about: Mapping[str, str] = field(default_factory=dict[str, str])
    band: Band | None = None
    title = "nearest neighbours"
    times = extras = MappingProxyType({})
    past = plugins = ()
    period = correction = None
    signed = True

    @property
    def numbers(self) -> Mapping[str, Any]:
        """Everything that was fitted, by name."""
        return {"rows": self.rows, "gain": self.gain, "offset": self.offset}

    def effort_of_rows(
        self,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array],
        *,
        exactly: bool,
    ) -> Array:
        """Effort, shape (n,)."""
        known, effort = self.rows[:, :-1], self.rows[:, -1]
        wanted = np.column_stack(
            [signal for element in elements for signal in (element.field, element.slip)]
        )
        spread = np.std(known, axis=0)
        distance = np.linalg.norm(
            (wanted[:, None] - known) / np.where(spread > 0, spread, 1.0), axis=2
        )
        nearest = np.argsort(distance, axis=1, kind="stable")[:, : self.structure.neighbours]
        return self.gain * effort[nearest].mean(axis=1) + self.offset

    def steady(
        self, fields: Sequence[Array], slips: Sequence[Array], extras: Sequence[Array] = ()
    ) -> Array:
        """The model has no memory, so it is always at rest."""
        pairs = [
            Element(np.atleast_1d(field), np.atleast_1d(slip))
            for field, slip in zip(fields, slips, strict=True)
        ]
        return self.effort_of_rows(
            pairs, Clock(np.zeros(pairs[0].field.size), ()), {}, exactly=True
        )

    def command(self, field: Any) -> Any:
        """No stage stands between command and model."""
        return field

    def scaled(self, factor: float, offset: float = 0.0) -> NearestModel:
        """So `erclutch recalibrate` can move a common gain."""
        return replace(self, gain=factor * self.gain, offset=factor * self.offset + offset)

    def equation(self) -> list[str]:
        """For people."""
        return [f"effort = mean of the {self.structure.neighbours} nearest training rows"]

    def to_dict(self) -> dict[str, Any]:
        """As JSON values; `sealed` adds the band and the digest that `read_model` checks."""
        return sealed(
            {
                "kind": "nearest",
                "schema": SCHEMA,
                "device": self.structure.device,
                "specification": self.structure.specification,
                "units": {name: getattr(self.units, name) for name in ("effort", "field", "slip")},
                "trained_on": self.trained_on.to_dict(),
                "rows": self.rows.tolist(),
                "gain": self.gain,
                "offset": self.offset,
                "about": dict(self.about),
            },
            self.band,
        )


def read(body: Mapping[str, Any], where: str) -> NearestModel:
    """The model that `NearestModel.to_dict` wrote."""

    def made(content: Mapping[str, Any]) -> NearestModel:
        structure = Nearest(content["device"], content["specification"])
        columns = 5 if structure.device == "coaxial" else 3
        return NearestModel(
            structure=structure,
            rows=table_of(content["rows"], "rows", len(content["rows"]), columns),
            units=units_of(content),
            trained_on=range_in(content),
            gain=float(content["gain"]),
            offset=float(content["offset"]),
            about=dict(content["about"]),
        )

    return read_model(body, "nearest", where, made)


class NearestRows(Kind):
    """Neighbours have no memory, whatever stages the settings ask for."""

    place = 3
    readers = MappingProxyType[str, Any]({"nearest": read})

    def means(self, model: str) -> bool:
        """`nearest-5` and the like."""
        return model.startswith("nearest-")

    def candidates(self, settings: Settings, train: Dataset) -> Sequence[Candidate]:
        """Those that are asked for."""
        named = asked(replace(settings, lag="none"), train, self)
        for name, _ in named:
            count = name.partition("-")[2]
            if not (count.isdecimal() and 1 <= int(count) <= _MOST_ROWS):
                raise SettingError(
                    f"no model {name!r}", remedy=f"Give nearest-1 to nearest-{_MOST_ROWS}"
                )
        return [Nearest(train.device, name) for name, _ in named]


KIND = NearestRows()
