"""A fault in a sensor of the loop, under a control, beside the same loop in health. TWIN.

The C core of the loop controls the TWIN step by step. From a random moment on one sensor is wrong for good. Until the
fault both loops are the same to the bit. `studies/sensor_faults.py` prints the table.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.device import DeviceName
from erclutch.wings.live.c_core import Core
from erclutch.wings.live.layout import EVENT_BITS, FRAME, SAMPLE
from erclutch.wings.live.live_model import live_model
from erclutch.wings.live.motion_limits import alpha_count, theta_count
from erclutch.wings.live.offered_programs import rig_settings, shaft_angle, standard_programs
from erclutch.wings.live.sensor_limits import free_drive, free_output, sensor_limits
from erclutch.wings.live.session import LiveModel
from erclutch.wings.live.settings import LoopProgram, LoopSettings
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig
from erclutch.wings.rig.twin.twin import Twin

ROWS = 2500
#: Rows in which a fault begins: drive and output are on their way.
BEGINS = (600, 1600)
#: Above the healthy field by more than this share, and this field (1 % of the TWIN's limit).
ABOVE, LEAST = 0.1, 0.005
#: Rows by which the healthy loop may be earlier or later.
NEAR = 2
#: Rows with a field that is too high, and rows until it is zero.
MOST_ABOVE, ZERO_WITHIN = 5, 20
LATE = 30  # rows
#: Of the check of the momentum (c/erc_plausible.c): times its sliding friction that an output at rest withstands, and
#: the share of the torque by which the inertia may be off.
REST_FRICTION, OFF_SHARE = 1.2, 0.35
#: Never too high and zero in time; never too high; higher than in health, but within what nothing tells from health: a
#: tenth above the field of the same loop without its meter, or a torque that passes the
#: check of the momentum while the output rests; too high.
OUTCOMES = ("held", "safe", "bounded", "not held")
NOT_HELD = OUTCOMES[-1]
#: What leaves nothing to tell of a fault in time, told by the rows themselves.
CAUSES = {
    "not asked": "control asks no meter: the field has the bits of health",
    "same bits": "the sensor reads as in health, to the bit",
    "a count": "the encoder reads as in health but for a count or two",
    "friction": "the meter is off by no more than dry friction withstands or varies",
    "noise": "the same, and with other noise of its meter the healthy loop is as high",
}
#: Rows from the first doubt of the momentum to zero field, and the share by which its filter moves in a row.
FALLS, MOVES = 6, 0.13
NOISES = (101, 102, 103)  # seeds
COUNTS = 2.0
SLOW = 1.0  # rad/s: a third of the speed up to which dry friction is elastic
HEALTHY = tuple(range(101, 121))  # seeds of the noise of healthy loops whose readings make a band
_DOUBTS = ("theta-doubted", "alpha-doubted", "torque-doubted")

#: Control -> device, program, and settings that differ.
CONTROLS: Mapping[str, tuple[DeviceName, str, Mapping[str, Any]]] = {
    "equation 23": ("coaxial", "tracking-fast", {}),
    "equation 23, meter needed": ("coaxial", "tracking-fast", {"meter_needed": 2.0}),
    "torque": ("coaxial", "torque-sine", {}),
    "computed torque": (
        "coaxial",
        "tracking-fast",
        {"track_bandwidth": 20.0, "output_inertia": 1.5e-5, "output_friction": 0.003},
    ),
    "impedance": (
        "coaxial",
        "impedance",
        {"observer_bandwidth": 8.0, "stiffness": 0.1, "damping": 0.004},
    ),
    "wall": ("single", "wall", {"stiffness": 5.0, "damping": 0.01}),
}
Change = Callable[[NDArray[Any], int, int], float]


def _stuck(seen: NDArray[Any], begin: int, k: int) -> float:
    return float(seen[begin - 1])


#: Kind of fault -> the reading at row k of a fault that begins at row `begin`, from the true readings up to now.
FAULTS: Mapping[str, Change] = {
    "1e30": lambda seen, begin, k: 1e30,
    "100": lambda seen, begin, k: 100.0,
    "5": lambda seen, begin, k: 5.0,
    "-5": lambda seen, begin, k: -5.0,
    "0": lambda seen, begin, k: 0.0,
    "stuck": _stuck,
    "reversed": lambda seen, begin, k: -float(seen[k]),
    "late": lambda seen, begin, k: float(seen[max(k - LATE, begin - 1)]),
    "silent": lambda seen, begin, k: np.nan,
    "doubled": lambda seen, begin, k: 2.0 * float(seen[k]),
}
SENSORS = ("torque", "theta", "alpha")


@dataclass(frozen=True)
class FaultRun:
    """What a fault came to.

    Attributes:
        above: longest run of rows in which the field was too high.
        zero: rows from the fault to zero field for good; -1: never.
        said: events that named a sensor.
        most: largest field above the healthy one.
        unbounded: longest run of rows that nothing bounded either.
        cause: why nothing tells of the fault in time, one of `CAUSES`; "" where it was held, or nobody knows.
        outside: how far the readings leave the band of healthy loops while an alarm would be in time: see
            `outside_health`. NaN where the fault was held, or nobody asked.
    """

    above: int
    zero: int
    said: tuple[str, ...]
    most: float
    unbounded: int
    cause: str = ""
    outside: float = np.nan

    @property
    def held(self) -> bool:
        """Whether the field did what a fault that lasts asks for."""
        return self.never_above and self.zero_in_time

    @property
    def never_above(self) -> bool:
        """To the letter: never above the healthy field by a tenth for longer than that."""
        return self.above <= MOST_ABOVE

    @property
    def zero_in_time(self) -> bool:
        """To the letter: zero in time, and for good."""
        return 0 <= self.zero <= ZERO_WITHIN

    @property
    def outcome(self) -> str:
        """One of `OUTCOMES`."""
        if not self.never_above:
            return NOT_HELD if self.unbounded > MOST_ABOVE else "bounded"
        return "held" if self.held else "safe"


@cache
def offered(device: DeviceName = "coaxial") -> tuple[LoopProgram, ...]:
    """What `erclutch live` offers with a model on the default rig; a minute of random fields is drawn once."""
    return standard_programs(default_rig(), model=True, device=device)


def settings_of(
    control: str, model: LiveModel, rig: RigParameters, observer: str = "sensor"
) -> LoopSettings:
    """Settings as `erclutch live` makes them."""
    device, name, changes = CONTROLS[control]
    of_default = rig is default_rig()
    programs = offered(device) if of_default else standard_programs(rig, model=True, device=device)
    program = next(p for p in programs if p.name == name)
    common = {
        "device": device,
        "observer": observer,
        "torque_lead": 1.5e-3,
        "torque_lag": 1e-3,
        "meter_needed": 1.0,
    }
    stroke = {"stroke": shaft_angle(rig, 0.9)} if device == "coaxial" else {}
    settings = rig_settings(rig, (program,), **common, **stroke)
    free = free_output(rig) if device == "coaxial" else free_drive(rig)
    return replace(settings, **{**sensor_limits(device, model, rig), **free, **changes})


def frames_of(
    settings: LoopSettings,
    model: Path,
    rig: RigParameters,
    seed: int,
    fault: tuple[str, str, int] | None = None,
    noise: tuple[int, int] | None = None,
) -> Any:
    """Frames of the loop on the TWIN, dtype `FRAME`, shape (ROWS,).

    Args:
        settings: of the loop.
        model: compiled.
        rig: parameters of the TWIN.
        seed: of the torque meter's noise.
        fault: sensor, kind and row of the fault.
        noise: row from which the meter has other noise, and its seed.
    """
    single, turns = settings.device == "single", 2.0 * np.pi / rig.value("screw.lead")
    twin, core = Twin(rig, seed=seed, locked=single, single=single), Core(settings, model)
    frames, sample = np.zeros(ROWS, FRAME), np.zeros(1, SAMPLE)
    seen = {name: np.zeros(ROWS) for name in SENSORS}
    for k in range(ROWS):
        if noise is not None and k == noise[0]:
            twin._random = np.random.default_rng(noise[1])
        read = twin.sense()
        for name, value in zip(
            SENSORS, (read.torque, read.theta, turns * read.alpha_raw), strict=True
        ):
            seen[name][k] = sample[name][0] = value
        if fault is not None and k >= fault[2]:
            sensor, kind, begin = fault
            sample[sensor] = FAULTS[kind](seen[sensor], begin, k)
        sample["seq"], sample["time_ns"] = k + 1, (k + 1) * 1_000_000
        command, frames[k] = core.step(sample, k)
        twin.command(command_of(command))
        twin.step()
    return frames


def command_of(command: Any) -> Any:
    """What the TWIN is told."""
    from erclutch.wings.rig.interface import RigCommand

    return RigCommand(
        float(command["field1"]), float(command["field2"]), float(command["motor_torque"])
    )


def judged(
    healthy: Any, faulty: Any, begin: int, without: Any = None, unseen: float = 0.0
) -> FaultRun:
    """What came of a fault, beside the healthy loop.

    Args:
        healthy, faulty: frames of both loops.
        begin: row of the fault.
        without: frames of the loop whose sensor falls silent at that row; None where that says nothing.
        unseen: torque in N m by the model that passes the check of the momentum while the output rests.
    """
    ill = np.abs(faulty["field1"] - faulty["field2"])
    most = _near(healthy)
    above = _field_above(faulty, most)[begin:]
    bounded = np.abs(faulty["estimate"]) <= unseen
    if without is not None:
        bounded |= ill <= (1.0 + ABOVE) * _near(without) + LEAST
    on = np.flatnonzero(ill != 0.0)
    last = int(on[-1]) if on.size else begin - 1
    bits = int(np.bitwise_or.reduce(faulty["events"][begin:]))
    named = (*_DOUBTS, "glitch", "out-of-range", "stuck", "disagrees")
    return FaultRun(
        above=_longest(above),
        zero=max(0, last + 1 - begin) if last + 1 < len(ill) else -1,
        said=tuple(name for name in named if bits & EVENT_BITS[name]),
        most=float(np.max(ill - most)),
        unbounded=_longest(above & ~bounded[begin:]),
    )


def _near(frames: Any) -> NDArray[np.float64]:
    """The largest field within `NEAR` rows of each."""
    size = np.abs(frames["field1"] - frames["field2"])
    return np.max([np.roll(size, shift) for shift in range(-NEAR, NEAR + 1)], axis=0)


def field_too_high(healthy: Any, faulty: Any) -> NDArray[np.bool_]:
    """Rows in which a fault brings a higher field than the healthy loop has nearby."""
    return _field_above(faulty, _near(healthy))


def _field_above(frames: Any, most: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Rows whose field is above another one by more than `ABOVE`."""
    return np.abs(frames["field1"] - frames["field2"]) > (1.0 + ABOVE) * most + LEAST


def _longest(rows: NDArray[np.bool_]) -> int:
    """The longest run of true rows."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], rows.astype(int), [0]))))
    return int(np.max(np.diff(edges)[::2], initial=0))


def fault_run(
    settings: LoopSettings,
    model: Path,
    rig: RigParameters,
    seed: int,
    fault: tuple[str, str, int],
    healthy: Any,
    *,
    banded: bool = False,
) -> FaultRun:
    """A fault beside health, and, where that is higher, beside the loop without the meter.

    Args:
        settings, model, rig, seed: see `frames_of`.
        fault: sensor, kind and row.
        healthy: frames of the same loop in health.
        banded: a fault that is not held is also put beside the band of healthy loops: twenty more sessions.
    """
    sensor, _, begin = fault
    faulty = frames_of(settings, model, rig, seed, fault)
    run = judged(healthy, faulty, begin)
    cause = "" if run.held else cause_of(settings, rig, fault, healthy, faulty)
    if cause == "friction" and not run.never_above:
        others = [frames_of(settings, model, rig, seed, noise=(begin, other)) for other in NOISES]
        high = _field_above(
            faulty, np.max([_near(frames) for frames in (healthy, *others)], axis=0)
        )
        cause = "noise" if _longest(high[begin:]) <= MOST_ABOVE else cause
    if banded and not run.held:
        run = replace(run, outside=outside_health(settings, model, rig, seed, fault, faulty))
    if run.outcome != "not held":
        return replace(run, cause=cause)
    without = (
        frames_of(settings, model, rig, seed, (sensor, "silent", begin))
        if sensor == "torque"
        else None
    )
    unseen = (settings.load_band + REST_FRICTION * settings.load_friction) / (1.0 - OFF_SHARE)
    judgement = judged(healthy, faulty, begin, without, unseen)
    return replace(judgement, cause=cause, outside=run.outside)


def outside_health(
    settings: LoopSettings,
    model: Path,
    rig: RigParameters,
    seed: int,
    fault: tuple[str, str, int],
    faulty: Any,
) -> float:
    """How far the readings of a faulty loop leave those of healthy loops while an alarm would be in time.

    The healthy loops are the same one up to the fault; then their meters have other noise (`HEALTHY`). Of each sensor
    and row they read from a least to a most, where one may be earlier or later by `NEAR` rows.

    Returns:
        The largest distance of a reading from that band: of an encoder in counts, of the meter in standard deviations
        of its noise. 0: each reading of each sensor is one of health.
    """
    begin = fault[2]
    rows = slice(begin, begin + ZERO_WITHIN - FALLS)
    well = [frames_of(settings, model, rig, seed, noise=(begin, other)) for other in HEALTHY]
    units = {
        "torque": rig.value("sensors.torque_noise"),
        "theta": theta_count(rig),
        "alpha": alpha_count(rig),
    }
    outside = 0.0
    for sensor, unit in units.items():
        shifts = range(-NEAR, NEAR + 1)
        read = np.array([np.roll(frames[sensor], by) for frames in well for by in shifts])[:, rows]
        below = read.min(axis=0) - faulty[sensor][rows]
        above = faulty[sensor][rows] - read.max(axis=0)
        outside = max(outside, float(np.max(np.maximum(below, above))) / unit)
    return outside


def cause_of(
    settings: LoopSettings,
    rig: RigParameters,
    fault: tuple[str, str, int],
    healthy: Any,
    faulty: Any,
) -> str:
    """What left nothing to tell of a fault in `ZERO_WITHIN` rows: one of `CAUSES`, or "" if nobody knows.

    Args:
        settings: of the loop.
        rig: parameters of the TWIN.
        fault: sensor, kind and row of the fault.
        healthy, faulty: frames of both loops.
    """
    sensor, _, begin = fault
    if all(np.array_equal(healthy[name], faulty[name]) for name in ("field1", "field2")):
        return "not asked"
    rows = slice(begin, begin + ZERO_WITHIN)
    off = float(np.nanmax(np.abs(faulty[sensor][rows] - healthy[sensor][rows])))
    if sensor == "torque":
        rows = slice(begin, begin + ZERO_WITHIN - FALLS)  # a doubt that begins later comes too late
        off = _filtered(faulty[sensor][rows] - healthy[sensor][rows])
        speed = faulty["theta_dot" if settings.device == "single" else "alpha_dot"][rows]
        if (
            float(np.max(np.abs(speed))) <= SLOW
        ):  # there elastic friction withstands whatever is read
            off = min(off, _filtered(faulty[sensor][rows]))
        return (
            "friction" if off <= settings.load_band + REST_FRICTION * settings.load_friction else ""
        )
    count = theta_count(rig) if sensor == "theta" else alpha_count(rig)
    return "same bits" if off == 0.0 else "a count" if off <= COUNTS * count else ""


def _filtered(torque: NDArray[np.float64]) -> float:
    """The largest size of a torque through the filter of the check of the momentum."""
    passed = most = 0.0
    for each in torque[np.isfinite(torque)].tolist():
        passed += MOVES * (each - passed)
        most = max(most, abs(passed))
    return most


def sessions(control: str, seed: int, name: str = "bingham") -> Iterator[tuple[str, str, FaultRun]]:
    """Each fault in each sensor under a control, from one random moment on: sensor, fault, and what came of it."""
    rig = default_rig()
    model = model_of(rig, name, CONTROLS[control][0])
    settings = settings_of(control, model, rig)
    healthy = frames_of(settings, model.library, rig, seed)
    begin = int(np.random.default_rng((7, seed)).choice(under_field(healthy)))
    for sensor, kind in itertools.product(SENSORS, FAULTS):
        if kind == "silent" or (sensor == "alpha" and control == "wall"):
            continue
        yield (
            sensor,
            kind,
            fault_run(settings, model.library, rig, seed, (sensor, kind, begin), healthy),
        )


def doubted(frames: Any) -> int:
    """Rows in which a sensor is in doubt."""
    return int(
        np.count_nonzero(frames["events"] & np.uint32(sum(EVENT_BITS[name] for name in _DOUBTS)))
    )


def under_field(frames: Any) -> NDArray[np.intp]:
    """Rows between `BEGINS` with a field that matters."""
    field = np.abs(frames["field1"] - frames["field2"])
    rows = np.arange(len(field))
    return np.flatnonzero((field > 10.0 * LEAST) & (rows >= BEGINS[0]) & (rows < BEGINS[1]))


#: Models of the default rig, by name and device: several files of tests ask for the same.
_MODELS: dict[tuple[str, DeviceName], LiveModel] = {}


def model_of(rig: RigParameters, name: str, device: DeviceName) -> LiveModel:
    """A law or network for the pair or the brake, fitted to the TWIN once."""
    if rig is not default_rig():
        return _fitted(rig, name, device)
    if (name, device) not in _MODELS:
        _MODELS[name, device] = _fitted(rig, name, device)
    return _MODELS[name, device]


def _fitted(rig: RigParameters, name: str, device: DeviceName) -> LiveModel:
    from rich.console import Console

    from erclutch.wings.rig.twin_model import twin_models

    return live_model(twin_models(rig, (name,), Console(stderr=True), device)[0], device)
