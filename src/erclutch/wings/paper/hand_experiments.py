"""Impedance of the pair and the wall of a brake on the TWIN, as a hand feels them, over many seeds.

A hand moves the output of the pair as a sine, whatever torque meets it. On the brake the motor is the hand. Models are
fitted to a log of the same TWIN and never see its parameters. No number here was tuned.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from erclutch.report.plots.plot_description import (
    PAGE,
    Axis,
    Line,
    Panel,
    Plot,
    PlotTable,
    ReferenceLine,
)
from erclutch.signals.array import Array
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.offered_programs import rig_settings, standard_programs, starting_with
from erclutch.wings.live.session import LiveModel
from erclutch.wings.live.settings import LoopProgram, Mode, Waveform
from erclutch.wings.paper.sweep_points import Points
from erclutch.wings.paper.torque_control import (
    INVERSES,
    KNOWS,
    ControlRun,
    fitted_inverses,
    fitted_models,
    frames_dataset,
    kept_runs,
    seeded_runs,
)
from erclutch.wings.rig.twin.parameters import RigParameters
from erclutch.wings.rig.twin.twin import PERIOD

HandName = Literal["impedance", "wall"]
#: What the controller knows of the torque; `KNOWS` has its settings.
KNOWN = ("stages", "stages, sensor")
#: Of the observer while the pair renders an impedance, in Hz. It takes 2 pi x bandwidth x the inertia ahead of the
#: sensor off the damping; with the rotor's inertia that is half of the damping.
_OBSERVER = 8.0
#: Asked of the pair, in N m/rad and N m s/rad, and the frequencies of the hand in Hz.
STIFFNESS, DAMPING = 0.2, 0.004
FREQUENCIES = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0)
#: Stiffnesses of the wall in N m/rad; the damping is what the sampled spring needs, and at least that of the pair.
WALLS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)
_FELT = 5.0  # N m/rad, of the wall from which a hand pulls away
_SINGLE: Mapping[str, Any] = {"device": "single", "theta_glitch": 0.0, "alpha_glitch": 0.0}
_SETTLING, _LOG_ROWS = 2000, 60_000
_TORQUE, _PUSH = 0.06, 0.15  # N m: largest torque of the spring; the hand's push
_SWING = 2000  # rows of a push and a pull
_AHEAD = 0.1  # rad, where the wall stands
_OUT = 0.02  # rad back from the deepest point: the hand comes out
_LOW = 0.04  # N m, of a step
_HIGH = 0.12
_EACH = 100  # rows of a level
_STEPS = 12
_FRICTION = 0.015  # N m, with which the motor keeps its speed on average
_SPEED = 40.0  # rad/s, at which the drag is read
#: Speed in rad/s that a hand may have from the middle of its push on: three of the encoder's counts in 10 ms.
CALM = 0.25


def hand_points(folder: Path, rig: RigParameters, name: HandName) -> Points:
    """Runs that are finished already; see `kept_runs`."""
    numbers = [STIFFNESS, DAMPING, FREQUENCIES, WALLS, _FELT, _PUSH, _OBSERVER, _LOW, _HIGH]
    return kept_runs(folder, rig, name, {"asked": numbers, "known": KNOWN})


def hand_runs(
    name: HandName,
    seeds: int,
    rig: RigParameters,
    points: Points,
    report: Callable[[float, float | None, str], None],
) -> list[ControlRun]:
    """All models with and without a sensor on the seeds 0, 1, ...; see `seeded_runs`.

    Raises:
        SettingError: no seeds.
    """
    figures = {"impedance": impedance_figures, "wall": wall_figures}[name]

    def felt(
        models: Mapping[str, LiveModel],
        model: str,
        knows: str,
        seed: int,
    ) -> dict[str, Any]:
        return figures(rig, models[model], knows, seed)

    return seeded_runs(seeds, KNOWN, partial(_models, name, rig), felt, points, report)


def _models(
    name: HandName,
    rig: RigParameters,
    seed: int,
    folder: Path,
) -> dict[str, LiveModel]:
    """The models of a log of the device of an experiment: the clutch pair, or a brake for the wall."""
    if name == "impedance":
        models, _ = fitted_models(rig, seed, folder)
        return models
    programs = standard_programs(rig, model=False, seed=seed, device="single")
    settings = rig_settings(rig, starting_with(programs, "sine"), **_SINGLE)
    run = AcceleratedRun(settings, None, rig, seed=seed, locked=True, single=True)
    frames, *_ = run.frames(_LOG_ROWS)
    return fitted_inverses(frames_dataset(frames, "single"), f"{seed}", folder)


# --- impedance --------------------------------------------------------------------------------------------------------


def impedance_figures(
    rig: RigParameters,
    model: LiveModel,
    knows: str,
    seed: int,
) -> dict[str, Any]:
    """Stiffness in N m/rad and damping in N m s/rad that a hand feels at each of `FREQUENCIES`."""
    program = LoopProgram("spring", Mode.IMPEDANCE, motor_torque=0.2)
    stages = {**KNOWS[knows], "observer_bandwidth": _OBSERVER}
    settings = rig_settings(rig, [program], **stages, stiffness=STIFFNESS, damping=DAMPING)
    felt: list[complex] = []  # torque over angle [N m/rad], one a frequency
    for frequency in FREQUENCIES:
        omega = 2.0 * math.pi * frequency
        cycles = max(10.0, 2.0 * frequency)
        rows = round(cycles / frequency / PERIOD)
        # The hand moves so far that the spring's torque is the same at each frequency, but no more than 0.5 rad.
        asked = STIFFNESS + 1j * omega * DAMPING
        amplitude = min(0.5, _TORQUE / abs(asked))  # [rad]
        time: Array = PERIOD * np.arange(_SETTLING + rows, dtype=np.float64)
        hand: Array = amplitude * omega * np.cos(omega * time)  # [rad/s]
        run = AcceleratedRun(
            settings,
            model.library,
            rig,
            seed=seed + 100,
            speed=80.0,
            hand=hand,
        )
        frames, *_ = run.frames(time.size)

        # Torque and angle at the hand's frequency, as complex amplitudes.
        settled: Array = time[_SETTLING:]
        turning: NDArray[np.complex128] = np.exp(-1j * omega * settled)
        torque: Array = frames["torque"][_SETTLING:]
        angle: Array = amplitude * np.sin(omega * settled)
        drive = np.mean(torque * turning)
        swing = np.mean(angle * turning)
        felt.append(complex(-drive / swing))
    stiffness = np.real(felt)
    damping = np.imag(felt) / (2.0 * math.pi * np.array(FREQUENCIES))
    return {"stiffness": stiffness.tolist(), "damping": damping.tolist()}


def describe_impedance(runs: Sequence[ControlRun]) -> Plot:
    """Stiffness and damping by frequency over what was asked: means over the seeds."""
    frequency: Array = np.array(FREQUENCIES)
    panels: list[Panel] = []
    columns = {"frequency": frequency}
    # Above 10 Hz the damper's torque hides the spring's.
    for quantity, asked, highest in (("stiffness", STIFFNESS, 10.0), ("damping", DAMPING, 40.0)):
        shown = frequency <= highest
        x = Axis("frequency", "Hz", log=True)
        y = Axis(f"{quantity} felt over asked", low=0.0, high=1.5)
        for knows in KNOWN:
            marks: list[Line | ReferenceLine] = [ReferenceLine(1.0)]
            for number, model in enumerate(INVERSES):
                share = _mean(runs, model, knows, quantity) / asked
                line = Line(frequency[shown], share[shown], f"series{number}", model, marked=True)
                marks.append(line)
                columns[f"{quantity} over asked, {model}, {knows}"] = share
            panels.append(Panel(x, y, marks, title=knows))
    numbers = np.column_stack(list(columns.values()))
    return Plot(
        panels,
        PlotTable(list(columns), numbers.tolist()),
        height=4.4,
        width=PAGE,
        columns=2,
        badge="TWIN",
        legend="shared",
    )


def _mean(
    runs: Sequence[ControlRun],
    model: str,
    knows: str,
    figure: str,
) -> Array:
    """The mean over the seeds of a figure that has several values, shape (values,)."""
    of_seeds: list[list[float]] = []
    for run in runs:
        if run.model == model and run.knows == knows:
            of_seeds.append(run.figures[figure])
    return np.mean(np.array(of_seeds, np.float64), axis=0)


# --- wall -------------------------------------------------------------------------------------------------------------


def wall_figures(
    rig: RigParameters,
    model: LiveModel,
    knows: str,
    seed: int,
) -> dict[str, Any]:
    """Step of the torque, drag, and the wall as a hand meets it.

    Returns:
        rise in s (10 to 90 %), overshoot as a share of the step, drag in N m with zero asked at 40 rad/s, the slowest
        speed of the steps in rad/s; how deep the hand comes in rad by `WALLS` (deepest), the standard deviation of its
        speed in rad/s from the middle of its push on (swing), and by which torque in N m it pulls when it comes out.
    """
    figures: dict[str, Any] = _steps(rig, model, knows, seed)
    # A hand pushes into a wall ahead, and pulls back: a sine of torque.
    hand: Array = _PUSH * np.sin(2.0 * math.pi * np.arange(_SWING) / _SWING)
    ahead = np.full(_SWING, _AHEAD)
    table = np.column_stack([ahead, np.zeros(_SWING), hand])
    program = LoopProgram("wall", Mode.WALL, Waveform.TABLE, table=table, relative=True)
    half = _SWING // 2  # rows of the push, and rows of the pull
    depths: list[float] = []  # [rad], one a wall
    swings: list[float] = []  # [rad/s], one a wall
    for stiffness in WALLS:
        settings = rig_settings(
            rig,
            [program],
            **_SINGLE,
            **KNOWS[knows],
            stiffness=stiffness,
            damping=max(DAMPING, 0.5 * PERIOD * stiffness),
        )
        twin = AcceleratedRun(
            settings,
            model.library,
            rig,
            seed=seed + 100,
            locked=True,
            single=True,
        )
        frames, _ = twin.frames(_SWING)
        push = frames[:half]
        pull = frames[half:_SWING]
        wall = float(frames["theta"][0]) + _AHEAD
        deepest = np.max(push["theta"])
        depths.append(float(deepest) - wall)
        later = push["theta_dot"][half // 2 :]
        swings.append(float(np.std(later)))
        if stiffness == _FELT:
            out = pull["theta"] < deepest - _OUT
            first_out = np.argmax(out)
            figures["pull"] = float(-pull["motor_torque"][first_out]) if out.any() else math.nan
    return {**figures, "deepest": depths, "swing": swings}


def _steps(
    rig: RigParameters,
    model: LiveModel,
    knows: str,
    seed: int,
) -> dict[str, float]:
    """Torque of a turning brake: steps up and down, and zero asked for while the motor runs up."""

    def run(wanted: Array, motor: float, speed: float) -> Any:
        rate = np.zeros(wanted.size)
        table = np.column_stack([wanted, rate, np.full(wanted.size, motor)])
        program = LoopProgram("steps", Mode.TORQUE, Waveform.TABLE, table=table)
        settings = rig_settings(rig, [program], **_SINGLE, **KNOWS[knows])
        twin = AcceleratedRun(
            settings,
            model.library,
            rig,
            seed=seed + 100,
            speed=speed,
            locked=True,
            single=True,
        )
        frames, *_ = twin.frames(wanted.size)
        return frames

    levels = np.repeat([_LOW, _HIGH], _EACH)
    wanted = np.tile(levels, _STEPS)
    mean_torque = 0.5 * (_LOW + _HIGH)
    frames = run(wanted, mean_torque + _FRICTION, 2.0 * _SPEED)
    steps = frames["torque"].reshape(_STEPS, 2 * _EACH)
    mean_step: Array = steps[2:].mean(axis=0)  # without the first two, (rows of both levels,)
    before = float(mean_step[_EACH // 2 : _EACH - 1].mean())
    after = float(mean_step[3 * _EACH // 2 :].mean())
    share: Array = (mean_step[_EACH:] - before) / (after - before)
    # The rising part alone, made to rise only, for `interp` asks for that.
    end = int(np.argmax(share >= 0.9)) + 1
    risen = np.maximum.accumulate(share[:end])
    rows = np.arange(end, dtype=np.float64)
    start_of_rise = np.interp(0.1, risen, rows)
    end_of_rise = np.interp(0.9, risen, rows)
    rise = float(end_of_rise - start_of_rise)  # rows

    running_up = run(np.zeros(_SETTLING), 3.0 * _FRICTION, 0.0)
    near_speed = np.abs(running_up["theta_dot"] - _SPEED) < 0.1 * _SPEED
    drag: Array = running_up["torque"][near_speed]
    after_two_levels = frames["theta_dot"][2 * _EACH :]
    return {
        "rise": PERIOD * rise,
        "overshoot": max(0.0, float(share.max()) - 1.0),
        "drag": float(np.mean(drag)),
        "slowest": float(after_two_levels.min()),
    }


def describe_wall(runs: Sequence[ControlRun]) -> Plot:
    """How deep a hand comes, over what its push takes of the spring: means over the seeds."""
    stiffness: Array = np.array(WALLS)
    lines: list[Line] = []
    columns = {"stiffness": stiffness}
    for number, model in enumerate(INVERSES):
        deepest = 1e3 * _mean(runs, model, "stages, sensor", "deepest")  # [mrad]
        lines.append(Line(stiffness, deepest, f"series{number}", model, marked=True))
        columns[f"deepest, {model}"] = deepest
    of_the_spring: Array = 1e3 * _PUSH / stiffness  # [mrad]
    lines.append(Line(stiffness, of_the_spring, "ref", "push over stiffness", dashed=True))
    columns["push over stiffness"] = of_the_spring
    x = Axis("stiffness", "N m/rad", log=True)
    y = Axis("deepest", "mrad", log=True)
    numbers = np.column_stack(list(columns.values()))
    return Plot(
        [Panel(x, y, lines)],
        PlotTable(list(columns), numbers.tolist()),
        height=2.8,
        badge="TWIN",
        legend="above",
    )
