"""A stage is a small system, most with a memory, that stands before or behind a law or a network.

A model is a chain::

    command -> [stages on the command] -> law or network <- [stages on the slip] <- slip
                                               |
                                    [stages on the effort] -> effort

A stage on the temperature stands beside them: what it makes of the temperature multiplies a part of the law's effort.
So does a stage on the position: what it makes of the position is added to the law's effort, each output with a gain.
A stage says its step once, in elementwise arithmetic. The exported C, the other targets and predictions with the C's
bits are made from a record of that step. A fit uses `Stage.respond`, which may be faster and carries derivatives.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

from erclutch.arithmetic.dual import pick
from erclutch.models.laws.law import Gain, ShapeParameter
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock

#: What a stage works on: the command or the slip of each element, the effort of the device, the fluid's temperature,
#: the position that is logged beside the slip.
Place = Literal["command", "slip", "effort", "temperature", "position"]


class SlipAndStrength(NamedTuple):
    """What a stage on the slip works on.

    Attributes:
        slip: of the element, over the reference slip; positive the way in which the element drives.
        strength: how strong the field in the fluid makes the yield effort, 1 at the reference field.
    """

    slip: Any
    strength: Any


class Memory(Protocol):
    """What a stage remembers while its step is computed.

    In the first row every number of the state has the value that `Stage.initial` gives, before and after the step.
    """

    def before(self, name: str) -> Any:
        """The value of a number after the row before."""
        ...

    def keep(self, name: str, value: Any) -> Any:
        """Set a number for the next row, and return the value that is kept: in the first row the initial one."""
        ...

    def back(self, name: str, value: Any, rows: int) -> Any:
        """A signal so many rows back; before the first row the signal was as in the first row."""
        ...

    def number(self, value: float) -> Any:
        """A constant as an operand, so that arithmetic on it rounds as in the export's precision."""
        ...


@runtime_checkable
class Stage(Protocol):
    """A stage of a model. Its functions take one element; each element has a memory of its own."""

    @property
    def name(self) -> str:
        """Identifier on the command line, for example ``lag``."""
        ...

    @property
    def title(self) -> str:
        """Name for people."""
        ...

    @property
    def source(self) -> str:
        """Where it is published."""
        ...

    @property
    def equation(self) -> str:
        """What it computes, in plain text with the names of its parameters and outputs.

        u is the command, E the field behind the stage, w the slip, y(E) the strength of the field, T_fluid the effort
        ahead of the stage and T behind it, t the temperature over that of reference; a prime is a derivative in time.
        """
        ...

    @property
    def place(self) -> Place:
        """What it works on."""
        ...

    @property
    def switches(self) -> bool:
        """Whether the step asks for the sign of its signal; then a signal of no size is all rounding."""
        ...

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The nonlinear parameters, for data sampled at a period in s."""
        ...

    def respond(
        self,
        signal: Any,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> Any:
        """The output over all rows, for fits; of a stage on slip, position or temperature a list of all outputs.

        Args:
            signal: shape (n,); an array or a dual, of a stage on the slip a `SlipAndStrength` of such. An `ArrayAsInC`
                asks for the bits of the step.
            clock: when the rows were sampled. Each span starts anew.
            q: the parameters; numbers or duals.
            rows: which rows of the result are wanted.
        """
        ...

    def initial(self, signal: Any, q: Mapping[str, float]) -> Mapping[str, Any]:
        """The state once the signal has long been the same, by name."""
        ...

    def step(
        self,
        memory: Memory,
        signal: Any,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row: the outputs, of which a stage on the command or on the effort has one.

        Args:
            memory: the state.
            signal: what comes in.
            q: the parameters by name.
            period: sampling period in s.
        """
        ...


@runtime_checkable
class SlipStage(Stage, Protocol):
    """A stage on the slip gets a `SlipAndStrength`. Its outputs are columns of a law, or inputs of a network."""

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        ...

    @property
    def gains(self) -> tuple[Gain, ...]:
        """The linear parameters that a law gets for the stage, one a column."""
        ...

    def settled(self, signal: SlipAndStrength, q: Mapping[str, float]) -> tuple[Any, ...]:
        """The outputs once slip and strength have long been the same; elementwise on any operand."""
        ...

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """A law's columns from the outputs and the strength of the field; elementwise on any operand."""
        ...


class RowByRow(ABC):
    """What stages share that have no state: the outputs of a row follow from the signal of that row alone.

    Attributes:
        needs_time: see `erclutch.models.stages.needs_time`.
    """

    needs_time = False

    @abstractmethod
    def outputs_at(self, signal: Any, *numbers: Any) -> tuple[Any, ...]:
        """The outputs for the stage's parameters, elementwise on any operand."""

    def respond(
        self,
        signal: Any,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The outputs over all rows; see `Stage`."""
        return [pick(output, rows) for output in self.outputs_at(signal, *q)]

    def initial(self, signal: Any, q: Mapping[str, float]) -> Mapping[str, Any]:
        """There is no state."""
        return {}

    def step(
        self,
        memory: Memory,
        signal: Any,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row."""
        return self.outputs_at(signal, *q.values())

    def settled(self, signal: Any, q: Mapping[str, float]) -> tuple[Any, ...]:
        """Nothing is remembered, so nothing has to settle; see `SlipStage`."""
        return self.outputs_at(signal, *q.values())


@runtime_checkable
class PositionStage(Stage, Protocol):
    """A stage on the position has no state. Its outputs are columns of a law, and rows tell where to look for it."""

    @property
    def gains(self) -> tuple[Gain, ...]:
        """The linear parameters that a law gets for the stage, one an output."""
        ...

    def outputs_at(self, signal: Any, *numbers: Any) -> tuple[Any, ...]:
        """The outputs, elementwise on any operand."""
        ...

    def usual(self, position: Array, effort: Array) -> tuple[float, float] | None:
        """Where the search for its number starts, by rows of an effort without its smooth part; None: as ever."""
        ...

    def without(self, position: Array, effort: Array, low: float, high: float) -> Array:
        """The effort without what the stage can say of it with a number between two; a further stage sees the rest."""
        ...


@dataclass(frozen=True)
class StageFamily:
    """What a stage's file brings under the name ``STAGE`` where users choose a number or a form of it.

    Attributes:
        make: the stage for a number and forms.
        count: the number that the name alone stands for; None where there is none to choose.
        forms: words that may follow after slashes.
        ladder: specifications that `fit.choice.ladder` tries on the best law by itself, from the simplest to the
            richest; a richer one takes the place of a simpler one of the family.
        behind: the same with the field behind the memory and not ahead of it, one for each of `ladder`; none: they have
            no such form.
        beside: the ladder tries it only where there is a stage of the family of this name; "": anywhere.
        edge: a parameter, a part of the field, that the ladder believes only above the noise of the field; "": none.
        fades: a slip that the ladder believes only well beyond the one over which the law's sign turns; "": none.
        forgets: a time after which a travel is forgotten, which the ladder believes only where the slip turns sooner;
            "": none.
        instead: the stage that the ladder tries where the travel is forgotten sooner; "": none.
        striking: share of the error that it must take off: the ladder searches it only where its columns show so much
            beside the law's. A corner that hardly shows is a bend, which other stages say. 0: as other stages.
        two_ways: the ladder tries it only where the slip goes either way: it is of what differs between the ways, and
            of one way the law says the same.
        of_travel: the ladder tries it only where the slip goes either way or was made of a logged position: else the
            travel is a time, and what drifts would be called a spring.
        apart: what `two_ways` says of some specifications of the ladder alone, each with the share of the error that it
            must take off, as `striking` says.
    """

    make: Callable[[int, tuple[str, ...]], Stage]
    count: int | None = None
    forms: tuple[str, ...] = ()
    ladder: tuple[str, ...] = ()
    behind: tuple[str, ...] = ()
    beside: str = ""
    edge: str = ""
    fades: str = ""
    forgets: str = ""
    instead: str = ""
    striking: float = 0.0
    two_ways: bool = False
    of_travel: bool = False
    apart: Mapping[str, float] = field(default_factory=dict[str, float])


#: Time constants are looked for up to a second, and in a slow log up to so many periods.
_PERIODS_OF_A_LAG = 100.0


def longest_lag(period: float) -> float:
    """The largest time constant of a lag that is looked for, in s, at a sampling period in s."""
    return max(1.0, _PERIODS_OF_A_LAG * period)


def numbered(stem: str, number: int, *, ahead: bool = False) -> str:
    """The name of a stage of a family: the number 1 is left out, as the name alone stands for it."""
    return stem + (f"-{number}" if number != 1 else "") + ("/field" if ahead else "")
