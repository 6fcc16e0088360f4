"""Faults, each injected into the live loop: how many, what is expected, what was observed.

    python studies/live_faults.py [--kills 100] [--only NAME] [--control NAME]

Every fault is injected under each control: equation 23, torque control, tracking by computed torque, impedance, wall.
The first part runs the loop's C core step by step on synthetic sensors, so counts are exact. The second part runs the
whole loop in its own process against a rig in another thread, kills and stops it, and times the rig's field. Nothing
here is a TWIN or a measurement: sensors are a motor at 40 rad/s and an output that swings.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import math
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.logs import read_table
from erclutch.wings.live.c_build import build, loop_program
from erclutch.wings.live.c_core import Core
from erclutch.wings.live.layout import EVENT_BITS, FRAME, SAMPLE
from erclutch.wings.live.orders import Order, order_bytes
from erclutch.wings.live.recording.recordings import Recordings
from erclutch.wings.live.ring import RingInfo, RingReader, State, make_ring, ring_folder
from erclutch.wings.live.settings import ZERO_BEFORE_TRIP, LoopProgram, LoopSettings, Mode, Waveform, config_of
from erclutch.wings.rig.interface import Measurement, RigCommand
from erclutch.wings.rig.packet import SensorPacket, pack_sensors
from erclutch.wings.rig.rig_process import start_rig
from erclutch.wings.rig.rig_server import WATCHDOG_TIME, RigServer

MODEL = Path(__file__).resolve().parents[1] / "tests" / "wings" / "live" / "bingham.c"
CRASHING = MODEL.with_name("crashing.c")
WALL_CLOCK = MODEL.with_name("wall_clock.c")
MODEL_FILE = MODEL.with_name("model.json")
DIGEST = "0" * 63 + "1"


def _pushing(mode: Mode, amplitude: float = 1000.0, **more: Any) -> LoopSettings:
    """Wants something that lies ahead, so that the field is on as long as all is well."""
    return LoopSettings(programs=(LoopProgram("push", mode, amplitude=amplitude, motor_torque=0.1),), **more)


SETTINGS = _pushing(Mode.TRACK)
_STAGES: dict[str, Any] = {"observer": "none", "least_slip": 1.0}
_MASS: dict[str, Any] = {**_STAGES, "track_bandwidth": 10.0, "track_integral": 0.0, "output_inertia": 1e-5}
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


def run_core(steps: list[Any], settings: LoopSettings | None = None, model: bool = True, **each: Any) -> Any:
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
    low = (np.maximum(frames["field1"], frames["field2"]) <= 0.5) & (frames["field1"] >= 0) & (frames["field2"] >= 0)
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


# --- faults of sensors and packets ------------------------------------------------------------------------------------


def bad_number(sensor: str, value: float) -> Finding:
    """A sensor that is not finite now and then, then for good."""
    samples, at = good_samples(), places(1)
    samples[sensor][at] = value
    frames = run_core(one_by_one(samples))
    seen, trips = count(frames, "sample-invalid"), count(frames, "trip")
    lasting = good_samples()
    lasting[sensor][1000:] = value
    zero = zero_after(run_core(one_by_one(lasting)), 1000)
    must_stop = sensor != "torque"  # no command depends on the torque meter
    passed = seen == 10 and trips == 0 and sound(frames) and (zero == 13 if must_stop else zero == -1)
    ends = "zero after 13 ms" if must_stop else "control goes on"
    return Finding(
        f"{sensor} is {value}", 10, f"10 invalid, no trip; lasting: {ends}", f"{seen}, {trips}; {zero} ms", passed
    )


def wraps() -> Finding:
    """Both encoders start again at zero after each turn."""
    samples, turn = good_samples(), 2.0 * np.pi
    raw = samples.copy()
    for name in ("theta", "alpha"):
        raw[name] = np.mod(samples[name], turn)
    settings = replace(chosen(), theta_wrap=turn, alpha_wrap=turn)
    frames, plain = run_core(one_by_one(raw), settings), run_core(one_by_one(samples))
    seen = count(frames, "wrap")
    off = max(float(np.max(np.abs(np.diff(frames[n]) - np.diff(plain[n])))) for n in ("theta", "alpha", "theta_dot"))
    at = [np.flatnonzero(np.abs(np.diff(raw[n])) > 1.0) for n in ("theta", "alpha")]
    steps = len(np.union1d(*at))  # both may wrap in one step
    passed = seen == steps and off < 1e-9 and count(frames, "glitch") == 0
    return Finding("encoder wraps", steps, f"{steps} wraps, angles as without", f"{seen}, off by {off:.1e}", passed)


def glitch(sensor: str) -> Finding:
    """A jump of 60 rad/s for one sample."""
    samples, at = good_samples(), places(2)
    samples[sensor][at] += 0.06
    frames, plain = run_core(one_by_one(samples)), run_core(one_by_one(good_samples()))
    seen = count(frames, "glitch")
    off = float(np.max(np.abs(frames[f"{sensor}_dot"] - plain[f"{sensor}_dot"])))
    passed = seen == 10 and off < 1.5 and sound(frames) and count(frames, "trip") == 0
    return Finding(f"{sensor}: 60 rad/s glitch", 10, "10 rejected, speed off < 1.5 rad/s", f"{seen}, {off:.2f}", passed)


def loss(share: float) -> Finding:
    """Samples lost at random; the expectation follows from the runs of losses that were drawn."""
    total = 60_000
    rng = np.random.default_rng(3)
    gone = rng.random(total) < share
    gone[:100] = False
    edges = np.flatnonzero(np.diff(np.concatenate(([0], gone.astype(int), [0]))))
    longest = int(np.max(np.diff(edges)[::2])) if edges.size else 0
    samples = good_samples(total)
    steps = [samples[k : k if gone[k] else k + 1] for k in range(total)]
    frames = run_core(steps)
    plain = run_core(one_by_one(samples))
    seen, trips = count(frames, "sample-lost"), count(frames, "trip")
    expected = int(np.count_nonzero(gone))
    off = float(np.max(np.abs((frames["alpha_dot"] - plain["alpha_dot"])[~gone])))
    passed = seen == expected and (trips > 0) == (longest >= 21) and sound(frames)
    said = f"{seen} lost, {trips} trips, speed off {off:.2f} rad/s"
    return Finding(f"{share:.0%} lost", expected, f"{expected} lost, longest run {longest}: no trip", said, passed)


def burst(length: int) -> Finding:
    """A run of lost samples."""
    samples = good_samples()
    steps = one_by_one(samples)
    for k in range(1000, 1000 + length):
        steps[k] = samples[:0]
    frames = run_core(steps)
    field1 = frames["field1"]
    tripped = count(frames, "trip") > 0
    zero = zero_after(frames, 1000)
    held = bool(np.all(field1[1000:1005] == field1[999]))
    falling = bool(np.all(np.diff(field1[1004 : 1000 + min(length, 14)]) < 0))
    passed = (
        tripped == (length >= 21) and (zero == 13 if tripped else zero == -1) and held and falling and sound(frames)
    )
    wanted = "hold 5, reduce, zero at the 14th, stay" if length >= 21 else "hold 5, reduce, then on as before"
    return Finding(f"burst of {length} lost", length, wanted, f"trip {tripped}, zero after {zero} ms", passed)


def recovery() -> Finding:
    """A second without samples trips; after a reset and an order to run, the field comes back without a jump."""
    samples, gone = good_samples(), slice(900, 1900)
    core, steps, frames = Core(chosen(), compiled_model()), one_by_one(samples), np.zeros(STEPS, FRAME)
    for k in range(STEPS):
        if k == gone.stop + 10:
            core.order(Order.RESET)
            core.order(Order.PROGRAM, 0.0)
        frames[k] = core.step(samples[:0] if gone.start <= k < gone.stop else steps[k], k)[1]
    field1 = frames["field1"]
    zero, most = zero_after(frames[: gone.stop + 10], gone.start), chosen().field_limit / EASE + 1e-9
    jump = float(np.max(np.diff(field1[gone.stop : gone.stop + EASE + 10])))
    eased = _control.get() == "equation 23" or jump <= most
    passed = zero == 13 and eased and bool(field1[-1] > 0.05) and sound(frames)
    said = f"zero after {zero} ms, then {jump:.3f} a step"
    return Finding("trip and recovery", 1, f"zero after 13 ms, then at most {most:.3f} a step in stages", said, passed)


def duplicates() -> Finding:
    """Packets that come twice."""
    samples = good_samples()
    steps = one_by_one(samples)
    at = places(4)
    for k in at:
        steps[k] = samples[[k, k]]
    frames, plain = run_core(steps), run_core(one_by_one(samples))
    seen = count(frames, "stale-packet")
    same = bool(np.array_equal(frames["estimate"], plain["estimate"], equal_nan=True))
    return Finding(
        "duplicated packets", 10, "10 dropped, nothing else changes", f"{seen}, same: {same}", seen == 10 and same
    )


def reordered() -> Finding:
    """Packets that come one step late, after the next one."""
    samples = good_samples()
    steps = one_by_one(samples)
    for k in places(5):
        steps[k] = samples[:0]
        steps[k + 1] = samples[[k + 1, k]]
    frames = run_core(steps)
    seen, lost = count(frames, "stale-packet"), count(frames, "sample-lost")
    passed = seen == 10 and lost == 10 and sound(frames) and count(frames, "trip") == 0
    return Finding("reordered packets", 10, "10 dropped as stale, 10 held", f"{seen}, {lost}", passed)


def clock_jump() -> Finding:
    """The rig's clock jumps by 10 s and back, and by an hour into the past."""
    samples = good_samples()
    samples["time_ns"][500:] += np.uint64(10_000_000_000)
    samples["time_ns"][1000:] -= np.uint64(10_000_000_000)
    samples["time_ns"][1500:] -= np.uint64(1_000_000)
    samples["time_ns"][1500:] = samples["time_ns"][1500:] + np.uint64(2**64 - 3600 * 10**9)
    frames, plain = run_core(one_by_one(samples)), run_core(one_by_one(good_samples()))
    seen = count(frames, "clock-jump")
    same = bool(np.array_equal(frames["estimate"], plain["estimate"], equal_nan=True))
    return Finding("rig's clock jumps", 3, "3 said, nothing else changes", f"{seen}, same: {same}", seen == 3 and same)


def mutated_packets(number: int = 100_000) -> Finding:
    """Packets with random bytes changed, cut or prolonged: each is refused."""
    import ctypes

    from erclutch.wings.live.c_build import core_library

    library = ctypes.CDLL(str(core_library()))
    out = np.zeros(1, SAMPLE)
    rng = random.Random(6)
    whole = pack_sensors(SensorPacket(77, 5, 6, 1.0, 2.0, 3.0))
    taken = 0
    for _ in range(number):
        data = mutated(whole, rng)
        taken += library.erc_get_sample(
            data, ctypes.c_size_t(len(data)), ctypes.c_uint32(77), ctypes.c_void_p(out.ctypes.data)
        )
    control = library.erc_get_sample(whole, ctypes.c_size_t(64), ctypes.c_uint32(77), ctypes.c_void_p(out.ctypes.data))
    foreign = library.erc_get_sample(whole, ctypes.c_size_t(64), ctypes.c_uint32(78), ctypes.c_void_p(out.ctypes.data))
    passed = taken == 0 and control == 1 and foreign == 0
    return Finding("forged packets", number, "none taken, the whole one is", f"{taken} taken; {control}", passed)


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


# --- faults of control ------------------------------------------------------------------------------------------------


def asked(rows: Any, **changes: Any) -> Any:
    """Frames for fields that are asked for outright."""
    table = np.asarray(rows, float)
    program = LoopProgram("asked", Mode.FIELDS, Waveform.TABLE, table=table)
    return run_core(one_by_one(good_samples(len(table))), replace(SETTINGS, programs=(program,), **changes))


def both_fields() -> Finding:
    """Both fields asked for, in all proportions."""
    rng = np.random.default_rng(7)
    table = np.column_stack([rng.uniform(0.01, 0.5, (1000, 2)), np.full(1000, 0.1)])
    frames = asked(table, rise_rate=1e6, fall_rate=1e6)
    seen = count(frames, "both-fields")
    larger = np.maximum(frames["field1"], frames["field2"]) == table[:, :2].max(axis=1)
    passed = seen == 1000 and sound(frames) and bool(larger.all())
    return Finding(
        "both fields asked for", 1000, "1000 said; the larger alone", f"{seen}; sound {sound(frames)}", passed
    )


def too_high() -> Finding:
    """3000 V asked for: 0.75 where 0.5 is 2000 V."""
    frames = asked(np.tile([0.75, 0.0, 0.1], (1000, 1)))
    seen, top = count(frames, "beyond-limit"), float(frames["field1"].max())
    return Finding(
        "3000 V asked for", 1000, "1000 clipped to 2000 V", f"{seen}, {4000 * top:.0f} V", (seen, top) == (1000, 0.5)
    )


def not_finite() -> Finding:
    """A command that is not finite."""
    table = np.tile([0.3, 0.0, 0.1], (1000, 1))
    table[100:110, 0], table[200:210, 2], table[300:310, 1] = np.nan, np.inf, -np.inf
    frames = asked(table)
    seen = count(frames, "command-not-finite")
    zero = float(np.max(frames["field1"][100:110]))
    return Finding(
        "command not finite", 30, "30 said, counted as zero", f"{seen}, field {zero:g}", seen == 30 and zero == 0.0
    )


def slew() -> Finding:
    """Steps from one clutch to the other, through a slow supply."""
    wave = np.where(np.arange(1000) // 50 % 2 == 0, 0.5, -0.5)
    table = np.column_stack([np.maximum(wave, 0), np.maximum(-wave, 0), np.full(1000, 0.1)])
    frames = asked(table, rise_rate=25.0, fall_rate=50.0)
    field_now = frames["field1"] - frames["field2"]
    up = float(np.max(np.diff(np.abs(field_now))))
    down = float(-np.min(np.diff(np.abs(field_now))))
    passed = up <= 0.025 + 1e-12 and down <= 0.05 + 1e-12 and sound(frames) and count(frames, "rate-limited") > 0
    return Finding("jumps of the field", 20, "up at most 0.025, down 0.05 a step", f"{up:.3f}, {down:.3f}", passed)


# --- the whole loop ---------------------------------------------------------------------------------------------------


@dataclass
class Spy:
    """A rig that runs well and keeps what it was told, with times.

    Attributes:
        told: (monotonic time, field on, step of the rig) whenever a command was applied.
    """

    period: float = 1e-3
    told: list[tuple[float, bool, int]] = field(default_factory=list)
    rows: int = 0

    def sense(self) -> Measurement:
        """Sensors of a motor at 40 rad/s."""
        t = self.rows * self.period
        return Measurement(t, 40.0 * t, 0.0, 0.0, 0.0)

    def command(self, command: RigCommand) -> None:
        """Keep it."""
        self.told.append((time.monotonic(), command.E1 > 0.0 or command.E2 > 0.0, self.rows))

    def step(self) -> None:
        """Time passes."""
        self.rows += 1

    def close(self) -> None:
        """Nothing."""

    def __enter__(self) -> Spy:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def zero_since(self, moment: float) -> float:
        """Seconds from a moment until the field was zero for good; inf if it still is on."""
        return max(0.0, self._end()[0] - moment)

    def steps_with_field(self) -> float:
        """Steps of the rig's own clock from the last command with a field to zero; inf if it still is on."""
        last = max((k for k, (_, on, _) in enumerate(self.told) if on), default=-1)
        return self._end()[1] - (self.told[last][2] if last >= 0 else 0)

    def commands_of_zero(self) -> int:
        """Since the last one with a field; the watchdog's are among them."""
        last = max((k for k, (_, on, _) in enumerate(self.told) if on), default=-1)
        return len(self.told) - 1 - last

    def _end(self) -> tuple[float, float]:
        """When the field went to zero for good: time and step."""
        last = max((k for k, (_, on, _) in enumerate(self.told) if on), default=-1)
        return (self.told[last + 1][0], self.told[last + 1][2]) if last + 1 < len(self.told) else (math.inf, math.inf)


@dataclass
class Running:
    """A loop in its own process, its rig in a thread of this one."""

    ring: Path
    loop: subprocess.Popen[bytes]
    spy: Spy
    server: RigServer
    reader: RingReader

    def ready(self, steps: int = 30, reset: bool = False) -> None:
        """Wait until the field is on; a trip before it ends the wait, or is reset (with ``--orders 0``)."""

        def over() -> bool:
            tripped = self.reader.state is State.TRIPPED
            if reset and tripped and self.loop.stdin is not None:
                os.write(self.loop.stdin.fileno(), order_bytes(Order.RESET) + order_bytes(Order.PROGRAM))
            return self._steady(steps) or (tripped and not reset)

        until(over, 30.0)
        if self._steady(steps):
            return
        said = self.loop.stderr.read() if self.loop.poll() is not None and self.loop.stderr else b""
        raise NeverReadyError(f"the loop does not run: {said!r}, {self.reader.trip_reason or 'not tripped'}")

    def _steady(self, steps: int) -> bool:
        frames = self.reader.latest(steps)
        return len(frames) == steps and bool((frames["field1"] > 0).all())

    def zero(self) -> bool:
        """Wait until the rig's field is zero; whether it came to that."""
        return until(lambda: not self.spy.told[-1][1], 5.0)

    def held_up(self) -> bool:
        """Whether the loop tripped for a delay that it recorded itself: its own, or 20 periods without a sample."""
        frames = self.reader.latest(self.reader.info.capacity)
        late = bool((frames["lateness_ns"] > 1e7).any())
        deadlines = frames["time_ns"].astype(np.int64) - frames["lateness_ns"]
        missed = int(np.rint(np.diff(deadlines) / self.reader.info.period_ns).sum()) - (len(frames) - 1)
        return self.reader.state is State.TRIPPED and (late or self.reader.counts["sample-lost"] + missed >= 20)


class NeverReadyError(RuntimeError):
    """The loop did not come to run, so nothing could be injected."""


def until(true: Callable[[], bool], seconds: float) -> bool:
    """Wait for something; whether it came."""
    limit = time.monotonic() + seconds
    while not true():
        if time.monotonic() > limit:
            return False
        time.sleep(0.002)
    return True


@contextlib.contextmanager
def running(
    model: Path = MODEL, *words: str, wrapper: tuple[str, ...] = (), port: int | None = None
) -> Iterator[Running]:
    """Start the loop and its rig: a thread's, or one that listens at a port already."""
    with tempfile.TemporaryDirectory(dir=ring_folder()) as name:
        folder = Path(name)
        (folder / "config").write_bytes(config_of(chosen())[0])
        ring = make_ring(folder / "ring", RingInfo(capacity=8192))
        library = compiled_model(model)
        spy = Spy()
        server = RigServer(spy, session=42, lead=0.01, device=chosen().device)
        stop = threading.Event()
        thread = threading.Thread(target=serve, args=(server, stop), daemon=True)
        thread.start()
        loop = subprocess.Popen(
            [
                *wrapper,
                *(str(loop_program()), "--config", str(folder / "config"), "--ring", str(ring)),
                *("--udp", "127.0.0.1", str(port or server.port), "0", "42", "--model", str(library), DIGEST, *words),
            ],
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        reader = RingReader(ring)
        try:
            yield Running(ring, loop, spy, server, reader)
        finally:
            loop.kill()
            loop.communicate()
            stop.set()
            thread.join()
            reader.close()


def serve(server: RigServer, stop: threading.Event) -> None:
    """The rig's thread, ahead of ordinary work where that is permitted."""
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(70))
    server.run(stop.is_set)


def killed(times: int) -> Finding:
    """Kill -9 of the loop at random times: the rig's watchdog acts."""
    rng = random.Random(8)
    waits: list[float] = []
    certain = True
    for _ in range(3 * times):  # a busy machine may trip a loop before it is killed: that one does not count
        if len(waits) == times:
            break
        with running() as now, contextlib.suppress(NeverReadyError):
            now.ready()
            time.sleep(rng.uniform(0.0, 0.02))
            now.loop.kill()
            moment = time.monotonic()
            now.zero()
            waits.append(now.spy.zero_since(moment))
            acted = until(lambda: now.server.counts["watchdog"] > 0, 5.0)
            certain &= acted and now.spy.steps_with_field() <= WATCHDOG_STEPS
    passed = certain and len(waits) == times and max(waits) <= 0.020 + SLACK
    return Finding("kill -9 of the loop", len(waits), "zero within 20 ms", _spread(waits), passed, certain)


def _spread(waits: list[float]) -> str:
    """Median, how many were late, the worst."""
    late = sum(wait > 0.020 for wait in waits)
    return f"median {1e3 * float(np.median(waits)):.1f} ms, {late} over 20 ms, worst {1e3 * max(waits):.1f} ms"


def told_to_end(number: signal.Signals) -> Finding:
    """A signal ends the loop at zero field."""
    with running() as now:
        now.ready()
        moment = time.monotonic()
        now.loop.send_signal(number)
        code = now.loop.wait(10.0)
        now.zero()
        wait = now.spy.zero_since(moment)
        state = now.reader.state
    certain = wait < math.inf and code == 0 and state is State.STOPPED
    passed = certain and wait <= 0.020 + SLACK
    said = f"{1e3 * wait:.1f} ms, exit {code}"
    return Finding(f"{number.name} to the loop", 1, "zero, exit 0", said, passed, certain)


def stopped(seconds: float) -> Finding:
    """SIGSTOP and SIGCONT: a short pause is an overrun, a long one trips; the rig's watchdog acts meanwhile."""
    with running() as now:
        now.ready()
        moment = time.monotonic()
        now.loop.send_signal(signal.SIGSTOP)
        time.sleep(seconds)
        now.loop.send_signal(signal.SIGCONT)
        head = now.reader.head
        until(lambda: now.reader.head > head + 60, 5.0)
        wait = now.spy.zero_since(moment)
        state, overruns = now.reader.state, now.reader.counts["overrun"]
        on = bool((now.reader.latest(50)["field1"] > 0).all())
        held_up = now.held_up()
    long = seconds > 0.02
    if long:
        certain = overruns > 0 and state is State.TRIPPED and wait < math.inf
        passed = certain and wait <= 0.020 + SLACK
    else:
        passed = overruns > 0 and on and state is State.RUNNING
        certain = passed or (overruns > 0 and held_up)
    said = f"{state.name.lower()}, field {'on' if on else f'zero after {1e3 * wait:.1f} ms'}"
    wanted = "zero within 20 ms, tripped" if long else "on"
    return Finding(f"SIGSTOP for {1e3 * seconds:.0f} ms", 1, wanted, said, passed, certain)


@contextlib.contextmanager
def preloaded(source: Path) -> Iterator[None]:
    """Processes that are started meanwhile have a library of ours before the system's."""
    library = build(f"{source.stem}.so", [source], shared=True)
    loop_program()
    compiled_model()  # compilers are not to be among them
    os.environ["LD_PRELOAD"] = str(library)
    try:
        yield
    finally:
        del os.environ["LD_PRELOAD"]


def wall_clock_jumps(samples: int = 1500) -> Finding:
    """The wall clock of the loop and of the recorder jumps by two hours, there and back, ten times a second."""
    ask = "import time; t = [time.sleep(0.01) or time.time() for _ in range(40)]; print(max(t) - min(t))"
    with preloaded(WALL_CLOCK), running(MODEL, "--orders", "0") as now, tempfile.TemporaryDirectory() as folder:
        moved = float(subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True).stdout)
        recordings = Recordings(now.ring, folder)
        recordings.start("jumps")
        try:
            recordings.wait_for_frames(30.0)
            now.ready(reset=True)  # to start a process held up the rig's thread
            head = now.reader.head
            until(lambda: now.reader.head > head + samples, 30.0)
        finally:
            recordings.stop()
        kept, reader = read_table(recordings.files[0]).columns, now.reader
        on, why, held_up = reader.state is State.RUNNING, reader.trip_reason, now.held_up()
    gaps = int((np.diff(kept["seq"]) - 1).sum())
    # Deadlines, from the stamps: a whole number of periods apart, and as many as there are steps and missed ones.
    periods = np.diff(kept["time_ns"] - kept["lateness_ns"]) / 1e6
    whole = bool((np.abs(periods - np.rint(periods)) < 1e-3).all() and (periods > 0.5).all() and periods.max() < 1e3)
    jumps, jumped = int(moved > 7000.0), count_of(kept["events"], "clock-jump")
    in_order = bool(jumps) and gaps == 0 and len(kept["seq"]) > samples and whole
    # A machine that stops the rig for 50 ms moves its stamps, now and then; the wall clock moved many times.
    certain = in_order and jumped < samples / 200 and (on or held_up)
    said = f"{gaps} missing of {len(kept['seq'])}, stamps in step: {whole}, {jumped} jumps, loop {why or 'on'}"
    passed = certain and on and jumped == 0
    return Finding("wall clock jumps", round(samples / 100), "nothing changes", said, passed, certain)


def tried_again(fault: Callable[[], Finding], times: int = 3) -> Finding:
    """A finding in which a delay of the machine alone failed does not count, as long as there are tries left."""
    found = fault()
    while times > 1 and found.certain and not found.passed:
        found, times = fault(), times - 1
    return found


def orphaned() -> Finding:
    """The loop's parent is killed."""
    with running(MODEL, wrapper=(sys.executable, str(Path(__file__).resolve()), "--parent")) as now:
        now.ready()
        moment = time.monotonic()
        now.loop.kill()  # the parent; the loop is its child
        certain = until(lambda: now.reader.state is State.STOPPED, 5.0) and now.zero()
        wait = now.spy.zero_since(moment)
        said = f"{1e3 * wait:.1f} ms, {now.reader.state.name.lower()}"
    passed = certain and wait <= 0.020 + SLACK
    return Finding("kill -9 of the parent", 1, "zero, loop ended", said, passed, certain)


def orders_gone() -> Finding:
    """The pipe of orders closes."""
    with running(MODEL, "--orders", "0") as now:
        now.ready()
        moment = time.monotonic()
        assert now.loop.stdin is not None
        now.loop.stdin.close()
        now.loop.stdin = None
        code = now.loop.wait(10.0)
        certain = now.zero() and code == 0
        wait = now.spy.zero_since(moment)
    said, passed = f"{1e3 * wait:.1f} ms, exit {code}", certain and wait <= 0.020 + SLACK
    return Finding("orders' pipe closed", 1, "zero, exit 0", said, passed, certain)


def noise_as_orders(number: int = 1000) -> Finding:
    """Random bytes and damaged orders: counted, never carried out."""
    rng = random.Random(9)
    with running(MODEL, "--orders", "0") as now:
        now.ready()
        assert now.loop.stdin is not None
        for _ in range(number):
            good = order_bytes(Order(rng.randrange(1, 6)), rng.uniform(-10, 10))
            os.write(now.loop.stdin.fileno(), damaged(good, rng))
        until(lambda: now.reader.counts["order-refused"] >= number // 5, 10.0)  # at most four are read a step
        refused, done = now.reader.counts["order-refused"], now.reader.counts["order"]
        there, state, held_up = now.loop.poll() is None, now.reader.state, now.held_up()
    certain = there and done == 0 and refused >= number // 5 and (state is State.RUNNING or held_up)
    passed = certain and state is State.RUNNING
    said = f"{done} carried out, runs on: {state is State.RUNNING}"
    return Finding("damaged orders", number, "none carried out", said, passed, certain)


def damaged(order: bytes, rng: random.Random) -> bytes:
    """An order with bytes changed; always 24 bytes, never whole."""
    out = bytearray(order)
    out[rng.randrange(len(out))] ^= rng.randrange(1, 256)
    if rng.random() < 0.3:  # whole, but of no known kind or out of range
        body = struct.pack("<IIdI", 0x4F435245, rng.randrange(6, 2**32), rng.uniform(-1e9, 1e9), 0)
        return body + struct.pack("<I", zlib.crc32(body))
    return bytes(out)


def crashed() -> Finding:
    """The model crashes inside the loop: its last act is a command of zero field."""
    with running(CRASHING) as now:
        now.ready()
        code = now.loop.wait(10.0)
        until(lambda: now.server.counts["watchdog"] > 0, 5.0)
        wait = now.spy.zero_since(max(at for at, on, _ in now.spy.told if on))
        zeros = now.spy.commands_of_zero()
    certain = code == -signal.SIGSEGV and zeros > 1  # the watchdog's is one
    said = f"signal {-code}, zero {1e3 * wait:.1f} ms after the last field"
    return Finding("crash in the model", 1, "zero by the loop's handler", said, certain and wait <= 0.010, certain)


def rig_killed(times: int) -> Finding:
    """Kill -9 of the rig's process: the loop's own field goes to zero and stays there."""
    rng = random.Random(10)
    waits: list[float] = []
    certain = True
    with tempfile.TemporaryDirectory(dir=ring_folder()) as name:
        samples = good_samples(60_000)
        angles = Path(name) / "angles.npy"
        np.save(angles, np.column_stack([samples[n] for n in ("theta", "alpha", "torque")]))
        for _ in range(3 * times):  # as above
            if len(waits) == times:
                break
            spec = {"kind": "replay", "angles": str(angles), "period": 1e-3, "session": 42, "device": chosen().device}
            rig, port = start_rig(spec)
            with running(port=port) as now, contextlib.suppress(NeverReadyError):
                now.ready()
                time.sleep(rng.uniform(0.0, 0.02))
                rig.kill()
                moment = time.monotonic()
                tripped = until(lambda now=now: now.reader.state is State.TRIPPED, 5.0)
                frames = now.reader.latest(8000)
                on = np.flatnonzero(frames["field1"] > 0)
                off = frames["time_ns"][on[-1] + 1 :]
                waits.append(1e-9 * float(off[0]) - moment if off.size else math.inf)
                lost = frames["events"] & EVENT_BITS["sample-lost"] != 0
                fresh = np.flatnonzero(~lost[: on[-1] + 1])  # steps with a sample, before zero
                certain &= tripped and now.loop.poll() is None and int(on[-1] - fresh[-1]) <= STEPS_WITH_FIELD
            rig.kill()
            rig.communicate()
    said = f"{_spread(waits)}; tripped and running: {certain}"
    passed = certain and len(waits) == times and max(waits) <= 0.020 + SLACK
    return Finding("kill -9 of the rig", len(waits), "zero within 20 ms, loop goes on", said, passed, certain)


def bad_configurations(number: int) -> Finding:
    """Configurations with bytes changed or cut: refused before anything moves."""
    rng = random.Random(11)
    whole = config_of(chosen())[0]
    codes: dict[int, int] = {}
    with tempfile.TemporaryDirectory(dir=ring_folder()) as name:
        ring = make_ring(Path(name) / "ring", RingInfo(capacity=16))
        for _ in range(number):
            (Path(name) / "config").write_bytes(mutated(whole, rng))
            words = ["--config", f"{name}/config", "--ring", str(ring), "--udp", "127.0.0.1", "9", "0", "1"]
            done = subprocess.run([str(loop_program()), *words], capture_output=True, timeout=10, check=False)
            codes[done.returncode] = codes.get(done.returncode, 0) + 1
    said = ", ".join(f"exit {code}: {n}" for code, n in sorted(codes.items()))
    return Finding("damaged configurations", number, f"exit 2: {number}", said, codes == {2: number})


def bad_models(number: int) -> Finding:
    """Model files with bytes changed or cut: refused, or, where only white space changed, the same model."""
    from erclutch.errors import RunError
    from erclutch.models.load import load_model

    rng = random.Random(12)
    accepted = crashed_by = 0
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "model.json"
        file.write_bytes(MODEL_FILE.read_bytes())
        good, whole = load_model(file).to_dict(), file.read_bytes()
        for _ in range(number):
            file.write_bytes(mutated(whole, rng))
            try:
                accepted += load_model(file).to_dict() != good
            except RunError:
                pass
            except Exception:
                crashed_by += 1
    said = f"{accepted} accepted, {crashed_by} other errors"
    return Finding("damaged models", number, "0 accepted, 0 other errors", said, accepted + crashed_by == 0)


EXACT: dict[str, Callable[[], Finding]] = {
    "nan-theta": lambda: bad_number("theta", float("nan")),
    "nan-alpha": lambda: bad_number("alpha", float("nan")),
    "nan-torque": lambda: bad_number("torque", float("nan")),
    "inf-theta": lambda: bad_number("theta", float("inf")),
    "inf-alpha": lambda: bad_number("alpha", float("-inf")),
    "wraps": wraps,
    "glitch-theta": lambda: glitch("theta"),
    "glitch-alpha": lambda: glitch("alpha"),
    "loss-1": lambda: loss(0.01),
    "loss-5": lambda: loss(0.05),
    "loss-50": lambda: loss(0.5),
    "burst-19": lambda: burst(19),
    "burst-20": lambda: burst(20),
    "burst-21": lambda: burst(21),
    "recovery": recovery,
    "duplicates": duplicates,
    "reordered": reordered,
    "forged": mutated_packets,
    "clock-jump": clock_jump,
    "both-fields": both_fields,
    "too-high": too_high,
    "not-finite": not_finite,
    "slew": slew,
}
#: What does not depend on the control.
ALIKE = {"forged", "both-fields", "too-high", "not-finite", "slew", "orders-noise", "models", "configurations"}
WHOLE: dict[str, Callable[[], Finding]] = {
    "sigterm": lambda: told_to_end(signal.SIGTERM),
    "sigint": lambda: told_to_end(signal.SIGINT),
    "stop-5": lambda: stopped(0.005),
    "stop-50": lambda: stopped(0.050),
    "orphan": orphaned,
    "orders-gone": orders_gone,
    "orders-noise": noise_as_orders,
    "crash": crashed,
    "wall-clock": lambda: tried_again(wall_clock_jumps),
    "models": lambda: bad_models(10_000),
}


def main() -> int:
    """Run all of them and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--only", default="")
    parser.add_argument("--control", choices=CONTROLS)
    given = parser.parse_args()
    counted: dict[str, Callable[[], Finding]] = {
        "kill": lambda: killed(given.kills),
        "kill-rig": lambda: rig_killed(given.kills),
        "configurations": lambda: bad_configurations(10 * given.kills),
    }
    faults = {**EXACT, **WHOLE, **counted}
    failed = 0
    for control, (name, fault) in itertools.product([given.control] if given.control else CONTROLS, faults.items()):
        if given.only in ("", name) and (name not in ALIKE or control in ("equation 23", given.control)):
            with under(control):
                found = fault()
            failed += not found.passed
            print(
                f"{'ok  ' if found.passed else 'FAIL'} {control:15} {found.fault:24} {found.injected:>7}  "
                f"expected: {found.expected:45} observed: {found.observed}",
                flush=True,
            )
    return 1 if failed else 0


def parent() -> None:
    """Start what follows on the command line as a child, and wait: somebody to kill."""
    subprocess.run(sys.argv[2:], check=False)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--parent"]:
        parent()
    else:
        sys.exit(main())
