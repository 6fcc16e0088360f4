"""What a fault came to, the controls that it meets, and the loop's core, run step by step on synthetic sensors.

Nothing here is a TWIN or a measurement: sensors are a motor at 40 rad/s and an output that swings.
"""

from __future__ import annotations

import contextlib
import random
from collections.abc import Iterator
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.wings.live.c_build import build
from erclutch.wings.live.c_core import Core
from erclutch.wings.live.layout import EVENT_BITS, FRAME, SAMPLE
from erclutch.wings.live.settings import ZERO_BEFORE_TRIP, LoopProgram, LoopSettings, Mode
from erclutch.wings.rig.rig_server import WATCHDOG_TIME

MODEL = Path(__file__).resolve().parents[2] / "wings" / "live" / "bingham.c"
CRASHING = MODEL.with_name("crashing.c")
WALL_CLOCK = MODEL.with_name("wall_clock.c")
MODEL_FILE = MODEL.with_name("model.json")
DIGEST = "0" * 63 + "1"


def _pushing(mode: Mode, amplitude: float = 1000.0, **more: Any) -> LoopSettings:
    """Wants something that lies ahead, so that the field is on as long as all is well."""
    return LoopSettings(
        programs=(LoopProgram("push", mode, amplitude=amplitude, motor_torque=0.1),), **more
    )


SETTINGS = _pushing(Mode.TRACK)
_STAGES: dict[str, Any] = {"observer": "none", "least_slip": 1.0}
_MASS: dict[str, Any] = {
    **_STAGES,
    "track_bandwidth": 10.0,
    "track_integral": 0.0,
    "output_inertia": 1e-5,
}
#: What controls while a fault is injected. Equation 23 stands at the field's limit, the others below.
CONTROLS = {
    "equation 23": SETTINGS,
    "torque": _pushing(Mode.TORQUE, 0.2, **{**_STAGES, "observer": "sensor"}),
    "computed torque": _pushing(Mode.TRACK, 8.0, **_MASS),
    "impedance": _pushing(Mode.IMPEDANCE, 15.0, stiffness=0.02, damping=0.002, **_STAGES),
    "wall": _pushing(Mode.WALL, -1000.0, device="single", stiffness=2e-4, damping=2e-4, **_STAGES),
}
_control = ContextVar("control", default="equation 23")
STEPS = 2000
#: Periods over which the stages of torque control let the field come back.
EASE = 20
#: What the rig's thread may be late by when a time is judged [s].
SLACK = 0.0005
#: Steps of the rig's own clock that its watchdog takes at most, and one for the command that came first.
WATCHDOG_STEPS = round(WATCHDOG_TIME * 1e3) + 1
#: The field is zero in the 14th step without a sample.
STEPS_WITH_FIELD = SETTINGS.trip - ZERO_BEFORE_TRIP - 1


@dataclass(frozen=True)
class Finding:
    """What one fault came to.

    Attributes:
        fault: what was injected.
        injected: how often.
        expected, observed: in words and numbers.
        passed: whether they agree.
        certain: where time is measured: whether all holds that no delay of the machine excuses; tests ask for this.
    """

    fault: str
    injected: int
    expected: str
    observed: str
    passed: bool
    certain: bool | None = None

    @property
    def holds(self) -> bool:
        """What a test may ask for on any machine."""
        return self.passed if self.certain is None else self.certain


# --- sensors and the core ---------------------------------------------------------------------------------------------


def good_samples(count: int = STEPS) -> Any:
    """Sensors of a device that runs well, dtype `SAMPLE`, shape (count,)."""
    samples = np.zeros(count, SAMPLE)
    t = 1e-3 * np.arange(count)
    samples["seq"] = np.arange(1, count + 1)
    samples["time_ns"] = samples["seq"] * np.uint64(1_000_000)
    turn = 2.0 * np.pi / 8192
    samples["theta"] = np.floor(40.0 * t / turn) * turn
    samples["alpha"] = 5.0 * np.sin(2.0 * np.pi * t)
    samples["torque"] = 0.1 * np.sin(2.0 * np.pi * t)
    return samples


@contextlib.contextmanager
def under(control: str) -> Iterator[None]:
    """Faults that are injected meanwhile meet this control."""
    token = _control.set(control)
    try:
        yield
    finally:
        _control.reset(token)


def chosen() -> LoopSettings:
    """Settings of the control that runs."""
    return CONTROLS[_control.get()]


def run_core(
    steps: list[Any], settings: LoopSettings | None = None, model: bool = True, **each: Any
) -> Any:
    """Frames of the core for the samples of each step."""
    core = Core(settings or chosen(), compiled_model() if model else None)
    frames = np.zeros(len(steps), FRAME)
    for k, samples in enumerate(steps):
        frames[k] = core.step(samples, k, **each)[1]
    return frames


def compiled_model(source: Path = MODEL) -> Path:
    """A hand-written model of the tests, for the device that is controlled."""
    flags = ("-DSINGLE",) if chosen().device == "single" else ()
    return build(f"{source.stem}.so", [source], shared=True, flags=flags)


def one_by_one(samples: Any) -> list[Any]:
    """One sample a step."""
    return [samples[k : k + 1] for k in range(len(samples))]


def count(frames: Any, event: str) -> int:
    """Steps with an event."""
    return count_of(frames["events"], event)


def count_of(events: Any, event: str) -> int:
    """How many of some words have the bit of an event."""
    return int(np.count_nonzero(events.astype(np.uint32) & np.uint32(EVENT_BITS[event])))


def sound(frames: Any) -> bool:
    """Whether no frame breaks what must never break: finite, one field, within limits."""
    one = np.minimum(frames["field1"], frames["field2"]) == 0.0
    low = (
        (np.maximum(frames["field1"], frames["field2"]) <= 0.5)
        & (frames["field1"] >= 0)
        & (frames["field2"] >= 0)
    )
    finite = np.isfinite(frames["field1"] + frames["field2"] + frames["motor_torque"])
    started = frames["estimate"][1:]
    return bool(np.all(one & low & finite) and np.all(np.isfinite(started)))


def zero_after(frames: Any, step: int) -> int:
    """Steps from the first bad one until the fields are zero for good; -1 if they never are."""
    off = np.maximum(frames["field1"], frames["field2"]) == 0.0
    on = np.flatnonzero(~off)
    last = int(on[-1]) if on.size else step - 1
    return last + 1 - step if last + 1 < len(frames) else -1


def places(seed: int, number: int = 10) -> Any:
    """Steps at which something is injected, at least 40 apart, after the filters have settled."""
    rng = np.random.default_rng(seed)
    return 200 + 170 * np.arange(number) + rng.integers(0, 130, number)


def mutated(data: bytes, rng: random.Random) -> bytes:
    """Some bytes changed, or another length; never the same."""
    out = bytearray(data)
    kind = rng.random()
    if kind < 0.1:
        return bytes(out[: rng.randrange(len(out))])
    if kind < 0.2:
        return bytes(out) + rng.randbytes(rng.randrange(1, 64))
    for _ in range(rng.choice((1, 1, 2, 8))):
        i = rng.randrange(len(out))
        out[i] ^= rng.randrange(1, 256)
    return bytes(out) if bytes(out) != data else bytes(out[:-1])
