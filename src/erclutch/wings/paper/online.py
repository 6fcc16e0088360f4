"""The live loop runs sections IV-B to IV-E and V of the paper: what is commanded, for how long, what comes out.

A run is accelerated (the loop's own C core on the twin) or in real time (the loop's process and the twin's). Either way
the online estimate is compared with the offline one, sample for sample.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import SettingError, did_you_mean
from erclutch.export.c.compiled_model import CompiledModel
from erclutch.export.exported_step import LIMITED, OUTSIDE
from erclutch.models.model import Model
from erclutch.signals.array import Array, largest_size
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import elements_of
from erclutch.signals.speed import Derivative, live
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.layout import EVENT_BITS
from erclutch.wings.live.offered_programs import (
    SOFT,
    field_table,
    half_sine_table,
    rig_settings,
    shaft_angle,
)
from erclutch.wings.live.orders import Order
from erclutch.wings.live.session import LiveModel, ServedRig, Session, SessionOptions
from erclutch.wings.live.settings import LoopProgram, Mode, Waveform
from erclutch.wings.rig.twin.excitation import held_peakedness
from erclutch.wings.rig.twin.parameters import RigParameters
from erclutch.wings.rig.twin.twin import PERIOD

_MOTOR = 0.1  # N m
_TRIAL = 20.0  # s: 60 trials are the paper's 20 minutes
_LONGEST = 3600.0
_Programs = Callable[[RigParameters, int, int], list[LoopProgram]]


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
    programs: _Programs
    speed: float = 40.0
    locked: bool = False
    rivals: bool = False
    encoders: bool = False


def _fields(name: str, soft: float = SOFT, **changes: float) -> _Programs:
    """Random fields, mirrored beyond a share of the stroke; 0: never."""

    def programs(rig: RigParameters, rows: int, seed: int) -> list[LoopProgram]:
        table = field_table(rig, rows, seed, **changes)
        limit = shaft_angle(rig, soft) if soft else 0.0
        return [LoopProgram(name, Mode.FIELDS, Waveform.TABLE, soft=limit, table=table)]

    return programs


def _zero_field(rig: RigParameters, rows: int, seed: int) -> list[LoopProgram]:
    table = half_sine_table(rig, rows, seed)
    return [LoopProgram("zero-field", Mode.FIELDS, Waveform.TABLE, table=table)]


def _held(rig: RigParameters, rows: int, seed: int) -> list[LoopProgram]:
    peakedness = held_peakedness(rig)
    return _fields("zero-motion", soft=0.0, peakedness=peakedness)(rig, rows, seed)


def _tracked(*frequencies: float) -> _Programs:
    def program(rig: RigParameters, frequency: float) -> LoopProgram:
        slower = 5.0 if frequency > 1.0 else 1.0
        height = 0.02 * 2.0 * math.pi / rig.value("screw.lead") / slower
        name = f"tracking at {frequency:g} Hz"
        return LoopProgram(name, Mode.TRACK, Waveform.SINE, height, frequency, motor_torque=_MOTOR)

    return lambda rig, rows, seed: [program(rig, frequency) for frequency in frequencies]


_TWO = "PD tracking, 30 trials at 0.4 Hz, 30 at 2 Hz: IV-C, figures 9, 10"
_SINE = _fields("sine", motor=_MOTOR, sines=1.0)
_SQUARE = _fields("square", sines=0.0)
_HALVES = "no field, half sines of motor torque: IV-D, figure 11"

EXPERIMENTS: Mapping[str, Experiment] = {
    e.name: e
    for e in (
        Experiment(
            "sine", "random sines of field, constant motor torque: IV-B, figure 7", 30.0, _SINE
        ),
        Experiment(
            "square", "random squares of field and motor torque: IV-B, figure 8", 30.0, _SQUARE
        ),
        Experiment("tracking", _TWO, 1200.0, _tracked(0.4, 2.0)),
        Experiment("zero-field", _HALVES, 20.0, _zero_field, speed=1.0, rivals=True),
        Experiment(
            "zero-motion",
            "output shaft held: IV-E, figure 12",
            20.0,
            _held,
            locked=True,
            rivals=True,
        ),
        Experiment(
            "encoders",
            "linear and rotary encoder: V, figure 13",
            15.0,
            _tracked(0.4),
            encoders=True,
        ),
    )
}


@dataclass(frozen=True)
class OnlineTrace:
    """One program of an experiment as it ran.

    Attributes:
        name: of the program.
        frames: dtype `erclutch.wings.live.ring.FRAME`, shape (n,).
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
class ErrorLine:
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


def lines(trace: OnlineTrace, rows: slice = slice(None)) -> list[ErrorLine]:
    """Figures of each estimate of a trace."""
    frames = trace.frames[rows]
    # A loop that has tripped or stops controls nothing.
    ended = EVENT_BITS["trip"] | EVENT_BITS["stopping"]
    running = (frames["events"] & ended) == 0
    good = np.isfinite(frames["torque"]) & running
    flagged: NDArray[np.uint32] = frames["flags"][good] & 1
    torque: Array = frames["torque"][good]
    spread = float(torque.std())
    errors: list[ErrorLine] = []
    for model, estimate in trace.estimates.items():
        error: Array = (estimate[rows] - frames["torque"])[good]
        mse = float((error * error).mean())
        rmse = math.sqrt(mse)
        line = ErrorLine(
            model,
            mse=mse,
            rmse=rmse,
            largest=largest_size(error),
            share=rmse / spread,
            outside=float(flagged.mean()),
            rows=int(good.sum()),
        )
        errors.append(line)
    return errors


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
) -> list[OnlineTrace]:
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
    experiment = experiment_of(name)
    length = experiment.seconds if seconds is None else seconds
    if not 1.0 <= length <= _LONGEST:
        raise SettingError(f"a length of {length:g} s", remedy=f"Give 1 to {_LONGEST:g} s")
    if real_time and experiment.encoders:
        raise SettingError(
            f"experiment {name} in real time: a rig's packets carry one encoder's angle, and it compares two",
            remedy="Run it without --real-time",
        )
    rows = round(length / PERIOD)
    programs = experiment.programs(rig, rows, seed)
    each = rows // len(programs)  # rows of a program
    settings = rig_settings(rig, programs)
    start: dict[str, Any] = {"seed": seed, "speed": experiment.speed, "locked": experiment.locked}
    # Of each program: its name, its frames, the other encoder's alpha and the warming; None and nan if not known.
    parts: list[tuple[str, Any, Array | None, float]] = []
    if real_time:
        # One after another on the loop's own process and the TWIN's.
        served = ServedRig("twin", "TWIN", {"kind": "twin", "rig_file": rig_file, **start})
        with Session(served, settings, model, SessionOptions()) as session:
            reader = session.reader()
            for number, program in enumerate(settings.programs):
                if number:
                    session.order(Order.PROGRAM, float(number))
                taken: list[Any] = []
                while sum(map(len, taken)) < each and session.running:
                    time.sleep(0.05)
                    taken.append(reader.read())
                parts.append((program.name, np.concatenate(taken)[:each], None, math.nan))
    else:
        # One after another in one process with the TWIN, as fast as they go.
        twin = AcceleratedRun(settings, model.library, rig, **start)
        for number, program in enumerate(settings.programs):
            if number:
                twin.core.order(Order.PROGRAM, float(number))
            parts.append((program.name, *twin.frames(each), twin.warming))
    return [_traced(*part, model, saved, experiment) for part in parts]


def experiment_of(name: str) -> Experiment:
    """The experiment of a name.

    Raises:
        SettingError: there is none.
    """
    if name not in EXPERIMENTS:
        known = (*EXPERIMENTS, "control", "impedance", "wall", "all")
        remedy = f"{did_you_mean(name, known)}Choose one of {', '.join(known)}"
        raise SettingError(f"there is no experiment {name!r}", remedy=remedy)
    return EXPERIMENTS[name]


def _offline(model: Model, frames: Any, alpha_dot: Array) -> Array:
    """What a model in NumPy makes of a run's frames and a speed of the output, shape (n,)."""
    rows = len(frames)
    time = np.arange(rows, dtype=np.float64) * PERIOD  # [s]
    clock = Clock(time, (Span(0, rows, PERIOD),))
    signals = {
        "E1": np.ascontiguousarray(frames["field1"]),
        "E2": np.ascontiguousarray(frames["field2"]),
        "theta_dot": np.ascontiguousarray(frames["theta_dot"]),
        "alpha_dot": alpha_dot,
    }
    elements = elements_of("coaxial", signals)
    return np.asarray(model.effort(elements, clock), np.float64)


def _traced(
    name: str,
    frames: Any,
    other: Array | None,
    warming: float,
    model: LiveModel,
    saved: Sequence[Model],
    experiment: Experiment,
) -> OnlineTrace:
    """Offline estimates beside the online one."""
    alpha_dot = np.ascontiguousarray(frames["alpha_dot"])
    online = np.ascontiguousarray(frames["estimate"])
    names = ["field1", "field2", "theta_dot", "alpha_dot"]
    if saved[0].band is not None:  # the model of a loop watches its own residual
        names.append("torque")
    inputs = np.column_stack([frames[name] for name in names])
    effort, *_ = CompiledModel(model.library).run(np.ascontiguousarray(inputs))
    again = np.asarray(effort)
    estimates = {saved[0].name: online}
    for rival in saved[1:] if experiment.rivals else ():
        estimates[rival.name] = _offline(rival, frames, alpha_dot)
    compared = None
    # A shaft that is held shows no angle worth comparing.
    if other is not None and experiment.encoders:
        speed = live(Derivative("kalman"), PERIOD)  # the loop's own filter
        other_dot = np.array([speed.step(angle) for angle in other.tolist()])
        compared = other, _offline(saved[0], frames, other_dot)

    known = np.isfinite(online)
    compiled_apart = np.abs(again - online)[known]
    inside = known & (frames["flags"] & (OUTSIDE | LIMITED) == 0)
    numpy_apart = np.abs(_offline(saved[0], frames, alpha_dot) - online)[inside]
    return OnlineTrace(
        name,
        frames,
        estimates,
        other_alpha=compared,
        warming=warming,
        compiled_off=float(np.max(compiled_apart)),
        numpy_off=float(np.max(numpy_apart, initial=0.0)),
    )


def tracking_error(trace: OnlineTrace) -> float:
    """Root mean square of reference less alpha, in rad."""
    error: Array = trace.frames["reference"] - trace.frames["alpha"]
    return math.sqrt(float(np.nanmean(np.square(error))))


def trial(trace: OnlineTrace, number: int) -> slice:
    """Rows of one trial of 20 s, counted from 0; from the end if negative."""
    each = round(_TRIAL / PERIOD)
    count = max(1, len(trace.frames) // each)
    first = (number % count) * each
    return slice(first, min(first + each, len(trace.frames)))
