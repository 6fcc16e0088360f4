"""Which stages may come next: users add one of each family, the simplest first, where the rows can tell of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from erclutch import registry
from erclutch.fit.checks.data_check import steady_command
from erclutch.logs.dataset import Dataset
from erclutch.logs.speed_of_position import is_of_position
from erclutch.models.laws.yield_stress import CONSTANT
from erclutch.models.stages import GROUP, NONE, needs_time, stage_named
from erclutch.models.stages.stage import StageFamily
from erclutch.models.structure import Structure
from erclutch.signals.recording import POSITION, TEMPERATURE


def families() -> list[tuple[str, ...]]:
    """Names of the stages that users can add, a family each, from the simplest to the richest."""
    return [family.ladder for family in _families()]


def _families() -> Iterator[StageFamily]:
    """The families of stages that the ladder tries."""
    for plugin in registry.plugins(GROUP):
        # Installing a package changes no figure: another package's stages are asked for by name.
        if plugin.own and isinstance(plugin.value, StageFamily) and plugin.value.ladder:
            yield plugin.value


def _family_of(name: str) -> StageFamily | None:
    """The family on whose ladder a stage stands; None for further inputs, and for stages that only users add."""
    return next((family for family in _families() if name in family.ladder), None)


def feels(
    train: Dataset,
    base: Structure,
    name: str,
    extras: Sequence[str],
) -> bool:
    """Whether a stage can do anything: one on the temperature needs it, and a law whose effort it knows apart.

    Points of a table, none after another in time, feel only stages that need no time.
    """
    stage = stage_named(name)
    if train.in_no_time and needs_time(stage):
        return False
    own = _family_of(name)
    turns = any(element.slip.min() < 0.0 < element.slip.max() for element in train.elements)
    if own is not None and not turns:
        # A slip that never turns does not show what differs between its two ways, and its travel is a time.
        if own.two_ways or name in own.apart:
            return False
        if own.of_travel and not is_of_position(train.notes):
            return False
    place = stage.place
    if place == "command":
        return not steady_command(train)
    if place == "position":
        return POSITION in extras
    if place != "temperature":
        return True
    return TEMPERATURE in extras and set(base.law.parts) >= {"yield", "viscous"}


def is_next(left: Sequence[str], name: str) -> bool:
    """Whether no simpler stage of the same family is left; a further input is a family of its own."""
    family = _family_of(name)
    ladder = (name,) if family is None else family.ladder
    simplest = next(each for each in ladder if each in left)
    return simplest == name


def has_company(structure: Structure, name: str) -> bool:
    """Whether the structure has what the stage stands beside: a second ripple is what the first leaves."""
    family = _family_of(name)
    if family is None or not family.beside:
        return True
    stages = structure.dynamics.split("+")
    company = _family_of(family.beside)
    return company is not None and any(stage in stages for stage in company.ladder)


def widened(structure: Structure, name: str) -> Structure:
    """The structure with a stage, in place of a simpler one of its family; or with a further input."""
    if name.startswith("="):
        return replace(structure, extras=(*structure.extras, name[1:]))
    return replace(structure, dynamics=with_stage(structure.dynamics, name))


def with_stage(dynamics: str, name: str) -> str:
    """The stages with one more, in place of a simpler one of its family."""
    family = next(family for family in _families() if name in (*family.ladder, *family.behind))
    kept = [
        each for each in dynamics.split("+") if each not in (*family.ladder, *family.behind, NONE)
    ]
    if stage_named(name).place == "command":
        # Ahead of the lag: what stays behind the command itself does not move with the lag's numbers, so that a solver
        # meets no corners where these change.
        return "+".join([name, *kept])
    return "+".join([*kept, name])


def edge_of(name: str) -> str:
    """The number of a stage that is the widest edge of its plays; "" for a stage without plays."""
    family = _family_of(name)
    return "" if family is None else family.edge


def fading_of(name: str) -> str:
    """The slip over which a stage fades that would be the sign's own turn if it were small; "" for other stages."""
    family = _family_of(name)
    return "" if family is None else family.fades


def forgetting_of(name: str) -> tuple[str, str]:
    """The time after which a stage forgets a travel, and the stage that says as much without one; else "" and ""."""
    family = _family_of(name)
    return ("", "") if family is None else (family.forgets, family.instead)


def simpler_than(left: Sequence[str], name: str) -> list[str]:
    """Those that are left of the stages of the same family that are simpler."""
    family = _family_of(name)
    if family is None:
        return []
    return [each for each in family.ladder[: family.ladder.index(name)] if each in left]


def has_to_take_off(name: str) -> float:
    """The share of the error that a stage has to show beside a law before it is searched, and to take off; 0: none."""
    family = _family_of(name)
    return 0.0 if family is None else family.apart.get(name, family.striking)


def with_field_behind(structure: Structure, name: str) -> Structure | None:
    """The structure with the field behind the memory of this name; None where it has no such form, or no field."""
    family = _family_of(name)
    if family is None or not family.behind or structure.law.yield_form is CONSTANT:
        return None
    behind = family.behind[family.ladder.index(name)]
    return replace(structure, dynamics=with_stage(structure.dynamics, behind))


def has_field_behind(structure: Structure, name: str) -> bool:
    """Whether the structure has a simpler memory of the same family with the field behind it."""
    family = _family_of(name)
    stages = structure.dynamics.split("+")
    return family is not None and any(stage in family.behind for stage in stages)
