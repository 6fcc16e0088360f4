"""Stages have names: each is a file in this folder or comes from another package (entry point ``erclutch.stages``).

A specification of stages is ``none``, a name such as ``lag``, or several names joined by ``+`` in the order of the
signal.
"""

from __future__ import annotations

from functools import cache
from typing import cast

from erclutch import registry
from erclutch.errors import PluginError, SettingError
from erclutch.models.stages.outside_stage import OutsideStage, made_stage
from erclutch.models.stages.stage import (
    Place,
    PositionStage,
    SlipStage,
    Stage,
    StageFamily,
)
from erclutch.models.stages.temperature_factor import TemperatureFactor
from erclutch.registry import Plugin

GROUP = "erclutch.stages"
NONE = "none"


@cache
def stage_named(specification: str) -> Stage:
    """A stage by its specification: a name, or of a family a name, a number and forms, such as ``dahl-2/field``.

    Raises:
        SettingError: there is none, or no such number or form (PluginError: a stage of another package fails).
    """
    name = specification.split("/")[0]
    stem, _, digits = name.rpartition("-")
    numbered = (
        digits.isdecimal() and name not in registry.names(GROUP) and stem in registry.names(GROUP)
    )
    return made_stage(registry.find(GROUP, stem if numbered else name), specification)


def shown_stages(failed: list[PluginError] | None = None) -> list[Stage]:
    """Each stage in each of its forms, without those of other packages that fail.

    Args:
        failed: gets what is wrong with each of these.
    """
    shown: list[Stage] = []
    for plugin in registry.plugins(GROUP):
        try:
            specifications = [plugin.name]
            if isinstance(plugin.value, StageFamily):
                specifications += [f"{plugin.name}/{form}" for form in plugin.value.forms]
            shown += [stage_named(specification) for specification in specifications]
        except PluginError as error:
            if failed is not None:
                failed.append(error)
    return shown


@cache
def stages_of(specification: str) -> tuple[Stage, ...]:
    """The stages that a specification names, in its order.

    Raises:
        SettingError: a stage that is not there.
    """
    if specification == NONE:
        return ()
    stages = tuple(stage_named(name) for name in specification.split("+"))
    names = [parameter.name for stage in stages for parameter in stage.parameters(1.0)]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        problem = f"two stages of {specification!r} have a parameter {twice}"
        raise SettingError(problem, remedy="Leave one of these stages out")
    return stages


def canonical(specification: str) -> str:
    """The specification with each stage by its own name, so that ``dahl-1`` and ``dahl`` are one.

    Raises:
        SettingError: a stage that is not there.
    """
    return "+".join(stage.name for stage in stages_of(specification)) or NONE


@cache
def stages_at(specification: str, place: Place) -> tuple[Stage, ...]:
    """The stages of one place."""
    return tuple(stage for stage in stages_of(specification) if stage.place == place)


def needs_time(stage: Stage) -> bool:
    """Whether a stage takes something from one row to the next, so that points of a table say nothing of it.

    A stage that works on each row alone says so: its ``needs_time`` is False, as that of every `RowByRow` is.
    """
    return getattr(stage, "needs_time", True)


def slip_stages(specification: str) -> tuple[SlipStage, ...]:
    """The stages on the slip."""
    return tuple(cast(SlipStage, stage) for stage in stages_at(specification, "slip"))


def temperature_stages(specification: str) -> tuple[TemperatureFactor, ...]:
    """The stages on the temperature."""
    return tuple(
        stage
        for stage in stages_at(specification, "temperature")
        if isinstance(stage, TemperatureFactor)
    )


def position_stages(specification: str) -> tuple[PositionStage, ...]:
    """The stages on the position."""
    return tuple(cast(PositionStage, stage) for stage in stages_at(specification, "position"))


def stage_equations(specification: str) -> list[str]:
    """What each stage computes, a line of text each."""
    return [f"{stage.name}: {stage.equation}." for stage in stages_of(specification)]


def outside_stages(specification: str) -> tuple[Plugin, ...]:
    """The plug-ins of other packages among the stages that a specification names."""
    return tuple(
        stage.plugin for stage in stages_of(specification) if isinstance(stage, OutsideStage)
    )
