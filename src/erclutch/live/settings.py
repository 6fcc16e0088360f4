"""What the loop is to do: limits, gains, programs; checked here, written as bytes, checked again by the loop.

The layout is ``erc_config`` in ``c/erc_layout.h``.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.device import DeviceName
from erclutch.differentiate import Derivative, LiveDerivative, live
from erclutch.errors import SettingError

Array = NDArray[np.float64]

MOST_PROGRAMS = 32
#: Periods from zero field to the trip; ``ERC_ZERO_BEFORE_TRIP``.
ZERO_BEFORE_TRIP = 7
_MAGIC, _VERSION = 0x47435245, 1


class Mode(IntEnum):
    """What a program controls."""

    REST = 0
    TRACK = 1
    TORQUE = 2
    FIELDS = 3


class Shape(IntEnum):
    """Course of a program's reference."""

    CONSTANT = 0
    SINE = 1
    SQUARE = 2
    TABLE = 3


_REPEAT, _BY_SAMPLE, _RELATIVE = 1, 2, 4


def _require(owner: object, name: str, allowed: Callable[[float], bool], wanted: str, where: str = "") -> None:
    """A number of an object has to be finite and allowed."""
    value = getattr(owner, name)
    if not (math.isfinite(value) and allowed(value)):
        raise SettingError(f"{name} is {value}", where=where, remedy=f"Give {wanted}")


@dataclass(frozen=True)
class Program:
    """A trajectory or predefined sequence, and what is controlled by it.

    Attributes:
        name: what the operator calls it.
        mode: rest (zero field), tracking in rad (equation 23), torque in N m, or fields given outright.
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
    shape: Shape = Shape.CONSTANT
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
        if (self.shape is Shape.TABLE) != (self.table is not None):
            raise SettingError(f"program {self.name!r} and its table do not fit", remedy="Give a table for shape TABLE")
        if self.table is not None and (self.table.ndim != 2 or self.table.shape[1] != 3 or not len(self.table)):
            raise SettingError(
                f"a table of shape {self.table.shape} in program {self.name!r}", remedy="Give rows of three numbers"
            )


REST = Program("rest", Mode.REST, meaning="no field, no motor torque")


@dataclass(frozen=True)
class LoopSettings:
    """Everything that the loop's core needs.

    Attributes:
        device: coaxial (E1, E2) or single (E1 alone).
        period: in s.
        derivative: causal filter of the speeds.
        theta_wrap, alpha_wrap: range of an encoder that starts again at zero, in rad; 0 for none.
        theta_glitch, alpha_glitch: a reading further than this from the predicted speed [rad/s] is rejected; 0: none.
        field_limit: largest field. motor_limit: largest motor torque in N m.
        rise_rate, fall_rate: of the field in 1/s, as the supply allows.
        stroke: fields that drive the output further out than this [rad] are refused; 0 for none.
        k_p, k_d: gains of equation (23), field per rad and per rad/s.
        torque_p, torque_i: torque control: field per N m and per N m s, on the estimate.
        late_trip: a wake-up so late [s] trips.
        hold, trip: periods in a row without a good sample until the command is reduced, and until it is zero for good;
            it is zero `ZERO_BEFORE_TRIP` periods before that.
        programs: what can be run; the first runs at the start.
    """

    device: DeviceName = "coaxial"
    period: float = 1e-3
    derivative: Derivative | LiveDerivative = field(default_factory=lambda: Derivative("kalman"))
    theta_wrap: float = 0.0
    alpha_wrap: float = 0.0
    theta_glitch: float = 20.0
    alpha_glitch: float = 45.0
    field_limit: float = 0.5
    motor_limit: float = 0.95
    rise_rate: float = 750.0
    fall_rate: float = 625.0
    stroke: float = 0.0
    k_p: float = 0.08
    k_d: float = 2.0e-3
    torque_p: float = 0.0
    torque_i: float = 0.0
    late_trip: float = 0.020
    hold: int = 5
    trip: int = 21
    programs: Sequence[Program] = (REST,)

    def __post_init__(self) -> None:
        for name in ("period", "field_limit", "motor_limit", "rise_rate", "fall_rate", "late_trip"):
            _require(self, name, lambda value: value > 0, "a number above 0")
        for name in ("theta_wrap", "alpha_wrap", "theta_glitch", "alpha_glitch", "stroke"):
            _require(self, name, lambda value: value >= 0, "0 for none, or a number above 0")
        for name in ("k_p", "k_d", "torque_p", "torque_i"):
            _require(self, name, lambda value: True, "a finite number")
        if not (0 <= self.hold < self.trip - ZERO_BEFORE_TRIP and self.trip <= 21):
            raise SettingError(
                f"hold {self.hold} and trip {self.trip} samples",
                remedy=f"Give 0 <= hold < trip - {ZERO_BEFORE_TRIP} and trip <= 21",
            )
        if not 1e-4 <= self.period <= 1:
            raise SettingError(f"a period of {self.period} s", remedy="Give 0.1 ms to 1 s")
        if not 1 <= len(self.programs) <= MOST_PROGRAMS:
            raise SettingError(f"{len(self.programs)} programs", remedy=f"Give 1 to {MOST_PROGRAMS}")
        names = [program.name for program in self.programs]
        if len(set(names)) != len(names):
            raise SettingError(f"two programs of one name among {', '.join(names)}", remedy="Give each its own")


PROGRAM = np.dtype(
    [
        ("mode", "<u4"),
        ("shape", "<u4"),
        ("flags", "<u4"),
        ("unused", "<u4"),
        *((name, "<f8") for name in ("amplitude", "frequency", "offset", "motor_torque", "soft")),
        ("first", "<u8"),
        ("rows", "<u8"),
    ]
)
_NUMBERS = (
    *("theta_wrap", "alpha_wrap", "filter_g", "filter_h", "theta_glitch", "alpha_glitch"),
    *("field_limit", "motor_limit", "rise_rate", "fall_rate", "stroke", "k_p", "k_d", "torque_p", "torque_i"),
)
CONFIG = np.dtype(
    [
        ("magic", "<u4"),
        ("version", "<u4"),
        ("size", "<u4"),
        ("device", "<u4"),
        ("period_ns", "<u8"),
        *((name, "<f8") for name in _NUMBERS),
        ("late_trip_ns", "<u8"),
        ("hold_samples", "<u4"),
        ("trip_samples", "<u4"),
        ("programs", "<u4"),
        ("program", "<u4"),
        ("list", PROGRAM, (MOST_PROGRAMS,)),
        ("unused", "<u4"),
        ("crc", "<u4"),
    ]
)


def config_of(settings: LoopSettings) -> tuple[bytes, Array]:
    """Settings as the loop reads them.

    Returns:
        The bytes of ``erc_config``, and the rows of all tables one after another, shape (n, 3).

    Raises:
        SettingError: a filter that looks ahead, or does not fit the period.
    """
    config = np.zeros((), CONFIG)
    config["magic"], config["version"], config["size"] = _MAGIC, _VERSION, CONFIG.itemsize
    config["device"] = 0 if settings.device == "coaxial" else 1
    config["period_ns"] = round(settings.period * 1e9)
    speed = speed_filter(settings)
    given: dict[str, Any] = {"filter_g": speed.g, "filter_h": speed.h}
    for name in _NUMBERS:
        config[name] = given.get(name, getattr(settings, name, 0.0))
    config["late_trip_ns"] = round(settings.late_trip * 1e9)
    config["hold_samples"], config["trip_samples"] = settings.hold, settings.trip
    config["programs"] = len(settings.programs)
    tables: list[Array] = []
    first = 0
    for at, program in zip(config["list"], settings.programs, strict=False):
        at["mode"], at["shape"] = program.mode, program.shape
        at["flags"] = _REPEAT * program.repeat | _BY_SAMPLE * program.by_sample | _RELATIVE * program.relative
        for name in ("amplitude", "frequency", "offset", "motor_torque", "soft"):
            at[name] = getattr(program, name)
        if program.table is not None:
            at["first"], at["rows"] = first, len(program.table)
            tables.append(program.table)
            first += len(program.table)
    config["crc"] = zlib.crc32(config.tobytes()[:-4])
    return config.tobytes(), np.ascontiguousarray(np.concatenate(tables) if tables else np.zeros((0, 3)))


def speed_filter(settings: LoopSettings) -> LiveDerivative:
    """Gains of the causal filter.

    Raises:
        SettingError: a filter that looks ahead, or does not fit the period.
    """
    chosen = settings.derivative
    return chosen if isinstance(chosen, LiveDerivative) else live(chosen, settings.period)


def settings_of(data: bytes, table: Array) -> LoopSettings:
    """The settings that `config_of` wrote, for the loop in Python; programs are named by their numbers.

    Raises:
        SettingError: not a configuration of this version, or damaged.
    """
    if len(data) != CONFIG.itemsize or zlib.crc32(data[:-4]) != int.from_bytes(data[-4:], "little"):
        raise SettingError("no configuration of the loop, or a damaged one", remedy="Start the session again")
    c = np.frombuffer(data, CONFIG)[0]
    if (int(c["magic"]), int(c["version"])) != (_MAGIC, _VERSION):
        raise SettingError("a configuration of another version", remedy="Start the session again")
    programs: list[Program] = []
    for i, at in enumerate(c["list"][: int(c["programs"])]):
        first, rows, flags = int(at["first"]), int(at["rows"]), int(at["flags"])
        programs.append(
            Program(
                str(i),
                Mode(int(at["mode"])),
                Shape(int(at["shape"])),
                *(float(at[n]) for n in ("amplitude", "frequency", "offset", "motor_torque", "soft")),
                table=table[first : first + rows] if rows else None,
                repeat=bool(flags & _REPEAT),
                by_sample=bool(flags & _BY_SAMPLE),
                relative=bool(flags & _RELATIVE),
            )
        )
    numbers = {name: float(c[name]) for name in _NUMBERS if not name.startswith("filter_")}
    return LoopSettings(
        device="coaxial" if int(c["device"]) == 0 else "single",
        period=1e-9 * int(c["period_ns"]),
        derivative=LiveDerivative(1e-9 * int(c["period_ns"]), float(c["filter_g"]), float(c["filter_h"])),
        **numbers,
        late_trip=1e-9 * int(c["late_trip_ns"]),
        hold=int(c["hold_samples"]),
        trip=int(c["trip_samples"]),
        programs=tuple(programs),
    )
