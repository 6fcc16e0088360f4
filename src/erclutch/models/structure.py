"""A Structure says what a law with its stages is made of, without numbers, and computes one column a gain from them.

The stages on the command make the field in the fluid. The law and the stages on the slip make columns of fluid and
slip. A model multiplies each column by its gain. Stages on the effort work on the sum.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.as_in_c import ArrayAsInC, array_as_in_c
from erclutch.arithmetic.dual import pick
from erclutch.errors import SettingError
from erclutch.models.laws import Dimension, Gain, Law, ShapeParameter, law_from_name
from erclutch.models.laws.law import Part, YieldForm
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
        law: the law itself; its functions are made anew each time, so equality asks the specification alone.
        dynamics: names of the stages on command, slip and effort, joined by ``+``; "none" for none.
        friction: a column of Coulomb friction at zero field (seals, bearings, remanence), one an element.
        offset: a constant effort (gas spring, preload, sensor zero).
        extras: further logged inputs, each with a gain (displacement, acceleration); with stages on the temperature
            that is one of them, and it has no gain; with stages on the position that is one of them too.
    """

    device: DeviceName
    specification: str
    law: Law = field(compare=False)
    dynamics: str = NONE
    friction: bool = False
    offset: bool = False
    extras: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "dynamics", canonical(self.dynamics))
        warmed = temperature_stages(self.dynamics)
        for stage in warmed:
            if stage.part not in self.law.parts:
                raise SettingError(
                    f"the law {self.specification} does not say which of its gains are the {stage.part} effort",
                    remedy=f"Leave {stage.name} out, or give the law's gains their part",
                )
        if warmed and TEMPERATURE not in self.extras:
            object.__setattr__(self, "extras", (*self.extras, TEMPERATURE))
        if position_stages(self.dynamics) and POSITION not in self.extras:
            object.__setattr__(self, "extras", (*self.extras, POSITION))

    def __reduce__(self) -> tuple[Any, ...]:
        """Law functions are made, not imported, so a copy in another process makes its own from the names."""
        return _structure, (self.device, self.specification, self.dynamics, self.friction, self.offset, self.extras)

    @property
    def elements(self) -> int:
        """Number of elements of the device."""
        return 2 if self.device == "coaxial" else 1

    @property
    def chosen_inputs(self) -> tuple[str, ...]:
        """The further inputs that no stage brings: each stands beside the law with a gain of its own."""
        of_stages: set[str] = set()
        if temperature_stages(self.dynamics):
            of_stages.add(TEMPERATURE)
        if position_stages(self.dynamics):
            of_stages.add(POSITION)
        return tuple(name for name in self.extras if name not in of_stages)

    @property
    def ways(self) -> tuple[float, ...]:
        """Sign in which each element drives: a law sees it as forward. Laws are odd, so only `Law.forward` feels it."""
        return (1.0, -1.0) if self.elements == 2 else (1.0,)

    def shapes(self, period: float) -> tuple[ShapeParameter, ...]:
        """All nonlinear parameters: of the stimulus, the law, the memory's strength, the stages."""
        shapes = [*self.law.stimulus_shape, *self.law.shape, *self._own_strength]
        for stage in self.stages:
            shapes += stage.parameters(period)
        return tuple(shapes)

    @property
    def stages(self) -> tuple[Stage, ...]:
        """All stages, in the order of the specification."""
        return stages_of(self.dynamics)

    @property
    def remembers(self) -> bool:
        """Whether a stage stands on the slip or on the effort."""
        return any(stage.place in ("slip", "effort") for stage in self.stages)

    def with_yield_form(self, form: YieldForm) -> Structure:
        """The same law with another form of the yield effort over the field."""
        name, *options = self.specification.split("/")
        forward = [option for option in options if option == "forward"]
        specification = "/".join([name, form.name, *forward])
        return replace(self, specification=specification, law=law_from_name(specification, self.device))

    @property
    def counts_from_the_start(self) -> bool:
        """Whether a stage begins at the start of a log and knows of all rows since: no window of rows is like it."""
        return any(getattr(stage, "from_the_start", "") for stage in self.stages)

    @property
    def _own_strength(self) -> tuple[ShapeParameter, ...]:
        """The exponent of the field in the memory, for a law that has no yield form to share with it."""
        needed = self.law.yield_form is None and slip_stages(self.dynamics)
        return (_EXPONENT,) if needed else ()

    def numbers_of(self, stage: Stage, q: Sequence[Any]) -> list[Any]:
        """The parameters of one of the stages among all nonlinear ones, ``q``."""
        return list(q[self._places[stage.name]])

    @cached_property
    def _strength_places(self) -> tuple[int, ...]:
        """Where the parameters of the memory's strength stand among all nonlinear ones."""
        names = [shape.name for shape in self.shapes(1.0)]
        form = self.law.yield_form
        strength = form.shape if form else (_EXPONENT,)
        return tuple(names.index(shape.name) for shape in strength)

    @cached_property
    def _places(self) -> Mapping[str, slice]:
        """Where the parameters of each stage stand among all nonlinear ones."""
        places: dict[str, slice] = {}
        start = len(self.law.stimulus_shape) + len(self.law.shape) + len(self._own_strength)
        for stage in self.stages:
            stop = start + len(stage.parameters(1.0))
            places[stage.name] = slice(start, stop)
            start = stop
        return places

    def gains(self) -> tuple[Gain, ...]:
        """All linear parameters, elements one after another, then those of the whole device."""
        gains: list[Gain] = []
        for element in range(1, self.elements + 1):
            for gain in self._gains_of_element:
                if self.elements > 1:
                    gain = replace(gain, name=f"{gain.name}_{element}", meaning=f"{gain.meaning}, CH{element}")
                gains.append(gain)
        effort = _FRICTION.dimension
        for place, name in enumerate(self.extras):
            if place != self._temperature_place:  # the temperature changes gains and has none itself
                gains.append(Gain(f"c_{place + 1}", f"effort per {name}", effort, nonnegative=False, extra=place))
        for stage in position_stages(self.dynamics):
            gains.extend(stage.gains)
        if self.offset:
            gains.append(OFFSET)
        return tuple(gains)

    @property
    def _gains_of_element(self) -> tuple[Gain, ...]:
        """Gains of one element in the order of its columns: the law's, friction, memory."""
        gains = list(self.law.gains)
        if self.friction:
            gains.append(_FRICTION)
        for stage in slip_stages(self.dynamics):
            gains += stage.gains
        return tuple(gains)

    @cached_property
    def _temperature_place(self) -> int | None:
        """Which further input is the temperature; None for a law that does not feel it."""
        if not temperature_stages(self.dynamics):
            return None
        return self.extras.index(TEMPERATURE)

    def _factors(
        self,
        extras: Sequence[Any],
        reference: Reference,
        q: Sequence[Any],
    ) -> dict[Part | None, Any]:
        """What the temperature makes of the parts of the fluid's effort, elementwise on any operand."""
        if self._temperature_place is None:
            return {}
        relative = extras[self._temperature_place] / reference.temperature
        factors: dict[Part | None, Any] = {}
        for stage in temperature_stages(self.dynamics):
            factors[stage.part] = stage.factor(relative, *self.numbers_of(stage, q))
        return factors

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
        # A stage on the effort needs the columns of all rows; stages on the slip need the signals of all rows.
        wanted = slice(None) if stages_at(self.dynamics, "effort") else rows
        listed = not isinstance(wanted, slice)
        remembers_slip = bool(slip_stages(self.dynamics))
        of_signals = slice(None) if remembers_slip else wanted
        fluids, slips, moved, remembered = self.signals(
            elements, clock, reference, q, functions, rows=of_signals, wanted=wanted
        )
        if remembers_slip and (listed or of_signals != wanted):
            fluids = [pick(fluid, wanted) for fluid in fluids]
            slips = [slip[wanted] for slip in slips]
            for element, of_all_rows in enumerate(moved):
                strength = pick(of_all_rows.strength, wanted)
                moved[element] = SlipAndStrength(of_all_rows.slip[wanted], strength)
        logged = extras or {}
        further = {name: functions(logged[name][wanted]) for name in self.extras}

        signals = FluidSignals(fluids, slips, remembered, further)
        columns = self.from_fluid(signals, reference, q, moved)
        if ahead or functions is not as_it_is:
            return columns
        return [self.behind(column, clock, q, rows) for column in columns]

    def signals(
        self,
        elements: Sequence[Element],
        clock: Clock,
        reference: Reference,
        q: Sequence[Any],
        functions: Callable[[Any], Any] = as_it_is,
        *,
        rows: slice | NDArray[np.intp] = slice(None),
        wanted: slice | NDArray[np.intp] = slice(None),
    ) -> tuple[list[Any], list[Any], list[SlipAndStrength], list[list[Sequence[Any]]]]:
        """What a law works on: field in the fluid and slip of each element, what moves its memory, and its memory.

        The memory comes at the rows that are wanted; it has run over ``rows``, as all else that comes.
        """
        fluids: list[Any] = []
        slips: list[Any] = []
        for element in elements:
            command = self.command(functions(element.field), reference, q)
            fluids.append(functions(self.in_fluid(command, clock, q, rows)))
            slips.append(functions(element.slip[rows]))
        moved = self.moved(fluids, slips, reference, q)
        remembered: list[list[Sequence[Any]]] = []  # of each element, of each stage, its outputs
        for of_one in moved:
            outputs: list[Sequence[Any]] = []
            for stage in slip_stages(self.dynamics):
                numbers = self.numbers_of(stage, q)
                asked: Any = wanted
                left = slice(None)  # to pick behind the stage
                if not (isinstance(wanted, slice) or _takes_places(stage)):
                    asked, left = left, wanted
                of_stage = stage.respond(of_one, clock, numbers, asked)
                outputs.append([pick(output, left) for output in of_stage])
            remembered.append(outputs)
        return fluids, slips, moved, remembered

    def behind(
        self,
        effort: Any,
        clock: Clock,
        q: Sequence[Any],
        rows: slice | NDArray[np.intp] = slice(None),
    ) -> Any:
        """What the stages on the effort make of an effort, or of a column of it, shape (n,), at some of the rows.

        The stages run over all rows of the clock, with their own among all nonlinear parameters ``q``.
        """
        stages = stages_at(self.dynamics, "effort")
        for stage in stages:
            numbers = self.numbers_of(stage, q)
            effort = stage.respond(effort, clock, numbers, slice(None))
        return pick(effort, rows) if stages else effort

    def command(self, field: Any, reference: Reference, q: Sequence[Any]) -> Any:
        """What the stages work on, elementwise on any operand."""
        command = field / reference.field
        stimulus = self.law.stimulus
        if stimulus is None:
            return command
        shape = q[: len(self.law.stimulus_shape)]
        return stimulus(command, *shape)

    def moved(
        self,
        fluids: Sequence[Any],
        slips: Sequence[Any],
        reference: Reference,
        q: Sequence[Any],
    ) -> list[SlipAndStrength]:
        """What the stages on the slip of each element work on, elementwise on any operand."""
        if not slip_stages(self.dynamics):
            return [SlipAndStrength(slip, 1.0) for slip in slips]
        form = self.law.yield_form or POWER
        shape = [q[place] for place in self._strength_places]
        moved: list[SlipAndStrength] = []
        for way, fluid, slip in zip(self.ways, fluids, slips, strict=True):
            relative = way * slip / reference.slip
            strength = form.factor(np.abs(fluid), *shape)
            moved.append(SlipAndStrength(relative, strength))
        return moved

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
        fluids = signals.fluids
        slips = signals.slips
        extras = [signals.extras[name] for name in self.extras]
        if moved is None:
            moved = self.moved(fluids, slips, reference, q)
        first = len(self.law.stimulus_shape)
        shape = q[first : first + len(self.law.shape)]
        turn = FORWARD if self.law.forward else shape[0]  # slip over which friction turns its sign
        factors = self._factors(extras, reference, q)
        if factors:
            # A viscosity that is a ratio to the yield effort feels the temperature inside of the law.
            ratio = factors.get("viscous", 1.0) / factors.get("yield", 1.0)
            warmed: list[Any] = []
            for of, number in zip(self.law.shape, shape, strict=True):
                warmed.append(number * ratio if of.viscous_over_yield else number)
            shape = warmed

        # Columns of each element, in the order of its gains.
        columns: list[Any] = []
        for element, way in enumerate(self.ways):
            strength = np.abs(fluids[element])
            slip = way * slips[element] / reference.slip
            own = list(self.law.columns(strength, slip, *shape))
            if self.friction:
                own.append(direction(slip, turn) * np.ones(slip.size))
            outputs_of = signals.remembered[element]
            for stage, outputs in zip(slip_stages(self.dynamics), outputs_of, strict=True):
                own += stage.columns(outputs, moved[element].strength)
            if factors:
                for place, gain in enumerate(self._gains_of_element):
                    if gain.part in factors:
                        own[place] = own[place] * factors[gain.part]
            columns += own if way > 0 else [-column for column in own]

        # Columns of the whole device.
        for place, further in enumerate(extras):
            if place != self._temperature_place:
                columns.append(further / reference.extras[place])
        for stage in position_stages(self.dynamics):
            # The slip's own scale, so that the numbers of the stage are ways, in the position's unit.
            position = signals.extras[POSITION] / reference.slip
            columns += stage.outputs_at(position, *self.numbers_of(stage, q))
        if self.offset:
            columns.append(np.ones(slips[0].size))
        return columns

    def in_fluid(
        self,
        command: Any,
        clock: Clock,
        q: Sequence[Any],
        rows: slice | NDArray[np.intp],
    ) -> Any:
        """The field in one element's fluid at some of the rows: the command after the stages on it."""
        left = rows  # to pick behind the stages
        stages = stages_at(self.dynamics, "command")
        for place, stage in enumerate(stages, start=1):
            wanted: Any = slice(None)  # the next stage remembers all rows
            if place == len(stages) and (isinstance(rows, slice) or _takes_places(stage)):
                wanted = rows
                left = slice(None)
            behind = stage.respond(command, clock, self.numbers_of(stage, q), wanted)
            command = array_as_in_c(behind) if isinstance(command, ArrayAsInC) else behind
        return pick(command, left)


def _takes_places(stage: Stage) -> bool:
    """Whether a stage takes the places of the rows that are wanted, where every stage takes a slice."""
    return getattr(stage, "takes_places", False)


def _structure(device: DeviceName, specification: str, *rest: Any) -> Structure:
    """The structure from what `Structure.__reduce__` gives; a copy in another process calls this by name."""
    return Structure(device, specification, law_from_name(specification, device), *rest)
