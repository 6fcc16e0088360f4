"""This module says what a model is: a device, a chain of stages with a law or a network, and the numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from erclutch.models.band import Band
from erclutch.models.covered_cells import CELLS, grid_cell
from erclutch.models.near_cells import NearCells, Nearness
from erclutch.models.stages import NONE, slip_stages, stages_of
from erclutch.models.stages.stage import SlipAndStrength, Stage
from erclutch.registry import Plugin
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import DeviceName, Element, Units

Pair = tuple[float, float]


def margins(covered: Pair) -> Pair:
    """A range widened by 1 % of its width on each side; a single value by 1 % of itself. A model guesses outside."""
    low, high = covered
    slack = 0.01 * ((high - low) or abs(high))
    return low - slack, high + slack


def held_window(covered: Pair) -> Pair:
    """A range widened by a tenth on each side: an exported step holds its inputs there, and a network its own."""
    low, high = covered
    room = 0.1 * max(high - low, abs(low), abs(high))
    return low - room, high + room


@dataclass(frozen=True)
class Range:
    """What the training data covered.

    A row is outside if a field or slip lies beyond the margins, or if no training row of its element had a field and
    slip near: in its cell of a grid over both ranges, or in a cell beside. Less than a sixteenth of the range from a
    training row is near, more than an eighth is not.

    Attributes:
        field: smallest and largest field over all elements.
        slip: smallest and largest slip over all elements.
        effort: smallest and largest effort.
        near: cells near training rows: for each element 16 numbers, one for each cell of the field from the lowest;
            bit k of a number is the cell k of the slip. Without them all cells inside the margins are near.
    """

    field: Pair
    slip: Pair
    effort: Pair
    near: tuple[tuple[int, ...], ...] = ()

    def cell(self, field: Any, slip: Any) -> tuple[Any, Any]:
        """Numbers of the cells of field and slip, less than 16, with a fraction; elementwise on any operand."""
        return grid_cell(field, self.field), grid_cell(slip, self.slip)

    def far(self, element: int, field: Any, slip: Any) -> Any:
        """Whether no training row of an element, from 0, was near; elementwise on any operand. It needs `near`."""
        return self.near_cells(element).far(field, slip)

    def near_cells(self, element: int) -> NearCells:
        """The cells near training rows of an element, from 0; all of them where that is not known."""
        masks = self.near[element] if self.near else (2**CELLS - 1,) * CELLS
        return NearCells(self.field, self.slip, masks)

    def outside(self, data: Rows) -> NDArray[np.bool_]:
        """Rows for which a model guesses, shape (n,)."""
        out = np.zeros(data.clock.time.size, np.bool_)
        for i, element in enumerate(data.elements):
            for values, covered in ((element.field, self.field), (element.slip, self.slip)):
                low, high = margins(covered)
                out |= (values < low) | (values > high)
            if self.near:
                with np.errstate(over="ignore"):  # a number of 1e308 is beyond all cells
                    out |= self.far(i, element.field, element.slip)
        return out

    def to_dict(self) -> dict[str, Any]:
        """As plain JSON values."""
        values: dict[str, Any] = {}
        for key in ("field", "slip", "effort"):
            values[key] = list(getattr(self, key))
        if self.near:
            values["near"] = [list(masks) for masks in self.near]
        return values


class Rows(Protocol):
    """What a model needs of a data set."""

    @property
    def device(self) -> DeviceName:
        """Which device the rows are of."""
        ...

    @property
    def elements(self) -> Sequence[Element]:
        """Field and slip of each element."""
        ...

    @property
    def clock(self) -> Clock:
        """When the rows were sampled."""
        ...

    @property
    def units(self) -> Units:
        """Units of effort, field and slip."""
        ...

    @property
    def extras(self) -> Mapping[str, Array]:
        """Further logged inputs by name."""
        ...


class ModelStructure(Protocol):
    """What is fitted, without numbers."""

    @property
    def device(self) -> DeviceName:
        """Which device it is of."""
        ...

    @property
    def specification(self) -> str:
        """Name of the law or network."""
        ...

    @property
    def dynamics(self) -> str:
        """Names of the stages, joined by ``+``."""
        ...


def present(signal: Any, rows: int) -> Any:
    """A signal so many rows back that has long been the same: the signal."""
    return signal


@dataclass(frozen=True)
class FluidSignals:
    """What a law or a network works on, behind the stages on command and slip: operands of any kind.

    Attributes:
        fluids: field in the fluid of each element.
        slips: slip of each element.
        remembered: outputs of each stage on the slip, for each element.
        extras: further inputs by name.
        past: ``past(signal, rows)``, a signal so many rows back.
    """

    fluids: Sequence[Any]
    slips: Sequence[Any]
    remembered: Sequence[Sequence[Sequence[Any]]]
    extras: Mapping[str, Any]
    past: Callable[[Any, int], Any] = present


class Correction(Protocol):
    """What a network adds to a law's effort, behind the stages on the effort; it can be switched off on a target."""

    @property
    def network(self) -> Any:
        """The network, a `NetworkModel`."""
        ...

    @property
    def limit(self) -> float:
        """The largest effort that is added or taken away."""
        ...

    def inputs(self, signals: FluidSignals) -> list[Any]:
        """All inputs of the network, elementwise on any operand."""
        ...

    def of(self, *inputs: Any) -> Any:
        """Effort that is added, for inputs that record."""
        ...


class GivesWay(Protocol):
    """A network alone that gives way to a law where no training row was near."""

    @property
    def nearness(self) -> Nearness:
        """Where training rows were, by field in the fluid, slip and further inputs."""
        ...

    def law_beyond(self, fluids: Sequence[Any], slips: Sequence[Any], extras: Sequence[Any]) -> Any:
        """Effort of the law, elementwise on any operand: fields in the fluid, slips, further inputs of the network."""
        ...


class Model(Protocol):
    """Effort of a device from its fields, slips and further inputs."""

    @property
    def structure(self) -> ModelStructure:
        """Which device, stages, law or network."""
        ...

    @property
    def units(self) -> Units:
        """Of inputs and output."""
        ...

    @property
    def trained_on(self) -> Range:
        """Range of the training data."""
        ...

    @property
    def name(self) -> str:
        """Identifier, for example ``bingham/power+lag``."""
        ...

    @property
    def title(self) -> str:
        """Name for people."""
        ...

    @property
    def period(self) -> float | None:
        """Sampling period of the training data in s, where the model knows it."""
        ...

    @property
    def times(self) -> Mapping[str, float]:
        """Parameters of the stages by name."""
        ...

    @property
    def extras(self) -> Mapping[str, Pair]:
        """Further inputs, and the range of each."""
        ...

    @property
    def extra_units(self) -> Mapping[str, str]:
        """The unit of each further input; "?" where nobody gave it."""
        ...

    @property
    def past(self) -> tuple[int, ...]:
        """Rows back whose signals are inputs too."""
        ...

    @property
    def law_part(self) -> Any:
        """The law that the model is or has, a `TorqueModel` with its numbers; None for a model without one."""
        ...

    @property
    def network_part(self) -> Any:
        """The network that the model is or has, a `NetworkModel`; None for a model without one."""
        ...

    @property
    def correction(self) -> Correction | None:
        """What a network adds to the effort of a law; None for a law or a network alone."""
        ...

    def added(
        self,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array],
        *,
        exactly: bool = True,
    ) -> Array:
        """Effort that the correction adds, shape (n,); zeros without a correction."""
        ...

    def scaled(self, factor: float, offset: float = 0.0) -> Any:
        """The same model with its effort times a factor, and a constant effort more.

        Raises:
            SettingError: a model of another package does not say how.
        """
        ...

    @property
    def gives_way(self) -> GivesWay | None:
        """The model, where it is a network alone with a law beyond its rows; else None."""
        ...

    @property
    def unbounded(self) -> str:
        """What to know of a network alone that has no law beyond its rows; else empty."""
        ...

    @property
    def band(self) -> Band | None:
        """How far the measured effort may lie from the estimate; None where that was not calibrated."""
        ...

    @property
    def signed(self) -> bool:
        """Whether the sign of a field makes a difference."""
        ...

    @property
    def numbers(self) -> Mapping[str, Any]:
        """Everything that was fitted or measured, by name."""
        ...

    def predict(self, data: Rows) -> Array:
        """Effort over a data set, shape (n,)."""
        ...

    def outside(self, data: Rows) -> NDArray[np.bool_]:
        """Rows for which the effort is a guess, shape (n,)."""
        ...

    def effort(
        self,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array] | None = None,
        *,
        exactly: bool = True,
    ) -> Array:
        """Effort for the fields and slips of each element, shape (n,); ``exactly``: with the bits of the C."""
        ...

    def effort_of_rows(
        self,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array],
        *,
        exactly: bool,
    ) -> Array:
        """Effort by arrays, for any number of rows, shape (n,)."""
        ...

    def steady(
        self, fields: Sequence[Array], slips: Sequence[Array], extras: Sequence[Array] = ()
    ) -> Array:
        """Effort at rest, shape (n,): the fluid settled, all past rows as the present one."""
        ...

    def command(self, field: Any) -> Any:
        """What the stages on the command work on, from the field of an element; elementwise on any operand."""
        ...

    def moved(self, fluids: Sequence[Any], slips: Sequence[Any]) -> list[SlipAndStrength]:
        """What the stages on the slip of each element work on, elementwise on any operand.

        Args:
            fluids: field in the fluid of each element.
            slips: slip of each element.
        """
        ...

    def from_fluid(self, signals: FluidSignals) -> Any:
        """Effort ahead of the stages on it, elementwise on any operand."""
        ...

    def equation(self) -> list[str]:
        """The equation and what it needs, as lines of a comment."""
        ...

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """What the model needs of other packages."""
        ...

    def to_dict(self) -> dict[str, Any]:
        """As plain JSON values."""
        ...


def stage_numbers(model: Model) -> list[tuple[Stage, dict[str, float]]]:
    """The stages of a model, each with its parameters by name."""
    stages: list[tuple[Stage, dict[str, float]]] = []
    for stage in stages_of(model.structure.dynamics):
        names = [parameter.name for parameter in stage.parameters(model.period or 1.0)]
        numbers = {name: float(model.times[name]) for name in names}
        stages.append((stage, numbers))
    return stages


def settled_memory(model: Model, moved: Sequence[SlipAndStrength]) -> list[list[Sequence[Any]]]:
    """Outputs of the stages on the slip once field and slip have long been the same, for each element."""
    numbers = {stage.name: q for stage, q in stage_numbers(model)}
    settled: list[list[Sequence[Any]]] = []
    for of_element in moved:
        outputs: list[Sequence[Any]] = []
        for stage in slip_stages(model.structure.dynamics):
            outputs.append(stage.settled(of_element, numbers[stage.name]))
        settled.append(outputs)
    return settled


def full_name(specification: str, dynamics: str) -> str:
    """A model's identifier from those of its parts, for example ``bingham/power+lag``."""
    return specification if dynamics == NONE else f"{specification}+{dynamics}"
