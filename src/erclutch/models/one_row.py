"""The effort of a lone row in microseconds: a record of the model runs as machine code, with the bits of `effort`."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import wraps
from typing import Any, TypeVar, cast

import numpy as np

from erclutch.arithmetic.machine import Machine, machine_of
from erclutch.arithmetic.record import Record, recorded
from erclutch.errors import ExportError
from erclutch.models.model import Model, further_inputs, stage_numbers
from erclutch.models.stages.stage import Place
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import Element

#: Lone rows of a model after which Numba, which takes half a second to load, has paid.
WORTH_LOADING = 1000

F = TypeVar("F", bound=Callable[..., Array])


class _LoneRows:
    """What a model keeps of the lone rows that it was asked for: their number, and then its machine."""

    asked = 0
    machine: Machine | None = None
    extras: tuple[str, ...] = ()

    def effort(self, model: Model, elements: Sequence[Element], extras: Mapping[str, Array]) -> float:
        """The effort by machine code; NaN asks for the long road."""
        if self.machine is None:
            self.asked += 1
            if self.asked <= WORTH_LOADING:
                return np.nan
            self.extras = tuple(model.extras)
            try:
                self.machine = machine_of(_recorded(model, len(elements)))
            except ExportError:  # a law or a stage of functions that are not exported: do not ask again
                self.asked = -sys.maxsize
                return np.nan
        row = [e.field.item() for e in elements] + [e.slip.item() for e in elements]
        if self.extras:
            row += [x.item() for x in further_inputs(self.extras, extras).values()]
        return self.machine.run(np.array(row))


def quick_for_one_row(effort: F) -> F:
    """``Model.effort`` with a short road for a model that is asked for one row again and again."""

    @wraps(effort)
    def road(model: Any, elements: Any, clock: Clock, extras: Any = None, *, exactly: bool = True) -> Array:
        if exactly and clock.time.size == 1:
            kept: dict[str, Any] = model.__dict__
            own: _LoneRows = kept.get("_lone_rows") or kept.setdefault("_lone_rows", _LoneRows())
            value = own.effort(model, elements, extras or {})
            if value == value:
                return np.array([value])
        return effort(model, elements, clock, extras, exactly=exactly)

    return cast(F, road)


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
    fields, slips = ([record.input(f"{name}{i}") for i in range(elements)] for name in ("field", "slip"))
    extras = {name: record.input(f"extra {name}") for name in model.extras}
    stages = stage_numbers(model)

    def through(place: Place, signal: Any) -> Any:
        for stage, q in stages:
            if stage.place == place:
                (signal,) = stage.step(_FirstRow(stage.initial(signal, q)), signal, q, 1.0)
        return signal

    fluids = [through("command", model.command(field)) for field in fields]
    remembered = [
        [stage.step(_FirstRow(stage.initial(m, q)), m, q, 1.0) for stage, q in stages if stage.place == "slip"]
        for m in model.moved(fluids, slips)
    ]
    effort = through("effort", model.from_fluid(fluids, slips, remembered, list(extras.values()), _present))
    if model.correction is not None:
        inputs = model.correction.inputs(fluids, slips, remembered, extras, _present)
        effort = effort + model.correction.of(*inputs)
    record.give(effort + 0.0)  # no effort is minus zero
    network: Any = model if model.correction is None else model.correction.network

    def forward(*inputs: Any) -> Any:
        return network.of_inputs(np.array([[x] for x in inputs], object))[0]

    for node in record.nodes:
        if node.operation == "network":
            record.calls["network"] = recorded(forward, [f"x{i}" for i in range(len(node.arguments))])
    return record


def _present(signal: Any, rows: int) -> Any:
    return signal
