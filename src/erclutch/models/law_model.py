"""A TorqueModel has a device, stages, a law and the numbers. It predicts effort and knows nothing of fits.

Normalisation is inside: fields are divided by the reference field, slips by the reference slip, so nobody ports it
by hand.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import add
from typing import Any

import numpy as np

from erclutch.arithmetic.as_in_c import array_as_in_c
from erclutch.models import model_file, plugin_efforts
from erclutch.models.band import Band
from erclutch.models.composition import OFFSET
from erclutch.models.given_rows import further_inputs
from erclutch.models.laws import law_from_name
from erclutch.models.model import FluidSignals, Pair, Range, settled_memory
from erclutch.models.parameter_units import (
    gain_in_user_units,
    in_user_units,
    known_unit,
    unit_of_gain,
    unit_text,
)
from erclutch.models.shared_answers import ModelBase
from erclutch.models.stages import (
    position_stages,
    slip_stages,
    stage_equations,
    temperature_stages,
)
from erclutch.models.stages.stage import SlipAndStrength
from erclutch.models.structure import Reference, Structure, as_it_is
from erclutch.registry import Plugin
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import Element, Units
from erclutch.signals.recording import POSITION, TEMPERATURE
from erclutch.signals.units import LEAST_KELVIN, MOST_KELVIN, UNKNOWN

KIND = "erclutch torque model"


@dataclass(frozen=True, repr=False)
class TorqueModel(ModelBase):
    """Effort of a device from its fields and slips.

    Attributes:
        structure: device, law, dynamics, friction and offset.
        reference: what normalises the inputs.
        shape: normalised nonlinear parameters by name.
        gains: linear parameters by name: effort per normalised column.
        units: units of inputs and output.
        trained_on: range of the training data.
        extra_ranges: range of each further input in the training data.
        units_as_logged: unit of each further input where the log gave it, else "?".
        band: how far the measured effort may lie from the estimate.
    """

    structure: Structure
    reference: Reference
    shape: Mapping[str, float]
    gains: Mapping[str, float]
    units: Units
    trained_on: Range
    about: Mapping[str, str] = field(default_factory=dict[str, str])
    extra_ranges: tuple[Pair, ...] = ()
    units_as_logged: tuple[str, ...] = ()
    band: Band | None = None
    #: Nothing is added to a law's effort.
    correction: None = field(
        default=None,
        init=False,
        repr=False,
        compare=False,
    )

    @property
    def law_part(self) -> TorqueModel:
        """The model itself."""
        return self

    @property
    def title(self) -> str:
        """Name for people."""
        return self.structure.law.title

    @property
    def period(self) -> float:
        """Sampling period of the training data in s."""
        return self.reference.period

    @property
    def times(self) -> Mapping[str, float]:
        """Parameters of the stages by name."""
        times: dict[str, float] = {}
        for stage in self.structure.stages:
            for number in stage.parameters(self.period):
                times[number.name] = self.shape[number.name]
        return times

    @property
    def extras(self) -> Mapping[str, Pair]:
        """Further inputs, and the range of each."""
        return dict(zip(self.structure.extras, self.extra_ranges, strict=True))

    @property
    def extra_units(self) -> Mapping[str, str]:
        """The unit of each further input, in the order of the structure; "?" where nobody gave it."""
        names = self.structure.extras
        logged = dict(zip(names, self.units_as_logged, strict=False))
        return {name: known_unit(name, self.units, logged.get(name, UNKNOWN)) for name in names}

    @property
    def past(self) -> tuple[int, ...]:
        """No law has past rows as inputs."""
        return ()

    @property
    def signed(self) -> bool:
        """A law sees the magnitude of the field."""
        return False

    @property
    def numbers(self) -> Mapping[str, Any]:
        """Parameters and what normalises the inputs, by name."""
        return {
            **self.shape,
            **self.gains,
            "reference field": self.reference.field,
            "reference slip": self.reference.slip,
            "reference of further inputs": self.reference.extras,
        }

    def in_units(self) -> Iterator[tuple[str, float, str, str]]:
        """Name, value in the data's units, unit and meaning of each parameter."""
        for shape in self.structure.shapes(self.period):
            value = in_user_units(self.shape[shape.name], shape.dimension, self.reference)
            unit = unit_text(shape.dimension, self.units)
            yield shape.name, value, unit, shape.meaning
        for gain in self.structure.gains():
            value = gain_in_user_units(self.gains[gain.name], gain, self.reference)
            unit = unit_of_gain(gain, self.units, self.extra_units)
            yield gain.name, value, unit, gain.meaning

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """What the model needs of other packages; its file names them."""
        return self.structure.plugins

    def effort_of_rows(
        self,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array],
        *,
        exactly: bool,
    ) -> Array:
        """Effort on the long road, shape (n,); see `ModelBase.effort`."""
        q = list(self.shape.values())
        functions = array_as_in_c if exactly else as_it_is
        further = further_inputs(self.structure.extras, extras)
        columns = self.structure.columns(
            elements, clock, self.reference, q, functions=functions, extras=further
        )
        effort = np.zeros(clock.time.size)
        for term in self._terms(columns):
            effort += np.asarray(term)
        if not exactly:  # the columns came from behind the stages on the effort
            return effort
        behind = self.structure.behind(array_as_in_c(effort), clock, q)
        return np.asarray(behind)

    def _terms(self, columns: Sequence[Any]) -> Iterator[Any]:
        """The columns times their gains; they are added from left to right as in the exported C."""
        return (gain * column for gain, column in zip(self.gains.values(), columns, strict=True))

    def steady(
        self,
        fields: Sequence[Array],
        slips: Sequence[Array],
        extras: Sequence[Array] = (),
    ) -> Array:
        """Effort once the field has settled, shape (n,): no stages.

        Args:
            fields: of each element, each (n,), in the data's unit.
            slips: of each element, each (n,), in the data's unit.
            extras: further inputs in the order of the structure, each (n,).
        """
        # A field that has settled is the command itself.
        fluids = [self.command(array_as_in_c(np.atleast_1d(field))) for field in fields]
        slips_as_in_c = [array_as_in_c(np.atleast_1d(slip)) for slip in slips]
        remembered = settled_memory(self, self.moved(fluids, slips_as_in_c))
        further = dict(zip(self.structure.extras, extras, strict=True))
        signals = FluidSignals(fluids, slips_as_in_c, remembered, further)
        return np.asarray(self.from_fluid(signals), np.float64)

    def command(self, field: Any) -> Any:
        """What the stages work on: the normalised field after the law's stimulus; elementwise on any operand."""
        shape = list(self.shape.values())
        return self.structure.command(field, self.reference, shape)

    def moved(self, fluids: Sequence[Any], slips: Sequence[Any]) -> list[SlipAndStrength]:
        """What the stages on the slip of each element work on, elementwise on any operand."""
        shape = list(self.shape.values())
        return self.structure.moved(fluids, slips, self.reference, shape)

    def from_fluid(self, signals: FluidSignals) -> Any:
        """Effort ahead of the stages on it, elementwise on any operand; see `Model`."""
        shape = list(self.shape.values())
        columns = self.structure.from_fluid(signals, self.reference, shape)
        return reduce(add, self._terms(columns))

    def scaled(self, factor: float, offset: float = 0.0) -> TorqueModel:
        """The same law with its effort times a factor, and a constant effort ``offset`` more, in the effort's unit."""
        gains = {name: factor * gain for name, gain in self.gains.items()}
        if offset:
            gains[OFFSET.name] = gains.get(OFFSET.name, 0.0) + offset
        return self.with_gains(gains)

    def with_gains(self, gains: Mapping[str, float]) -> TorqueModel:
        """The same law with other gains, by name; a constant effort may be among them, though the law had none."""
        offset = self.structure.offset or OFFSET.name in gains
        structure = replace(self.structure, offset=offset)
        return replace(self, structure=structure, gains={**self.gains, **gains})

    def equation(self) -> list[str]:
        """The equation and its numbers, as lines of a comment."""
        from erclutch.models.laws.symbolic import equation_text, memory_terms

        structure = self.structure
        law = structure.law
        effort = equation_text(law)
        for stage in slip_stages(structure.dynamics):
            for gain, column in memory_terms(stage):
                effort += f" + {gain}*{column}"
        lines = [f"{self.title} ({law.source}). One element, for w > 0 (odd in w):", ""]
        lines += [f"  effort = {effort}", ""]
        lines += [
            f"with E = |field in the fluid| / {self.reference.field:.9g}, w = slip / {self.reference.slip:.9g}."
        ]
        if slip_stages(structure.dynamics):
            lines += [
                "y(E) is the strength of the field: 1 at E = 1, of the form of the yield effort, else E^n_m."
            ]
        if structure.elements == 2:
            lines += [
                "T = T1 + T2; element 2 drives the other way: its law sees -w2 and its effort counts negative."
            ]
        if law.forward:
            lines += ["The yield effort keeps the sign in which the device drives."]
        references = dict(zip(structure.extras, self.reference.extras, strict=True))
        lines += [term.sentence(references) for term in structure.added_terms()]
        if temperature_stages(structure.dynamics):
            lines += [f"t is {TEMPERATURE} over {self.reference.temperature:.9g}."]
        if position_stages(structure.dynamics):
            lines += [f"x is {POSITION} over {self.reference.slip:.9g}."]
        lines += [*stage_equations(structure.dynamics), ""]
        numbers = {**self.shape, **self.gains}
        lines += [f"  {name:<10} = {value:.17g}" for name, value in numbers.items()]
        return lines

    def to_dict(self) -> dict[str, Any]:
        """As plain JSON values, with a schema version and a digest over all of them."""
        body: dict[str, Any] = {
            "kind": KIND,
            "schema": model_file.SCHEMA,
            "device": self.structure.device,
            "law": self.structure.specification,
            "dynamics": self.structure.dynamics,
            "friction": self.structure.friction,
            "offset": self.structure.offset,
            "units": {
                "effort": self.units.effort,
                "field": self.units.field,
                "slip": self.units.slip,
            },
            "reference": {
                "field": self.reference.field,
                "slip": self.reference.slip,
                "period_s": self.reference.period,
            },
            "shape": dict(self.shape),
            "gains": dict(self.gains),
        }
        extras: list[dict[str, Any]] = []
        further = zip(self.structure.extras, self.reference.extras, self.extra_ranges, strict=True)
        for name, scale, covered in further:
            entry = {"name": name, "reference": scale, "trained_on": list(covered)}
            unit = self.extra_units[name]
            if unit != known_unit(name, self.units):  # what the name does not tell
                entry["unit"] = unit
            extras.append(entry)
        if extras:
            body["extras"] = extras
        body["trained_on"] = self.trained_on.to_dict()
        body["about"] = dict(self.about)
        if self.plugins:
            body["plugins"] = [plugin.to_dict() for plugin in self.plugins]
            body[plugin_efforts.ENTRY] = plugin_efforts.efforts_of(self)
        return model_file.sealed(body, self.band)


def model_from_dict(body: Mapping[str, Any], where: str = "model") -> TorqueModel:
    """The model that `TorqueModel.to_dict` wrote.

    Raises:
        RunError: another schema, a missing or unfitting entry, or numbers that do not match the digest.
    """
    return model_file.read_model(body, KIND, where, _model_from)


def _model_from(body: Mapping[str, Any]) -> TorqueModel:
    """The model of a file's content; `model_file.read_model` makes a RunError of what is raised here."""
    device = model_file.device_of(body)
    specification = model_file.specification_of(body["law"], "law")
    further: list[Any] = body.get("extras", [])
    structure = Structure(
        device=device,
        specification=specification,
        law=law_from_name(specification, device),
        dynamics=model_file.specification_of(body["dynamics"], "dynamics"),
        friction=model_file.truth_of(body["friction"], "friction"),
        offset=model_file.truth_of(body["offset"], "offset"),
        extras=model_file.names_of([entry["name"] for entry in further], "further inputs"),
    )

    references = body["reference"]
    reference_field = model_file.number_of(references["field"], "field", positive=True)
    slip = model_file.number_of(references["slip"], "slip", positive=True)
    period = model_file.number_of(references["period_s"], "period_s", positive=True)
    scales = tuple(
        model_file.number_of(entry["reference"], "reference", positive=True) for entry in further
    )
    scale_of = dict(zip(structure.extras, scales, strict=True))
    warmth = scale_of.get(TEMPERATURE, 1.0)
    if temperature_stages(structure.dynamics) and not LEAST_KELVIN <= warmth <= MOST_KELVIN:
        raise ValueError(
            f"the reference temperature is {warmth} K, not from {LEAST_KELVIN:g} to {MOST_KELVIN:g} K"
        )

    shape: dict[str, float] = {}
    for number in structure.shapes(period):
        value = body["shape"][number.name]
        shape[number.name] = model_file.number_of(value, number.name)
    # Values after names: a name that is missing is told before a value that does not fit.
    for number in structure.shapes(period):
        if not number.lower <= shape[number.name] <= number.upper:
            limits = f"from {number.lower:g} to {number.upper:g}"
            raise ValueError(f"{number.name} is {shape[number.name]}, not {limits}")
    gains: dict[str, float] = {}
    for gain in structure.gains():
        value = body["gains"][gain.name]
        gains[gain.name] = model_file.number_of(value, gain.name)
    ranges = [
        model_file.pair_of(entry["trained_on"], "range of a further input") for entry in further
    ]
    return TorqueModel(
        structure=structure,
        reference=Reference(reference_field, slip, period, scales, warmth),
        shape=shape,
        gains=gains,
        units=model_file.units_of(body),
        trained_on=model_file.range_of(body),
        about=model_file.about_of(body),
        extra_ranges=tuple(ranges),
        units_as_logged=tuple(model_file.unit_of(entry.get("unit", UNKNOWN)) for entry in further),
    )
