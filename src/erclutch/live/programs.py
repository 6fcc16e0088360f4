"""Programs that a session offers: the paper's experiments and a few tests, made for a rig."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import SettingError
from erclutch.live.settings import REST, Mode, Program, Shape
from erclutch.rig.excitation import field_sequence, field_settings, half_sine_torque, torque_sequence
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
    programs = (REST, *_trackings(rig, motor), *_excitations(rig, motor, seed))
    return (*programs, *_torques(motor)) if model else programs


def _trackings(rig: RigParameters, motor: float) -> tuple[Program, ...]:
    lead = rig.value("screw.lead")
    height = 2.0 * math.pi * _AMPLITUDE / lead

    def tracking(name: str, shape: Shape, share: float, frequency: float, meaning: str) -> Program:
        relative = shape is Shape.SQUARE
        return Program(
            name, Mode.TRACK, shape, height * share, frequency, motor_torque=motor, relative=relative, meaning=meaning
        )

    mm = 1e3 * _AMPLITUDE
    return (
        tracking("tracking-slow", Shape.SINE, 1.0, 0.4, f"PD tracking of {mm:.0f} mm at 0.4 Hz, equation 23"),
        tracking("tracking-fast", Shape.SINE, 0.2, 2.0, f"PD tracking of {0.2 * mm:.0f} mm at 2 Hz"),
        tracking("step", Shape.SQUARE, 0.125, 0.5, f"PD tracking of steps of {0.25 * mm:.0f} mm about where it is"),
    )


def _excitations(rig: RigParameters, motor: float, seed: int) -> tuple[Program, ...]:
    soft = _SOFT * rig.value("screw.half_stroke") * 2.0 * math.pi / rig.value("screw.lead")

    def repeated(name: str, table: Array, soft: float, meaning: str) -> Program:
        return Program(name, Mode.FIELDS, Shape.TABLE, table=table, soft=soft, repeat=True, meaning=meaning)

    sines, squares = _fields(rig, 1.0, motor, seed), _fields(rig, 0.0, None, seed)
    return (
        repeated("sine", sines, soft, "random sines of field at constant motor torque, IV-B"),
        repeated("square", squares, soft, "random squares of field and of motor torque, IV-B"),
        repeated("zero-field", _half_sines(seed), 0.0, "no field, half sines of motor torque, IV-D"),
    )


def _torques(motor: float) -> tuple[Program, ...]:
    def torque(name: str, shape: Shape, meaning: str) -> Program:
        return Program(name, Mode.TORQUE, shape, _TORQUE, 5.0, motor_torque=motor, meaning=meaning)

    return (
        torque("torque-sine", Shape.SINE, f"torque control, {_TORQUE:g} N m at 5 Hz"),
        torque("torque-step", Shape.SQUARE, f"torque control, steps between {_TORQUE:g} and -{_TORQUE:g} N m"),
    )


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
    settings = field_settings(rig, sines=sines)
    rows = 1000 * _SECONDS
    field = field_sequence(rows, rng, settings)
    torque = np.full(rows, motor) if motor is not None else torque_sequence(rows, rng, 0.05, 0.10, settings=settings)
    return np.column_stack([np.maximum(field, 0.0), np.maximum(-field, 0.0), torque])


def _half_sines(seed: int) -> Array:
    rows = 1000 * _SECONDS
    torque = half_sine_torque(rows, np.random.default_rng(seed))
    return np.column_stack([np.zeros((rows, 2)), torque])
