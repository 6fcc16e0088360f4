"""A Structure says what a law with its stages is made of, without numbers, and computes one column a gain from them.

The stages on the command make the field in the fluid. The law and the stages on the slip make columns of fluid and
slip. A model multiplies each column by its gain. Stages on the effort work on the sum.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.as_in_c import ArrayAsInC, array_as_in_c
from erclutch.arithmetic.dual import pick
from erclutch.errors import SettingError
from erclutch.models.laws import Dimension, Gain, Law, ShapeParameter, law_from_name
from erclutch.models.laws.law import Part
from erclutch.models.laws.smooth import FORWARD, direction
from erclutch.models.laws.yield_stress import POWER
from erclutch.models.model import FluidSignals
from erclutch.models.stages import (
    NONE,
    canonical,
    position_stages,
    slip_stages,
    stages_at,
    stages_of,
    temperature_stages,
)
from erclutch.models.stages.stage import SlipAndStrength, Stage
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import DeviceName, Element
from erclutch.signals.recording import POSITION, TEMPERATURE

_FRICTION = Gain("T_f", "friction effort at zero field", Dimension(effort=1))
#: Of the field in the memory's effort, where the law has no form of its own to share.
_EXPONENT = ShapeParameter("n_m", "exponent of the field in the memory's effort", 0.2, 4.0)
OFFSET = Gain("T_0", "constant effort", Dimension(effort=1), nonnegative=False)


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


def as_it_is(x: Any) -> Any:
    """An array with NumPy's own functions, where a law could also compute as the exported C does."""
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
            that is one of them, and it has no gain; with stages on the position that is one of them too.
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
        if position_stages(self.dynamics) and POSITION not in self.extras:
            object.__setattr__(self, "extras", (*self.extras, POSITION))

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
        moving = (gain for stage in position_stages(self.dynamics) for gain in stage.gains)
        return (*named, *further, *moving, *((OFFSET,) if self.offset else ()))

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
        rows: slice | NDArray[np.intp] = slice(None),
        functions: Callable[[Any], Any] = as_it_is,
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
        slices = wanted if isinstance(wanted, slice) else slice(None)
        whole = slice(None) if memory else slices
        fluids, slips, moved, remembered = self.signals(
            elements, clock, reference, q, functions, rows=whole, wanted=slices
        )
        if slices is not wanted or whole != slices:
            fluids, slips = [pick(fluid, wanted) for fluid in fluids], [slip[wanted] for slip in slips]
            moved = [SlipAndStrength(m.slip[wanted], pick(m.strength, wanted)) for m in moved]
        if slices is not wanted:
            remembered = [[[pick(x, wanted) for x in outputs] for outputs in own] for own in remembered]
        further = {name: functions((extras or {})[name][wanted]) for name in self.extras}
        columns = self.from_fluid(FluidSignals(fluids, slips, remembered, further), reference, q, moved)
        plain = ahead or functions is not as_it_is
        return columns if plain else [self.behind(column, clock, q, rows) for column in columns]

    def signals(
        self,
        elements: Sequence[Element],
        clock: Clock,
        reference: Reference,
        q: Sequence[Any],
        functions: Callable[[Any], Any] = as_it_is,
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

    def behind(self, effort: Any, clock: Clock, q: Sequence[Any], rows: slice | NDArray[np.intp] = slice(None)) -> Any:
        """What the stages on the effort make of an effort, or of a column of it, over all rows; some of them."""
        stages = stages_at(self.dynamics, "effort")
        for stage in stages:
            effort = stage.respond(effort, clock, self.numbers_of(stage, q), slice(None))
        return pick(effort, rows) if stages else effort

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
        for stage in position_stages(self.dynamics):
            # The slip's own scale, so that the numbers of the stage are ways, in the position's unit.
            position = signals.extras[POSITION] / reference.slip
            columns.extend(stage.outputs_at(position, *self.numbers_of(stage, q)))
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
