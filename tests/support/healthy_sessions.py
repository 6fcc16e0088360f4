"""What `erclutch live` runs on a healthy TWIN: each of its programs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from erclutch.signals.channels import NamedChannels
from erclutch.signals.device import DeviceName, Units
from erclutch.wings.live.command_line.chosen_rig import channels_of_rig
from erclutch.wings.live.command_line.chosen_settings import settings_of
from erclutch.wings.live.command_line.live_options import ControlOptions, RigOptions
from erclutch.wings.live.session import LiveModel, ServedRig
from erclutch.wings.live.settings import LoopSettings
from erclutch.wings.rig.twin.parameters import default_rig


def sessions(
    device: DeviceName, model: LiveModel, **control: Any
) -> Iterator[tuple[LoopSettings, str]]:
    """Settings of ``erclutch live`` for each program that it offers on the TWIN, and the program's name."""
    named = NamedChannels({}, Units("N*m", "", "rad/s"), motor=True, sensor=True)
    twin = ServedRig("twin", "TWIN", {"kind": "twin"}, named)
    options = RigOptions(seed=1), ControlOptions(**control)
    offered = settings_of(
        twin, device, model, channels_of_rig(twin, device, model), default_rig(), options, {}, None
    )
    for program in offered.programs:
        yield replace(offered, programs=(program,)), program.name
