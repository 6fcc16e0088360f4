"""A stage of another package is named where it fails."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from erclutch.errors import SettingError
from erclutch.models.laws.law import Gain, ShapeParameter
from erclutch.models.stages.stage import Memory, Moved, Place, SlipStage, Stage, StageFamily
from erclutch.registry import Plugin, find
from erclutch.signals.clock import Clock

MOST_STATES = 8


@dataclass(frozen=True)
class OutsideStage:
    """The stage with its plug-in; whatever its functions raise names the plug-in."""

    stage: Stage
    plugin: Plugin

    def __post_init__(self) -> None:
        if not re.fullmatch(re.escape(self.plugin.name) + r"(-\d+)?(/\w+)*", self.stage.name):
            raise self.plugin.fault(f"calls itself {self.stage.name!r}; its name and its entry point must agree")
        if self.stage.place not in ("command", "slip", "effort"):
            raise self.plugin.fault(f"stands on the {self.stage.place}; command, slip and effort are open to packages")

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy in another process finds the stage by its name."""
        return _again, (self.plugin.group, self.plugin.name, self.stage.name)

    @property
    def name(self) -> str:
        """See `Stage`."""
        return self.stage.name

    @property
    def title(self) -> str:
        """See `Stage`."""
        return self.stage.title

    @property
    def source(self) -> str:
        """See `Stage`."""
        return self.stage.source

    @property
    def equation(self) -> str:
        """See `Stage`."""
        return self.stage.equation

    @property
    def place(self) -> Place:
        """See `Stage`."""
        return self.stage.place

    @property
    def switches(self) -> bool:
        """See `Stage`."""
        return self.stage.switches

    @property
    def outputs(self) -> tuple[str, ...]:
        """See `SlipStage`."""
        return tuple(self._slip.outputs)

    @property
    def gains(self) -> tuple[Gain, ...]:
        """See `SlipStage`."""
        return tuple(self._slip.gains)

    @property
    def _slip(self) -> SlipStage:
        return cast(SlipStage, self.stage)

    def settled(self, signal: Moved, q: Mapping[str, float]) -> tuple[Any, ...]:
        """See `SlipStage`."""
        with self.plugin.working():
            return self._slip.settled(signal, q)

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """See `SlipStage`."""
        with self.plugin.working():
            return self._slip.columns(outputs, strength)

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """See `Stage`."""
        with self.plugin.working():
            return self.stage.parameters(period)

    def respond(self, signal: Any, clock: Clock, q: Sequence[Any], rows: slice) -> Any:
        """See `Stage`."""
        with self.plugin.working():
            return self.stage.respond(signal, clock, q, rows)

    def initial(self, signal: Any, q: Mapping[str, float]) -> Mapping[str, Any]:
        """See `Stage`."""
        with self.plugin.working():
            return self.stage.initial(signal, q)

    def step(self, memory: Memory, signal: Any, q: Mapping[str, float], period: float) -> tuple[Any, ...]:
        """See `Stage`."""
        with self.plugin.working():
            return self.stage.step(memory, signal, q, period)


def made_stage(plugin: Plugin, specification: str) -> Stage:
    """The stage that a specification such as ``dahl-2/field`` names, of the plug-in with its name.

    Raises:
        SettingError: no such number or form (PluginError: the plug-in fails).
    """
    family: Any = plugin.value if isinstance(plugin.value, StageFamily) else None
    name, *forms = specification.split("/")
    digits = name.removeprefix(plugin.name).removeprefix("-")
    count = int(digits) if digits.isdecimal() and len(digits) < 4 else None
    most = MOST_STATES if family and family.count is not None else 0
    known: tuple[str, ...] = family.forms if family else ()
    if set(forms) - set(known) or (digits and not (count and 1 <= count <= most)):
        offered = [f"{plugin.name}-N with N from 1 to {most}" if most else plugin.name]
        offered += [f"{plugin.name}/{form}" for form in known]
        raise SettingError(f"unknown stage {specification!r}", remedy=f"Write {', '.join(offered)}")
    with plugin.working():
        chosen = tuple(sorted(set(forms)))
        stage = family.make(count or family.count or 1, chosen) if family else plugin.of_type(Stage)
    return stage if plugin.own else OutsideStage(stage, plugin)


def _again(group: str, name: str, specification: str) -> Stage:
    return made_stage(find(group, name), specification)
