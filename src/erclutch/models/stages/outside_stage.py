"""A stage of another package is named where it fails."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, cast

from erclutch.errors import SettingError
from erclutch.models.laws.law import ShapeParameter
from erclutch.models.laws.outside_law import (
    LONGEST_LINE,
    LONGEST_TITLE,
    is_line,
    require_parameters,
    require_rows,
    rows_of,
)
from erclutch.models.stages.stage import SlipAndStrength, Stage, StageFamily
from erclutch.registry import Plugin, find
from erclutch.signals.clock import Clock

MOST_STATES = 8  # of a stage of another package, counted by the number in its name


class OutsideStage:
    """A stage of another package: it answers as that stage does, and whatever its functions raise names the plug-in.

    Attributes:
        stage: of the other package.
        plugin: that brings it.
    """

    def __init__(self, stage: Stage, plugin: Plugin) -> None:
        self.stage = stage
        self.plugin = plugin
        with plugin.working("does not say what it is"):
            texts: tuple[Any, ...] = (
                stage.name,
                stage.place,
                stage.title,
                stage.source,
                stage.equation,
            )
        called = all(is_line(text, LONGEST_TITLE) for text in texts[:3])
        if not called or not all(is_line(text, LONGEST_LINE) for text in texts[3:]):
            raise plugin.fault(
                "must have a name, a place, a title, a source and an equation: lines of up to "
                f"{LONGEST_TITLE} characters, the last two of up to {LONGEST_LINE}"
            )
        if not re.fullmatch(re.escape(plugin.name) + r"(-\d+)?(/\w+)*", stage.name):
            raise plugin.fault(
                f"calls itself {stage.name!r}; its name and its entry point must agree"
            )
        if stage.place not in ("command", "slip", "effort"):
            raise plugin.fault(
                f"stands on the {stage.place}; command, slip and effort are open to packages"
            )

    def __getattr__(self, name: str) -> Any:
        """What the stage has by a name."""
        value = getattr(self.stage, name)
        return self.plugin.guarded(value) if callable(value) else value

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The nonlinear parameters, with bounds that a search can use."""
        given: Any = self.plugin.guarded(self.stage.parameters)(period)
        if not isinstance(given, tuple | list):
            raise self.plugin.fault(f"gives a {type(given).__name__} as its parameters")
        return require_parameters(tuple(cast("Sequence[Any]", given)), self.plugin)

    def respond(self, signal: Any, clock: Clock, q: Sequence[Any], rows: slice) -> Any:
        """The output over all rows, looked at: many rows meet what a few do not."""
        given: Any = self.plugin.guarded(self.stage.respond)(signal, clock, q, rows)
        ahead = signal.slip if isinstance(signal, SlipAndStrength) else signal
        all_rows = rows_of(ahead)
        if not all_rows:
            return given
        wanted = (len(range(*rows.indices(all_rows[0]))),)
        outputs = cast("list[Any]", given if isinstance(given, list | tuple) else [given])
        for output in outputs:
            require_rows(output, wanted, "for the signal behind it", self.plugin)
        return cast(Any, given)

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy in another process finds the stage by its name."""
        return _again, (self.plugin.group, self.plugin.name, self.stage.name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, OutsideStage) and (self.stage, self.plugin) == (
            other.stage,
            other.plugin,
        )

    def __hash__(self) -> int:
        return hash((self.stage, self.plugin))


def made_stage(plugin: Plugin, specification: str) -> Stage:
    """The stage that a specification such as ``dahl-2/field`` names, of the plug-in with its name.

    Raises:
        SettingError: no such number or form (PluginError: the plug-in fails).
    """
    family: Any = plugin.value if isinstance(plugin.value, StageFamily) else None
    name, *forms = specification.split("/")
    digits = name.removeprefix(plugin.name).removeprefix("-")
    count = int(digits) if digits.isdecimal() and len(digits) < 4 else None
    most = 0
    known: tuple[str, ...] = ()
    if family is not None:
        most = MOST_STATES if family.count is not None else 0
        known = family.forms
    is_count = not digits or (count is not None and 1 <= count <= most)
    if not is_count or set(forms) - set(known):
        offered = [f"{plugin.name}-N with N from 1 to {most}" if most else plugin.name]
        offered += [f"{plugin.name}/{form}" for form in known]
        raise SettingError(f"unknown stage {specification!r}", remedy=f"Write {', '.join(offered)}")

    with plugin.working():
        if family is None:
            stage = plugin.of_type(Stage)
        else:
            stage = family.make(count or family.count or 1, tuple(sorted(set(forms))))
    return stage if plugin.own else cast(Stage, OutsideStage(stage, plugin))


def _again(group: str, name: str, specification: str) -> Stage:
    return made_stage(find(group, name), specification)
