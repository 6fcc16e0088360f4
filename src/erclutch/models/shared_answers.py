"""All kinds of model answer this in the same way; a lone row is answered in microseconds, with the same bits."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.machine import Machine, machine_of
from erclutch.arithmetic.record import Record, recorded
from erclutch.errors import ExportError, SettingError
from erclutch.models.given_rows import further_inputs, require_same_signals
from erclutch.models.model import (
    FluidSignals,
    GivesWay,
    Model,
    Rows,
    full_name,
    margins,
    stage_numbers,
)
from erclutch.models.parameter_units import known_unit
from erclutch.models.stages.stage import Place
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import Element
from erclutch.signals.shown import Shown, one_line

#: Lone rows of a model after which Numba, which takes half a second to load, has paid.
WORTH_LOADING = 1000


class _LoneRows:
    """What a model keeps of the lone rows that it was asked for: their number, and then its machine."""

    asked = 0
    machine: Machine | None = None
    extras: tuple[str, ...] = ()

    def effort(
        self,
        model: Model,
        elements: Sequence[Element],
        extras: Mapping[str, Array],
    ) -> float:
        """The effort by machine code; NaN asks for the long road."""
        if self.machine is None:
            self.asked += 1
            if self.asked <= WORTH_LOADING:
                return np.nan
            self.extras = tuple(model.extras)
            try:
                self.machine = machine_of(_recorded(model, len(elements)))
            except ExportError:  # of functions that are not exported
                self.asked = -sys.maxsize  # do not ask again
                return np.nan
        row = [element.field.item() for element in elements]
        row += [element.slip.item() for element in elements]
        if self.extras:
            row += [x.item() for x in further_inputs(self.extras, extras).values()]
        return self.machine.run(np.array(row))


class ModelBase(Shown):
    """What all kinds of model do in the same way: name themselves, refuse other signals, answer a lone row quickly."""

    @property
    def name(self: Model) -> str:
        """Identifier: law or network and the stages, for example ``bingham/power+lag``."""
        return full_name(self.structure.specification, self.structure.dynamics)

    def __repr__(self: Model) -> str:
        effort = f"effort in {self.units.effort or '1'}"
        band = "with a prediction band" if self.band else "without a prediction band"
        return one_line(self, self.name, self.structure.device, self.title, effort, band)

    @property
    def extra_units(self: Model) -> Mapping[str, str]:
        """The unit of each further input: that of the law's logs, or what its name tells; else "?"."""
        law = self.law_part
        of_law: Mapping[str, str] = {} if law is None else law.extra_units
        return {name: of_law.get(name) or known_unit(name, self.units) for name in self.extras}

    @property
    def gives_way(self) -> GivesWay | None:
        """A model with a law inside is bounded by it everywhere."""
        return None

    @property
    def unbounded(self) -> str:
        """A model with a law inside is bounded by it everywhere."""
        return ""

    @property
    def law_part(self) -> Any:
        """A model has no law unless its class says so."""
        return None

    @property
    def network_part(self) -> Any:
        """A model has no network unless its class says so."""
        return None

    def added(
        self: Model,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array],
        *,
        exactly: bool = True,
    ) -> Array:
        """Nothing is added unless the class says so: zeros, shape (n,)."""
        return np.zeros(clock.time.size)

    def scaled(self: Model, factor: float, offset: float = 0.0) -> Any:
        """A class that says how its effort is multiplied can be recalibrated.

        Raises:
            SettingError: this class does not say so.
        """
        raise SettingError(
            f"{self.name} has no gain that could be recalibrated",
            where=type(self).__name__,
            remedy="Fit the log anew, or recalibrate a law",
        )

    def in_units(self) -> Iterator[tuple[str, float, str, str]]:
        """Name, value in the data's units, unit and meaning of each parameter; weights have no meaning."""
        return iter(())

    def predict(self: Model, data: Rows) -> Array:
        """Effort over a data set, shape (n,), in the unit of the training data.

        Raises:
            ErclutchError: the data set is of another device, in other units or at another rate, or lacks an input.
        """
        require_same_signals(self, data)
        return self.effort(data.elements, data.clock, data.extras)

    def outside(self: Model, data: Rows) -> NDArray[np.bool_]:
        """Rows whose field, slip or further input lies outside what it was trained on, shape (n,): a guess there.

        The exported step raises its flag for the same rows.
        """
        out = self.trained_on.outside(data)
        for name, covered in self.extras.items():
            low, high = margins(covered)
            values = data.extras[name]
            out |= (values < low) | (values > high)
        return out

    def effort(
        self: Model,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array] | None = None,
        *,
        exactly: bool = True,
    ) -> Array:
        """Effort for the fields and slips of each element on a clock, shape (n,).

        To the bit that of the exported C; with ``exactly=False`` by NumPy's own exp, tanh and powers, off by rounding.
        A model that is asked for one row again and again answers in some 10 us.

        Raises:
            MappingError: a further input is not there.
        """
        if exactly and clock.time.size == 1:
            kept: dict[str, Any] = self.__dict__
            own: _LoneRows = kept.get("_lone_rows") or kept.setdefault("_lone_rows", _LoneRows())
            value = own.effort(self, elements, extras or {})
            if value == value:
                return np.array([value])
        return self.effort_of_rows(elements, clock, extras or {}, exactly=exactly)


@dataclass(frozen=True)
class _FirstRow:
    """The `Memory` of a stage in a first row."""

    initial: Mapping[str, Any]

    def before(self, name: str) -> Any:
        return self.initial[name]

    def keep(self, name: str, value: Any) -> Any:
        return self.initial[name]

    def back(self, name: str, value: Any, rows: int) -> Any:
        return value

    def number(self, value: float) -> Any:
        return value


def _recorded(model: Model, elements: int) -> Record:
    """From the fields, slips and further inputs of a first row to the effort."""
    record = Record()
    fields = [record.input(f"field{i}") for i in range(elements)]
    slips = [record.input(f"slip{i}") for i in range(elements)]
    extras = {name: record.input(f"extra {name}") for name in model.extras}
    stages = stage_numbers(model)

    def through(place: Place, signal: Any) -> Any:
        for stage, q in stages:
            if stage.place == place:
                memory = _FirstRow(stage.initial(signal, q))
                (signal,) = stage.step(memory, signal, q, 1.0)
        return signal

    fluids = [through("command", model.command(field)) for field in fields]
    remembered: list[list[Any]] = []  # of each element, of each stage on the slip, its outputs
    for moved in model.moved(fluids, slips):
        outputs: list[Any] = []
        for stage, q in stages:
            if stage.place == "slip":
                memory = _FirstRow(stage.initial(moved, q))
                outputs.append(stage.step(memory, moved, q, 1.0))
        remembered.append(outputs)
    signals = FluidSignals(fluids, slips, remembered, extras)
    effort = through("effort", model.from_fluid(signals))
    if model.correction is not None:
        effort = effort + model.correction.of(*model.correction.inputs(signals))
    record.give(effort + 0.0)  # no effort is minus zero

    def forward(*inputs: Any) -> Any:
        one_row = np.array([[x] for x in inputs], object)
        return model.network_part.of_inputs(one_row)[0]

    for node in record.nodes:
        if node.operation == "network":
            record.calls["network"] = recorded(
                forward, [f"x{i}" for i in range(len(node.arguments))]
            )
    return record
