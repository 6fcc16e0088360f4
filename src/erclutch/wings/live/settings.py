"""Settings tell the loop its limits, gains and programs. They are checked here, and again by the loop."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Literal

import numpy as np

from erclutch.errors import SettingError
from erclutch.signals.array import Array
from erclutch.signals.device import DeviceName
from erclutch.signals.speed import Derivative, LiveDerivative, live
from erclutch.wings.live.layout import CONFIG, CONSTANTS, MOST, SETTINGS, sealed

MOST_PROGRAMS = CONSTANTS["ERC_PROGRAMS"]
#: Periods from zero field to the trip.
ZERO_BEFORE_TRIP = CONSTANTS["ERC_ZERO_BEFORE_TRIP"]


class Mode(IntEnum):
    """What a program controls."""

    REST = CONSTANTS["ERC_REST"]
    TRACK = CONSTANTS["ERC_TRACK"]
    TORQUE = CONSTANTS["ERC_TORQUE"]
    FIELDS = CONSTANTS["ERC_FIELDS"]
    IMPEDANCE = CONSTANTS["ERC_IMPEDANCE"]
    WALL = CONSTANTS["ERC_WALL"]

    @property
    def reference(self) -> str:
        """Role of the channel that a program wants to follow its reference; empty where it wants nothing."""
        if self in (Mode.TORQUE, Mode.WALL):
            return "effort"
        return "position" if self in (Mode.TRACK, Mode.IMPEDANCE) else ""


class Waveform(IntEnum):
    """Course of a program's reference."""

    CONSTANT = CONSTANTS["ERC_CONSTANT"]
    SINE = CONSTANTS["ERC_SINE"]
    SQUARE = CONSTANTS["ERC_SQUARE"]
    TABLE = CONSTANTS["ERC_TABLE"]


ObserverName = Literal["off", "none", "sensor", "motion"]
#: As `CONSTANTS` calls them.
_OBSERVERS = {"off": "NO_STAGES", "none": "BY_MODEL", "sensor": "BY_SENSOR", "motion": "BY_MOTION"}
#: What a program may do besides: a switch each.
_SWITCHES = ("repeat", "by_sample", "relative")


def _require(
    owner: object,
    name: str,
    allowed: Callable[[float], bool],
    wanted: str,
    where: str = "",
) -> None:
    """A number of an object has to be finite and allowed."""
    value = getattr(owner, name)
    if not (math.isfinite(value) and allowed(value)):
        raise SettingError(f"{name} is {value}", where=where, remedy=f"Give {wanted}")


@dataclass(frozen=True)
class LoopProgram:
    """A trajectory or predefined sequence, and what is controlled by it.

    Attributes:
        name: what the operator calls it.
        mode: rest (zero field), tracking in rad (equation 23), torque in N m, fields given outright, impedance (spring
            and damper to a reference in rad; a pair), or wall (a brake resists beyond the reference in rad; single).
        shape: constant, sine, square, or a table.
        amplitude, offset: in the unit of the mode.
        frequency: in Hz.
        motor_torque: constant, in N m; a table has its own.
        soft: fields only: half-waves that drive the output further out than this [rad] are mirrored; 0 for none.
        relative: the reference counts from where the output is when the program starts.
        table: rows of (reference, its rate) or (E1, E2), and motor torque, shape (n, 3); one a period.
        repeat: the table starts again at its end; else its last row holds.
        by_sample: row k goes with the rig's sample k + 1, whenever that comes (replay).
        meaning: for people.
    """

    name: str
    mode: Mode
    shape: Waveform = Waveform.CONSTANT
    amplitude: float = 0.0
    frequency: float = 0.0
    offset: float = 0.0
    motor_torque: float = 0.0
    soft: float = 0.0
    relative: bool = False
    table: Array | None = None
    repeat: bool = False
    by_sample: bool = False
    meaning: str = ""

    def __post_init__(self) -> None:
        where = f"program {self.name!r}"
        for name in ("amplitude", "offset", "motor_torque"):
            _require(self, name, lambda value: True, "a finite number", where)
        for name in ("frequency", "soft"):
            _require(self, name, lambda value: value >= 0, "0 or a number above", where)
        if (self.shape is Waveform.TABLE) != (self.table is not None):
            raise SettingError(
                f"program {self.name!r} and its table do not fit",
                remedy="Give a table for shape TABLE",
            )
        if self.table is None:
            return
        rows_of_three = self.table.ndim == 2 and self.table.shape[1] == 3
        if not rows_of_three or not len(self.table):
            problem = f"a table of shape {self.table.shape} in program {self.name!r}"
            raise SettingError(problem, remedy="Give rows of three numbers")


REST = LoopProgram("rest", Mode.REST, meaning="no field, no motor torque")


@dataclass(frozen=True)
class LoopSettings:
    """Everything that the loop's core needs.

    Attributes:
        device: coaxial (E1, E2) or single (E1 alone).
        period: in s.
        derivative: causal filter of the speeds.
        observer: of torque control. off: gains on the estimate. Else in stages (``c/erc_torque.c``), and what the
            device gives beyond its model comes from nothing (none), a torque sensor, or the motion of the drive.
        late_trip: a wake-up so late [s] trips.
        hold, trip: periods in a row without a good sample until the command is reduced, and until it is zero for good;
            it is zero `ZERO_BEFORE_TRIP` periods before that.
        programs: what can be run; the first runs at the start.

    Raises:
        SettingError: a number that cannot be, or programs that are none. `config_of` asks the loop's C for the rest.
    """

    device: DeviceName = "coaxial"
    period: float = 1e-3
    derivative: Derivative | LiveDerivative = field(default_factory=lambda: Derivative("kalman"))
    theta_wrap: float = 0.0
    alpha_wrap: float = 0.0
    theta_glitch: float = 20.0
    alpha_glitch: float = 45.0
    theta_fastest: float = 1000.0
    alpha_fastest: float = 1000.0
    alpha_limit: float = 0.0
    torque_limit: float = 0.0
    torque_rate: float = 0.0
    torque_band: float = 0.0
    torque_still: float = 0.0
    meter_needed: float = 0.0
    load_inertia: float = 0.0
    load_friction: float = 0.0
    load_drag: float = 0.0
    load_band: float = 0.0
    field_limit: float = 0.5
    motor_limit: float = 0.95
    rise_rate: float = 750.0
    fall_rate: float = 625.0
    stroke: float = 0.0
    k_p: float = 0.08
    k_d: float = 2.0e-3
    torque_p: float = 0.0
    torque_i: float = 0.0
    observer: ObserverName = "off"
    torque_lead: float = 0.0
    torque_lag: float = 0.0
    observer_bandwidth: float = 20.0
    integral_rate: float = 0.0
    gain_rate: float = 0.0
    torque_scale: float = 0.01
    least_slip: float = 5.0
    drive_inertia: float = 0.0
    drive_friction: float = 0.0
    drive_drag_1: float = 0.0
    drive_drag_2: float = 0.0
    track_bandwidth: float = 0.0
    track_integral: float = 10.0
    output_inertia: float = 0.0
    output_friction: float = 0.0
    stiffness: float = 0.1
    damping: float = 4.0e-3
    wall_play: float = 0.01
    late_trip: float = 0.020
    hold: int = 5
    trip: int = 21
    programs: Sequence[LoopProgram] = (REST,)

    def __post_init__(self) -> None:
        for name, note in SETTINGS.items():
            value = getattr(self, name)
            if not note.least <= value <= MOST:
                raise SettingError(
                    f"{name} is {value}", remedy=f"Give {note.wanted}: {note.meaning}"
                )
        if not (math.isfinite(self.late_trip) and self.late_trip > 0.0):
            raise SettingError(f"late_trip is {self.late_trip}", remedy="Give a number above 0")
        if not 0.0 < self.period < 1e9:
            raise SettingError(f"period is {self.period}", remedy="Give 0.1 ms to 1 s")
        if not 1 <= len(self.programs) <= MOST_PROGRAMS:
            raise SettingError(
                f"{len(self.programs)} programs", remedy=f"Give 1 to {MOST_PROGRAMS}"
            )
        names = [program.name for program in self.programs]
        if len(set(names)) != len(names):
            raise SettingError(
                f"two programs of one name among {', '.join(names)}",
                remedy="Give each program a name of its own",
            )


def config_of(settings: LoopSettings) -> tuple[bytes, Array]:
    """Settings as the loop reads them.

    Returns:
        The bytes of ``erc_config``, and the rows of all tables one after another, shape (n, 3).

    Raises:
        SettingError: a filter that looks ahead or does not fit the period, or what the loop's C refuses.
        CompilerError: there is no C compiler.
    """
    import ctypes

    from erclutch.wings.live.c_build import loaded_core

    config = np.zeros((), CONFIG)
    config["magic"] = CONSTANTS["ERC_CONFIG_MAGIC"]
    config["version"] = CONSTANTS["ERC_CONFIG_VERSION"]
    config["size"] = CONFIG.itemsize
    config["device"] = CONSTANTS[f"ERC_{settings.device.upper()}"]
    config["period_ns"] = round(settings.period * 1e9)
    config["late_trip_ns"] = round(settings.late_trip * 1e9)
    config["observer"] = CONSTANTS[f"ERC_{_OBSERVERS[settings.observer]}"]
    config["hold_samples"] = settings.hold
    config["trip_samples"] = settings.trip
    config["programs"] = len(settings.programs)
    chosen = settings.derivative
    speed = chosen if isinstance(chosen, LiveDerivative) else live(chosen, settings.period)
    config["filter_g"] = speed.g
    config["filter_h"] = speed.h
    _copy_numbers(settings, config)
    tables: list[Array] = []
    first = 0
    for at, program in zip(config["list"], settings.programs, strict=False):
        at["mode"] = program.mode
        at["shape"] = program.shape
        at["flags"] = sum(
            CONSTANTS[f"ERC_{name.upper()}"] for name in _SWITCHES if getattr(program, name)
        )
        _copy_numbers(program, at)
        if program.table is not None:
            at["first"] = first
            at["rows"] = len(program.table)
            tables.append(program.table)
            first += len(program.table)
    rows = np.ascontiguousarray(np.concatenate(tables) if tables else np.zeros((0, 3)))
    whole = sealed(config)

    # What settings have to be to each other stands in ``c/erc_config.c`` alone.
    library = loaded_core()
    library.erc_config_error.restype = ctypes.c_char_p
    answer: bytes | None = library.erc_config_error(whole, ctypes.c_uint64(len(rows)))
    if answer is not None:
        problem, remedy = answer.decode().split("; ")
        raise SettingError(problem, remedy=remedy)
    return whole, rows


def _copy_numbers(source: object, record: Any) -> None:
    """Each number of an object that a record has under the same name."""
    for name, (kind, *_) in record.dtype.fields.items():
        if kind == np.float64 and hasattr(source, name):
            record[name] = getattr(source, name)


_NUMBERS = "\n".join(
    f"        {name}: {note.meaning}{f' [{note.unit}]' if note.unit else ''}."
    for name, note in SETTINGS.items()
)
LoopSettings.__doc__ = str(LoopSettings.__doc__).replace(
    "\n    Raises:", f"{_NUMBERS}\n\n    Raises:", 1
)
