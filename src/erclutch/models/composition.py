"""A Composition says what a law's model is made of: device, law, stages, what is added; and the numbers of these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple, Self

from erclutch.errors import SettingError
from erclutch.models.laws import (
    Dimension,
    Gain,
    Law,
    ShapeParameter,
    Specification,
    law_from_name,
)
from erclutch.models.laws.law import YieldForm
from erclutch.models.laws.yield_stress import FALLING
from erclutch.models.stages import (
    NONE,
    canonical,
    position_stages,
    slip_stages,
    stages_of,
    temperature_stages,
)
from erclutch.models.stages.stage import Stage
from erclutch.signals.device import WAYS_OF, DeviceName, names_in_elements
from erclutch.signals.recording import POSITION, TEMPERATURE

FRICTION = Gain("T_f", "friction effort at zero field", Dimension(effort=1))
_LASTING_FRICTION = replace(FRICTION, meaning="friction effort that no field takes away")
#: Of the field in the memory's effort, where the law has no form of its own to share.
_EXPONENT = ShapeParameter("n_m", "exponent of the field in the memory's effort", 0.2, 4.0)
OFFSET = Gain("T_0", "constant effort", Dimension(effort=1), nonnegative=False)


class AddedTerm(NamedTuple):
    """An effort beside those of the law and of its memory.

    Attributes:
        kind: friction is added for each element, the others for the whole device.
        gain: its number.
        factor: by what the gain is multiplied: a formula, the name of an input; "" for nothing.
    """

    kind: Literal["friction", "input", "constant"]
    gain: str
    factor: str = ""

    def sentence(self, references: Mapping[str, float]) -> str:
        """The term for whoever reads an equation as text.

        Args:
            references: what normalises each further input.
        """
        effort = f"{self.gain} {self.factor}".strip()
        if self.kind == "friction":
            return f"A friction effort {effort} is added for each element."
        if self.kind == "input":
            return f"An effort {effort} / {references[self.factor]:.9g} is added."
        return f"A constant effort {effort} is added."


@dataclass(frozen=True)
class Composition:
    """What a law's model is made of, without numbers.

    Attributes:
        device: "single" or "coaxial".
        specification: name of the law, for example ``hem/square``.
        law: the law itself; its functions are made anew each time, so equality asks the specification alone.
        dynamics: names of the stages on command, slip and effort, joined by ``+``; "none" for none.
        friction: a column of Coulomb friction at zero field (seals, bearings, remanence), one an element.
        offset: a constant effort (gas spring, preload, sensor zero).
        extras: further logged inputs, each with a gain (displacement, acceleration); with stages on the temperature
            that is one of them, and it has no gain; with stages on the position that is one of them too.

    Raises:
        SettingError: a stage that needs what the law does not say, or two numbers of one name.
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
        # Of two numbers of one name a model's file and its tables would have but one.
        names = [number.name for number in (*self.shapes(1.0), *self.gains())]
        for name in names:
            if names.count(name) > 1:
                raise SettingError(
                    f"two numbers of {self.specification}+{self.dynamics} are called {name}",
                    remedy="Leave one of the stages out",
                )

    def __reduce__(self) -> tuple[Any, ...]:
        """Law functions are made, not imported, so a copy in another process makes its own from the names."""
        rest = (self.dynamics, self.friction, self.offset, self.extras)
        return _made_again, (type(self), self.device, self.specification, *rest)

    @property
    def elements(self) -> int:
        """Number of elements of the device."""
        return len(WAYS_OF[self.device])

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
        return WAYS_OF[self.device]

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

    def with_yield_form(self, form: YieldForm) -> Self:
        """The same law with another form of the yield effort over the field."""
        own = Specification.of(self.specification)
        specification = str(own._replace(forms=(form.name,)))
        return replace(
            self, specification=specification, law=law_from_name(specification, self.device)
        )

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
        for element in range(self.elements):
            for gain in self.gains_of_element:
                if self.elements > 1:
                    gain = replace(
                        gain,
                        name=self.names_of(gain.name)[element],
                        meaning=f"{gain.meaning}, CH{element + 1}",
                    )
                gains.append(gain)
        effort = FRICTION.dimension
        for place, name in enumerate(self.extras):
            # The temperature changes gains and has none itself.
            if place != self._temperature_place:
                gains.append(
                    Gain(
                        f"c_{place + 1}",
                        f"effort per {name}",
                        effort,
                        nonnegative=False,
                        extra=place,
                    )
                )
        for stage in position_stages(self.dynamics):
            gains.extend(stage.gains)
        if self.offset:
            gains.append(OFFSET)
        return tuple(gains)

    def names_of(self, gain: str) -> tuple[str, ...]:
        """What a gain of an element is called in each element of the device, in their order."""
        return names_in_elements(self.device, gain)

    @property
    def gains_of_element(self) -> tuple[Gain, ...]:
        """Gains of one element in the order of its columns: the law's, friction, memory."""
        gains = list(self.law.gains)
        if self.friction:
            gains.append(_LASTING_FRICTION if self.law.yield_form is FALLING else FRICTION)
        for stage in slip_stages(self.dynamics):
            gains += stage.gains
        return tuple(gains)

    @cached_property
    def _temperature_place(self) -> int | None:
        """Which further input is the temperature; None for a law that does not feel it."""
        if not temperature_stages(self.dynamics):
            return None
        return self.extras.index(TEMPERATURE)

    def added_terms(self) -> list[AddedTerm]:
        """Efforts beside those of the law and of its memory, in the order in which an equation has them."""
        terms: list[AddedTerm] = []
        if self.friction:
            turn = "" if self.law.forward else "tanh(w / w_s)"
            terms.append(AddedTerm("friction", FRICTION.name, turn))
        for gain in self.gains():
            if gain.extra is not None:
                terms.append(AddedTerm("input", gain.name, self.extras[gain.extra]))
        if self.offset:
            terms.append(AddedTerm("constant", OFFSET.name))
        return terms


def _made_again(
    kind: type[Composition],
    device: DeviceName,
    specification: str,
    *rest: Any,
) -> Composition:
    """What `Composition.__reduce__` tells of; a copy in another process calls this by name."""
    return kind(device, specification, law_from_name(specification, device), *rest)
