"""``erclutch live`` estimates, controls, records and shows at 1 kHz."""

from __future__ import annotations

import json as json_text
import math
import signal
import tempfile
import time
from collections.abc import Generator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.errors import SettingError, require
from erclutch.files import plain_words, toml_of

if TYPE_CHECKING:
    from rich.console import Console

    from erclutch.signals.channels import LiveChannel
    from erclutch.signals.device import DeviceName
    from erclutch.wings.live.companions import Observers
    from erclutch.wings.live.session import LiveModel, RigChoice, Session
    from erclutch.wings.live.session_figures import SessionFigures
    from erclutch.wings.live.settings import LoopProgram, LoopSettings
    from erclutch.wings.rig.twin.parameters import RigParameters

COMMAND = {
    "help": "Estimate, control, record and watch at 1 kHz, on the digital TWIN or on your rig.",
    "panel": "Live",
    "place": 1,
}

_RIG = Group("Rig", sort_key=0)
_CONTROL = Group("Control", sort_key=1)
_LOOP = Group("Loop", sort_key=1)
_Observer = Literal["off", "none", "sensor", "motion"]
_POLL = 0.05  # s
_PERIOD = 1e-3  # s
_PATIENCE = 3.0  # s
#: The motor's torque of a replay, and the jumps of its angles, are what they were.
_AS_RECORDED = {"motor_limit": 1e9}
_NO_JUMPS = dict.fromkeys(("theta_glitch", "alpha_glitch", "theta_fastest", "alpha_fastest"), 0.0)
_TWINS = ("twin", "twin-brake")
_ASTRAY = (
    "The fields that the model names do not give the wanted torque here. Try --observer sensor, another model of the "
    "run (--model RUN/models/NAME.json, such as bingham+fnn-16), or a log of this motion (erclutch excite)."
)
_NO_SAMPLE = (
    "no sample came from the rig. Is it on, at this address, with this --session, of a {} device (byte 52: {})?"
)


@Parameter(name="*")
@dataclass(frozen=True)
class RigOptions:
    """What is driven."""

    rig: Annotated[str, Parameter(group=_RIG)] = "twin"
    """What is driven: twin, twin-brake (CH1 alone), replay, udp, or a plug-in's name (entry point erclutch.rigs)."""
    log: Annotated[Path | None, Parameter(group=_RIG)] = None
    """Recording that --rig replay plays."""
    address: Annotated[str, Parameter(group=_RIG)] = ""
    """HOST:PORT of the rig behind --rig udp."""
    session: Annotated[int, Parameter(group=_RIG)] = 0
    """Number that both sides put into their packets with --rig udp."""
    rig_file: Annotated[Path | None, Parameter(group=_RIG)] = None
    """A rig file (TOML) with what differs from the default rig: limits of the supply, screw, twin."""
    seed: Annotated[int, Parameter(group=_RIG)] = 0
    """Seed of the twin's noise and of random sequences."""


@Parameter(name="*")
@dataclass(frozen=True)
class ControlOptions:
    """What is done."""

    program: Annotated[str | None, Parameter(group=_CONTROL)] = None
    """Program that runs first. Default: tracking-slow on the twin, rest on hardware, recorded commands in a replay."""
    motor: Annotated[float, Parameter(group=_CONTROL)] = 0.1
    """Constant motor torque of the programs in N m."""
    k_p: Annotated[float, Parameter(group=_CONTROL)] = 0.08
    """Tracking gain k_p of equation 23: field per rad."""
    k_d: Annotated[float, Parameter(group=_CONTROL)] = 2.0e-3
    """Tracking gain k_d of equation 23: field per rad/s."""
    torque_p: Annotated[float, Parameter(group=_CONTROL)] = 0.1
    """Proportional gain of torque control: field per N m of error of the estimate."""
    torque_i: Annotated[float, Parameter(group=_CONTROL)] = 20.0
    """Integral gain of torque control: field per N m s."""
    observer: Annotated[_Observer | None, Parameter(group=_CONTROL)] = None
    """Torque control in stages, or by torque_p and torque_i (off). In stages, what the device gives beyond its model
    comes from nothing (none), a torque sensor, or the motion of the drive, whose inertia and friction stand in
    --rig-file. Default: none where there is a model, else off; off with --adapt, --torque-p or --torque-i."""
    observer_bandwidth: Annotated[float, Parameter(group=_CONTROL)] = 20.0
    """Bandwidth of that observer in Hz; above some 60 Hz the TWIN swings."""
    torque_lead: Annotated[float, Parameter(group=_CONTROL)] = 1.5e-3
    """Lead of the wanted torque in s: dead time and lag from command to torque, with --observer."""
    track_bandwidth: Annotated[float, Parameter(group=_CONTROL)] = 0.0
    """Track by computed torque with this bandwidth in Hz, in place of k_p and k_d; 0: equation 23. It needs --tuned or
    --output-inertia."""
    stiffness: Annotated[float, Parameter(group=_CONTROL)] = 0.1
    """Stiffness of the programs impedance (a pair) and wall (a brake) in N m/rad; at most 2 damping / period."""
    damping: Annotated[float, Parameter(group=_CONTROL)] = 4.0e-3
    """Damping of these programs in N m s/rad. The device's own damping is not counted: the inverse takes it away."""
    output_inertia: Annotated[float | None, Parameter(group=_CONTROL)] = None
    """Inertia that the model's torque moves, in kg m2, for --track-bandwidth; erclutch tune finds it."""
    output_friction: Annotated[float, Parameter(group=_CONTROL)] = 0.0
    """Dry friction of the output in N m, for --track-bandwidth."""
    tuned: Annotated[Path | None, Parameter(group=_CONTROL)] = None
    """Settings that erclutch tune wrote; an option with another value than its default goes before them."""
    field_limit: Annotated[float | None, Parameter(group=_CONTROL)] = None
    """Largest field, in the unit of the rig. Default: that of the supply (the TWIN's 0.5 is 2000 V)."""
    theta_wrap: Annotated[float, Parameter(group=_CONTROL)] = 0.0
    """Range of the motor's encoder in rad, if its angle starts again at zero."""
    alpha_wrap: Annotated[float, Parameter(group=_CONTROL)] = 0.0
    """Range of the output's encoder in rad, if its angle starts again at zero."""
    bandwidth: Annotated[float, Parameter(group=_CONTROL)] = 150.0
    """Bandwidth of the speed filter (kalman) in Hz."""


@Parameter(name="*")
@dataclass(frozen=True)
class LoopOptions:
    """How the loop runs."""

    seconds: Annotated[float | None, Parameter(group=_LOOP)] = None
    """End after so many seconds. Default: run until Ctrl-C."""
    headless: Annotated[bool, Parameter(group=_LOOP, negative=())] = False
    """Run without the page."""
    record: Annotated[bool, Parameter(group=_LOOP, negative=())] = False
    """Record from the start."""
    folder: Annotated[Path, Parameter(group=_LOOP)] = Path("recordings")
    """Where recordings go."""
    port: Annotated[int, Parameter(group=_LOOP)] = 0
    """Port of the page; 0: any that is free."""
    priority: Annotated[int, Parameter(group=_LOOP)] = 80
    """Real-time priority, 1 to 99; 0: none."""
    cpu: Annotated[int | None, Parameter(group=_LOOP)] = None
    """Processor that the loop stays on."""
    json: Annotated[bool, Parameter(group=_LOOP, negative=())] = False
    """Print the figures at the end as JSON."""


_DEFAULTS = (RigOptions(), ControlOptions(), LoopOptions())


def live(
    *,
    model: Path | None = None,
    no_model: Annotated[bool, Parameter(negative=())] = False,
    adapt: Annotated[bool, Parameter(negative=())] = False,
    explain: Annotated[bool, Parameter(negative=())] = False,
    rig: RigOptions = _DEFAULTS[0],
    control: ControlOptions = _DEFAULTS[1],
    loop: LoopOptions = _DEFAULTS[2],
    reading: LogOptions = DEFAULT_READING,
) -> int:
    """Estimate torque, control, record and watch at 1 kHz, on the digital TWIN or on your rig. Ctrl-C: zero field, end.

    Args:
        model: A run, for its recommended model, or a model's file. Default on the twin: a network, fitted to it once.
        no_model: Control and record without an estimate.
        adapt: Let a gain and an offset of the model follow the torque sensor; at most 2 % worse in RMSE.
        explain: Only print what the loop does on each event in each of its states.
        rig: What is driven.
        control: What is done.
        loop: How the loop runs.
        reading: How to read the log of a replay.
    """
    from erclutch.cli import terminal
    from erclutch.wings.live.session import Session, SessionOptions
    from erclutch.wings.live.session_figures import SessionFigures
    from erclutch.wings.rig.twin.parameters import load_rig

    if explain:
        return _explained(terminal.console())
    # With --json standard output is one JSON document: all that is for people goes to standard error.
    output = terminal.console(stderr=loop.json)
    require(0.001, unit=" s", seconds=math.inf if loop.seconds is None else loop.seconds)
    require(0, 99, priority=loop.priority)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="erclutch-")))
        model = model and _file_of(model)
        parameters, (control, tuned) = load_rig(rig.rig_file), _tuned(control)
        _knows_inertia(control)
        what, program = _rig(rig, reading, folder, model, control, loop)
        device = _device(what, reading)
        chosen = None if no_model else _model(model, rig, what, parameters, output, device, adapt)
        control = _supported(control, what, chosen, adapt)
        channels = _channels(what, device, chosen)
        settings = _settings(parameters, control, device, chosen is not None, channels, program, rig)
        settings = _for_rig(_sensing(settings, what, device, chosen, parameters), what, device, control, tuned)
        options = SessionOptions(loop.seconds, loop.priority, loop.cpu, settings.programs[0].name, channels)
        told = stack.enter_context(_interrupts())
        session = stack.enter_context(Session(what, settings, chosen, options))
        observers = stack.enter_context(_observers(session, settings, parameters, loop))
        watch = SessionFigures(session.reader(), settings.programs[0].mode.reference)
        _introduce(output, session, observers, chosen)
        _follow(session, watch, told, output)
        code = session.wait(5.0)
        watch.poll()
        return _ended(session, watch, observers, code, bool(told), None if loop.json else output)


def _file_of(model: Path) -> Path:
    """The file of a model, of a run its recommended one."""
    from erclutch.runs.run_folder import read_run

    return read_run(model).model_file() if model.is_dir() else model


def _explained(output: Console) -> int:
    from erclutch.cli import terminal
    from erclutch.wings.live.explained_states import transitions

    answers = list(transitions())
    for state in dict.fromkeys(answer.state for answer in answers):
        rows = [[t.event, t.next.name.lower(), t.field, ", ".join(t.said)] for t in answers if t.state is state]
        title = f"In the state {state.name.lower()}"
        output.print(terminal.table(title, ["event", "next state", "field", "events in the frame"], rows, left=4))
    output.print("Asked of tracking. Torque, impedance and wall are answered alike.")
    return 0


def _rig(
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
        device = "coaxial" if model is None else load_model(model).structure.device
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
    np.save(folder / "angles.npy", at_period(log, angles, _PERIOD, held=False, seconds=seconds))
    commands = at_period(log, fields_of(log), _PERIOD, held=True, seconds=seconds)
    spec = {"kind": "replay", "angles": str(folder / "angles.npy"), "period": _PERIOD}
    effort = log.units.get(EFFORT_OF[reading.device], UNKNOWN)
    field = next((log.units[name] for name in ("field", "E1", "E") if name in log.units), UNKNOWN)
    speed = {"rad": "rad/s", "m": "m/s"}.get(log.units.get("position", ""), UNKNOWN)
    slip = log.units.get("slip", speed) if reading.device == "single" else "rad/s"
    sensor = EFFORT_OF[reading.device] in log.signals
    named = NamedChannels({}, Units(effort, field, slip), "motor_torque" in log.signals, sensor)
    origin = "RECORDING" if log.origin in terminal.MEASURED else f"RECORDING of {log.origin}"
    return ServedRig(log.name, origin, spec, named), recorded(commands)


def _channels(rig: RigChoice, device: DeviceName, model: LiveModel | None) -> tuple[LiveChannel, ...]:
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


def _model(
    path: Path | None,
    rig: RigOptions,
    what: RigChoice,
    parameters: RigParameters,
    output: Console,
    device: DeviceName,
    adapt: bool,
) -> LiveModel | None:
    from erclutch.wings.live.live_model import live_model

    if path is not None:
        return live_model(path, device, adapt=adapt, units=what.named and what.named.units)
    if rig.rig not in _TWINS:
        return None
    from erclutch.wings.rig.twin_model import twin_model

    return live_model(twin_model(parameters, output, device), device, adapt=adapt)


def _supported(control: ControlOptions, rig: RigChoice, model: LiveModel | None, adapt: bool) -> ControlOptions:
    """The options with an observer that the model allows.

    Raises:
        SettingError: an option lacks its model, or it is known that nothing measures the torque.
    """
    asked = {"--adapt": (adapt, adapt)}
    asked["--observer"] = control.observer not in (None, "off"), control.observer == "sensor"
    asked["--track-bandwidth"] = control.track_bandwidth != 0.0, False
    for option, (needs_model, needs_sensor) in asked.items():
        if needs_model and model is None:
            raise SettingError(f"{option} without a model", remedy=f"Give --model FILE, or leave {option} out")
        if needs_sensor and rig.named is not None and not rig.named.sensor:
            problem = f"{option} needs a torque sensor, and this rig has none"
            raise SettingError(problem, where=rig.name, remedy=f"Leave {option} out")
    gains = (control.torque_p, control.torque_i) != (_DEFAULTS[1].torque_p, _DEFAULTS[1].torque_i)
    return replace(control, observer=control.observer or ("off" if model is None or adapt or gains else "none"))


def _settings(
    parameters: RigParameters,
    control: ControlOptions,
    device: DeviceName,
    model: bool,
    channels: Sequence[LiveChannel],
    replay: LoopProgram | None,
    rig: RigOptions,
) -> LoopSettings:
    from erclutch.signals.speed import Derivative
    from erclutch.wings.live.offered_programs import rig_settings, shaft_angle, standard_programs, starting_with

    names = ("k_p", "k_d", "torque_p", "torque_i", "theta_wrap", "alpha_wrap", "stiffness", "damping")
    gains = {name: getattr(control, name) for name in names}
    common: dict[str, Any] = {"derivative": Derivative("kalman", control.bandwidth), "device": device, **gains}
    common |= _stages(parameters, control)
    if replay is not None:
        largest = 0.0 if replay.table is None else float(abs(replay.table[:, :2]).max())
        rate = (2.0 * largest or 1.0) / _PERIOD
        limits = {"field_limit": largest or 1.0, "rise_rate": rate, "fall_rate": rate}
        return rig_settings(parameters, (replay,), **common, **_AS_RECORDED, **_NO_JUMPS, **limits)
    # Torques of the programs are those of the rig file: a force needs programs of its own.
    turns = all(channel.unit in ("N*m", "?") for channel in channels if channel.role == "estimate")
    drive = device == "coaxial" or (turns and any(channel.role == "motor" for channel in channels))
    programs = standard_programs(
        parameters, model=model and turns, motor=control.motor, seed=rig.seed, device=device, drive=drive
    )
    first = control.program or {"twin": "tracking-slow", "twin-brake": "sine"}.get(rig.rig, "rest")
    first = "sine" if device == "single" and first == "tracking-slow" else first
    stroke = shaft_angle(parameters, 0.9)
    return rig_settings(parameters, starting_with(programs, first), **common, stroke=stroke)


def _stages(parameters: RigParameters, control: ControlOptions) -> dict[str, Any]:
    """Settings of computed torque, and of the stages: gains and the drag on the drive are learned from motion alone."""
    found: dict[str, Any] = {"track_bandwidth": control.track_bandwidth}
    if control.track_bandwidth:
        found |= {name: getattr(control, name) for name in ("output_inertia", "output_friction")}
    if control.observer == "off":
        return found
    found |= {name: getattr(control, name) for name in ("observer", "observer_bandwidth", "torque_lead")}
    if control.observer == "sensor":
        found["torque_lag"] = 1e-3
    elif control.observer == "motion":
        found["gain_rate"] = 0.2
        found["drive_inertia"], found["drive_friction"] = (
            parameters.value(f"drive.{n}") for n in ("inertia", "coulomb")
        )
        found |= dict.fromkeys(("drive_drag_1", "drive_drag_2"), parameters.value("drive.viscous"))
    return found


def _tuned(control: ControlOptions) -> tuple[ControlOptions, dict[str, float]]:
    """The options with what a settings file says of those that have their defaults, and its further settings.

    Raises:
        SettingError: the file cannot be read, or holds what is no setting or no number.
    """
    from erclutch.wings.live.commands.tune import TUNED

    if control.tuned is None:
        return control, {}
    try:
        body = toml_of(control.tuned.read_bytes())
    except (OSError, ValueError, RecursionError) as error:
        problem = f"cannot be read ({plain_words(error)})"
        raise SettingError(problem, where=str(control.tuned), remedy="Give a file that erclutch tune wrote") from error
    for name, value in body.items():
        if name not in TUNED or isinstance(value, bool) or not isinstance(value, int | float):
            known = ", ".join(TUNED)
            raise SettingError(f"{name} = {value!r}", where=str(control.tuned), remedy=f"Give numbers to {known}")
    options = {name: value for name, value in body.items() if hasattr(control, name)}
    default = {name: value for name, value in options.items() if getattr(control, name) == getattr(_DEFAULTS[1], name)}
    return replace(control, **default), {name: value for name, value in body.items() if name not in options}


def _knows_inertia(control: ControlOptions) -> None:
    if control.track_bandwidth and control.output_inertia is None:
        remedy = "Run erclutch tune RUN and give its control.toml to --tuned, or give --output-inertia in kg m2"
        raise SettingError("--track-bandwidth without the inertia that the model's torque moves", remedy=remedy)


def _device(rig: RigChoice, reading: LogOptions) -> DeviceName:
    """What hangs on the rig."""
    from erclutch.wings.rig.rig_plugins import RigDevice

    if isinstance(rig, RigDevice):
        return rig.device
    if rig.origin.startswith("RECORDING"):
        return reading.device
    return "single" if rig.spec["single"] else "coaxial"


def _sensing(
    settings: LoopSettings, rig: RigChoice, device: DeviceName, model: LiveModel | None, parameters: RigParameters
) -> LoopSettings:
    """The settings with what the sensors can read.

    A recording is as it was, and a single device is not that of the rig's file unless it is the TWIN's.
    """
    from erclutch.wings.live.sensor_limits import sensor_limits

    if rig.origin.startswith("RECORDING"):
        return settings
    known = device == "coaxial" or rig.origin == "TWIN"
    limits = sensor_limits(device, model, parameters if known else None, _PERIOD)
    if not known and model is not None:
        limits["least_slip"] = 0.05 * model.slip
    return replace(settings, **limits)


def _for_rig(
    settings: LoopSettings, rig: RigChoice, device: DeviceName, control: ControlOptions, tuned: dict[str, float]
) -> LoopSettings:
    """The settings as tuned, within the rig's supply; a single device has no stroke that ends.

    The supply of a rig that is not ours, with a single device that names no limit, is the operator's to know.

    Raises:
        SettingError: a field limit that is none, or beyond the supply's.
    """
    from erclutch.wings.rig.rig_plugins import RigDevice

    settings, asked = replace(settings, **tuned), control.field_limit
    if not rig.origin.startswith("RECORDING"):
        most = settings.field_limit
        if isinstance(rig, RigDevice):
            most = rig.field_limit or (most if device == "coaxial" or asked is None else math.inf)
        if asked is not None and not 0 < asked <= min(most, 1e9):
            remedy = "Give a number above 0" + (f", at most the supply's {most:g}" if most < math.inf else "")
            raise SettingError(f"--field-limit {asked:g}", remedy=remedy)
        share = (asked if most == math.inf and asked else most) / settings.field_limit
        rates = {"rise_rate": settings.rise_rate * share, "fall_rate": settings.fall_rate * share}
        settings = replace(settings, field_limit=asked or most, **rates)
    return replace(settings, stroke=0.0) if device == "single" else settings


@contextmanager
def _interrupts() -> Generator[list[int]]:
    """Ctrl-C and SIGTERM end the session in order, instead of wherever Python happens to be."""
    told: list[int] = []
    kinds = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(kind, lambda kind, _frame: told.append(kind)) for kind in kinds]
    try:
        yield told
    finally:
        for kind, handler in zip(kinds, before, strict=True):
            signal.signal(kind, handler)


@contextmanager
def _observers(
    session: Session, settings: LoopSettings, parameters: RigParameters, loop: LoopOptions
) -> Generator[Observers | None]:
    if loop.headless and not loop.record:
        yield None
        return
    from erclutch.wings.live.companions import Observers

    with Observers(
        session.ring,
        session.carry_out,
        programs=[(p.name, p.meaning, p.mode.reference) for p in settings.programs],
        motor_limit=settings.motor_limit,
        folder=loop.folder,
        page=not loop.headless,
        port=loop.port,
        stroke=settings.stroke,
        lead=parameters.value("screw.lead"),
    ) as observers:
        if loop.record:
            observers.record(True, whole=True)
        yield observers


def _introduce(output: Console, session: Session, observers: Observers | None, model: LiveModel | None) -> None:
    output.print(f"{session.origin}: {session.rig.name}", markup=False)
    listed = (str(channel) for channel in session.reader().info.channels if channel.role != "reference")
    output.print(f"channels: {', '.join(listed)}", markup=False, soft_wrap=True)
    if session.origin == "HARDWARE":
        output.print(f"largest field: {session.settings.field_limit:g}", markup=False)
    output.print(f"model: {f'{model.name} ({model.digest[:12]})' if model else 'none'}", markup=False)
    if model and model.note:
        output.print(f"note: {model.note}.", markup=False)
    output.print(f"loop: {session.reader().realtime}", markup=False, soft_wrap=True)
    if observers is not None and observers.url:
        output.print(f"page: {observers.url}", markup=False, soft_wrap=True)


def _follow(session: Session, watch: SessionFigures, told: list[int], output: Console) -> None:
    """Read frames until the loop ends, or until somebody says so."""
    from erclutch.wings.live.orders import Order

    said, answers, warn_at = "", False, time.monotonic() + _PATIENCE

    def look(said: str) -> str:
        watch.poll()
        reason = watch.reader.trip_reason
        if reason not in ("", said):
            output.print(f"fields are held at zero: {reason}", style="red", markup=False, soft_wrap=True)
        return reason

    while session.running and session.rig_running and not told:
        said = look(said)
        if not answers and watch.reader.sensor_seq:
            answers = True
            output.print("the rig answers", markup=False)
        if not answers and time.monotonic() > warn_at:
            warn_at = math.inf
            output.print(_no_sample(session), style="red", markup=False, soft_wrap=True)
        time.sleep(_POLL)
    session.order(Order.STOP)  # told to, or the rig is gone
    session.wait(2.0)
    look(said)


def _no_sample(session: Session) -> str:
    from erclutch.wings.rig.packet import NUMBERS

    device = session.settings.device
    return _NO_SAMPLE.format(device, NUMBERS[device])


def _figures(session: Session, watch: SessionFigures) -> dict[str, Any]:
    """What was seen, for scripts; times in us."""
    from erclutch.wings.live.session_figures import SHARES

    reader = watch.reader
    return {
        "origin": session.origin,
        "frames": watch.frames,
        "missed": reader.missed,
        "lost_by_reader": reader.lost,
        "lateness_us": [*watch.lateness.percentiles(SHARES), watch.lateness.largest],
        "step_us": [*watch.step.percentiles(SHARES), watch.step.largest],
        "events": {name: n for name, n in reader.counts.items() if n},
        "realtime": reader.realtime,
        "tripped": reader.trip_reason,
        **dict(zip(("off_reference_rms", "reference_rms"), watch.followed or (None, None), strict=True)),
    }


def _show(session: Session, watch: SessionFigures, notes: Sequence[str], output: Console) -> None:
    """What was seen, for people."""
    from erclutch.cli import terminal

    seconds = watch.frames * watch.reader.info.period_ns * 1e-9
    title = f"{session.origin}: {watch.frames:,} steps ({seconds:.1f} s), {watch.reader.missed} deadlines missed"
    output.print(terminal.table(title, ["us", "p50", "p99", "p99.9", "largest"], watch.rows()))
    counts = (
        f"{name}: {n:,} ({n / max(watch.frames, 1):.0%} of the steps)" if n > 0.01 * watch.frames else f"{name}: {n}"
        for name, n in watch.reader.counts.items()
        if n and name != "overrun"
    )
    output.print(", ".join(counts) or "no event", markup=False)
    if watch.follower is not None and watch.followed is not None:
        off, wanted = watch.followed
        said = f"{watch.follower.label} off the reference by {off:.3g} rms; the reference has {wanted:.3g}"
        output.print(f"{said} {watch.follower.unit}", markup=False)
        if off > 0.5 * wanted and watch.role == "effort":
            output.print(_ASTRAY, style="yellow", markup=False, soft_wrap=True)
    for note in notes:
        output.print(note, markup=False, soft_wrap=True)


def _ended(
    session: Session,
    watch: SessionFigures,
    observers: Observers | None,
    code: int | None,
    told: bool,
    output: Console | None,
) -> int:
    """Tells what was seen, as JSON without an output; the exit code: 0, or 3 and the reason for another end.

    Raises:
        KeyboardInterrupt: the loop was told to end before the rig answered.
    """
    from erclutch.cli import terminal
    from erclutch.wings.live.ring import State

    if observers is not None:
        observers.record(False)  # so that its note says that the file is whole
    notes = () if observers is None else observers.notes
    answered, reason = watch.reader.sensor_seq > 0, ""
    if code != 0 or watch.reader.state is not State.STOPPED:
        reason = f"the loop ended with code {code}: {session.said() or 'killed'}"
    elif not answered:
        reason = _no_sample(session)
    if told and not answered and code == 0:
        raise KeyboardInterrupt
    ended = 3 if reason else 0
    if output is None:
        print(json_text.dumps({**_figures(session, watch), "notes": notes, "exit": ended}))
    else:
        _show(session, watch, notes, output)
        if watch.reader.trip_reason and session.rig_running:
            output.print(f"held at zero to the end: {watch.reader.trip_reason}", style="red", markup=False)
    if reason:
        terminal.console(stderr=True).print(f"error: {reason}", style="red", soft_wrap=True)
    return ended
