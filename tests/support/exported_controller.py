"""The exported controller on the TWIN, with a fault in one of its inputs, beside the same controller in health.

It gets what a user's program gives it: the wanted torque, the speeds of the encoders through the usual filter, and the
torque of the meter. A fault is in a reading: that of the meter or of an encoder, before its filter.
"""

from __future__ import annotations

import ctypes
import itertools
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from erclutch.export import ExportOptions, step_of
from erclutch.export.c.compilers import native
from erclutch.models.load import load_model
from erclutch.signals.speed import live
from erclutch.wings.live.layout import EVENT_BITS, FRAME
from erclutch.wings.live.motion_limits import USUAL_FILTER
from erclutch.wings.live.targets import controller
from erclutch.wings.rig.interface import RigCommand
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig
from erclutch.wings.rig.twin.twin import Twin
from erclutch.wings.rig.twin_model import twin_models
from tests.support.sensor_faults import (
    FAULTS,
    ROWS,
    SENSORS,
    FaultRun,
    judged,
    model_of,
    offered,
    settings_of,
    under_field,
)

PERIOD = 1e-3
#: Faults that the controller cannot tell by what it gets: NaN is a rig without a meter, and of the drive's encoder it
#: gets the speed alone, which falls as that of a drive that is braked.
UNTOLD = (("torque", "silent"), ("theta", "stuck"), ("theta", "late"))
#: Events that say that a sensor is in doubt.
DOUBTED = sum(EVENT_BITS[name] for name in ("theta-doubted", "alpha-doubted", "torque-doubted"))


class Exported:
    """The C of a model's controller, compiled in a folder."""

    def __init__(self, model: Path, folder: Path) -> None:
        step = step_of(load_model(model), ExportOptions("m", "float64", PERIOD))
        files = controller.write_core(step, folder)
        size = folder / "size.c"
        size.write_text('#include "m.h"\nunsigned size(void) { return sizeof(m_controller); }\n')
        library = folder / "m.so"
        native().build([*files, size], library, "-O2", "-shared", "-fPIC", f"-I{folder}")
        self._library = ctypes.CDLL(str(library))
        self.defaults = controller.defaults(step)
        kinds = {"period_ns": ctypes.c_uint64, "observer": ctypes.c_uint32}
        fields = [(name, kinds.get(name, ctypes.c_double)) for name in controller.settings_of()]
        self._config = type("Config", (ctypes.Structure,), {"_fields_": fields})

    def start(self, given: Mapping[str, float]) -> Any:
        """Memory of a controller with these settings, as of a reset."""
        memory = ctypes.create_string_buffer(self._library.size())
        config = self._config(**{**self.defaults, "period_ns": round(1e9 * PERIOD), **given})
        assert self._library.m_control_reset(memory, ctypes.byref(config)) == 1
        return memory

    def step(self, memory: Any, sample: tuple[float, ...]) -> tuple[int, list[float]]:
        """Flags of a step, and fields and estimate."""
        out = (ctypes.c_double * 3)()
        flags = self._library.m_control_step(memory, (ctypes.c_double * 7)(*sample), out)
        return flags & 0xFFFFFFFF, list(out)


def known_of(rig: RigParameters, live_model: Any) -> dict[str, float]:
    """What a user tells a controller of this rig: the settings that the loop has by its rig file."""
    loop = settings_of("torque", live_model, rig)
    names = controller.settings_of()
    told = {
        name: float(getattr(loop, name))
        for name in names
        if isinstance(getattr(loop, name, None), float)
    }
    return {**told, "observer": 2}


def frames_of(
    exported: Exported,
    given: Mapping[str, float],
    rig: RigParameters,
    seed: int,
    fault: tuple[str, str, int] | None = None,
) -> Any:
    """Frames of the controller on the TWIN, dtype `FRAME`, shape (ROWS,): fields, estimate, torque, and events.

    Args:
        exported: the controller.
        given: its settings that differ from its defaults.
        rig: parameters of the TWIN.
        seed: of the torque meter's noise.
        fault: sensor, kind and row of the fault.
    """
    program = next(each for each in offered() if each.name == "torque-sine")
    twin, memory = Twin(rig, seed=seed), exported.start(given)
    turns = 2.0 * np.pi / rig.value("screw.lead")
    seen = {name: np.zeros(ROWS) for name in SENSORS}
    speeds = {name: live(USUAL_FILTER, PERIOD) for name in ("theta", "alpha")}
    frames = np.zeros(ROWS, FRAME)
    pace = 2.0 * np.pi * program.frequency
    for k in range(ROWS):
        read = twin.sense()
        readings = {"torque": read.torque, "theta": read.theta, "alpha": turns * read.alpha_raw}
        for name, value in readings.items():
            seen[name][k] = value
        if fault is not None and k >= fault[2]:
            sensor, kind, begin = fault
            readings[sensor] = FAULTS[kind](seen[sensor], begin, k)
        wanted = program.amplitude * np.sin(pace * k * PERIOD)
        rate = program.amplitude * pace * np.cos(pace * k * PERIOD)
        theta_dot, alpha_dot = (speeds[name].step(readings[name]) for name in ("theta", "alpha"))
        motor = program.motor_torque
        sample = (wanted, rate, theta_dot, alpha_dot, readings["alpha"], readings["torque"], motor)
        events, (field1, field2, estimate) = exported.step(memory, sample)
        frame = frames[k]
        for name, value in (
            ("field1", field1),
            ("field2", field2),
            ("estimate", estimate),
            ("events", events),
        ):
            frame[name] = value
        for name in SENSORS:
            frame[name] = readings[name]
        twin.command(RigCommand(field1, field2, motor))
        twin.step()
    return frames


def sessions(seeds: range) -> Iterator[tuple[str, str, list[FaultRun]]]:
    """Each fault in each sensor, from one random moment on, for each seed: sensor, fault, and what came of it."""
    rig = default_rig()
    live_model = model_of(rig, "bingham", "coaxial")
    (file,) = twin_models(rig, ("bingham",), Console(stderr=True))
    with tempfile.TemporaryDirectory() as folder:
        exported = Exported(file, Path(folder))
        given = known_of(rig, live_model)
        healthy = {seed: frames_of(exported, given, rig, seed) for seed in seeds}
        assert not any(np.any(frames["events"] & DOUBTED) for frames in healthy.values())
        for sensor, kind in itertools.product(SENSORS, FAULTS):
            runs: list[FaultRun] = []
            for seed, well in healthy.items():
                begin = int(np.random.default_rng((7, seed)).choice(under_field(well)))
                faulty = frames_of(exported, given, rig, seed, (sensor, kind, begin))
                runs.append(judged(well, faulty, begin))
            yield sensor, kind, runs
