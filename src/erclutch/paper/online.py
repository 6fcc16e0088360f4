"""Sections IV-B to IV-E and V of the paper as runs of the live loop: what is commanded, for how long, what comes out.

A run is accelerated (the loop's own C core on the twin) or in real time (the loop's process and the twin's). Either way
the online estimate is compared with the offline one, sample for sample.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.device import Element
from erclutch.dynamics import Clock, Span
from erclutch.errors import SettingError
from erclutch.export.compiled import CompiledModel
from erclutch.export.program import LIMITED, OUTSIDE
from erclutch.live.accelerated import AcceleratedRun
from erclutch.live.frame import EVENT_BITS
from erclutch.live.session import LiveModel, Options, ServedRig, Session
from erclutch.live.settings import LoopSettings, Mode, Program, Shape
from erclutch.rig.excitation import field_sequence, field_settings, half_sine_torque, torque_sequence
from erclutch.rig.parameters import RigParameters
from erclutch.rig.twin import PERIOD
from erclutch.saved import Model

Array = NDArray[np.float64]

_MOTOR = 0.1  # N m
_TRIAL = 20.0  # s: 60 trials are the paper's 20 minutes
_SOFT = 0.18  # of the stroke; half-waves beyond are mirrored
_LONGEST = 3600.0


@dataclass(frozen=True)
class Experiment:
    """One experiment.

    Attributes:
        name, meaning: with the paper's section and figure.
        seconds: default length.
        programs: makes what runs, one after another, each with its share of the time.
        speed: initial speed of the motor in rad/s.
        locked: the output shaft is held.
        rivals: other models that are compared with, offline, on the same samples.
        encoders: compare the two encoders.
    """

    name: str
    meaning: str
    seconds: float
    programs: Callable[[RigParameters, int, int], list[Program]]
    speed: float = 40.0
    locked: bool = False
    rivals: bool = False
    encoders: bool = False


def _signed(field: Array, motor: Array) -> Array:
    return np.column_stack([np.maximum(field, 0.0), np.maximum(-field, 0.0), motor])


def _soft(rig: RigParameters) -> float:
    return _SOFT * rig.value("screw.half_stroke") * 2.0 * math.pi / rig.value("screw.lead")


def _sine(rig: RigParameters, rows: int, seed: int) -> list[Program]:
    rng = np.random.default_rng(seed)
    table = _signed(field_sequence(rows, rng, field_settings(rig, sines=1.0)), np.full(rows, _MOTOR))
    return [Program("sine", Mode.FIELDS, Shape.TABLE, soft=_soft(rig), table=table)]


def _square(rig: RigParameters, rows: int, seed: int) -> list[Program]:
    rng, settings = np.random.default_rng(seed), field_settings(rig, sines=0.0)
    field = field_sequence(rows, rng, settings)
    table = _signed(field, torque_sequence(rows, rng, 0.05, 0.10, settings=settings))
    return [Program("square", Mode.FIELDS, Shape.TABLE, soft=_soft(rig), table=table)]


def _held(rig: RigParameters, rows: int, seed: int) -> list[Program]:
    rng, settings = np.random.default_rng(seed), field_settings(rig)
    table = _signed(field_sequence(rows, rng, settings), torque_sequence(rows, rng, 0.05, 0.10, settings=settings))
    return [Program("zero-motion", Mode.FIELDS, Shape.TABLE, table=table)]


def _zero_field(rig: RigParameters, rows: int, seed: int) -> list[Program]:
    table = _signed(np.zeros(rows), half_sine_torque(rows, np.random.default_rng(seed)))
    return [Program("zero-field", Mode.FIELDS, Shape.TABLE, table=table)]


def _tracked(rig: RigParameters, frequency: float) -> Program:
    height = 0.02 * 2.0 * math.pi / rig.value("screw.lead") / (5.0 if frequency > 1.0 else 1.0)
    return Program(f"tracking at {frequency:g} Hz", Mode.TRACK, Shape.SINE, height, frequency, motor_torque=_MOTOR)


def _slow(rig: RigParameters, rows: int, seed: int) -> list[Program]:
    return [_tracked(rig, 0.4)]


def _both(rig: RigParameters, rows: int, seed: int) -> list[Program]:
    return [_tracked(rig, 0.4), _tracked(rig, 2.0)]


EXPERIMENTS: Mapping[str, Experiment] = {
    e.name: e
    for e in (
        Experiment("sine", "random sines of field, constant motor torque: IV-B, figure 7", 30.0, _sine),
        Experiment("square", "random squares of field and motor torque: IV-B, figure 8", 30.0, _square),
        Experiment("tracking", "PD tracking, 30 trials at 0.4 Hz, 30 at 2 Hz: IV-C, figures 9, 10", 1200.0, _both),
        Experiment(
            "zero-field", "no field, half sines of motor torque: IV-D, figure 11", 20.0, _zero_field, 1.0, False, True
        ),
        Experiment("zero-motion", "output shaft held: IV-E, figure 12", 20.0, _held, 40.0, True, True),
        Experiment("encoders", "linear and rotary encoder: V, figure 13", 15.0, _slow, encoders=True),
    )
}


@dataclass(frozen=True)
class Trace:
    """One program of an experiment as it ran.

    Attributes:
        name: of the program.
        frames: dtype `erclutch.live.frame.FRAME`, shape (n,).
        estimates: model -> its estimate in N m, shape (n,); the online one first.
        other_alpha: the other encoder's alpha in rad, and the estimate with it; None where it was not read.
        warming: of the clutches at the end, in K; nan where nobody knows.
        compiled_off: largest difference of the online estimate from the compiled model run offline, in N m.
        numpy_off: and from the model in NumPy, over samples inside the training range with an effort not limited:
            the compiled model holds its inputs to the one and its effort to the other.
    """

    name: str
    frames: Any
    estimates: Mapping[str, Array]
    other_alpha: tuple[Array, Array] | None
    warming: float
    compiled_off: float
    numpy_off: float


@dataclass(frozen=True)
class Line:
    """Figures of an estimate over a trace.

    Attributes:
        model: which one.
        mse: mean squared error in (N m)^2.
        rmse, largest: in N m.
        share: RMSE over the torque's standard deviation.
        outside: share of samples outside the training range.
        rows: samples.
    """

    model: str
    mse: float
    rmse: float
    largest: float
    share: float
    outside: float
    rows: int


def lines(trace: Trace, rows: slice = slice(None)) -> list[Line]:
    """Figures of each estimate of a trace."""
    frames = trace.frames[rows]
    good = np.isfinite(frames["torque"]) & ((frames["events"] & (EVENT_BITS["trip"] | EVENT_BITS["stopping"])) == 0)
    flagged: NDArray[np.uint32] = frames["flags"][good] & 1
    outside = float(flagged.mean())
    torque: Array = frames["torque"][good]
    spread = float(torque.std())
    out: list[Line] = []
    for model, estimate in trace.estimates.items():
        error: Array = (estimate[rows] - frames["torque"])[good]
        mse = float((error * error).mean())
        rmse = math.sqrt(mse)
        out.append(Line(model, mse, rmse, float(np.abs(error).max()), rmse / spread, outside, int(good.sum())))
    return out


def run(
    name: str,
    model: LiveModel,
    saved: Sequence[Model],
    rig: RigParameters,
    *,
    seconds: float | None = None,
    seed: int = 0,
    real_time: bool = False,
    rig_file: str = "",
) -> list[Trace]:
    """Run an experiment.

    Args:
        name: of `EXPERIMENTS`.
        model: what estimates online.
        saved: the same model and its rivals, for the offline estimates; the first is the online one.
        rig: parameters of the twin.
        seconds: length in place of the experiment's own.
        seed: of the commands and the noise.
        real_time: the loop's process and the twin's, in place of both in one as fast as they go.
        rig_file: of the parameters, for the twin's process.

    Raises:
        SettingError: an unknown experiment or a length that cannot be.
    """
    if name not in EXPERIMENTS:
        raise SettingError(f"there is no experiment {name!r}", remedy=f"Choose one of {', '.join(EXPERIMENTS)}")
    experiment = EXPERIMENTS[name]
    length = experiment.seconds if seconds is None else seconds
    if not 1.0 <= length <= _LONGEST:
        raise SettingError(f"{length:g} s", remedy=f"Give 1 to {_LONGEST:g} s")
    if real_time and experiment.encoders:
        raise SettingError(
            f"experiment {name} in real time: a rig's packets carry one encoder's angle, and it compares two",
            remedy="Run it without --real-time",
        )
    rows = round(length / PERIOD)
    programs = experiment.programs(rig, rows, seed)
    if real_time:
        parts = _in_real_time(experiment, programs, model, rig, rows // len(programs), seed, rig_file)
    else:
        parts = _accelerated(experiment, programs, model, rig, rows // len(programs), seed)
    return [_traced(*part, model, saved, experiment) for part in parts]


_Part = tuple[str, Any, Array | None, float]


def _settings(rig: RigParameters, programs: Sequence[Program]) -> LoopSettings:
    limit = rig.value("supply.command_limit")
    volts = rig.value("supply.voltage_limit") / limit
    return LoopSettings(
        field_limit=limit,
        motor_limit=rig.value("drive.torque_limit"),
        rise_rate=rig.value("supply.slew_up") / volts,
        fall_rate=rig.value("supply.slew_down") / volts,
        programs=tuple(programs),
    )


def _accelerated(
    experiment: Experiment, programs: Sequence[Program], model: LiveModel, rig: RigParameters, rows: int, seed: int
) -> list[_Part]:
    from erclutch.live.orders import Order

    run = AcceleratedRun(
        _settings(rig, programs),
        _library(model),
        rig,
        seed=seed,
        speed=experiment.speed,
        locked=experiment.locked,
    )
    parts: list[_Part] = []
    for number, program in enumerate(programs):
        if number:
            run.core.order(Order.PROGRAM, float(number))
        frames, other = run.frames(rows)
        # A shaft that is held shows no angle worth comparing.
        parts.append((program.name, frames, other if experiment.encoders else None, run.warming))
    return parts


def _in_real_time(
    experiment: Experiment,
    programs: Sequence[Program],
    model: LiveModel,
    rig: RigParameters,
    rows: int,
    seed: int,
    rig_file: str,
) -> list[_Part]:
    from erclutch.live.orders import Order

    spec = {"kind": "twin", "seed": seed, "speed": experiment.speed, "locked": experiment.locked, "rig_file": rig_file}
    parts: list[_Part] = []
    with Session(ServedRig("twin", "TWIN", spec), _settings(rig, programs), model, Options()) as session:
        reader = session.reader()
        for number, program in enumerate(programs):
            if number:
                session.order(Order.PROGRAM, float(number))
            taken: list[Any] = []
            while sum(map(len, taken)) < rows and session.running:
                time.sleep(0.05)
                taken.append(reader.read())
            parts.append((program.name, np.concatenate(taken)[:rows], None, math.nan))
    return parts


def _library(model: LiveModel) -> Path:
    if model.library is None:
        raise SettingError(
            "an experiment needs a C compiler", remedy="Install one, or pip install 'erclutch[compiler]'"
        )
    return model.library


def _elements(frames: Any, alpha_dot: Array) -> tuple[Element, Element]:
    theta_dot = frames["theta_dot"]
    return (
        Element(np.ascontiguousarray(frames["field1"]), theta_dot - alpha_dot),
        Element(np.ascontiguousarray(frames["field2"]), -theta_dot - alpha_dot),
    )


def _offline(model: Model, frames: Any, alpha_dot: Array) -> Array:
    clock = Clock(np.arange(len(frames), dtype=np.float64) * PERIOD, (Span(0, len(frames), PERIOD),))
    return np.asarray(model.effort(_elements(frames, alpha_dot), clock), np.float64)


def _traced(
    name: str,
    frames: Any,
    other: Array | None,
    warming: float,
    model: LiveModel,
    saved: Sequence[Model],
    experiment: Experiment,
) -> Trace:
    """Offline estimates beside the online one."""
    alpha_dot = np.ascontiguousarray(frames["alpha_dot"])
    online = np.ascontiguousarray(frames["estimate"])
    inputs = np.column_stack([frames[n] for n in ("field1", "field2", "theta_dot", "alpha_dot")])
    again = np.asarray(CompiledModel(_library(model)).run(np.ascontiguousarray(inputs))[0])
    estimates = {saved[0].name: online}
    for rival in saved[1:] if experiment.rivals else ():
        estimates[rival.name] = _offline(rival, frames, alpha_dot)
    compared = None
    if other is not None:
        speed = _live_speed(other)
        compared = other, _offline(saved[0], frames, speed)
    known = np.isfinite(online)
    off = float(np.max(np.abs(again - online)[known]))
    inside = known & (frames["flags"] & (OUTSIDE | LIMITED) == 0)
    numpy_off = float(np.max(np.abs(_offline(saved[0], frames, alpha_dot) - online)[inside], initial=0.0))
    return Trace(name, frames, estimates, compared, warming, off, numpy_off)


def _live_speed(alpha: Array) -> Array:
    """Speed by the loop's own filter."""
    from erclutch.differentiate import Derivative, live

    speed = live(Derivative("kalman"), PERIOD)
    return np.array([speed.step(x) for x in alpha.tolist()])


def tracking_error(trace: Trace) -> float:
    """Root mean square of reference less alpha, in rad."""
    error: Array = trace.frames["reference"] - trace.frames["alpha"]
    return math.sqrt(float(np.nanmean(np.square(error))))


def trial(trace: Trace, number: int) -> slice:
    """Rows of one trial of 20 s, counted from 0; from the end if negative."""
    each = round(_TRIAL / PERIOD)
    count = max(1, len(trace.frames) // each)
    first = (number % count) * each
    return slice(first, min(first + each, len(trace.frames)))
