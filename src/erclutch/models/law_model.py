"""A TorqueModel has a device, stages, a law and the numbers. It predicts effort and knows nothing of fits.

Normalisation is inside: fields are divided by the reference field, slips by the reference slip, so nobody ports it
by hand.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from operator import add
from typing import Any

import numpy as np

from erclutch.arithmetic.as_in_c import ArrayAsInC, array_as_in_c
from erclutch.arithmetic.dual import pick
from erclutch.errors import SettingError
from erclutch.models import model_file
from erclutch.models.band import Band
from erclutch.models.laws import Dimension, Gain, Law, ShapeParameter, law_from_name
from erclutch.models.laws.law import Part
from erclutch.models.laws.smooth import FORWARD, direction
from erclutch.models.laws.yield_stress import POWER
from erclutch.models.model import FluidSignals, Pair, Range, further_inputs, settled_memory
from erclutch.models.shared_answers import ModelBase
from erclutch.models.stages import (
    NONE,
    canonical,
    outside_stages,
    slip_stages,
    stage_equations,
    stages_at,
    stages_of,
    temperature_stages,
)
from erclutch.models.stages.stage import SlipAndStrength, Stage
from erclutch.registry import Plugin
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import DeviceName, Element, Units
from erclutch.signals.recording import TEMPERATURE
from erclutch.signals.units import LEAST_KELVIN, MOST_KELVIN

KIND = "erclutch torque model"


@dataclass(frozen=True)
class Reference:
    """What normalises a model's inputs.

    Attributes:
        field: largest magnitude of the training fields, in the data's unit.
        slip: root mean square of the training slips, in the data's unit.
        period: sampling period of the training data in s; bounds the lags that can be told.
        extras: root mean square of each further input, in its unit.
        temperature: that of the temperature, in K, of a law that feels it.
    """

    field: float
    slip: float
    period: float
    extras: tuple[float, ...] = ()
    temperature: float = 1.0


def _as_it_is(x: Any) -> Any:
    return x


@dataclass(frozen=True)
class Structure:
    """What is fitted, without numbers.

    Attributes:
        device: "single" or "coaxial".
        specification: name of the law, for example ``hem/square``.
        law: the law itself.
        dynamics: names of the stages on command, slip and effort, joined by ``+``; "none" for none.
        friction: a column of Coulomb friction at zero field (seals, bearings, remanence), one an element.
        offset: a constant effort (gas spring, preload, sensor zero).
        extras: further logged inputs, each with a gain (displacement, acceleration); with stages on the temperature
            that is one of them, and it has no gain.
    """

    device: DeviceName
    specification: str
    law: Law
    dynamics: str = NONE
    friction: bool = False
    offset: bool = False
    extras: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "dynamics", canonical(self.dynamics))
        self._require_parts()
        if temperature_stages(self.dynamics) and TEMPERATURE not in self.extras:
            object.__setattr__(self, "extras", (*self.extras, TEMPERATURE))

    def _require_parts(self) -> None:
        for stage in temperature_stages(self.dynamics):
            if stage.part not in self.law.parts:
                raise SettingError(
                    f"the law {self.specification} does not say which of its gains are the {stage.part} effort",
                    remedy=f"Leave {stage.name} out, or give the law's gains their part",
                )

    def __reduce__(self) -> tuple[Any, ...]:
        """Law functions are made, not imported, so a copy in another process makes its own from the names."""
        return _structure, (self.device, self.specification, self.dynamics, self.friction, self.offset, self.extras)

    @property
    def elements(self) -> int:
        """Number of elements of the device."""
        return 2 if self.device == "coaxial" else 1

    @property
    def ways(self) -> tuple[float, ...]:
        """Sign in which each element drives: a law sees it as forward. Laws are odd, so only `Law.forward` feels it."""
        return (1.0, -1.0) if self.elements == 2 else (1.0,)

    def shapes(self, period: float) -> tuple[ShapeParameter, ...]:
        """All nonlinear parameters: of the stimulus, the law, the memory's strength, the stages."""
        times = (p for stage in self.stages for p in stage.parameters(period))
        return (*self.law.stimulus_shape, *self.law.shape, *self._own_strength, *times)

    @property
    def stages(self) -> tuple[Stage, ...]:
        """All stages, in the order of the specification."""
        return stages_of(self.dynamics)

    @property
    def remembers(self) -> bool:
        """Whether a stage stands on the slip or on the effort."""
        return any(stage.place in ("slip", "effort") for stage in self.stages)

    @property
    def _own_strength(self) -> tuple[ShapeParameter, ...]:
        """The exponent of the field in the memory, for a law that has no yield form to share with it."""
        return (_EXPONENT,) if self.law.yield_form is None and slip_stages(self.dynamics) else ()

    def numbers_of(self, stage: Stage, q: Sequence[Any]) -> list[Any]:
        """The parameters of one of the stages among all nonlinear ones."""
        return list(q[self._places[stage.name]])

    @cached_property
    def _strength_places(self) -> tuple[int, ...]:
        """Where the parameters of the memory's strength stand among all nonlinear ones."""
        names = [p.name for p in self.shapes(1.0)]
        own = self.law.yield_form.shape if self.law.yield_form else (_EXPONENT,)
        return tuple(names.index(p.name) for p in own)

    @cached_property
    def _places(self) -> Mapping[str, slice]:
        """Where the parameters of each stage stand among all nonlinear ones."""
        counts = [len(stage.parameters(1.0)) for stage in self.stages]
        first = len(self.law.stimulus_shape) + len(self.law.shape) + len(self._own_strength)
        ends = first + np.cumsum([0, *counts])
        return {stage.name: slice(int(a), int(b)) for stage, a, b in zip(self.stages, ends, ends[1:], strict=False)}

    def gains(self) -> tuple[Gain, ...]:
        """All linear parameters, elements one after another, then those of the whole device."""
        own = self._gains_of_element
        if self.elements == 1:
            named = own
        else:
            named = tuple(
                replace(g, name=f"{g.name}_{i + 1}", meaning=f"{g.meaning}, CH{i + 1}")
                for i in range(self.elements)
                for g in own
            )
        further = (
            Gain(f"c_{i + 1}", f"effort per {name}", _FRICTION.dimension, nonnegative=False, extra=i)
            for i, name in enumerate(self.extras)
            if i != self._temperature_place
        )
        return (*named, *further, *((_OFFSET,) if self.offset else ()))

    @property
    def _gains_of_element(self) -> tuple[Gain, ...]:
        memory = (gain for stage in slip_stages(self.dynamics) for gain in stage.gains)
        return (*self.law.gains, *((_FRICTION,) if self.friction else ()), *memory)

    @cached_property
    def _temperature_place(self) -> int | None:
        """Which further input is the temperature; None for a law that does not feel it."""
        return self.extras.index(TEMPERATURE) if temperature_stages(self.dynamics) else None

    def _factors(self, extras: Sequence[Any], reference: Reference, q: Sequence[Any]) -> dict[Part | None, Any]:
        """What the temperature makes of the parts of the fluid's effort, elementwise on any operand."""
        if self._temperature_place is None:
            return {}
        relative = extras[self._temperature_place] / reference.temperature
        factors: dict[Part | None, Any] = {}
        for stage in temperature_stages(self.dynamics):
            factors[stage.part] = stage.factor(relative, *self.numbers_of(stage, q))
        return factors

    def _law_columns(
        self, strength: Any, slip: Any, shape: Sequence[Any], factors: Mapping[Part | None, Any]
    ) -> list[Any]:
        """The law's columns; a viscosity that is a ratio to the yield effort feels the temperature before them."""
        if factors:
            shape = [
                value * (factors.get("viscous", 1.0) / factors.get("yield", 1.0)) if s.viscous_over_yield else value
                for s, value in zip(self.law.shape, shape, strict=True)
            ]
        return [*self.law.columns(strength, slip, *shape)]

    def columns(
        self,
        elements: Sequence[Element],
        clock: Clock,
        reference: Reference,
        q: Sequence[Any],
        rows: slice = slice(None),
        functions: Callable[[Any], Any] = _as_it_is,
        extras: Mapping[str, Array] | None = None,
        *,
        ahead: bool = False,
    ) -> list[Any]:
        """One column a gain, for normalised nonlinear parameters ``q`` (numbers or duals), at some of the rows.

        Stages run over all rows whatever is asked for: the fluid remembers its whole past. What ``functions``
        makes of an array is what the law computes with: `array_as_in_c` brings the exported C's exp, tanh and powers.
        Stages on the effort are not in the columns of such arrays, nor in those ``ahead`` of them, which come at all
        rows where there are such stages; `behind` has them.
        """
        memory = slip_stages(self.dynamics)
        wanted = slice(None) if stages_at(self.dynamics, "effort") else rows
        whole = slice(None) if memory else wanted
        fluids, slips, moved, remembered = self.signals(
            elements, clock, reference, q, functions, rows=whole, wanted=wanted
        )
        if whole != wanted:
            fluids, slips = [pick(fluid, wanted) for fluid in fluids], [slip[wanted] for slip in slips]
            moved = [SlipAndStrength(m.slip[wanted], pick(m.strength, wanted)) for m in moved]
        further = {name: functions((extras or {})[name][wanted]) for name in self.extras}
        columns = self.from_fluid(FluidSignals(fluids, slips, remembered, further), reference, q, moved)
        plain = ahead or functions is not _as_it_is
        return columns if plain else [self.behind(column, clock, q, rows) for column in columns]

    def signals(
        self,
        elements: Sequence[Element],
        clock: Clock,
        reference: Reference,
        q: Sequence[Any],
        functions: Callable[[Any], Any] = _as_it_is,
        *,
        rows: slice = slice(None),
        wanted: slice = slice(None),
    ) -> tuple[list[Any], list[Any], list[SlipAndStrength], list[list[Sequence[Any]]]]:
        """What a law works on: field in the fluid and slip of each element, what moves its memory, and its memory.

        The memory comes at the rows that are wanted; it has run over ``rows``, as all else that comes.
        """
        commands = [self.command(functions(e.field), reference, q) for e in elements]
        fluids = [functions(self.in_fluid(command, clock, q, rows)) for command in commands]
        slips = [functions(e.slip[rows]) for e in elements]
        moved = self.moved(fluids, slips, reference, q)
        stages = slip_stages(self.dynamics)
        remembered = [[stage.respond(m, clock, self.numbers_of(stage, q), wanted) for stage in stages] for m in moved]
        return fluids, slips, moved, remembered

    def behind(self, effort: Any, clock: Clock, q: Sequence[Any], rows: slice = slice(None)) -> Any:
        """What the stages on the effort make of an effort, or of a column of it, over all rows; some of them."""
        stages = stages_at(self.dynamics, "effort")
        for stage in stages:
            effort = stage.respond(effort, clock, self.numbers_of(stage, q), slice(None))
        return pick(effort, rows) if stages and rows != slice(None) else effort

    def command(self, field: Any, reference: Reference, q: Sequence[Any]) -> Any:
        """What the stages work on, elementwise on any operand."""
        command, stimulus = field / reference.field, self.law.stimulus
        return command if stimulus is None else stimulus(command, *q[: len(self.law.stimulus_shape)])

    def moved(
        self, fluids: Sequence[Any], slips: Sequence[Any], reference: Reference, q: Sequence[Any]
    ) -> list[SlipAndStrength]:
        """What the stages on the slip of each element work on, elementwise on any operand."""
        if not slip_stages(self.dynamics):
            return [SlipAndStrength(slip, 1.0) for slip in slips]
        form, shape = self.law.yield_form or POWER, [q[i] for i in self._strength_places]
        return [
            SlipAndStrength(way * slip / reference.slip, form.factor(np.abs(fluid), *shape))
            for way, fluid, slip in zip(self.ways, fluids, slips, strict=True)
        ]

    def from_fluid(
        self,
        signals: FluidSignals,
        reference: Reference,
        q: Sequence[Any],
        moved: Sequence[SlipAndStrength] | None = None,
    ) -> list[Any]:
        """One column a gain, elementwise on any operand.

        Args:
            signals: what the law works on.
            reference: what normalises.
            q: nonlinear parameters.
            moved: what `moved` makes of fluids and slips, where that is known.
        """
        first = len(self.law.stimulus_shape)
        shape = q[first : first + len(self.law.shape)]
        fluids, slips, extras = signals.fluids, signals.slips, [signals.extras[name] for name in self.extras]
        moved = self.moved(fluids, slips, reference, q) if moved is None else moved
        factors, gains = self._factors(extras, reference, q), self._gains_of_element
        columns: list[Any] = []
        for way, fluid, relative, m, outputs in zip(self.ways, fluids, slips, moved, signals.remembered, strict=True):
            strength, slip = np.abs(fluid), way * relative / reference.slip
            turn = FORWARD if self.law.forward else shape[0]
            own = self._law_columns(strength, slip, shape, factors)
            if self.friction:
                own.append(direction(slip, turn) * np.ones(slip.size))
            for stage, values in zip(slip_stages(self.dynamics), outputs, strict=True):
                own.extend(stage.columns(values, m.strength))
            if factors:
                own = [c * factors[g.part] if g.part in factors else c for c, g in zip(own, gains, strict=True)]
            columns.extend(own if way > 0 else (-c for c in own))
        scaled = enumerate(zip(extras, reference.extras, strict=True))
        columns.extend(x / scale for i, (x, scale) in scaled if i != self._temperature_place)
        if self.offset:
            columns.append(np.ones(slips[0].size))
        return columns

    def in_fluid(self, command: Any, clock: Clock, q: Sequence[Any], rows: slice) -> Any:
        """The field in one element's fluid at some of the rows: the command after the stages on it."""
        stages = stages_at(self.dynamics, "command")
        for k, stage in enumerate(stages):
            wanted = rows if k == len(stages) - 1 else slice(None)
            behind = stage.respond(command, clock, self.numbers_of(stage, q), wanted)
            command = array_as_in_c(behind) if isinstance(command, ArrayAsInC) else behind
        return command if stages else pick(command, rows)


def _structure(device: DeviceName, specification: str, *rest: Any) -> Structure:
    return Structure(device, specification, law_from_name(specification, device), *rest)


_FRICTION = Gain("T_f", "friction effort at zero field", Dimension(effort=1))
#: Of the field in the memory's effort, where the law has no form of its own to share.
_EXPONENT = ShapeParameter("n_m", "exponent of the field in the memory's effort", 0.2, 4.0)
_OFFSET = Gain("T_0", "constant effort", Dimension(effort=1), nonnegative=False)


def in_user_units(value: float, dimension: Dimension, reference: Reference) -> float:
    """A normalised number in the data's own units."""
    scale = reference.field**dimension.field * reference.slip**dimension.slip
    return value * scale * reference.temperature**dimension.temperature


def unit_text(dimension: Dimension, units: Units) -> str:
    """Unit of a parameter, such as ``N/(m/s)``; "1" for a pure number, "?" inside where the log gave no unit."""
    above: list[str] = []
    below: list[str] = []
    motion = ((dimension.slip, units.slip), (dimension.time, "s"))
    if dimension.slip and dimension.time and units.slip.endswith("/s"):
        way = units.slip.removesuffix("/s")
        motion = ((dimension.slip, way if dimension.slip == dimension.time else f"{way}/s^2"),)
    powers = ((dimension.effort, units.effort), (dimension.field, units.field), *motion, (dimension.temperature, "K"))
    for exponent, unit in powers:
        if exponent and unit:
            name = f"({unit})" if "/" in unit and (exponent < 0 or exponent > 1) else unit
            power = f"^{abs(exponent)}" if abs(exponent) > 1 else ""
            (above if exponent > 0 else below).append(name + power)
    text = "*".join(above) or "1"
    return text + "".join(f"/{name}" for name in below)


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
    band: Band | None = None
    #: Nothing is added to a law's effort.
    correction: None = field(default=None, init=False, repr=False, compare=False)

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
        names = [p.name for stage in self.structure.stages for p in stage.parameters(self.period)]
        return {name: self.shape[name] for name in names}

    @property
    def extras(self) -> Mapping[str, Pair]:
        """Further inputs, and the range of each."""
        return dict(zip(self.structure.extras, self.extra_ranges, strict=True))

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
        reference = {"reference field": self.reference.field, "reference slip": self.reference.slip}
        return {**self.shape, **self.gains, **reference, "reference of further inputs": self.reference.extras}

    def in_units(self) -> Iterator[tuple[str, float, str, str]]:
        """Name, value in the data's units, unit and meaning of each parameter."""
        for shape in self.structure.shapes(self.period):
            value = in_user_units(self.shape[shape.name], shape.dimension, self.reference)
            yield shape.name, value, unit_text(shape.dimension, self.units), shape.meaning
        for gain in self.structure.gains():
            scale = 1.0 if gain.extra is None else self.reference.extras[gain.extra]
            value = in_user_units(self.gains[gain.name], gain.dimension, self.reference) / scale
            yield gain.name, value, unit_text(gain.dimension, self.units), gain.meaning

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """What the model needs of other packages; its file names them."""
        law = self.structure.law.plugin
        return (*(() if law is None else (law,)), *outside_stages(self.structure.dynamics))

    def effort_of_rows(
        self, elements: Sequence[Element], clock: Clock, extras: Mapping[str, Array], *, exactly: bool
    ) -> Array:
        """Effort on the long road, shape (n,); see `ModelBase.effort`."""
        q = list(self.shape.values())
        functions = array_as_in_c if exactly else _as_it_is
        further = further_inputs(self.structure.extras, extras)
        total = np.zeros(clock.time.size)
        columns = self.structure.columns(elements, clock, self.reference, q, functions=functions, extras=further)
        for term in self._terms(columns):
            total += np.asarray(term)
        return np.asarray(self.structure.behind(array_as_in_c(total), clock, q)) if exactly else total

    def _terms(self, columns: Sequence[Any]) -> Iterator[Any]:
        """The columns times their gains; they are added from left to right as in the exported C."""
        return (gain * column for gain, column in zip(self.gains.values(), columns, strict=True))

    def steady(self, fields: Sequence[Array], slips: Sequence[Array], extras: Sequence[Array] = ()) -> Array:
        """Effort once the field has settled: no stages. One array (n,) an element, in the data's units."""
        fluids = [self.command(array_as_in_c(np.atleast_1d(f))) for f in fields]
        relative = [array_as_in_c(np.atleast_1d(w)) for w in slips]
        remembered = settled_memory(self, self.moved(fluids, relative))
        further = dict(zip(self.structure.extras, extras, strict=True))
        return np.asarray(self.from_fluid(FluidSignals(fluids, relative, remembered, further)), np.float64)

    def command(self, field: Any) -> Any:
        """What the stages work on: the normalised field after the law's stimulus; elementwise on any operand."""
        return self.structure.command(field, self.reference, list(self.shape.values()))

    def moved(self, fluids: Sequence[Any], slips: Sequence[Any]) -> list[SlipAndStrength]:
        """What the stages on the slip of each element work on, elementwise on any operand."""
        return self.structure.moved(fluids, slips, self.reference, list(self.shape.values()))

    def from_fluid(self, signals: FluidSignals) -> Any:
        """Effort ahead of the stages on it, elementwise on any operand; see `Model`."""
        columns = self.structure.from_fluid(signals, self.reference, list(self.shape.values()))
        return reduce(add, self._terms(columns))

    def equation(self) -> list[str]:
        """The equation and its numbers, as lines of a comment."""
        from erclutch.models.laws.symbolic import equation_text, memory_terms

        law, structure = self.structure.law, self.structure
        lines = [f"{self.title} ({law.source}). One element, for w > 0 (odd in w):", ""]
        memory = (f" + {g}*{c}" for stage in slip_stages(structure.dynamics) for g, c in memory_terms(stage))
        lines += [f"  effort = {equation_text(law)}{''.join(memory)}", ""]
        lines += [f"with E = |field in the fluid| / {self.reference.field:.9g}, w = slip / {self.reference.slip:.9g}."]
        if slip_stages(structure.dynamics):
            lines += ["y(E) is the strength of the field: 1 at E = 1, of the form of the yield effort, else E^n_m."]
        if structure.elements == 2:
            lines += ["T = T1 + T2; element 2 drives the other way: its law sees -w2 and its effort counts negative."]
        if law.forward:
            lines += ["The yield effort keeps the sign in which the device drives."]
        if structure.friction:
            lines += ["A friction effort T_f tanh(w / w_s) is added for each element."]
        if structure.offset:
            lines += ["A constant effort T_0 is added."]
        if temperature_stages(structure.dynamics):
            lines += [f"t is {TEMPERATURE} over {self.reference.temperature:.9g}."]
        lines += stage_equations(structure.dynamics)
        numbers = {**self.shape, **self.gains}
        return [*lines, "", *(f"  {name:<10} = {value:.17g}" for name, value in numbers.items())]

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
            "units": {"effort": self.units.effort, "field": self.units.field, "slip": self.units.slip},
            "reference": {
                "field": self.reference.field,
                "slip": self.reference.slip,
                "period_s": self.reference.period,
            },
            "shape": dict(self.shape),
            "gains": dict(self.gains),
            **({"extras": self._extras_to_dict()} if self.structure.extras else {}),
            "trained_on": self.trained_on.to_dict(),
            "about": dict(self.about),
        }
        if self.plugins:
            body["plugins"] = [plugin.to_dict() for plugin in self.plugins]
        return model_file.sealed(body, self.band)

    def _extras_to_dict(self) -> list[dict[str, Any]]:
        inputs = zip(self.structure.extras, self.reference.extras, self.extra_ranges, strict=True)
        return [{"name": name, "reference": scale, "trained_on": list(pair)} for name, scale, pair in inputs]


def model_from_dict(body: Mapping[str, Any], where: str = "model") -> TorqueModel:
    """The model that `TorqueModel.to_dict` wrote.

    Raises:
        RunError: another schema, a missing or unfitting entry, or numbers that do not match the digest.
    """
    return model_file.read_model(body, KIND, where, _model_from)


def _model_from(body: Mapping[str, Any]) -> TorqueModel:
    device = model_file.device_of(body)
    specification = model_file.specification_of(body["law"], "law")
    further: list[Any] = body.get("extras", [])
    structure = Structure(
        device,
        specification,
        law_from_name(specification, device),
        model_file.specification_of(body["dynamics"], "dynamics"),
        model_file.truth_of(body["friction"], "friction"),
        model_file.truth_of(body["offset"], "offset"),
        model_file.names_of([entry["name"] for entry in further], "further inputs"),
    )
    keys = ("field", "slip", "period_s")
    field_, slip, period = (model_file.number_of(body["reference"][key], key, positive=True) for key in keys)
    scaled = tuple(model_file.number_of(entry["reference"], "reference", positive=True) for entry in further)
    warmth = dict(zip(structure.extras, scaled, strict=True)).get(TEMPERATURE, 1.0)
    if temperature_stages(structure.dynamics) and not LEAST_KELVIN <= warmth <= MOST_KELVIN:
        raise ValueError(f"the reference temperature is {warmth} K, not from {LEAST_KELVIN:g} to {MOST_KELVIN:g} K")
    reference = Reference(field_, slip, period, scaled, warmth)
    shape = {s.name: model_file.number_of(body["shape"][s.name], s.name) for s in structure.shapes(reference.period)}
    for s in structure.shapes(reference.period):
        if not s.lower <= shape[s.name] <= s.upper:
            raise ValueError(f"{s.name} is {shape[s.name]}, not from {s.lower:g} to {s.upper:g}")
    return TorqueModel(
        structure=structure,
        reference=reference,
        shape=shape,
        gains={g.name: model_file.number_of(body["gains"][g.name], g.name) for g in structure.gains()},
        units=model_file.units_of(body),
        trained_on=model_file.range_of(body),
        about=model_file.about_of(body),
        extra_ranges=tuple(model_file.pair_of(entry["trained_on"], "range of a further input") for entry in further),
    )
