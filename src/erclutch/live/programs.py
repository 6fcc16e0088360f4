"""Programs that a session offers: the paper's experiments and a few tests, made for a rig."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import SettingError
from erclutch.live.settings import REST, Mode, Program, Shape
from erclutch.rig.excitation import FieldSettings, field_sequence, half_sine_torque, torque_sequence
from erclutch.rig.parameters import RigParameters

Array = NDArray[np.float64]

#: As on the twin: 20 mm at low frequency, a fifth of it at high (equation 23 saturates beyond).
_AMPLITUDE = 0.02
_SECONDS = 60
_MOTOR = 0.1  # N m
#: N m. A free output soon turns as fast as the motor, and then no field gives torque: small and quick.
_TORQUE = 0.02
#: Half-waves are mirrored beyond this share of the stroke, so that the table comes back.
_SOFT = 0.18


def standard_programs(rig: RigParameters, *, model: bool, motor: float = _MOTOR, seed: int = 0) -> tuple[Program, ...]:
    """What can be chosen on the page and with ``--program``.

    Args:
        rig: its screw, limits and excitation.
        model: whether there is a model: torque control needs its inverse.
        motor: constant motor torque in N m.
        seed: of the random sequences.
    """
    turns = 2.0 * math.pi / rig.value("screw.lead")
    height, soft = _AMPLITUDE * turns, _SOFT * rig.value("screw.half_stroke") * turns
    sines, squares = _fields(rig, 1.0, motor, seed), _fields(rig, 0.0, None, seed)
    lead = 1e3 * rig.value("screw.lead") / (2.0 * math.pi)
    programs = [
        REST,
        Program(
            *("tracking-slow", Mode.TRACK, Shape.SINE, height, 0.4),
            motor_torque=motor,
            meaning=f"PD tracking of {lead * height:.0f} mm at 0.4 Hz, equation 23",
        ),
        Program(
            *("tracking-fast", Mode.TRACK, Shape.SINE, height / 5.0, 2.0),
            motor_torque=motor,
            meaning=f"PD tracking of {lead * height / 5:.0f} mm at 2 Hz",
        ),
        Program(
            *("step", Mode.TRACK, Shape.SQUARE, height / 8.0, 0.5),
            motor_torque=motor,
            relative=True,
            meaning=f"PD tracking of steps of {lead * height / 4:.0f} mm about where it is",
        ),
        Program(
            *("sine", Mode.FIELDS, Shape.TABLE),
            table=sines,
            soft=soft,
            repeat=True,
            meaning="random sines of field at constant motor torque, IV-B",
        ),
        Program(
            *("square", Mode.FIELDS, Shape.TABLE),
            table=squares,
            soft=soft,
            repeat=True,
            meaning="random squares of field and of motor torque, IV-B",
        ),
        Program(
            *("zero-field", Mode.FIELDS, Shape.TABLE),
            table=_half_sines(seed),
            repeat=True,
            meaning="no field, half sines of motor torque, IV-D",
        ),
    ]
    if model:
        programs += [
            Program(
                *("torque-sine", Mode.TORQUE, Shape.SINE, _TORQUE, 5.0),
                motor_torque=motor,
                meaning=f"torque control, {_TORQUE:g} N m at 5 Hz",
            ),
            Program(
                *("torque-step", Mode.TORQUE, Shape.SQUARE, _TORQUE, 5.0),
                motor_torque=motor,
                meaning=f"torque control, steps between {_TORQUE:g} and -{_TORQUE:g} N m",
            ),
        ]
    return tuple(programs)


def starting_with(programs: Sequence[Program], name: str) -> tuple[Program, ...]:
    """The same programs, one of them first: the one that runs at the start.

    Raises:
        SettingError: there is none of that name.
    """
    chosen = [p for p in programs if p.name == name]
    if not chosen:
        known = ", ".join(p.name for p in programs)
        raise SettingError(f"there is no program {name!r}", remedy=f"Choose one of {known}")
    return (*chosen, *(p for p in programs if p.name != name))


def recorded(commands: Array) -> Program:
    """The commands of a recording again, each with its own row: fields and motor torque, shape (n, 3)."""
    return Program("recording", Mode.FIELDS, Shape.TABLE, table=commands, by_sample=True, meaning="as recorded")


def _fields(rig: RigParameters, sines: float, motor: float | None, seed: int) -> Array:
    """Random sines or squares of section IV-B: E1, E2, motor torque (None: random between 0.05 and 0.1 N m)."""
    rng = np.random.default_rng(seed)
    own = rig.section("excitation")
    settings = FieldSettings(
        largest=rig.value("supply.command_limit"),
        lowest=own["lowest"],
        highest=own["highest"],
        peakedness=own["peakedness"],
        sines=sines,
        alternating=own["alternating"],
        stretch=own["stretch"],
    )
    rows = 1000 * _SECONDS
    field = field_sequence(rows, rng, settings)
    torque = np.full(rows, motor) if motor is not None else torque_sequence(rows, rng, 0.05, 0.10, settings=settings)
    return np.column_stack([np.maximum(field, 0.0), np.maximum(-field, 0.0), torque])


def _half_sines(seed: int) -> Array:
    rows = 1000 * _SECONDS
    torque = half_sine_torque(rows, np.random.default_rng(seed))
    return np.column_stack([np.zeros((rows, 2)), torque])
