"""Torque control on the TWIN by the loop's own C core: each model with each way to know the torque, over many seeds.

The output shaft is held, as on a test bench. Models are fitted to a log of the same TWIN and never see its parameters.
Numbers of the controller and of the log were tuned on logs and runs of the seeds 1001 to 1008 alone.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cache, partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import SettingError
from erclutch.files import scratch_folder
from erclutch.fit.comparison import Settings, compare
from erclutch.logs.dataset import Dataset, build_dataset, joined
from erclutch.signals.array import Array
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import Recording
from erclutch.signals.speed import Derivative
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.c_build import SOURCES
from erclutch.wings.live.live_model import live_model
from erclutch.wings.live.offered_programs import SOFT, field_table, rig_settings, shaft_angle
from erclutch.wings.live.session import LiveModel
from erclutch.wings.live.settings import LoopProgram, Mode, Waveform
from erclutch.wings.paper.control_errors import (
    AMPLITUDE,
    LOCK,
    SETTLING,
    error_share,
    reaches,
    share_of_range,
    stands_still,
)
from erclutch.wings.paper.sweep_points import Points, make_folder
from erclutch.wings.rig.twin.excitation import FieldSettings, torque_sequence
from erclutch.wings.rig.twin.parameters import RigParameters
from erclutch.wings.rig.twin.twin import LABEL, PERIOD

#: Model of the inverse -> its law or network, and the memory that is fitted with it.
INVERSES: Mapping[str, tuple[str, str]] = {
    "Bingham": ("bingham", "none"),
    "fnn-16": ("fnn-16", "none"),
    "Bingham and fnn-16": ("bingham+fnn-16", "none"),
    "law with memory": ("seo-seo", "rise-fall"),
}
_STAGES: Mapping[str, Any] = {"torque_lead": 1.5e-3, "least_slip": 5.0}
#: What the controller knows of the torque -> its settings.
KNOWS: Mapping[str, Mapping[str, Any]] = {
    "inverse alone": {},
    "stages": {**_STAGES, "observer": "none"},
    "stages, motion": {
        **_STAGES,
        "observer": "motion",
        "observer_bandwidth": 20.0,
        "gain_rate": 0.2,
    },
    "stages, sensor": {
        **_STAGES,
        "observer": "sensor",
        "observer_bandwidth": 30.0,
        "torque_lag": 1e-3,
    },
}
#: What a run is called -> what differs in the TWIN; the models do not know it.
WITHHELD: Mapping[str, tuple[float, float]] = {
    # kelvin that the TWIN is warmer by, and what its yield torque is multiplied by
    "+20 K": (20.0, 1.0),
    "-20 K": (-20.0, 1.0),
    "+20 % yield": (0.0, 1.2),
    "-20 % yield": (0.0, 0.8),
}
_MOTOR = 0.2  # N m, of the motor in a log
_ROWS = 10_000
_LOG_ROWS = 120_000
_FREE_ROWS = 12_000
_PARTS = 4  # of the log, each with a held and a free output, so that each fold of a fit has both
#: N m: the motor turns faster than in any run, so a network knows the speeds of a warm device.
_PUSH = (0.05, 0.4)
_EACH = 500  # rows of one largest field
_FASTEST = 150.0  # Hz
#: Edges of the frequencies in which errors of the chirp are counted, in Hz.
EDGES = np.geomspace(0.1, 10.0, 9)

Figures = Mapping[str, Any]


@dataclass(frozen=True)
class ControlRun:
    """Figures of one model with one controller and one seed.

    Attributes:
        seed, model, knows: which.
        figures: of torque control RMS errors as shares of the reference's range (chirp, steps, random, and `WITHHELD`),
            of the chirp by frequency (bands), what `reaches` finds (bandwidth, within 10 %), and whether the locked
            regime is stable. Of the experiments with a hand see `impedance_figures` and `wall_figures`.
    """

    seed: int
    model: str
    knows: str
    figures: Figures


def kept_runs(
    folder: Path, rig: RigParameters, name: str = "control", asked: Mapping[str, Any] | None = None
) -> Points:
    """Runs that are finished already, of the same TWIN and the same controllers.

    Args:
        folder: where they are kept; it is made.
        rig: parameters of the TWIN.
        name: of the experiment.
        asked: what else its results depend on.

    Raises:
        RunError: the folder cannot be made, or the file not read.
    """
    make_folder(folder)
    # A finished run counts only where all that it depends on is the same, the loop's C too.
    sources = [file.read_bytes() for file in sorted(SOURCES.glob("*.[ch]"))]
    about: dict[str, Any] = {
        "rig": rig.to_dict(),
        "inverses": INVERSES,
        "knows": KNOWS,
        "withheld": WITHHELD,
        "runs": (
            AMPLITUDE,
            _MOTOR,
            _ROWS,
            SETTLING,
            _LOG_ROWS,
            _FREE_ROWS,
            _PARTS,
            *_PUSH,
            _EACH,
            LOCK,
        ),
        "core": hashlib.sha256(b"\0".join(sources)).hexdigest(),
    }
    about |= asked or {}
    return Points(folder / f"{name}.jsonl", about, f"file of {name} runs")


def control_runs(
    seeds: int,
    rig: RigParameters,
    points: Points,
    report: Callable[[float, float | None, str], None],
) -> list[ControlRun]:
    """Torque control by all models with all controllers; see `seeded_runs`.

    Raises:
        SettingError: no seeds.
    """
    return seeded_runs(
        seeds, KNOWS, partial(fitted_models, rig), partial(_figures, rig), points, report
    )


def seeded_runs(
    seeds: int,
    known: Collection[str],
    fit: Callable[[int, Path], Any],
    figures: Callable[[Any, str, str, int], Figures],
    points: Points,
    report: Callable[[float, float | None, str], None],
) -> list[ControlRun]:
    """Each model with each controller on the seeds 0, 1, ...; models are fitted where a run is not finished yet.

    Args:
        seeds: how many.
        known: what the controllers know, of `KNOWS`.
        fit: makes what ``figures`` needs of a seed's models, with a folder for files.
        figures: of that, the model, what the controller knows, and the seed.
        points: where finished runs are kept.
        report: called after each run with (done, total, what).

    Raises:
        SettingError: no seeds.
    """
    if not 1 <= seeds <= 1000:
        raise SettingError(f"--seeds {seeds}", remedy="Give 1 to 1000")
    runs: list[ControlRun] = []
    total = seeds * len(INVERSES) * len(known)
    with scratch_folder() as folder:
        for seed in range(seeds):
            # Fitted once, and only if a run of the seed is not finished.
            fitted = cache(partial(fit, seed, Path(folder)))
            for model, knows in product(INVERSES, known):
                key = f"{seed}, {model}, {knows}"
                made = points.get(
                    key, lambda of=fitted, m=model, k=knows, s=seed: figures(of(), m, k, s)
                )
                runs.append(ControlRun(seed, model, knows, made))
                report(len(runs), total, key)
    return runs


# --- models -----------------------------------------------------------------------------------------------------------


def fitted_models(
    rig: RigParameters, seed: int, folder: Path
) -> tuple[dict[str, LiveModel], dict[str, float]]:
    """The models of a log of the TWIN, ready for the loop, and what the log says of the drive.

    Args:
        rig: parameters of the TWIN.
        seed: of the log.
        folder: for the models' files.
    """
    held = _log(rig, seed, _LOG_ROWS, held=True)
    free = _log(rig, seed, _FREE_ROWS, held=False)
    # In turn, so that each fold of a fit has both.
    parts_held = np.array_split(held, _PARTS)
    parts_free = np.array_split(free, _PARTS)
    stretches: list[Dataset] = []
    for part_held, part_free in zip(parts_held, parts_free, strict=True):
        stretches.append(frames_dataset(part_held))
        stretches.append(frames_dataset(part_free))
    models = fitted_inverses(joined(stretches), f"{seed}", folder)
    return models, drive_numbers(held)


def fitted_inverses(data: Dataset, stem: str, folder: Path) -> dict[str, LiveModel]:
    """The models of `INVERSES` on a log, ready for the loop; their files begin with ``stem``."""
    models: dict[str, LiveModel] = {}
    for name, (specification, lag) in INVERSES.items():
        comparison = compare(data, Settings(models=(specification,), lag=lag))
        best = comparison.entries[0].outcome.model
        file = folder / f"{stem}-{specification}.json"
        file.write_text(json.dumps(best.to_dict()), encoding="utf-8")
        models[name] = live_model(file, data.device)
    return models


def _log(rig: RigParameters, seed: int, rows: int, *, held: bool) -> Any:
    """Frames of random fields and motor torques. A network needs an output that moves at times."""
    rng = np.random.default_rng([seed, held])
    # Fields in the first two columns, the motor's torque in the third.
    table = field_table(
        rig, rows, seed + 10_000 * held, motor=_MOTOR, peakedness=1.0, lowest=0.5, highest=50.0
    )
    table[:, 2] = torque_sequence(rows, rng, *_PUSH, settings=FieldSettings(highest=20.0))
    of_stretches = rng.uniform(0.2, 1.0, rows // _EACH + 1)
    sizes = np.repeat(of_stretches, _EACH)[:rows]
    largest = 0.8 if held else 0.3  # field, as a share
    table[:, :2] *= largest * sizes[:, None]

    soft = 0.0 if held else shaft_angle(rig, SOFT)
    program = LoopProgram("log", Mode.FIELDS, Waveform.TABLE, soft=soft, table=table)
    settings = rig_settings(rig, [program])
    run = AcceleratedRun(settings, None, rig, seed=seed, speed=40.0, locked=held)
    frames, *_ = run.frames(rows)
    return frames


def frames_dataset(frames: Any, device: DeviceName = "coaxial") -> Dataset:
    """Rows of the fields and angles of a period, and of the torque at its end."""
    now = frames[:-1]
    torque = np.ascontiguousarray(frames["torque"][1:])
    field = np.ascontiguousarray(now["field1"])
    if device == "single":
        slip = np.ascontiguousarray(frames["theta_dot"])[:-1]
        signals = {"field": field, "slip": slip, "effort": torque}
        units = {"field": "", "slip": "rad/s", "effort": "N*m"}
    else:
        signals = {
            "E1": field,
            "E2": np.ascontiguousarray(now["field2"]),
            "theta": np.ascontiguousarray(now["theta"]),
            "alpha": np.ascontiguousarray(now["alpha"]),
            "T": torque,
        }
        units = {"E1": "", "E2": "", "theta": "rad", "alpha": "rad", "T": "N*m"}
    rows = len(frames) - 1
    recording = Recording(
        name="log",
        signals=signals,
        units=units,
        time=np.arange(rows, dtype=np.float64) * PERIOD,
        period=PERIOD,
        segments=((0, rows),),
        uniform=True,
        digest="",
        origin=LABEL,
    )
    return build_dataset([recording], device=device, derivative=Derivative("kalman"))


def drive_numbers(frames: Any) -> dict[str, float]:
    """Inertia, dry friction and drag of the drive out of a log with a held output, by least squares.

    Args:
        frames: dtype `erclutch.wings.live.layout.FRAME`, shape (n,).
    """
    window = 50  # rows
    before = 20  # rows ahead of a window, over which the clutch must have been the same one
    side = np.sign(frames["field1"] - frames["field2"])
    kept: list[int] = []
    for start in range(before, len(frames) - window - 1, window):
        sides = side[start - before : start + window]
        if side[start] and np.ptp(sides) == 0:
            kept.append(start)

    def mean(values: Array) -> Array:
        return np.array([values[start : start + window].mean() for start in kept])

    # motor torque - clutch's torque = inertia acceleration + friction + drag speed, with a drag for each clutch
    first = np.array(kept)
    clutch = side[kept]
    theta_dot = frames["theta_dot"]
    speed = mean(theta_dot)  # [rad/s]
    acceleration = (theta_dot[first + window] - theta_dot[first]) / (window * PERIOD)  # [rad/s^2]
    columns: Array = np.column_stack(
        [acceleration, np.ones(len(kept)), speed * (clutch > 0), speed * (clutch < 0)],
    )
    rest: Array = mean(frames["motor_torque"]) - clutch * mean(frames["torque"])  # [N m]
    turning = speed > 20.0
    numbers = np.linalg.lstsq(columns[turning], rest[turning], rcond=None)[0]
    names = ("drive_inertia", "drive_friction", "drive_drag_1", "drive_drag_2")
    return dict(zip(names, numbers.tolist(), strict=True))


# --- runs -------------------------------------------------------------------------------------------------------------


def _chirp(low: float, high: float) -> tuple[Array, Array]:
    """Phase and frequency of a chirp with as much time in each decade; in rad and rad/s."""
    growth = math.log(high / low) / (_ROWS * PERIOD)  # [1/s]
    omega = 2.0 * math.pi * low * np.exp(growth * np.arange(_ROWS) * PERIOD)
    phase = (omega - omega[0]) / growth
    return phase, omega


def _table(torque: Array, rate: Array, motor: float) -> Array:
    """A program of torques: reference in N m, its rate in N m/s, and the motor's torque in N m, shape (n, 3)."""
    return np.column_stack([torque, rate, np.full(torque.size, motor)])


def _sine(phase: Array, omega: Array, motor: float) -> Array:
    """A program of torques along a chirp, see `_table`."""
    torque = AMPLITUDE * np.sin(phase)
    rate = AMPLITUDE * omega * np.cos(phase)
    return _table(torque, rate, motor)


def _figures(
    rig: RigParameters,
    fitted: tuple[dict[str, LiveModel], dict[str, float]],
    model: str,
    knows: str,
    seed: int,
) -> Figures:
    """The figures of a `ControlRun`."""
    models, drive = fitted
    settings = dict(KNOWS[knows])
    if settings.get("observer") == "motion":
        settings |= drive
    rng = np.random.default_rng([seed, 7])
    motor = rng.uniform(0.18, 0.22)  # [N m]
    speed = rng.uniform(50.0, 150.0)  # [rad/s] at the start

    def run(table: Array, on: RigParameters = rig) -> Any:
        program = LoopProgram("torque", Mode.TORQUE, Waveform.TABLE, table=table)
        own = rig_settings(rig, [program], **settings)
        twin = AcceleratedRun(
            own, models[model].library, on, seed=seed + 100, speed=speed, locked=True
        )
        frames, *_ = twin.frames(len(table))
        return frames

    # A slow chirp: errors by frequency.
    slow, slow_omega = _chirp(0.1, 10.0)
    slow_table = _sine(slow, slow_omega, motor)
    chirp = run(slow_table)
    off = chirp["torque"] - chirp["reference"]
    hertz = slow_omega / (2.0 * math.pi)
    band = np.digitize(hertz, EDGES[1:-1])  # of each row
    settled = np.arange(_ROWS) >= SETTLING

    # A fast chirp: how far the torque follows.
    fast, fast_omega = _chirp(0.5, _FASTEST)
    followed = run(_sine(fast, fast_omega, motor))
    bandwidth, within = reaches(followed, fast, fast_omega)

    levels = np.repeat(rng.uniform(-AMPLITUDE, AMPLITUDE, _ROWS // 500), 250)
    steps = run(_table(levels, np.zeros(levels.size), motor))

    # A sum of sines up to 10 Hz with random phases.
    omega = 2.0 * math.pi * rng.uniform(0.1, 10.0, 24)
    first_phase = rng.uniform(0.0, 2.0 * math.pi, omega.size)
    phase = np.outer(np.arange(_ROWS) * PERIOD, omega) + first_phase  # (rows, sines)
    torque = np.sin(phase).sum(axis=1)
    rate = np.cos(phase) @ omega
    scale = AMPLITUDE / float(np.max(np.abs(torque)))
    random = run(_table(scale * torque, scale * rate, motor))

    # Steps that the motor cannot hold: it stalls, and both sides stand.
    beyond = np.where(np.arange(8 * LOCK) // LOCK % 2 == 0, 0.12, -0.12)
    stalled = run(_table(beyond, np.zeros(beyond.size), 0.06))

    figures: dict[str, Any] = {
        "chirp": error_share(chirp),
        "bands": [
            share_of_range(off[(band == number) & settled]) for number in range(EDGES.size - 1)
        ],
        "steps": error_share(steps),
        "random": error_share(random),
        "bandwidth": bandwidth,
        "within 10 %": within,
        "locked": stands_still(stalled),
    }
    for name, (warmer, share) in WITHHELD.items():
        changes = {"thermal.room": warmer}
        for rated in ("clutch.rated_torque_1", "clutch.rated_torque_2"):
            changes[rated] = share * rig.value(rated)
        figures[name] = error_share(run(slow_table, rig.changed(changes)))
    return figures
