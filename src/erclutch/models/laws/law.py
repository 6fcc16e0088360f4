"""A law is a plain NumPy function that returns columns, with the names, units and bounds of its numbers.

The effort of one element is the columns times their gains. Fields and slips come in normalised (field by the largest
field of the training data, slip by its typical size), so bounds hold for any device; `Dimension` turns a number back
into the user's units.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from erclutch.registry import Plugin

#: The columns of one element, ``columns(E, w, *shape)``, are one array (n,) a gain.
#: Branch-free; arrays, duals or symbols.
Columns = Callable[..., tuple[Any, ...]]


@dataclass(frozen=True)
class Dimension:
    """Exponents of effort, field, slip, time and temperature in a parameter's unit."""

    effort: int = 0
    field: int = 0
    slip: int = 0
    time: int = 0
    temperature: int = 0


@dataclass(frozen=True)
class ShapeParameter:
    """A parameter that enters a law nonlinearly; shared by all elements of a device.

    Attributes:
        name: identifier, the argument's name in the law.
        meaning: one phrase.
        lower, upper: bounds in normalised units.
        dimension: exponents of the units, to convert to the user's units.
        scale: "log" for a positive number that may span decades: searched, and given its interval, in its logarithm.
        usual: range that the search starts from, where the bounds are much wider than what is met in practice.
        viscous_over_yield: whether it is a ratio of the viscous to the yield effort, which the temperature changes.
    """

    name: str
    meaning: str
    lower: float
    upper: float
    dimension: Dimension = Dimension()
    scale: Literal["linear", "log"] = "linear"
    usual: tuple[float, float] | None = None
    viscous_over_yield: bool = False

    @property
    def scanned(self) -> tuple[float, float]:
        """Range that the scan for starts covers."""
        return self.usual or (self.lower, self.upper)

    def at(self, place: float) -> float:
        """The number at a place of the scanned range, 0 to 1; of one that spans decades by its logarithm."""
        low, high = self.scanned
        if self.scale == "log":
            return float(low * (high / low) ** place)
        return low + place * (high - low)


@dataclass(frozen=True)
class YieldForm:
    """How the yield stress follows the field.

    Attributes:
        name: identifier on the command line: square, power, critical, saturating, tanh, falling or constant.
        label: how tables show it.
        factor: ``factor(E, *shape)``, 1 at E = 1; 0 at E = 0 where the field strengthens the fluid.
        shape: its parameters.
    """

    name: str
    label: str
    factor: Callable[..., Any]
    shape: tuple[ShapeParameter, ...]


#: What the temperature changes of the fluid: its yield effort or its viscous effort.
Part = Literal["yield", "viscous"]


@dataclass(frozen=True)
class Gain:
    """A parameter that multiplies a column; one for each element.

    Attributes:
        name: identifier; element numbers are appended for a device with several elements.
        meaning: one phrase.
        dimension: exponents of the units.
        nonnegative: whether physics bounds it by zero from below.
        extra: index of the further input that its column is, None for all other columns.
        part: which effort of the fluid its column is; None: neither, such as friction of seals.
        negative: what a value below zero tells, a sentence or two; empty where such a value is usual.
    """

    name: str
    meaning: str
    dimension: Dimension
    nonnegative: bool = True
    extra: int | None = None
    part: Part | None = None
    negative: str = ""


@dataclass(frozen=True)
class Law:
    """Closed-form effort of one element.

    Attributes:
        name: identifier on the command line, for example ``bingham``.
        title: name for people.
        source: equation number and doi.
        columns: the equation.
        shape: nonlinear parameters, in the order of the arguments of `columns` after E and w.
        gains: one for each column.
        stimulus: static map of the command ahead of the dynamics, ``stimulus(E, *shape)``; None is the identity.
            A law with a stimulus gets its result as E and none of the `stimulus_shape` parameters.
        stimulus_shape: parameters of the stimulus.
        paper_form: gives the published symbols from (shape, gains of one element, reference field), all in the user's
            units, where they differ from ours.
        forward: whether the yield effort keeps its sign, that in which the device drives, at any slip.
        yield_form: how its yield effort grows with the field, where users choose that; a memory of the slip shares it.
        plugin: of another package that brings the law; None for ours.
    """

    name: str
    title: str
    source: str
    columns: Columns
    shape: tuple[ShapeParameter, ...]
    gains: tuple[Gain, ...]
    stimulus: Callable[..., Any] | None = None
    stimulus_shape: tuple[ShapeParameter, ...] = ()
    paper_form: Callable[[dict[str, float], dict[str, float], float], dict[str, float]] | None = (
        None
    )
    forward: bool = False
    yield_form: YieldForm | None = None
    plugin: Plugin | None = None

    @property
    def parts(self) -> frozenset[Part | None]:
        """The efforts of the fluid that its numbers keep apart, so that the temperature can change each of them."""
        parts: set[Part | None] = {gain.part for gain in self.gains}
        if any(shape.viscous_over_yield for shape in self.shape):
            parts.add("viscous")
        return frozenset(parts)


@dataclass(frozen=True)
class LawFamily:
    """What a law's file or package brings under the name ``LAW``.

    Attributes:
        law: the law; or a function that makes it from a `YieldForm`, where the user chooses how the yield effort grows
            with the field; or from a `YieldForm` and a number N, where `count` is given.
        formula: effort of one element on one line, as published; y(E) is the yield form.
        about: a paragraph for the pages (Markdown): what the law is good for, and what to beware of.
        curves: numbers for which the pages draw the law, for example ``w_s=0.05 n=2 T_y=1 eta=0.3``; "" for no curves.
        ladder: which of its specifications stand in a table of laws, and the place of each: a larger one stands behind,
            as the richer model. Ours have 10, 20, ... 110, and ``--models all`` fits these.
        aliases: further names.
        count: of a family such as rbfm-N: the N that the name without a number stands for.
        quick: whether its numbers are few and known from few rows, so that it can be fitted while a log grows
            (``erclutch live --program learn``).
        without_yield: whether the field's effort vanishes at rest. ``--models all`` fits such a law only to rows that
            look so (`erclutch.fit.checks.field_drag`).
    """

    law: Law | Callable[..., Law]
    formula: str
    about: str
    curves: str = ""
    ladder: Mapping[str, int] = field(default_factory=dict[str, int])
    aliases: tuple[str, ...] = ()
    count: int | None = None
    quick: bool = False
    without_yield: bool = False


EFFORT = Dimension(effort=1)
VISCOUS = Dimension(effort=1, slip=-1)
PER_SLIP = Dimension(slip=-1)
PER_FIELD = Dimension(field=-1)
FIELD = Dimension(field=1)
SLIP = Dimension(slip=1)

YIELD = Gain("T_y", "yield effort at the reference field", EFFORT, part="yield")
VISCOSITY = Gain("eta", "viscous effort per slip", VISCOUS, part="viscous")
