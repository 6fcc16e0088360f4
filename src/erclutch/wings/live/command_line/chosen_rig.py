"""The rig, its device, its model, and what the numbers of a session are called, as the options choose them."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
TWINS = ("twin", "twin-brake")


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
        raise SettingError(f"{model!r} is a model of a run, and no run is given", where=where, remedy="Give --run RUN")
    return run


def rig_of(
    rig: RigOptions, reading: LogOptions, folder: Path, model: Path | None, control: ControlOptions, loop: LoopOptions
) -> tuple[RigChoice, LoopProgram | None]:
    """The rig, and the program of a replay. The twin, and a rig behind UDP, are of the model's device."""
    from erclutch.models.load import load_model
    from erclutch.signals.channels import NamedChannels
    from erclutch.signals.device import Units
    from erclutch.wings.live.session import ServedRig
    from erclutch.wings.rig.rig_plugins import hardware, udp_rig

    if rig.rig in ("twin", "twin-brake"):
        brake = rig.rig == "twin-brake" or (model is not None and load_model(model).structure.device == "single")
        spec: dict[str, Any] = {"kind": "twin", "seed": rig.seed, "single": brake, "locked": brake}
        if rig.rig_file is not None:
            spec["rig_file"] = str(rig.rig_file.resolve())
        named = NamedChannels({}, Units("N*m", "", "rad/s"), motor=True, sensor=True)
        return ServedRig("twin-brake" if brake else "twin", "TWIN", spec, named), None
    if rig.rig == "replay":
        return _replay(rig, reading, folder, control, math.inf if loop.seconds is None else loop.seconds)
    if rig.rig == "udp":
        device = (reading.device or "coaxial") if model is None else load_model(model).structure.device
        return udp_rig(rig.address, rig.session, device), None
    return hardware(rig.rig), None


def _replay(
    rig: RigOptions, reading: LogOptions, folder: Path, control: ControlOptions, seconds: float
) -> tuple[RigChoice, LoopProgram]:
    import numpy as np

    from erclutch.cli import terminal
    from erclutch.signals.channels import NamedChannels
    from erclutch.signals.device import EFFORT_OF, Units
    from erclutch.signals.units import UNKNOWN
    from erclutch.wings.live.offered_programs import recorded
    from erclutch.wings.live.session import ServedRig
    from erclutch.wings.rig.playback import angles_of, at_period, fields_of

    if rig.log is None:
        raise SettingError("--rig replay needs a recording", remedy="Give --log FILE")
    if control.field_limit is not None:
        raise SettingError("--field-limit with a replay", remedy="Leave it out: the fields are those of the log")
    log = reading.read((rig.log,))[0]
    angles = angles_of(log, (control.theta_wrap, control.alpha_wrap))
    np.save(folder / "angles.npy", at_period(log, angles, PERIOD, held=False, seconds=seconds))
    commands = at_period(log, fields_of(log), PERIOD, held=True, seconds=seconds)
    device = reading.device or ("coaxial" if EFFORT_OF["coaxial"] in log.signals else "single")
    single = device == "single"
    spec = {"kind": "replay", "angles": str(folder / "angles.npy"), "period": PERIOD, "single": single}
    effort = log.units.get(EFFORT_OF[device], UNKNOWN)
    field = next((log.units[name] for name in ("field", "E1", "E") if name in log.units), UNKNOWN)
    speed = {"rad": "rad/s", "m": "m/s"}.get(log.units.get("position", ""), UNKNOWN)
    slip = log.units.get("slip", speed) if single else "rad/s"
    sensor = EFFORT_OF[device] in log.signals
    named = NamedChannels({}, Units(effort, field, slip), "motor_torque" in log.signals, sensor)
    origin = "RECORDING" if log.origin in terminal.MEASURED else f"RECORDING of {log.origin}"
    return ServedRig(log.name, origin, spec, named), recorded(commands)


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

    if path is not None:
        return live_model(path, device, adapt=adapt, units=what.named and what.named.units)
    if rig.rig not in TWINS:
        return None
    from erclutch.wings.rig.twin_model import twin_model

    return live_model(twin_model(parameters, output, device), device, adapt=adapt)


def channels_of_rig(rig: RigChoice, device: DeviceName, model: LiveModel | None) -> tuple[LiveChannel, ...]:
    """What the numbers of the session are called: units as the rig says, else as the model has them."""
    from erclutch.signals.channels import USUAL, channels_of
    from erclutch.signals.device import Units
    from erclutch.signals.units import UNKNOWN

    units, named = model and model.units, rig.named
    if named is None:
        return channels_of(device, units)
    known = {name: unit for name, unit in asdict(named.units).items() if unit != UNKNOWN}
    usual = Units(UNKNOWN, UNKNOWN, UNKNOWN) if rig.origin.startswith("RECORDING") else USUAL[device]
    merged = replace(units or usual, **known)
    return named.of(channels_of(device, merged, motor=named.motor))
