"""A Structure computes one column a gain from what a law with its stages is made of, without numbers.

The stages on the command make the field in the fluid. The law and the stages on the slip make columns of fluid and
slip. A model multiplies each column by its gain. Stages on the effort work on the sum.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.as_in_c import ArrayAsInC, array_as_in_c
from erclutch.arithmetic.dual import pick
from erclutch.models.composition import Composition
from erclutch.models.laws.law import Part
from erclutch.models.laws.smooth import FORWARD, direction
from erclutch.models.laws.yield_stress import POWER
from erclutch.models.model import FluidSignals
from erclutch.models.stages import (
    outside_stages,
    position_stages,
    slip_stages,
    stages_at,
    temperature_stages,
)
from erclutch.models.stages.stage import SlipAndStrength, Stage
from erclutch.registry import Plugin
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import Element
from erclutch.signals.recording import POSITION


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
class Structure(Composition):
    """What is fitted, without numbers, and the columns that it makes of rows."""

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """The law and the stages of other packages."""
        stages = outside_stages(self.dynamics)
        return stages if self.law.plugin is None else (self.law.plugin, *stages)

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
                of_stage = stage.columns(outputs, moved[element].strength)
                if getattr(stage, "turns_as_friction", False):
                    of_stage = tuple(direction(slip, turn) * column for column in of_stage)
                own += of_stage
            if factors:
                for place, gain in enumerate(self.gains_of_element):
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
