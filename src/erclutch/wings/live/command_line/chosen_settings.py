"""Settings of the loop, as the options, a tuning, the rig and its model say them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from erclutch.errors import SettingError
from erclutch.files.given_files import plain_words, small_file, toml_of
from erclutch.wings.live.command_line.chosen_rig import PERIOD
from erclutch.wings.live.command_line.live_options import DEFAULTS, ControlOptions, RigOptions
from erclutch.wings.live.motion_limits import MOTION

if TYPE_CHECKING:
    from erclutch.signals.channels import LiveChannel
    from erclutch.signals.device import DeviceName
    from erclutch.wings.live.session import LiveModel, RigChoice
    from erclutch.wings.live.settings import LoopProgram, LoopSettings
    from erclutch.wings.rig.twin.parameters import RigParameters

#: The motor's torque of a replay, and the jumps of its angles, are what they were.
_AS_RECORDED = {"motor_limit": 1e9}

#: Of an output on which nothing acts beside the measured torque and dry friction: only the user knows that.
_LOAD = ("load_inertia", "load_friction", "load_drag", "load_band")

#: Of --meter-needed, of neither, and of --no-meter-needed.
_METER_NEEDED = {True: 2.0, None: 1.0, False: 0.0}

_NO_JUMPS = dict.fromkeys(MOTION, 0.0)

#: The program that runs first where none is named, by the rig; on others they rest.
_FIRST = {"twin": "tracking-slow", "twin-brake": "sine"}


def settings_of(
    rig: RigChoice,
    device: DeviceName,
    model: LiveModel | None,
    channels: Sequence[LiveChannel],
    parameters: RigParameters,
    options: tuple[RigOptions, ControlOptions],
    tuning: dict[str, float],
    replay: LoopProgram | None,
) -> LoopSettings:
    """Settings of a session.

    Args:
        rig: what is driven.
        device: what hangs on it.
        model: what estimates; None where there is none.
        channels: what the numbers of a frame are called.
        parameters: of the rig file.
        options: of the rig and of control; see `supported`.
        tuning: further settings of a tuning; see `tuned`.
        replay: the program of a recording that is played; None where there is none.

    Raises:
        SettingError: an unknown program, or a field limit that is none or beyond the supply's.
    """
    from erclutch.wings.live.sensor_limits import free_drive, free_output, sensor_limits
    from erclutch.wings.rig.rig_plugins import RigDevice

    of_rig, control = options
    settings = _settings(parameters, control, device, model, channels, replay, of_rig)
    as_recorded = rig.origin.startswith("RECORDING")  # a recording is as it was

    # What the sensors can read. A single device is not that of the rig's file unless it is the TWIN's.
    if not as_recorded:
        known = device == "coaxial" or rig.origin == "TWIN"
        of_file = parameters if known else None
        limits = sensor_limits(device, model, of_file, settings.derivative, PERIOD)
        if rig.origin == "TWIN":  # nobody holds its output or turns its drive
            free = free_output if device == "coaxial" else free_drive
            limits |= free(parameters, settings.derivative, PERIOD)
        if not known and model is not None:
            limits["least_slip"] = 0.05 * model.slip
        settings = replace(settings, **limits)
    settings = replace(settings, **tuning)

    # A field limit within the rig's supply, and rates in proportion. The supply of a rig that is not ours, with a
    # single device that names no limit, is the operator's to know.
    if not as_recorded:
        asked = control.field_limit
        most = settings.field_limit
        if isinstance(rig, RigDevice):
            if rig.field_limit:
                most = rig.field_limit
            elif device == "single" and asked is not None:
                most = math.inf
        if asked is not None and not 0 < asked <= min(most, 1e9):
            at_most = f", at most the supply's {most:g}" if most < math.inf else ""
            raise SettingError(f"--field-limit {asked:g}", remedy=f"Give a number above 0{at_most}")
        # The field of which the supply's rates are.
        full = asked if asked and most == math.inf else most
        share = full / settings.field_limit
        settings = replace(
            settings,
            field_limit=asked or most,
            rise_rate=settings.rise_rate * share,
            fall_rate=settings.fall_rate * share,
        )
    if device == "single":
        settings = replace(settings, stroke=0.0)  # it has none that ends
    return settings


def supported(
    control: ControlOptions,
    rig: RigChoice,
    model: LiveModel | None,
    adapt: bool,
) -> ControlOptions:
    """The options with an observer that the model allows.

    Raises:
        SettingError: an option lacks its model, or it is known that nothing measures the torque.
    """
    # Of each option that is asked for: whether it needs a model, and whether a torque sensor.
    asked = {
        "--adapt": (adapt, adapt),
        "--observer": (control.observer not in (None, "off"), control.observer == "sensor"),
        "--track-bandwidth": (control.track_bandwidth != 0.0, False),
    }
    for option, (needs_model, needs_sensor) in asked.items():
        if needs_model and model is None:
            raise SettingError(
                f"{option} without a model", remedy=f"Give --run RUN, or leave {option} out"
            )
        if needs_sensor and rig.named is not None and not rig.named.sensor:
            problem = f"{option} needs a torque sensor, and this rig has none"
            raise SettingError(problem, where=rig.name, remedy=f"Leave {option} out")
    if control.observer:
        return control
    _, usual, _ = DEFAULTS
    has_gains = (control.torque_p, control.torque_i) != (usual.torque_p, usual.torque_i)
    by_gains = model is None or adapt or has_gains
    return replace(control, observer="off" if by_gains else "none")


def tuned(control: ControlOptions) -> tuple[ControlOptions, dict[str, float]]:
    """The options with what a settings file says of those that have their defaults, and its further settings.

    Raises:
        SettingError: the file cannot be read, or holds what is no setting or no number.
    """
    from erclutch.wings.live.commands.tune import TUNED

    if control.tuned is None:
        return control, {}
    try:
        body = toml_of(small_file(control.tuned))
    except (OSError, ValueError, RecursionError) as error:
        problem = f"cannot be read ({plain_words(error)})"
        raise SettingError(
            problem, where=str(control.tuned), remedy="Give a file that erclutch tune wrote"
        ) from error
    known = (*TUNED, *_LOAD)
    for name, value in body.items():
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if name not in known or not is_number:
            remedy = f"Give numbers to {', '.join(known)}"
            raise SettingError(f"{name} = {value!r}", where=str(control.tuned), remedy=remedy)
    _, usual, _ = DEFAULTS
    options: dict[str, float] = {}  # that nobody gave
    further: dict[str, float] = {}
    for name, value in body.items():
        if not hasattr(control, name):
            further[name] = value
        elif getattr(control, name) == getattr(usual, name):
            options[name] = value
    return replace(control, **options), further


def knows_inertia(control: ControlOptions) -> None:
    """Computed torque needs the inertia that the model's torque moves.

    Raises:
        SettingError: it is not given.
    """
    if control.track_bandwidth and control.output_inertia is None:
        remedy = "Run erclutch tune RUN and give its control.toml to --tuned, or give --output-inertia in kg m2"
        raise SettingError(
            "--track-bandwidth without the inertia that the model's torque moves", remedy=remedy
        )


def _settings(
    parameters: RigParameters,
    control: ControlOptions,
    device: DeviceName,
    model: LiveModel | None,
    channels: Sequence[LiveChannel],
    replay: LoopProgram | None,
    rig: RigOptions,
) -> LoopSettings:
    from erclutch.signals.speed import Derivative
    from erclutch.wings.live.offered_programs import (
        rig_settings,
        shaft_angle,
        standard_programs,
        starting_with,
    )

    common: dict[str, Any] = {
        "device": device,
        "derivative": Derivative("kalman", control.speed_bandwidth),
        **_values(
            control,
            "k_p",
            "k_d",
            "torque_p",
            "torque_i",
            "theta_wrap",
            "alpha_wrap",
            "stiffness",
            "damping",
        ),
        **_values(control, "track_bandwidth"),
        "meter_needed": _METER_NEEDED[control.meter_needed],
    }
    if control.track_bandwidth:
        common |= _values(control, "output_inertia", "output_friction")
    if control.observer != "off":
        common |= _values(control, "observer", "observer_bandwidth", "torque_lead")
    if control.observer == "sensor":
        common["torque_lag"] = 1e-3
    elif control.observer == "motion":
        # Gains and the drag on the drive are learned from motion alone.
        common["gain_rate"] = 0.2
        common["drive_inertia"] = parameters.value("drive.inertia")
        common["drive_friction"] = parameters.value("drive.coulomb")
        common["drive_drag_1"] = parameters.value("drive.viscous")
        common["drive_drag_2"] = parameters.value("drive.viscous")
    if replay is not None:
        largest = 0.0  # field of the recording
        if replay.table is not None:
            largest = float(abs(replay.table[:, :2]).max())
        limit = 1.0  # where no field is on
        rate = 1.0 / PERIOD
        if largest > 0.0:
            limit = largest
            rate = 2.0 * largest / PERIOD  # from one end to the other in a period
        limits = {"field_limit": limit, "rise_rate": rate, "fall_rate": rate}
        if not control.meter_needed:  # a recording drives nothing
            common["meter_needed"] = 0.0
        return rig_settings(parameters, (replay,), **common, **_AS_RECORDED, **_NO_JUMPS, **limits)

    # Torques of the programs are those of the rig file: a force needs programs of its own.
    estimates = [channel for channel in channels if channel.role == "estimate"]
    turns = all(channel.unit in ("N*m", "?") for channel in estimates)
    has_motor = any(channel.role == "motor" for channel in channels)
    programs = standard_programs(
        parameters,
        model=model is not None and turns,
        motor=control.motor,
        seed=rig.seed,
        device=device,
        drive=device == "coaxial" or (turns and has_motor),
        effort=0.0 if model is None else model.effort,
        stiffness=control.stiffness,
    )
    first = control.program or _FIRST.get(rig.rig, "rest")
    if device == "single" and first == "tracking-slow":
        first = "sine"  # it has no table
    stroke = shaft_angle(parameters, 0.9)
    return rig_settings(parameters, starting_with(programs, first), **common, stroke=stroke)


def _values(control: ControlOptions, *names: str) -> dict[str, Any]:
    """Options that are settings of the same name."""
    return {name: getattr(control, name) for name in names}
