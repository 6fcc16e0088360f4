"""Faults of the whole loop: it runs in its own process against a rig in another thread, is killed and stopped."""

from __future__ import annotations

import contextlib
import math
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from erclutch.logs import read_table
from erclutch.wings.live.c_build import build, loop_program
from erclutch.wings.live.layout import EVENT_BITS
from erclutch.wings.live.orders import Order, order_bytes
from erclutch.wings.live.recording.recordings import Recordings
from erclutch.wings.live.ring import RingInfo, State, make_ring, ring_folder
from erclutch.wings.live.settings import config_of
from erclutch.wings.rig.rig_process import start_rig
from tests.support.live_faults.finding import (
    CRASHING,
    MODEL,
    MODEL_FILE,
    SLACK,
    STEPS_WITH_FIELD,
    WALL_CLOCK,
    WATCHDOG_STEPS,
    Finding,
    chosen,
    compiled_model,
    count_of,
    good_samples,
    mutated,
)
from tests.support.live_faults.running_loop import NeverReadyError, running, until


def killed(times: int) -> Finding:
    """Kill -9 of the loop at random times: the rig's watchdog acts."""
    rng = random.Random(8)
    waits: list[float] = []
    certain = True
    for _ in range(
        3 * times
    ):  # a busy machine may trip a loop before it is killed: that one does not count
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
    return Finding(
        "kill -9 of the loop", len(waits), "zero within 20 ms", _spread(waits), passed, certain
    )


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
    with (
        preloaded(WALL_CLOCK),
        running(MODEL, "--orders", "0") as now,
        tempfile.TemporaryDirectory() as folder,
    ):
        moved = float(
            subprocess.run(
                [sys.executable, "-c", ask], capture_output=True, text=True, check=True
            ).stdout
        )
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
    whole = bool(
        (np.abs(periods - np.rint(periods)) < 1e-3).all()
        and (periods > 0.5).all()
        and periods.max() < 1e3
    )
    jumps, jumped = int(moved > 7000.0), count_of(kept["events"], "clock-jump")
    in_order = bool(jumps) and gaps == 0 and len(kept["seq"]) > samples and whole
    # A machine that stops the rig for 50 ms moves its stamps, now and then; the wall clock moved many times.
    certain = in_order and jumped < samples / 200 and (on or held_up)
    said = f"{gaps} missing of {len(kept['seq'])}, stamps in step: {whole}, {jumped} jumps, loop {why or 'on'}"
    passed = certain and on and jumped == 0
    return Finding(
        "wall clock jumps", round(samples / 100), "nothing changes", said, passed, certain
    )


def tried_again(fault: Callable[[], Finding], times: int = 3) -> Finding:
    """A finding in which a delay of the machine alone failed does not count, as long as there are tries left."""
    found = fault()
    while times > 1 and found.certain and not found.passed:
        found, times = fault(), times - 1
    return found


#: Starts what follows as a child, and waits: somebody to kill.
_PARENT = "import subprocess, sys; subprocess.run(sys.argv[1:], check=False)"


def orphaned() -> Finding:
    """The loop's parent is killed."""
    with running(MODEL, wrapper=(sys.executable, "-c", _PARENT)) as now:
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
        until(
            lambda: now.reader.counts["order-refused"] >= number // 5, 10.0
        )  # at most four are read a step
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
    return Finding(
        "crash in the model",
        1,
        "zero by the loop's handler",
        said,
        certain and wait <= 0.010,
        certain,
    )


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
            spec = {
                "kind": "replay",
                "angles": str(angles),
                "period": 1e-3,
                "session": 42,
                "device": chosen().device,
            }
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
                certain &= (
                    tripped
                    and now.loop.poll() is None
                    and int(on[-1] - fresh[-1]) <= STEPS_WITH_FIELD
                )
            rig.kill()
            rig.communicate()
    said = f"{_spread(waits)}; tripped and running: {certain}"
    passed = certain and len(waits) == times and max(waits) <= 0.020 + SLACK
    return Finding(
        "kill -9 of the rig", len(waits), "zero within 20 ms, loop goes on", said, passed, certain
    )


def bad_configurations(number: int) -> Finding:
    """Configurations with bytes changed or cut: refused before anything moves."""
    rng = random.Random(11)
    whole = config_of(chosen())[0]
    codes: dict[int, int] = {}
    with tempfile.TemporaryDirectory(dir=ring_folder()) as name:
        ring = make_ring(Path(name) / "ring", RingInfo(capacity=16))
        for _ in range(number):
            (Path(name) / "config").write_bytes(mutated(whole, rng))
            words = [
                "--config",
                f"{name}/config",
                "--ring",
                str(ring),
                "--udp",
                "127.0.0.1",
                "9",
                "0",
                "1",
            ]
            done = subprocess.run(
                [str(loop_program()), *words], capture_output=True, timeout=10, check=False
            )
            codes[done.returncode] = codes.get(done.returncode, 0) + 1
    said = ", ".join(f"exit {code}: {n}" for code, n in sorted(codes.items()))
    return Finding(
        "damaged configurations", number, f"exit 2: {number}", said, codes == {2: number}
    )


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
    return Finding(
        "damaged models", number, "0 accepted, 0 other errors", said, accepted + crashed_by == 0
    )


#: What does not depend on the control.
ALIKE = {
    "forged",
    "both-fields",
    "too-high",
    "not-finite",
    "slew",
    "orders-noise",
    "models",
    "configurations",
}
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
