"""Options of ``erclutch live`` in groups; those of every day come first."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from erclutch.cli import quantities
from erclutch.cli.folded_help import folded
from erclutch.cli.quantities import ANGLE, HERTZ, SECONDS, quantity

EVERY_DAY = Group("Every day", sort_key=0)
TORQUE = folded("Torque control", 1.1)
_MOTION = folded("Tracking, impedance, wall", 1.2)
_RIG = folded("The rig", 1.3)
LEARN = folded("Rounds of --program learn", 1.35)
LOOP = folded("Loop, page, recordings", 1.4)
ObserverOption = Literal["off", "none", "sensor", "motion"]


@Parameter(name="*")
@dataclass(frozen=True)
class RigOptions:
    """What is driven."""

    rig: Annotated[str, Parameter(group=EVERY_DAY)] = "twin"
    """What is driven: twin, twin-brake (CH1 alone), replay, udp, or a plug-in's name (entry point erclutch.rigs)."""
    log: Annotated[Path | None, Parameter(group=EVERY_DAY)] = None
    """Recording that --rig replay plays."""
    address: Annotated[str, Parameter(group=_RIG)] = ""
    """HOST:PORT of the rig behind --rig udp."""
    session: Annotated[int, Parameter(group=_RIG)] = 0
    """Number that both sides put into their packets, with --rig udp."""
    rig_file: Annotated[Path | None, Parameter(group=_RIG)] = None
    """A rig file (TOML) with what differs from the default rig: limits of the supply, screw, twin."""
    seed: Annotated[int, Parameter(group=_RIG)] = 0
    """Seed of the twin's noise and of random sequences."""


@Parameter(name="*")
@dataclass(frozen=True)
class ControlOptions:
    """What is done."""

    program: Annotated[str | None, Parameter(group=EVERY_DAY)] = None
    """Program that runs first, such as rest, tracking-slow, torque-step, impedance (a pair), wall (a brake); a wrong
    name lists all. learn plays rounds, each chosen by what a law does not know yet. Default: tracking-slow on the twin,
    rest on hardware, recorded commands in a replay."""
    motor: Annotated[float, quantities.TORQUE, Parameter(group=EVERY_DAY)] = 0.1
    """Constant motor torque of the programs in N m."""
    k_p: Annotated[float, Parameter(group=_MOTION)] = 0.08
    """Tracking gain k_p of equation 23: field per rad."""
    k_d: Annotated[float, Parameter(group=_MOTION)] = 2.0e-3
    """Tracking gain k_d of equation 23: field per rad/s."""
    torque_p: Annotated[float, Parameter(group=TORQUE)] = 0.1
    """Proportional gain of torque control: field per N m of error of the estimate."""
    torque_i: Annotated[float, Parameter(group=TORQUE)] = 20.0
    """Integral gain of torque control: field per N m s."""
    observer: Annotated[ObserverOption | None, Parameter(group=EVERY_DAY)] = None
    """How torque is controlled. off: by --torque-p and --torque-i. The others invert the model and learn what it misses
    from nothing (none), from a torque sensor, or from the motion of the drive, whose inertia and friction stand in
    --rig-file. Default: none where there is a model, else off; off with --adapt, --torque-p or --torque-i."""
    observer_bandwidth: Annotated[float, HERTZ, Parameter(group=TORQUE)] = 20.0
    """Bandwidth of that observer in Hz; above some 60 Hz the TWIN swings."""
    torque_lead: Annotated[float, SECONDS, Parameter(group=TORQUE)] = 1.5e-3
    """Lead of the wanted torque in s: dead time and lag from command to torque, with --observer."""
    track_bandwidth: Annotated[float, HERTZ, Parameter(group=_MOTION)] = 0.0
    """Track by computed torque with this bandwidth in Hz, in place of k_p and k_d; 0: equation 23. It needs --tuned or
    --output-inertia."""
    meter_needed: Annotated[bool | None, Parameter(group=TORQUE)] = None
    """Under programs that do not ask the torque sensor. Default: zero field where its readings cannot be, whatever the
    model says. --meter-needed: also where they disagree with the model. --no-meter-needed: such a program goes on, and
    the event is shown."""
    stiffness: Annotated[float, quantity("N*m/rad"), Parameter(group=_MOTION)] = 0.1
    """Stiffness of the programs impedance (a pair) and wall (a brake) in N m/rad; at most 2 damping / period."""
    damping: Annotated[float, quantity("N*m*s/rad"), Parameter(group=_MOTION)] = 4.0e-3
    """Damping of these programs in N m s/rad. The device's own damping is not counted: the inverse takes it away."""
    output_inertia: Annotated[float | None, quantity("kg*m^2"), Parameter(group=_MOTION)] = None
    """Inertia that the model's torque moves, in kg m², for --track-bandwidth; erclutch tune finds it."""
    output_friction: Annotated[float, quantities.TORQUE, Parameter(group=_MOTION)] = 0.0
    """Dry friction of the output in N m, for --track-bandwidth."""
    tuned: Annotated[Path | None, Parameter(group=TORQUE)] = None
    """Settings that erclutch tune wrote; an option with another value than its default goes before them."""
    field_limit: Annotated[float | None, Parameter(group=_RIG)] = None
    """Largest field, in the unit of the rig. Default: that of the supply (the TWIN's 0.5 is 2000 V)."""
    theta_wrap: Annotated[float, ANGLE, Parameter(group=_RIG)] = 0.0
    """Range of the motor's encoder in rad, if its angle starts again at zero."""
    alpha_wrap: Annotated[float, ANGLE, Parameter(group=_RIG)] = 0.0
    """Range of the output's encoder in rad, if its angle starts again at zero."""
    speed_bandwidth: Annotated[float, HERTZ, Parameter(group=_RIG)] = 150.0
    """Bandwidth of the speed filter (kalman) in Hz."""


@Parameter(name="*")
@dataclass(frozen=True)
class LoopOptions:
    """How the loop runs."""

    seconds: Annotated[float | None, SECONDS, Parameter(group=EVERY_DAY)] = None
    """End after so many seconds. Default: run until Ctrl-C."""
    headless: Annotated[bool, Parameter(group=EVERY_DAY, negative=())] = False
    """Run without the page."""
    record: Annotated[bool, Parameter(group=EVERY_DAY, negative=())] = False
    """Record from the start."""
    folder: Annotated[Path, Parameter(group=LOOP)] = Path("recordings")
    """Where recordings go."""
    port: Annotated[int, Parameter(group=LOOP)] = 0
    """Port of the page; 0: any that is free."""
    priority: Annotated[int, Parameter(group=LOOP)] = 80
    """Real-time priority, 1 to 99; 0: none."""
    cpu: Annotated[int | None, Parameter(group=LOOP)] = None
    """Processor that the loop stays on."""
    json: Annotated[bool, Parameter(group=LOOP, negative=())] = False
    """Print the figures at the end as JSON."""


DEFAULTS = (RigOptions(), ControlOptions(), LoopOptions())
