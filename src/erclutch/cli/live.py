"""``erclutch live``: estimate, control, record and watch at 1 kHz."""

from __future__ import annotations

import json as json_text
import math
import signal
import tempfile
import time
from collections.abc import Generator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter

from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.errors import SettingError

if TYPE_CHECKING:
    from rich.console import Console

    from erclutch.live.observers import Observers
    from erclutch.live.session import LiveModel, Rig, Session
    from erclutch.live.settings import LoopSettings, Program
    from erclutch.live.watch import Watch
    from erclutch.rig.parameters import RigParameters

_RIG = Group("Rig", sort_key=0)
_CONTROL = Group("Control", sort_key=1)
_LOOP = Group("Loop", sort_key=1)
_POLL = 0.05  # s
_PATIENCE = 3.0  # s
_NO_SAMPLE = "no sample came from the rig. Is it on, at this address, with this --session number?"


@Parameter(name="*")
@dataclass(frozen=True)
class RigOptions:
    """What is driven."""

    rig: Annotated[str, Parameter(group=_RIG)] = "twin"
    """twin, replay, udp, or the name of a plug-in (entry point erclutch.rigs)."""
    log: Annotated[Path | None, Parameter(group=_RIG)] = None
    """replay: the recording."""
    address: Annotated[str, Parameter(group=_RIG)] = ""
    """udp: HOST:PORT of the rig."""
    session: Annotated[int, Parameter(group=_RIG)] = 0
    """udp: the number that both sides put into their packets."""
    rig_file: Annotated[Path | None, Parameter(group=_RIG)] = None
    """A rig file (TOML) with what differs from the default rig: limits of the supply, screw, twin."""
    seed: Annotated[int, Parameter(group=_RIG)] = 0
    """Seed of the twin's noise and of random sequences."""


@Parameter(name="*")
@dataclass(frozen=True)
class ControlOptions:
    """What is done."""

    program: Annotated[str | None, Parameter(group=_CONTROL)] = None
    """What runs first; default: tracking-slow on the twin, rest on hardware, the recorded commands in a replay."""
    motor: Annotated[float, Parameter(group=_CONTROL)] = 0.1
    """Constant motor torque of the programs in N m."""
    k_p: Annotated[float, Parameter(group=_CONTROL)] = 0.08
    """Equation 23: field per rad."""
    k_d: Annotated[float, Parameter(group=_CONTROL)] = 2.0e-3
    """Equation 23: field per rad/s."""
    torque_p: Annotated[float, Parameter(group=_CONTROL)] = 0.1
    """Torque control: field per N m of error of the estimate."""
    torque_i: Annotated[float, Parameter(group=_CONTROL)] = 20.0
    """Torque control: field per N m s."""
    field_limit: Annotated[float | None, Parameter(group=_CONTROL)] = None
    """Largest field; default: the supply's (0.5 is 2000 V)."""
    theta_wrap: Annotated[float, Parameter(group=_CONTROL)] = 0.0
    """Range of the motor's encoder in rad, if it starts again at zero."""
    alpha_wrap: Annotated[float, Parameter(group=_CONTROL)] = 0.0
    """Range of the output's encoder in rad."""
    bandwidth: Annotated[float, Parameter(group=_CONTROL)] = 150.0
    """Bandwidth of the speed filter (kalman) in Hz."""


@Parameter(name="*")
@dataclass(frozen=True)
class LoopOptions:
    """How the loop runs."""

    seconds: Annotated[float | None, Parameter(group=_LOOP)] = None
    """End by itself after so long."""
    headless: Annotated[bool, Parameter(group=_LOOP, negative=())] = False
    """No page."""
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
    python_loop: Annotated[bool, Parameter(group=_LOOP, negative=())] = False
    """The loop in Python even if there is a C compiler: soft real time."""
    json: Annotated[bool, Parameter(group=_LOOP, negative=())] = False
    """Print the figures at the end as JSON."""


_DEFAULTS = (RigOptions(), ControlOptions(), LoopOptions())


def live(
    *,
    model: Path | None = None,
    no_model: Annotated[bool, Parameter(negative=())] = False,
    rig: RigOptions = _DEFAULTS[0],
    control: ControlOptions = _DEFAULTS[1],
    loop: LoopOptions = _DEFAULTS[2],
    reading: LogOptions = DEFAULT_READING,
) -> int:
    """Estimate torque, control, record and watch at 1 kHz, on the digital TWIN or on your rig. Ctrl-C: zero field, end.

    Args:
        model: A model's file out of a run's models folder. Default on the twin: fnn-16, fitted to it once.
        no_model: Control and record without an estimate.
        rig: What is driven.
        control: What is done.
        loop: How the loop runs.
        reading: How to read the log of a replay.
    """
    from rich.console import Console

    from erclutch.cli import show
    from erclutch.live.session import Options, Session
    from erclutch.live.watch import Watch

    # With --json standard output is one JSON document: all that is for people goes to standard error.
    output = Console(stderr=True, highlight=False, soft_wrap=True) if loop.json else show.console()
    _checked(loop)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="erclutch-")))
        parameters = _parameters(rig)
        what, program = _rig(rig, reading, folder)
        chosen = None if no_model else _model(model, rig, loop, parameters, reading, output)
        settings = _settings(parameters, control, reading, chosen is not None, program, rig)
        options = Options(loop.seconds, loop.priority, loop.cpu, loop.python_loop, note=settings.programs[0].name)
        told = stack.enter_context(_interrupts())
        session = stack.enter_context(Session(what, settings, chosen, options))
        observers = stack.enter_context(_observers(session, settings, parameters, loop))
        watch = Watch(session.reader())
        _introduce(output, session, observers, chosen)
        _follow(session, watch, told, output)
        code = session.wait(5.0)
        watch.poll()
        if observers is not None:
            observers.record(False)  # so that its note says that the file is whole
        notes = () if observers is None else observers.notes
        if loop.json:
            print(json_text.dumps({**_figures(session, watch), "notes": notes, "exit": code}))
        else:
            _show(session, watch, notes, output)
        return _ended(session, watch, code)


def _checked(loop: LoopOptions) -> None:
    if loop.seconds is not None and not loop.seconds > 0:
        raise SettingError(f"--seconds {loop.seconds:g}", remedy="Give a time above 0 s")
    if not 0 <= loop.priority <= 99:
        raise SettingError(f"--priority {loop.priority}", remedy="Give 1 to 99, or 0 for none")


def _parameters(rig: RigOptions) -> RigParameters:
    from erclutch.rig.parameters import default_rig, load_rig

    return default_rig() if rig.rig_file is None else load_rig(rig.rig_file)


def _rig(rig: RigOptions, reading: LogOptions, folder: Path) -> tuple[Rig, Program | None]:
    """The rig, and the program of a replay."""
    from erclutch.live.session import ServedRig
    from erclutch.rig.plugin import hardware, udp_rig

    if rig.rig == "twin":
        spec: dict[str, Any] = {"kind": "twin", "seed": rig.seed}
        if rig.rig_file is not None:
            spec["rig_file"] = str(rig.rig_file.resolve())
        return ServedRig("twin", "TWIN", spec), None
    if rig.rig == "replay":
        return _replay(rig, reading, folder)
    if rig.rig == "udp":
        return udp_rig(rig.address, rig.session), None
    return hardware(rig.rig), None


def _replay(rig: RigOptions, reading: LogOptions, folder: Path) -> tuple[Rig, Program]:
    import numpy as np

    from erclutch.live.programs import recorded
    from erclutch.live.session import ServedRig
    from erclutch.rig.playback import angles_of, fields_of

    if rig.log is None:
        raise SettingError("a replay without a recording", remedy="Give --log FILE")
    log = reading.read((rig.log,))[0]
    np.save(folder / "angles.npy", angles_of(log))
    spec = {"kind": "replay", "angles": str(folder / "angles.npy"), "period": log.period}
    return ServedRig(log.name, "RECORDING", spec), recorded(fields_of(log))


def _model(
    path: Path | None,
    rig: RigOptions,
    loop: LoopOptions,
    parameters: RigParameters,
    reading: LogOptions,
    output: Console,
) -> LiveModel | None:
    from erclutch.live.model import live_model

    if path is not None:
        device = "single" if rig.rig == "replay" and reading.device == "single" else "coaxial"
        return live_model(path, device, python=loop.python_loop)
    if rig.rig != "twin":
        return None
    from erclutch.cli.twin_model import twin_model

    return live_model(twin_model(parameters, output), "coaxial", python=loop.python_loop)


def _settings(
    parameters: RigParameters,
    control: ControlOptions,
    reading: LogOptions,
    model: bool,
    replay: Program | None,
    rig: RigOptions,
) -> LoopSettings:
    from erclutch.differentiate import Derivative
    from erclutch.live.programs import standard_programs, starting_with
    from erclutch.live.settings import LoopSettings

    programs = standard_programs(parameters, model=model, motor=control.motor, seed=rig.seed)
    first = control.program or ("tracking-slow" if rig.rig == "twin" else "rest")
    programs = (replay,) if replay is not None else starting_with(programs, first)
    limit = parameters.value("supply.command_limit")
    if control.field_limit is not None and not 0 < control.field_limit <= limit:
        raise SettingError(f"--field-limit {control.field_limit:g}", remedy=f"Give at most the supply's {limit:g}")
    volts = parameters.value("supply.voltage_limit") / limit
    turns = 2.0 * math.pi / parameters.value("screw.lead")
    fast = 1e9  # a recording's fields are what they were
    return LoopSettings(
        device=reading.device if replay is not None else "coaxial",
        derivative=Derivative("kalman", control.bandwidth),
        theta_wrap=control.theta_wrap,
        alpha_wrap=control.alpha_wrap,
        field_limit=(control.field_limit or limit) if replay is None else fast,
        motor_limit=parameters.value("drive.torque_limit") if replay is None else fast,
        rise_rate=parameters.value("supply.slew_up") / volts if replay is None else fast,
        fall_rate=parameters.value("supply.slew_down") / volts if replay is None else fast,
        theta_glitch=20.0 if replay is None else 0.0,
        alpha_glitch=45.0 if replay is None else 0.0,
        stroke=0.9 * parameters.value("screw.half_stroke") * turns if replay is None else 0.0,
        k_p=control.k_p,
        k_d=control.k_d,
        torque_p=control.torque_p,
        torque_i=control.torque_i,
        programs=programs,
    )


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
    from erclutch.live.observers import Observers

    with Observers(
        session.ring,
        session.carry_out,
        programs=[(p.name, p.meaning) for p in settings.programs],
        motor_limit=settings.motor_limit,
        folder=loop.folder,
        page=not loop.headless,
        port=loop.port,
        stroke=settings.stroke,
        lead=parameters.value("screw.lead"),
    ) as observers:
        if loop.record:
            observers.record(True)
        yield observers


def _introduce(output: Console, session: Session, observers: Observers | None, model: LiveModel | None) -> None:
    output.print(f"{session.origin}: {session.rig.name}", markup=False)
    output.print(f"model: {f'{model.name} ({model.digest[:12]})' if model else 'none'}", markup=False)
    output.print(f"loop: {session.reader().realtime}", markup=False, soft_wrap=True)
    if observers is not None and observers.url:
        output.print(f"page: {observers.url}", markup=False, soft_wrap=True)


def _follow(session: Session, watch: Watch, told: list[int], output: Console) -> None:
    """Read frames until the loop ends, or until somebody says so."""
    from erclutch.live.orders import Order

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
            output.print(_NO_SAMPLE, style="red", markup=False, soft_wrap=True)
        time.sleep(_POLL)
    session.order(Order.STOP)  # told to, or the rig is gone
    session.wait(2.0)
    look(said)


def _figures(session: Session, watch: Watch) -> dict[str, Any]:
    """What was seen, for scripts; times in us."""
    shares = (0.5, 0.99, 0.999)
    reader = watch.reader
    return {
        "origin": session.origin,
        "frames": watch.frames,
        "missed": watch.missed,
        "lost_by_reader": reader.lost,
        "lateness_us": [*watch.lateness.percentiles(shares), watch.lateness.largest],
        "step_us": [*watch.step.percentiles(shares), watch.step.largest],
        "events": {name: n for name, n in reader.counts.items() if n},
        "realtime": reader.realtime,
        "tripped": reader.trip_reason,
    }


def _show(session: Session, watch: Watch, notes: Sequence[str], output: Console) -> None:
    """What was seen, for people."""
    from erclutch.cli import show

    seconds = watch.frames * watch.reader.info.period_ns * 1e-9
    title = f"{session.origin}: {watch.frames:,} steps ({seconds:.1f} s), {watch.missed} deadlines missed"
    output.print(show.table(title, ["us", "p50", "p99", "p99.9", "largest"], watch.rows()))
    counts = (f"{name}: {n}" for name, n in watch.reader.counts.items() if n)
    output.print(", ".join(counts) or "no event", markup=False)
    for note in notes:
        output.print(note, markup=False, soft_wrap=True)


def _ended(session: Session, watch: Watch, code: int | None) -> int:
    """The exit code: 0, or 3 and the reason if the loop did not end in order."""
    from rich.console import Console

    from erclutch.live.frame import State

    if code == 0 and watch.reader.state is State.STOPPED and watch.reader.sensor_seq > 0:
        return 0
    reason = _NO_SAMPLE if code == 0 else f"the loop ended with code {code}: {session.said() or 'killed'}"
    Console(stderr=True, soft_wrap=True).print(f"error: {reason}", style="red", markup=False)
    return 3
