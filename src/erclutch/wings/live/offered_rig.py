"""A rig of ours is a file in the folder `rigs`: what it is, and how the options of ``erclutch live`` choose it.

Rigs of other packages take no options, see `erclutch.wings.rig.rig_plugins`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from erclutch import registry
from erclutch.wings.rig.rig_plugins import GROUP

if TYPE_CHECKING:
    from erclutch.cli.options import LogOptions
    from erclutch.wings.live.command_line.live_options import (
        ControlOptions,
        LoopOptions,
        RigOptions,
    )
    from erclutch.wings.live.session import RigChoice
    from erclutch.wings.live.settings import LoopProgram
    from erclutch.wings.rig.interface import SteppedRig


@dataclass(frozen=True)
class AskedRig:
    """What a user says that a rig may depend on.

    Attributes:
        options, control, loop, reading: as they are typed.
        model: file of the model; None without a model.
        folder: for files that the session needs; it goes with the session.
    """

    options: RigOptions
    control: ControlOptions
    loop: LoopOptions
    reading: LogOptions
    model: Path | None
    folder: Path


@dataclass(frozen=True)
class OfferedRig:
    """A rig of ours.

    Attributes:
        place: in a list of rigs.
        chosen: the rig that is asked for, and the program that it brings; None: the session's own programs.
        stepped: of a rig in a process of its own: what steps there, and its lead in m, by the specification
            that ``chosen`` gave.
        is_twin: a network is fitted to it where no model is given.
        learns: the rounds of ``--program learn`` can be played on it.
    """

    place: int
    chosen: Callable[[AskedRig], tuple[RigChoice, LoopProgram | None]]
    stepped: Callable[[Mapping[str, Any]], tuple[SteppedRig, float]] | None = None
    is_twin: bool = False
    learns: bool = True


def offered_rig(name: str) -> OfferedRig | None:
    """Our rig of a name; None where the name is not ours."""
    for plugin in registry.plugins(GROUP):
        if plugin.own and plugin.name == name and isinstance(plugin.value, OfferedRig):
            return plugin.value
    return None
