"""The rig, its device, its model, and what the numbers of a session are called, as the options choose them."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

from erclutch.cli.options import LogOptions
from erclutch.errors import SettingError
from erclutch.wings.live.command_line.live_options import ControlOptions, LoopOptions, RigOptions

if TYPE_CHECKING:
    from rich.console import Console

    from erclutch.signals.channels import LiveChannel
    from erclutch.signals.device import DeviceName
    from erclutch.wings.live.session import LiveModel, RigChoice
    from erclutch.wings.live.settings import LoopProgram
    from erclutch.wings.rig.twin.parameters import RigParameters

PERIOD = 1e-3  # s


def file_of(run: Path | None, model: str | None) -> Path | None:
    """The file of a model of a run, of its recommended one where none is named, or the file that is given itself.

    Raises:
        SettingError: a model is named, and there is no run that has it.
    """
    from erclutch.runs.run_folder import read_run

    if run is not None and run.is_dir():
        return read_run(run).model_file(model)
    if model is not None:
        where = "" if run is None else str(run)
        raise SettingError(
            f"{model!r} is a model of a run, and no run is given",
            where=where,
            remedy="Give --run RUN",
        )
    return run


def rig_of(
    rig: RigOptions,
    reading: LogOptions,
    folder: Path,
    model: Path | None,
    control: ControlOptions,
    loop: LoopOptions,
) -> tuple[RigChoice, LoopProgram | None]:
    """The rig, and the program that it brings. The twin, and a rig behind UDP, are of the model's device."""
    from erclutch.wings.live.offered_rig import AskedRig, offered_rig
    from erclutch.wings.rig.rig_plugins import hardware

    offered = offered_rig(rig.rig)
    if offered is None:
        return hardware(rig.rig), None
    asked = AskedRig(
        options=rig,
        control=control,
        loop=loop,
        reading=reading,
        model=model,
        folder=folder,
    )
    return offered.chosen(asked)


def device_of(rig: RigChoice) -> DeviceName:
    """What hangs on the rig."""
    from erclutch.wings.rig.rig_plugins import RigDevice

    if isinstance(rig, RigDevice):
        return rig.device
    return "single" if rig.spec["single"] else "coaxial"


def model_of(
    path: Path | None,
    rig: RigOptions,
    what: RigChoice,
    parameters: RigParameters,
    output: Console,
    device: DeviceName,
    adapt: bool,
) -> LiveModel | None:
    """The compiled model: of a file, else on the TWIN a network that is fitted to it once; None on other rigs."""
    from erclutch.wings.live.live_model import live_model
    from erclutch.wings.live.offered_rig import offered_rig

    if path is not None:
        units = None if what.named is None else what.named.units
        return live_model(path, device, adapt=adapt, units=units)
    offered = offered_rig(rig.rig)
    if offered is None or not offered.is_twin:
        return None
    from erclutch.wings.rig.twin_model import twin_model

    return live_model(twin_model(parameters, output, device), device, adapt=adapt)


def channels_of_rig(
    rig: RigChoice,
    device: DeviceName,
    model: LiveModel | None,
) -> tuple[LiveChannel, ...]:
    """What the numbers of the session are called: units as the rig says, else as the model has them."""
    from erclutch.signals.channels import USUAL, channels_of
    from erclutch.signals.device import Units
    from erclutch.signals.units import UNKNOWN

    units = None if model is None else model.units
    named = rig.named
    if named is None:
        return channels_of(device, units)
    if units is None and rig.origin.startswith("RECORDING"):
        units = Units(UNKNOWN, UNKNOWN, UNKNOWN)
    elif units is None:
        units = USUAL[device]
    known = {name: unit for name, unit in asdict(named.units).items() if unit != UNKNOWN}
    units = replace(units, **known)
    return named.of(channels_of(device, units, motor=named.motor))
