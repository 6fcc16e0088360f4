"""A session offers these programs: the paper's experiments and a few tests, made for a rig."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from erclutch.errors import SettingError, did_you_mean
from erclutch.signals.array import Array
from erclutch.signals.device import DeviceName
from erclutch.wings.live.motion_limits import MOTION, motion_limits, stroke_end
from erclutch.wings.live.settings import REST, LoopProgram, LoopSettings, Mode, Waveform
from erclutch.wings.rig.twin.excitation import (
    both_ways_torque,
    field_sequence,
    field_settings,
    half_sine_torque,
    torque_sequence,
)
from erclutch.wings.rig.twin.parameters import RigParameters

#: As on the twin: 20 mm at low frequency, a fifth of it at high (equation 23 saturates beyond).
_AMPLITUDE = 0.02
_SECONDS = 60
_MOTOR = 0.1  # N m
#: Of the largest torque that a pair's model knows. A free output soon turns as fast as the motor, and then no field
#: gives torque: small and quick. A step drives the output further than a sine does. On the TWIN: 20 and 12 mN m.
_SINE, _STEP = 0.144, 0.087
#: Of the same: what a step of the spring asks for, as far as it is no longer than this [rad]. On the TWIN: 0.3 rad.
_PULL, _SPRING = 0.22, 0.3
#: Of a brake's largest torque: what it holds at most. Of that torque: by how much it swings.
_HELD, _SWING = 0.5, 0.2
#: Largest torque in N m that a model of the TWIN's training run knows, for sessions that name no model's.
_OF_TWIN = {"coaxial": 0.139, "single": 0.684}
_WALL = 1.0  # rad
#: Half-waves are mirrored beyond this share of the stroke, so that the table comes back.
SOFT = 0.18


def standard_programs(
    rig: RigParameters,
    *,
    model: bool,
    motor: float = _MOTOR,
    seed: int = 0,
    device: DeviceName = "coaxial",
    drive: bool = True,
    effort: float = 0.0,
    stiffness: float = 0.1,
) -> tuple[LoopProgram, ...]:
    """What can be chosen on the page and with ``--program``.

    Args:
        rig: its screw, limits and excitation.
        model: whether there is a model of a torque: torque control, impedance and wall need its inverse.
        motor: constant motor torque in N m.
        seed: of the random sequences.
        device: a single device has one field, no table to track, and a torque of one sign.
        drive: whether the loop commands a drive of the single device; else its fields alone are excited.
        effort: largest torque that the model knows in N m, so that a program asks for no more; 0: that of the TWIN.
        stiffness: of the impedance in N m/rad.
    """
    effort = effort or _OF_TWIN[device]
    programs = [REST]
    if device == "coaxial":
        programs += _trackings(rig, motor)
    programs += _excitations(rig, motor, seed, device, drive)
    if not model:
        return tuple(programs)

    if device == "single":
        # By motor and brake: a stronger motor runs away.
        held = min(motor, _as_shown(_HELD * effort))
        programs += _torques(held, _SWING * held, _SWING * held, held)
        # The motor is the hand: it pushes into the wall and pulls back by less, so that it comes again.
        rows = 2000
        swing: Array = np.sin(2.0 * math.pi * np.arange(rows) / rows)
        push: Array = held * np.where(swing > 0.0, swing, 0.4 * swing)
        table = np.column_stack([np.full(rows, _WALL), np.zeros(rows), push])
        meaning = f"wall {_WALL:g} rad ahead; the motor pushes with {held:g} N m and pulls with {0.4 * held:g}"
        programs.append(
            LoopProgram(
                "wall",
                Mode.WALL,
                Waveform.TABLE,
                table=table,
                repeat=True,
                relative=True,
                meaning=meaning,
            )
        )
        return tuple(programs)

    programs += _torques(motor, _as_shown(_SINE * effort), _as_shown(_STEP * effort), 0.0)
    spring = _SPRING
    if stiffness > 0.0:
        spring = min(spring, _as_shown(_PULL * effort / stiffness))
    impedance = LoopProgram(
        "impedance",
        Mode.IMPEDANCE,
        Waveform.SQUARE,
        spring,
        0.25,
        motor_torque=motor,
        relative=True,
        meaning=f"spring and damper to a point that steps by {spring:g} rad to either side of where the output is",
    )
    programs.append(impedance)
    return tuple(programs)


def _as_shown(number: float) -> float:
    """A number to two digits."""
    return float(f"{number:.2g}")


def _trackings(rig: RigParameters, motor: float) -> tuple[LoopProgram, ...]:
    """The table follows references (equation 23)."""
    mm = 1e3 * _AMPLITUDE
    lead = rig.value("screw.lead")
    angle = 2.0 * math.pi * _AMPLITUDE / lead  # of the shaft

    def tracking(
        name: str,
        shape: Waveform,
        amplitude: float,
        frequency: float,
        meaning: str,
    ) -> LoopProgram:
        return LoopProgram(
            name,
            Mode.TRACK,
            shape,
            amplitude,
            frequency,
            motor_torque=motor,
            relative=shape is Waveform.SQUARE,
            meaning=f"PD tracking of {meaning}",
        )

    return (
        tracking(
            "tracking-slow", Waveform.SINE, angle * 1.0, 0.4, f"{mm:.0f} mm at 0.4 Hz, equation 23"
        ),
        tracking("tracking-fast", Waveform.SINE, angle * 0.2, 2.0, f"{0.2 * mm:.0f} mm at 2 Hz"),
        tracking(
            "step",
            Waveform.SQUARE,
            angle * 0.125,
            0.5,
            f"steps of {0.25 * mm:.0f} mm about where it is",
        ),
    )


def _excitations(
    rig: RigParameters,
    motor: float,
    seed: int,
    device: DeviceName,
    drive: bool,
) -> tuple[LoopProgram, ...]:
    """Random fields, and no field; what a log is made of."""
    rows = 1000 * _SECONDS
    soft = shaft_angle(rig, SOFT) if device == "coaxial" else 0.0

    def repeated(
        name: str,
        table: Array,
        soft: float,
        meaning: str,
    ) -> LoopProgram:
        return LoopProgram(
            name, Mode.FIELDS, Waveform.TABLE, table=table, soft=soft, repeat=True, meaning=meaning
        )

    sines = field_table(rig, rows, seed, motor=motor, sines=1.0)
    squares = field_table(rig, rows, seed, sines=0.0)
    if device == "single":
        for table in (sines, squares):
            table[:, 0] += table[:, 1]
            table[:, 1] = 0.0
            table[:, 2] = 0.0
            if drive:  # both ways: else it runs away
                table[:, 2] = both_ways_torque(rows, np.random.default_rng(seed))
    if not drive:
        return (
            repeated("sine", sines, 0.0, "random sines of field, IV-B"),
            repeated("square", squares, 0.0, "random squares of field, IV-B"),
        )
    how = "constant" if device == "coaxial" else "random"
    return (
        repeated("sine", sines, soft, f"random sines of field at {how} motor torque, IV-B"),
        repeated("square", squares, soft, "random squares of field and of motor torque, IV-B"),
        repeated(
            "zero-field",
            half_sine_table(rig, rows, seed),
            0.0,
            "no field, half sines of motor torque, IV-D",
        ),
    )


def _torques(
    motor: float,
    sine: float,
    step: float,
    middle: float,
) -> tuple[LoopProgram, ...]:
    """Torques in N m about a middle: a brake gives no torque of the other sign."""
    about = f" about {middle:g} N m" if middle else ""

    def torque(
        name: str,
        shape: Waveform,
        amplitude: float,
        meaning: str,
    ) -> LoopProgram:
        return LoopProgram(
            name,
            Mode.TORQUE,
            shape,
            amplitude,
            5.0,
            middle,
            motor_torque=motor,
            meaning=f"torque control, {meaning}{about}",
        )

    return (
        torque("torque-sine", Waveform.SINE, sine, f"{sine:g} N m at 5 Hz"),
        torque("torque-step", Waveform.SQUARE, step, f"steps between {step:g} and -{step:g} N m"),
    )


def starting_with(programs: Sequence[LoopProgram], name: str) -> tuple[LoopProgram, ...]:
    """The same programs, one of them first: the one that runs at the start.

    Raises:
        SettingError: there is none of that name.
    """
    first = [program for program in programs if program.name == name]
    others = [program for program in programs if program.name != name]
    if not first:
        # "learn" are rounds, which the command plays itself.
        known = [*(program.name for program in programs), "learn"]
        remedy = f"{did_you_mean(name, known)}Choose one of {', '.join(known)}"
        raise SettingError(f"there is no program {name!r}", remedy=remedy)
    return (*first, *others)


def recorded(commands: Array) -> LoopProgram:
    """The commands of a recording again, each with its own row: fields and motor torque, shape (n, 3)."""
    return LoopProgram(
        "recording",
        Mode.FIELDS,
        Waveform.TABLE,
        table=commands,
        by_sample=True,
        meaning="as recorded",
    )


def field_table(
    rig: RigParameters, rows: int, seed: int, *, motor: float | None = None, **changes: float
) -> Array:
    """Random fields of section IV-B and motor torque: E1, E2, N m, shape (rows, 3).

    Args:
        rig: its excitation.
        rows: one a period.
        seed: of the sequences.
        motor: constant motor torque; None: random between 0.05 and 0.1 N m.
        changes: of the excitation, for example the share of sines.
    """
    rng = np.random.default_rng(seed)
    settings = field_settings(rig, **changes)
    field = field_sequence(rows, rng, settings)
    if motor is None:
        torque = torque_sequence(rows, rng, 0.05, 0.10, settings=settings)
    else:
        torque = np.full(rows, motor)
    return np.column_stack([np.maximum(field, 0.0), np.maximum(-field, 0.0), torque])


def half_sine_table(rig: RigParameters, rows: int, seed: int) -> Array:
    """No field, and half sines of motor torque: section IV-D; shape (rows, 3)."""
    torque = half_sine_torque(rows, np.random.default_rng(seed), rig)
    return np.column_stack([np.zeros((rows, 2)), torque])


def shaft_angle(rig: RigParameters, share: float) -> float:
    """A share of the table's stroke to either side, as an angle of the output shaft in rad."""
    return share * stroke_end(rig)


def rig_settings(
    rig: RigParameters, programs: Sequence[LoopProgram], **changes: Any
) -> LoopSettings:
    """Settings with the limits of a rig's supply and drive, and with how its healthy sides can move.

    Args:
        rig: the rig.
        programs: what can be run.
        changes: further settings, or others than the rig's.
    """
    limit = rig.value("supply.command_limit")
    volts = rig.value("supply.voltage_limit") / limit
    own: dict[str, Any] = {
        "field_limit": limit,
        "motor_limit": rig.value("drive.torque_limit"),
        "rise_rate": rig.value("supply.slew_up") / volts,
        "fall_rate": rig.value("supply.slew_down") / volts,
    }
    plain = LoopSettings()
    moves = motion_limits(
        rig,
        changes.get("device", plain.device),
        changes.get("derivative", plain.derivative),
        changes.get("period", plain.period),
    )
    own |= {name: moves[name] for name in MOTION}  # a hand may take the output anywhere
    return LoopSettings(programs=tuple(programs), **{**own, **changes})
