"""Whole sessions: rigs, replay, library, compilers; and the rig's side of the packets."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import ErclutchError, SettingError
from erclutch.export import ExportOptions, step_of
from erclutch.export.c.compiled_model import CompiledModel
from erclutch.export.exported_step import ADAPTED, LIMITED, NON_FINITE
from erclutch.export.step_numbers import run
from erclutch.logs import read_table
from erclutch.logs.dataset import Dataset
from erclutch.models.load import load_model
from erclutch.signals.channels import channels_of
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import elements_of
from erclutch.wings.live.c_build import SOURCES, CompilerError, build
from erclutch.wings.live.layout import EVENT_BITS, EVENTS, FRAME
from erclutch.wings.live.live_model import live_model
from erclutch.wings.live.orders import Order
from erclutch.wings.live.ring import RingError, RingInfo, RingReader, State, make_ring
from erclutch.wings.live.session import (
    TWIN,
    LiveError,
    LiveModel,
    ServedRig,
    Session,
    SessionOptions,
)
from erclutch.wings.live.session_figures import Histogram, SessionFigures
from erclutch.wings.live.settings import REST, LoopProgram, LoopSettings, Mode, Waveform
from erclutch.wings.rig.interface import Measurement, RigCommand
from erclutch.wings.rig.packet import (
    LAST,
    WATCHDOG,
    CommandPacket,
    SensorPacket,
    pack_command,
    pack_sensors,
    unpack_command,
    unpack_sensors,
)
from erclutch.wings.rig.rig_plugins import LibraryRig, UdpRig, udp_rig
from erclutch.wings.rig.rig_server import WATCHDOG_TIME, RigEnd, RigServer
from erclutch.wings.rig.twin.parameters import load_rig
from erclutch.wings.rig.twin.twin import Twin

pytestmark = pytest.mark.timed

HERE = Path(__file__).parent
DIGEST = "0" * 63 + "1"
PUSH = LoopProgram("push", Mode.TRACK, amplitude=1000.0, motor_torque=0.1)


def replayed(folder: Path, rows: int) -> tuple[ServedRig, Any]:
    t = 1e-3 * np.arange(rows)
    angles = np.column_stack([40.0 * t, 5.0 * np.sin(2.0 * np.pi * t), 0.1 * np.cos(t)])
    np.save(folder / "angles.npy", angles)
    return ServedRig(
        "a log",
        "RECORDING",
        {"kind": "replay", "angles": str(folder / "angles.npy"), "period": 1e-3},
    ), angles


def collected(session: Session) -> Any:
    reader, frames = session.reader(), []
    while session.running:
        frames.append(reader.read())
        if reader.state is State.TRIPPED:  # a busy machine holds the rig up for 21 samples
            session.run_again()
        if not session.rig_running:
            session.order(Order.STOP)
        time.sleep(0.02)
    frames.append(reader.read())
    assert reader.lost == 0
    return np.concatenate(frames)


@pytest.mark.slow
def test_replay_estimates_what_the_model_says(tmp_path: Path, bingham: Path) -> None:
    """The estimate made live is the offline one, sample for sample: fields of the recording with its own speeds."""
    rows = 600
    rig, angles = replayed(tmp_path, rows)
    wave = 0.4 * np.sin(2.0 * np.pi * 3.0 * 1e-3 * np.arange(rows))
    commands = np.column_stack([np.maximum(wave, 0), np.maximum(-wave, 0), np.full(rows, 0.1)])
    program = LoopProgram("recording", Mode.FIELDS, Waveform.TABLE, table=commands, by_sample=True)
    settings = LoopSettings(
        programs=(program,),
        rise_rate=1e9,
        fall_rate=1e9,
        theta_glitch=0.0,
        alpha_glitch=0.0,
        late_trip=5.0,
    )
    with Session(rig, settings, LiveModel(bingham, "bingham-by-hand", DIGEST)) as session:
        frames = collected(session)
        assert session.origin == "RECORDING"
    fresh = frames[(frames["events"] & 1) == 0]  # a step without a new sample repeats the last one
    row = np.rint(fresh["theta"] / 0.04).astype(int)
    assert len(np.unique(row)) > 10
    np.testing.assert_allclose(fresh["alpha"], angles[row, 1], atol=1e-12)
    running = (fresh["events"] & ((1 << 10) | (1 << 21))) == 0
    applied = fresh["field1"] - fresh["field2"]
    on = running & (applied != 0.0)
    assert on.sum() > 5
    np.testing.assert_array_equal(applied[on], wave[row][on])
    offline = CompiledModel(bingham)
    for frame in fresh[running]:
        inputs = [float(frame[n]) for n in ("field1", "field2", "theta_dot", "alpha_dot")]
        assert (offline.step(*inputs), offline.flags) == (frame["estimate"], frame["flags"])


@cache
def _fitted(name: str) -> str:
    """The file of a law or a network with a lag and a Dahl memory, fitted to a log of the TWIN, once for all tests."""
    from erclutch.fit.comparison import Settings, compare
    from erclutch.logs.dataset import build_dataset
    from erclutch.models.networks.network_model import NetworkModel
    from erclutch.wings.rig.twin.scenarios import prepare

    data = build_dataset(prepare("training", seconds=10.0).recording(), device="coaxial")
    model = compare(data, Settings(models=(name,), lag="none")).entries[0].outcome.model
    if isinstance(
        model, NetworkModel
    ):  # a rig at rest is outside its training: the guess there is not to be limited
        model = replace(model, trained_on=replace(model.trained_on, effort=(-10.0, 10.0)))
    return json.dumps(model.to_dict())


@contextmanager
def _any_rig(kind: str, folder: Path) -> Iterator[Any]:
    if kind == "replay":
        yield replayed(folder, 1500)[0]
    elif kind == "twin":
        yield TWIN
    else:
        server = RigServer(Twin(load_rig(None)), session=7, lead=0.01)
        stop = threading.Event()
        thread = threading.Thread(target=server.run, args=(stop.is_set,))
        thread.start()
        yield udp_rig(f"127.0.0.1:{server.port}", 7)
        stop.set()
        thread.join()


def _resets(frames: Any) -> Any:
    """The frames with which the loop and its model begin anew: the first order after each trip."""
    events = frames["events"]
    trips = np.flatnonzero(events & EVENT_BITS["trip"])
    orders = np.flatnonzero(events & EVENT_BITS["order"])
    after = np.searchsorted(orders, trips, side="right")
    return np.unique(orders[after[after < orders.size]])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *(("bingham+lag+dahl/field", kind) for kind in ("twin", "replay", "udp", "twin, held up")),
        *(("fnn-16+lag+dahl-2", kind) for kind in ("twin", "replay")),
        ("bingham+lag+dahl/field", "twin, adapting"),
    ],
)
def test_a_model_with_memory_estimates_what_predict_says(
    kind: str, name: str, tmp_path: Path
) -> None:
    """However late some rows were, the estimates have the bits of the step, and those of `effort` inside all ranges.

    With adaptation the bits are those of the step that adapts. A reset after a trip begins the model anew.
    """
    kind, _, how = kind.partition(", ")
    adapt, held_up = how == "adapting", how == "held up"
    path = tmp_path / "model.json"
    path.write_text(_fitted(name))
    model = load_model(path)
    steps = LoopProgram(
        "sine", Mode.FIELDS, Waveform.SINE, amplitude=0.4, frequency=5.0, motor_torque=0.1
    )
    settings = LoopSettings(programs=(steps,), late_trip=5.0, theta_glitch=0.0, alpha_glitch=0.0)
    live = live_model(path, "coaxial", adapt=adapt)
    with (
        _any_rig(kind, tmp_path) as rig,
        Session(rig, settings, live, SessionOptions(seconds=1.2)) as session,
    ):
        if held_up:
            _until(lambda: session.reader().state is State.RUNNING)
            time.sleep(0.6)
            assert session._rig is not None
            for order in (signal.SIGSTOP, signal.SIGCONT):
                session._rig.send_signal(order)
                time.sleep(0.06)
        frames = collected(session)
    frames = frames[np.flatnonzero(np.isfinite(frames["estimate"]))[0] :]
    starts = _resets(frames)
    assert starts.size > 0 or not held_up
    rows = np.column_stack(
        [frames[name] for name in ("field1", "field2", "theta_dot", "alpha_dot")]
    )
    not_used = ("sample-lost", "sample-invalid", "glitch", "torque-doubted")
    lost = (frames["events"] & sum(EVENT_BITS[name] for name in not_used)) != 0
    # The loop's model watches its own residual. A clutch at one speed passes on whatever is asked of it: no residual.
    slips = np.abs(rows[:, 2:3] * np.array([1.0, -1.0]) - rows[:, 3:]) > settings.least_slip
    field = frames["field1"] - frames["field2"]
    slipping = np.where(
        field > 0.0, slips[:, 0], np.where(field < 0.0, slips[:, 1], slips.all(axis=1))
    )
    measured = np.where(lost | ~slipping, np.nan, frames["torque"])
    step = step_of(model, ExportOptions("m", period=1e-3, alarms=True, adapt=adapt))
    parts = [run(step, part) for part in np.split(np.column_stack([rows, measured]), starts)]
    effort, flags = (np.concatenate(column) for column in zip(*parts, strict=True))
    assert frames.size > 500
    assert np.ptp(frames["field1"]) > 0.2
    np.testing.assert_array_equal(frames["estimate"], effort)
    np.testing.assert_array_equal(frames["flags"], flags)
    if adapt:
        assert live.name.endswith(", adapting")
        assert np.any(flags & ADAPTED)
        return
    elements = elements_of(
        "coaxial", dict(zip(("E1", "E2", "theta_dot", "alpha_dot"), rows.T, strict=True))
    )
    clock = Clock(1e-3 * np.arange(frames.size), (Span(0, frames.size, 1e-3),))
    data = Dataset("coaxial", tuple(elements), effort, clock, model.units)
    # A row far from training rows is told and not changed; a row beyond the ranges, or of an effort at its limit, is.
    changed = replace(model.trained_on, near=()).outside(data) | (
        (flags & (LIMITED | NON_FINITE)) != 0
    )
    inside = int(np.argmax(changed)) if changed.any() else frames.size
    inside = min([inside, *starts])
    assert inside > 300
    np.testing.assert_array_equal(
        frames["estimate"][:inside], model.effort(elements, clock)[:inside]
    )


@pytest.mark.slow
def test_library_rig_and_its_fault() -> None:
    library = build("rig.so", [HERE / "rig_library.c"], shared=True, flags=("-I", str(SOURCES)))
    with Session(
        LibraryRig("mine", library, "200"), LoopSettings(programs=(PUSH,), late_trip=5.0), None
    ) as session:
        reader = session.reader()
        _until(lambda: reader.state is State.TRIPPED)
        assert reader.trip_reason == "rig-fault"
        assert session.origin == "HARDWARE"
        frames = reader.read()
        assert (frames["field1"][10:190] > 0.4).all()
        assert frames["field1"][-1] == 0.0
    words = {"position": "stroke [m]", "field": "current [A]", "effort": "force [N]"}
    one = LibraryRig("mine", library, "200", device="single", channels=words)
    assert one.named is not None
    channels = one.named.of(channels_of("single", one.named.units, motor=one.named.motor))
    settings = LoopSettings(
        "single", programs=(LoopProgram("on", Mode.FIELDS, amplitude=0.4),), late_trip=5.0
    )
    with Session(one, settings, None, SessionOptions(channels=channels)) as session:
        reader = session.reader()
        _until(lambda: reader.state is State.TRIPPED)
        frames = reader.read()
    assert [str(c) for c in reader.info.channels[:3]] == [
        "position = stroke [m]",
        "slip [m/s]",
        "field = current [A]",
    ]
    assert (frames["field"][10:190] == 0.4).all()
    assert frames["slip"][150] == pytest.approx(40.0, rel=1e-3)
    assert np.nanmax(frames["effort"]) == 0.1
    with pytest.raises(LiveError, match="no such device: 0"):
        Session(LibraryRig("mine", library, "0"), LoopSettings(), None)


@pytest.mark.slow
def test_a_model_of_another_digest_is_refused(tmp_path: Path, bingham: Path) -> None:
    rig, _ = replayed(tmp_path, 10)
    with pytest.raises(LiveError, match="has digest"):
        Session(rig, LoopSettings(), LiveModel(bingham, "bingham", "f" * 64))
    with pytest.raises(LiveError, match="4 inputs"):
        Session(rig, LoopSettings(device="single"), LiveModel(bingham, "bingham", DIGEST))


@pytest.mark.slow
def test_orders_and_end(tmp_path: Path) -> None:
    rig, _ = replayed(tmp_path, 60_000)
    with Session(rig, LoopSettings(programs=(PUSH, REST), late_trip=60.0), None) as session:
        reader = session.reader()

        def running() -> bool:
            """The machine may trip it at any moment, by holding it up: then the operator runs it again."""
            if reader.state is State.TRIPPED:
                session.run_again()
            return reader.state is State.RUNNING

        def stopped_by_order() -> bool:
            """As above: an order is no reason where there is one already."""
            if reader.state is State.TRIPPED and reader.trip_reason != "order":
                session.run_again()
            session.order(Order.ZERO)
            return reader.trip_reason == "order"

        _until(lambda: running() and bool(reader.latest(1)["field1"][0] > 0))
        _until(stopped_by_order)
        _until(lambda: bool(reader.latest(1)["field1"][0] == 0.0))
        _until(running)
        session.order(Order.PROGRAM, 1.0)
        _until(lambda: reader.program == 1)
        session.stop()
        assert reader.state is State.STOPPED
        assert session.wait(0) == 0
        assert not session.order(Order.ZERO)
        ring = session.ring
    assert not ring.exists()


def _until(true: Callable[[], bool], seconds: float = 30.0) -> None:
    limit = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < limit
        time.sleep(0.005)


# --- the rig's side ---------------------------------------------------------------------------------------------------


@dataclass
class Fake:
    period: float = 1e-3
    commands: list[tuple[float, RigCommand]] = field(default_factory=list)
    rows: int = 0

    def sense(self) -> Measurement:
        return Measurement(0.0, float(self.rows), 0.0, 0.0, 0.5)

    def command(self, command: RigCommand) -> None:
        self.commands.append((time.monotonic(), command))

    def step(self) -> None:
        self.rows += 1

    def close(self) -> None:
        self.command(RigCommand())


@contextmanager
def served(fake: Fake) -> Iterator[tuple[RigServer, socket.socket]]:
    server = RigServer(fake, session=7, lead=0.01)
    stop = threading.Event()
    thread = threading.Thread(target=server.run, args=(stop.is_set,))
    thread.start()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as loop:
        loop.bind(("127.0.0.1", 0))
        loop.connect(("127.0.0.1", server.port))
        loop.settimeout(2.0)
        try:
            yield server, loop
        finally:
            stop.set()
            thread.join()


def _asked(
    loop: socket.socket, seq: int, field1: float = 0.3, session: int = 7, flags: int = 0
) -> Any:
    loop.send(pack_command(CommandPacket(session, seq, 0, field1, 0.0, 0.1, flags)))
    return unpack_sensors(loop.recv(100), 7)


def test_rig_answers_each_command_and_goes_on_alone() -> None:
    """In steps of the rig's own clock, which a busy machine makes longer, never shorter."""
    fake = Fake()
    with served(fake) as (server, loop):
        time.sleep(0.03)
        assert fake.rows == 0  # at rest until somebody speaks
        asked_at = time.monotonic()  # the rig hears it after that, and its clock runs from there
        first = _asked(loop, 1)
        assert (first.seq, first.theta, first.torque, first.status) == (1, 1.0, 0.5, 0)
        seen = [
            unpack_sensors(loop.recv(100), 7) for _ in range(40)
        ]  # no more commands: its own clock, its watchdog
        assert [p.seq for p in seen if p] == list(range(2, 42))
        status = [p.status for p in seen if p]
        on = status.index(WATCHDOG)
        assert on <= round(WATCHDOG_TIME / fake.period)
        assert status == [0] * on + [WATCHDOG] * (40 - on)
        _, (zero_at, zero) = fake.commands
        assert zero == RigCommand()
        assert zero_at - asked_at >= WATCHDOG_TIME
        assert server.counts["watchdog"] == 1


def test_rig_drops_what_is_not_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "erclutch.wings.rig.rig_server.WATCHDOG_TIME", 60.0
    )  # after it, packets of others are taken
    fake = Fake()
    with served(fake) as (server, loop):
        _asked(loop, 5)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.sendto(
                pack_command(CommandPacket(7, 99, 0, 0.5, 0.0, 0.1)), ("127.0.0.1", server.port)
            )
        for packet in (
            pack_command(CommandPacket(7, 5, 0, 0.5, 0.0, 0.1)),  # again
            pack_command(CommandPacket(7, 4, 0, 0.5, 0.0, 0.1)),  # late
            pack_command(CommandPacket(8, 6, 0, 0.5, 0.0, 0.1)),  # of another session
            b"x" * 64,
            b"",
            pack_command(CommandPacket(7, 7, 0, 0.5, 0.0, 0.1)) + b"x",
        ):
            loop.send(packet)
        _until(lambda: sum(server.counts[name] for name in ("stale", "foreign", "bad")) >= 7)
        assert {c.E1 for _, c in fake.commands} == {0.3}
        assert server.counts["stale"] == 2
        assert server.counts["foreign"] == 1
        assert server.counts["bad"] == 4
        assert server.counts["valid"] == 1
        _asked(loop, 8, flags=LAST)
        _until(lambda: fake.commands[-1][1] == RigCommand())
        assert server.counts["watchdog"] == 0


def test_another_loop_is_heard_after_the_watchdog() -> None:
    fake = Fake()
    with served(fake) as (server, loop):
        _asked(loop, 1000)
        _until(lambda: server.counts["watchdog"] == 1)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.connect(("127.0.0.1", server.port))
            other.settimeout(2.0)
            assert _asked(other, 1).status == 0
        assert server.counts["loops"] == 2


# --- names, compilers, figures ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text", ["", "10.0.0.1", "10.0.0.1:x", "host:5005", "10.0.0.1:0", "10.0.0.1:70000", "::1:5"]
)
def test_addresses_that_are_none(text: str) -> None:
    with pytest.raises(SettingError):
        udp_rig(text)


@pytest.mark.slow
def test_compiled_once_and_again_if_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ERCLUTCH_CACHE", str(tmp_path))
    source = HERE / "bingham.c"
    made = build("m.so", [source], shared=True)
    stamp = made.stat().st_mtime_ns
    assert build("m.so", [source], shared=True).stat().st_mtime_ns == stamp
    whole = made.read_bytes()
    made.write_bytes(whole[:100] + b"\0" + whole[101:])
    build("m.so", [source], shared=True)
    assert made.read_bytes() == whole
    assert sorted(p.name for p in made.parent.iterdir()) == ["m.so", "m.so.sha256"]


def test_a_compiler_that_fails_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ERCLUTCH_CACHE", str(tmp_path))
    wrong = tmp_path / "wrong.c"
    wrong.write_text("int main(void) { return nothing; }\n")
    with pytest.raises(CompilerError, match="nothing"):
        build("wrong", [wrong])


@pytest.mark.slow
def test_a_compiler_that_does_not_answer_is_passed_over(tmp_path: Path) -> None:
    """As cc on a Mac without its tools: it is there, and says only how to get them."""
    (tmp_path / "cc").write_text("#!/bin/sh\nexit 1\n")
    (tmp_path / "cc").chmod(0o755)
    script = "from erclutch.wings.live.c_build import find_compiler; print(find_compiler().name)"
    said = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        env={**os.environ, "PATH": str(tmp_path)},
    )
    assert said.stdout == "zig\n", said.stderr


@pytest.mark.slow
def test_live_with_zig_alone(tmp_path: Path) -> None:
    """No other compiler on the path, nothing in the cache: the loop and a model are compiled by the wheel, and run."""
    (tmp_path / "bin").mkdir()
    environment = {
        "PATH": str(tmp_path / "bin"),
        "ERCLUTCH_CACHE": str(tmp_path / "cache"),
        "CC": "",
    }
    words = ("--headless", "--seconds", "0.5", "--run", str(HERE / "model.json"), "--json")
    done = _cli(*words, **environment)
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    assert (figures["origin"], figures["exit"]) == ("TWIN", 0)
    assert figures["frames"] + figures["missed"] >= 500
    made = [
        file.name for file in (tmp_path / "cache").rglob("*") if not file.name.endswith(".sha256")
    ]
    assert "erclutch-loop" in made
    assert any(name.startswith("liblive-") for name in made)


@pytest.mark.slow
def test_no_compiler_at_all_is_one_sentence(tmp_path: Path) -> None:
    """Without compilers on the path and without the wheel."""
    hidden = "import sys; sys.modules['ziglang'] = None; import importlib.util as u; found = u.find_spec\n"
    hidden += (
        "u.find_spec = lambda name, *rest: None if name == 'ziglang' else found(name, *rest)\n"
    )
    script = f"{hidden}from erclutch.cli import main; sys.argv = ['erclutch', *sys.argv[1:]]; sys.exit(main())"
    for words in ((), ("--run", str(HERE / "model.json"))):
        done = subprocess.run(
            [sys.executable, "-c", script, "live", "--headless", *(words or ("--no-model",))],
            capture_output=True,
            text=True,
            timeout=100,
            env={
                **os.environ,
                "PATH": str(tmp_path),
                "CC": "",
                "ERCLUTCH_CACHE": str(tmp_path),
                "COLUMNS": "200",
            },
        )
        assert done.returncode != 0
        assert (
            done.stderr == 'error: there is no C compiler. Get one: pip install "erclutch[live]".\n'
        )


@pytest.mark.parametrize("late", [0, 2, 5])
def test_a_trip_on_a_busy_machine_says_so(late: int, tmp_path: Path, ring_writer: Any) -> None:
    ring = make_ring(tmp_path / "ring", RingInfo(capacity=64))
    writer, watch = ring_writer(ring), SessionFigures(RingReader(ring, "oldest"))
    frame = np.zeros((), FRAME)
    for tick in range(20):
        frame["time_ns"] = 10**9 + tick * 1_000_000
        frame["events"] = (
            EVENT_BITS["trip"] if tick == 19 else EVENT_BITS["sample-lost"] if tick < late else 0
        )
        frame["lateness_ns"] = 7_900_000
        writer.write(frame)
        watch.poll()
    assert watch.busy.startswith(
        "This machine was busy: in the second before, 5 samples" if late == 5 else ""
    )
    assert bool(watch.busy) == (late == 5)


@pytest.mark.parametrize(
    ("origin", "late_from", "at_fault"),
    [
        ("HARDWARE", 40, "The rig was silent"),
        ("HARDWARE", 35, "The rig was silent"),
        ("HARDWARE", 20, "This machine was busy"),
        ("TWIN", 40, "This machine was busy"),
    ],
)
def test_a_trip_by_a_silent_rig_is_not_blamed_on_the_machine(
    origin: str,
    late_from: int,
    at_fault: str,
    tmp_path: Path,
    ring_writer: Any,
) -> None:
    """A device behind UDP that was unplugged was told as a busy machine, though each step was on time."""
    ring = make_ring(tmp_path / "ring", RingInfo(capacity=64, origin=origin))
    writer, watch = ring_writer(ring), SessionFigures(RingReader(ring, "oldest"))
    frame = np.zeros((), FRAME)
    for tick in range(40):
        frame["time_ns"] = 10**9 + tick * 1_000_000
        frame["lateness_ns"] = 7_900_000 if tick >= late_from else 80_000
        lost = EVENT_BITS["sample-lost"] * (tick >= 19)
        late = EVENT_BITS["overrun"] * (tick >= late_from)
        frame["events"] = lost | late | EVENT_BITS["trip"] * (tick == 39)
        writer.write(frame)
    watch.poll()
    assert watch.busy.startswith(f"{at_fault}: in the second before, 21 samples of the rig")


def test_a_step_that_took_long_is_not_called_late_by_nothing(
    tmp_path: Path, ring_writer: Any
) -> None:
    """ "by up to 0.0 ms" stood there: the step before woke up in time, and then took long."""
    ring = make_ring(tmp_path / "ring", RingInfo(capacity=64))
    writer, watch = ring_writer(ring), SessionFigures(RingReader(ring, "oldest"))
    frame = np.zeros((), FRAME)
    for tick in range(20):
        frame["time_ns"] = 10**9 + tick * 1_000_000
        frame["events"] = (
            EVENT_BITS["trip"]
            if tick == 19
            else EVENT_BITS["overrun"]
            if tick in (3, 5, 7, 9)
            else 0
        )
        frame["lateness_ns"] = 0
        writer.write(frame)
    watch.poll()
    # Nothing is said of samples: none was lost.
    assert "in the second before, 4 steps came late. Close other programs" in watch.busy


def test_the_estimate_is_judged_where_both_are_known(tmp_path: Path, ring_writer: Any) -> None:
    ring = make_ring(tmp_path / "ring", RingInfo(capacity=64))
    writer, watch = ring_writer(ring), SessionFigures(RingReader(ring, "oldest"))
    assert watch.estimated is None
    frame = np.zeros((), FRAME)
    for estimate, torque in ((1.5, 2.0), (2.5, 2.0), (np.nan, 9.0), (9.0, np.nan)):
        frame["estimate"], frame["torque"] = estimate, torque
        writer.write(frame)
    watch.poll()
    assert watch.estimated == pytest.approx((0.5, 2.0))


def test_figures_in_bounded_memory(tmp_path: Path, ring_writer: Any) -> None:
    histogram = Histogram()
    histogram.add(np.array([-5000, 1500, 2500, 300_000_000]))
    assert histogram.percentiles((0.5, 1.0)) == [2.0, 100_000.0]
    assert histogram.largest == 300_000.0
    assert np.isnan(Histogram().percentiles((0.5,))[0])
    one = Histogram()
    one.add(np.array([1500]))
    assert one.percentiles((0.999,)) == [1.5]  # never above the largest
    ring = make_ring(tmp_path / "ring", RingInfo(capacity=64))
    writer, watch = ring_writer(ring), SessionFigures(RingReader(ring, "oldest"), "effort")
    frame = np.zeros((), FRAME)
    frame["reference"] = 0.4
    for tick in (0, 1, 2, 5, 6):
        frame["time_ns"] = 10**9 + tick * 1_000_000 + 40_000
        frame["lateness_ns"] = 40_000
        frame["torque"] = np.nan if tick == 2 else 0.1  # a sensor that is silent counts for nothing
        writer.write(frame)
    watch.poll()
    assert (watch.frames, watch.lateness.largest) == (5, 40.0)
    assert watch.followed == pytest.approx((0.3, 0.4))
    assert SessionFigures(RingReader(ring, "oldest")).followed is None
    frame["theta"], frame["alpha"] = 100.0, 0.5  # the motor turns on, the output is to follow
    writer.write(frame)
    angle = SessionFigures(RingReader(ring), "position")
    writer.write(frame)
    angle.poll()
    assert angle.followed == pytest.approx((0.1, 0.4))
    assert angle.follower is not None
    assert angle.follower.label == "output"


def test_what_is_no_ring_of_this_version_is_refused(tmp_path: Path) -> None:
    ring = make_ring(tmp_path / "ring", RingInfo(capacity=64))
    whole = ring.read_bytes()
    for name in (b"time", b"lateness", b"step"):  # the page's own columns
        at = whole.index(b"theta\0")
        ring.write_bytes(whole[:at] + name.ljust(9, b"\0") + whole[at + 9 :])
        with pytest.raises(RingError, match="table of channels"):
            RingReader(ring)
    for at in (0, 7, 8, 12, 16):  # magic, version, size of a frame, capacity
        ring.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
        with pytest.raises(RingError, match="no ring of version"):
            RingReader(ring)
    ring.write_bytes(whole[:-1])
    with pytest.raises(RingError, match="no ring of version"):
        RingReader(ring)
    ring.write_bytes(whole)
    RingReader(ring).close()


# --- the command line -------------------------------------------------------------------------------------------------


def _cli(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "erclutch", "live", *words],
        capture_output=True,
        text=True,
        timeout=100,
        env={**os.environ, "COLUMNS": "200", **environment},
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--rig", "nothing"), "unknown rig 'nothing'"),
        (("--rig", "replay"), "Give --log FILE"),
        (
            ("--rig", "replay", "--log", "any.csv", "--field-limit", "1"),
            "--field-limit with a replay",
        ),
        (("--rig", "udp"), "the address of the rig is missing"),
        (("--seconds", "0"), "--seconds 0"),
        (("--priority", "100"), "--priority 100"),
        (("--no-model", "--program", "torque-sine"), "there is no program 'torque-sine'"),
        (("--no-model", "--field-limit", "2"), "--field-limit 2"),
        (
            ("--no-model", "--rig", "udp", "--address", "127.0.0.1:9", "--field-limit", "0.6"),
            "at most the supply's 0.5",
        ),
        (("--run", "none.json"), "none.json"),
        (
            ("--no-model", "--stiffness", "9", "--damping", "0.004"),
            "Give at most 2 damping / period, 8 N m/rad",
        ),
        (("--no-model", "--stiffness", "nan"), "--stiffness 'nan' is no quantity in N*m/rad"),
        (
            ("--no-model", "--rig", "twin-brake", "--program", "impedance"),
            "there is no program 'impedance'",
        ),
    ],
)
def test_bad_words_get_one_sentence(
    words: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from erclutch.cli import app

    with pytest.raises(ErclutchError, match=said.split()[0]) as caught:
        app(["live", "--headless", *words], exit_on_error=False)
    assert said in str(caught.value)


@pytest.mark.slow
def test_a_replay_has_the_units_of_its_log_or_none(tmp_path: Path) -> None:
    for head, unit in (("E [V]", "V"), ("E", "?")):
        log = tmp_path / "log.csv"
        rows = "".join(
            f"{1e-3 * k:.3f},{0.02 * k:.2f},0,0.1,{100 * (-1) ** (k // 50)}\n" for k in range(300)
        )
        log.write_text(f"time [s],theta [rad],alpha [rad],T [N*m],{head}\n{rows}", encoding="utf-8")
        done = _cli(
            "--no-model", "--rig", "replay", "--log", str(log), "--device", "coaxial", "--headless"
        )
        assert done.returncode == 0, done.stderr
        assert f"field1 = CH1 [{unit}]" in done.stdout
        assert "rate-limited" not in done.stdout  # fields are what they were


def test_packets_of_another_device_are_dropped() -> None:
    """A rig that answers as the pair does is none for the loop of one brake."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wire:
        wire.bind(("127.0.0.1", 0))
        wire.settimeout(5.0)
        rig = UdpRig("pair", "127.0.0.1", wire.getsockname()[1], 3, device="single")
        with Session(rig, LoopSettings(device="single", late_trip=5.0), None) as session:
            reader = session.reader()
            for device in (0, 2, 1):
                bad, limit = reader.counts["bad-packet"], time.monotonic() + 20.0
                while time.monotonic() < limit and reader.sensor_seq == 0:
                    if device != 1 and reader.counts["bad-packet"] > bad + 5:
                        break
                    data, sender = wire.recvfrom(100)
                    asked = unpack_command(data, 3)
                    assert asked is not None
                    assert asked.device == 1
                    wire.sendto(
                        pack_sensors(SensorPacket(3, 1, 0, 0.1, 0.0, 0.2, 0, device)), sender
                    )
                assert reader.sensor_seq == (1 if device == 1 else 0)
            frames = session.reader().read()
    assert frames.dtype.names is not None
    assert frames.dtype.names[2:5] == ("position", "slip", "field")
    assert frames["position"][-1] == pytest.approx(0.1)


@pytest.mark.slow
def test_a_rig_that_does_not_answer() -> None:
    done = _cli(
        "--rig", "udp", "--address", "127.0.0.1:9", "--headless", "--seconds", "0.2", "--no-model"
    )
    assert done.returncode == 3
    assert "no sample came from the rig" in done.stderr


@pytest.mark.slow
def test_a_single_device_on_the_twin(tmp_path: Path) -> None:
    """A brake: one field, a motor that goes both ways, the law's estimate near the torque meter."""
    log = tmp_path / "brake.csv"
    erclutch = (sys.executable, "-m", "erclutch")
    fit = (
        "--models",
        "bingham",
        "--lag",
        "lag",
        "--derivative",
        "kalman",
        "--out",
        str(tmp_path / "run"),
    )
    for words in (
        ("simulate", "brake", "--seconds", "12", "--out", str(log)),
        ("fit", str(log), *fit),
    ):
        subprocess.run([*erclutch, *words], check=True, capture_output=True)
    (model,) = (tmp_path / "run" / "models").glob("bingham+lag.json")
    done = _cli(
        "--run",
        str(model),
        "--headless",
        "--seconds",
        "3",
        "--json",
        "--record",
        "--folder",
        str(tmp_path),
    )
    assert done.returncode == 0, done.stderr
    (file,) = tmp_path.glob("*.mcap")
    assert (
        read_table(file).columns["seq"][0] == 1.0
    )  # from the start, however late the recorder begins
    frames = {name: values[300:] for name, values in read_table(file).columns.items()}
    assert list(frames)[2:9] == [
        "position",
        "slip",
        "field",
        "drive",
        "effort",
        "estimate",
        "reference",
    ]
    assert np.max(frames["field"]) > 0.1
    assert np.min(frames["drive"]) < 0.0 < np.max(frames["drive"])
    off, spread = np.nanstd(frames["effort"] - frames["estimate"]), np.nanstd(frames["effort"])
    assert off < 0.5 * spread, (off, spread)
    figures = json.loads(done.stdout)
    assert 0.0 < figures["off_effort_rms"] < figures["effort_rms"]


@pytest.mark.slow
def test_live_on_the_twin(tmp_path: Path) -> None:
    """Whatever the machine does meanwhile: every deadline is a frame or a miss, and a trip has its reason on record."""
    words = ("--seconds", "2", "--no-model", "--json", "--record", "--folder", str(tmp_path))
    done = _cli("--headless", *words)
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    events = figures["events"]
    assert (figures["origin"], figures["exit"], figures["lost_by_reader"]) == ("TWIN", 0, 0)
    assert figures["frames"] + figures["missed"] >= 2000
    assert 0 <= events.get("overrun", 0) <= figures["missed"] <= 2000 * events.get("overrun", 0)
    assert events["stopping"] == 5
    assert figures["off_effort_rms"] is None  # no model estimates the torque
    (file,) = tmp_path.glob("*.mcap")
    assert any(f"recording {file.name} is complete" in note for note in figures["notes"]), figures[
        "notes"
    ]
    frames = read_table(file).columns
    assert np.all(np.diff(frames["seq"]) == 1)
    assert frames["seq"][-1] == figures["frames"] - 1
    if not figures["tripped"]:
        assert "trip" not in events
        return
    assert f"fields are held at zero: {figures['tripped']}" in done.stderr
    held_up = figures["lateness_us"][-1] > 10_000 or events.get("sample-lost", 0) > 10
    assert held_up, (figures, "a trip for which the loop recorded no delay")


@pytest.mark.slow
def test_json_is_one_document_whatever_goes_wrong() -> None:
    """A rig that falls silent after 200 steps: the trip is said on standard error alone."""

    class Ending(Fake):
        def step(self) -> None:
            if self.rows == 200:
                raise RigEnd
            super().step()

    server = RigServer(Ending(), session=7, lead=0.01)
    thread = threading.Thread(target=server.run, args=(lambda: False,))
    thread.start()
    address = f"127.0.0.1:{server.port}"
    done = _cli(
        *("--rig", "udp", "--address", address, "--session", "7", "--no-model"),
        *("--headless", "--seconds", "1", "--json"),
    )
    thread.join(10.0)
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    assert figures["origin"] == "HARDWARE"
    assert figures["tripped"] in (
        "sample-lost",
        "overrun",
        "rig-watchdog",
    )  # the latter: a machine that held it up
    meaning = dict(EVENTS)[figures["tripped"]]
    assert f"fields are held at zero: {figures['tripped']} ({meaning})" in done.stderr


def _session_in_a_process() -> subprocess.Popen[str]:
    """A session whose ring's folder is the first line that its process says."""
    words = "import time; from erclutch.wings.live.session import *\n"
    words += "from erclutch.wings.live.settings import LoopSettings\n"
    words += "with Session(TWIN, LoopSettings()) as session: print(session.ring.parent, flush=True); time.sleep(60)"
    return subprocess.Popen([sys.executable, "-c", words], stdout=subprocess.PIPE, text=True)


@pytest.mark.slow
def test_a_session_removes_what_a_killed_one_left_in_memory() -> None:
    with _session_in_a_process() as killed, _session_in_a_process() as alive:
        assert killed.stdout is not None
        assert alive.stdout is not None
        left, kept = (Path(said.readline().strip()) for said in (killed.stdout, alive.stdout))
        killed.kill()
        killed.wait()
        assert (left / "ring").exists()
        with Session(TWIN, LoopSettings()) as session:
            assert not left.exists()
            assert (kept / "ring").exists()
            assert session.ring.exists()
        alive.kill()
    with Session(TWIN, LoopSettings()):
        assert not kept.exists()


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP])
def test_a_signal_ends_in_order(number: int) -> None:
    """A closed terminal (SIGHUP) ended wherever Python was."""
    with subprocess.Popen(
        [sys.executable, "-m", "erclutch", "live", "--headless", "--no-model"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    ) as process:
        assert process.stdout is not None
        said = ""
        while "the rig answers" not in said:
            line = process.stdout.readline()
            assert line, said
            said += line
        process.send_signal(number)
        out, error = process.communicate(timeout=60)
    assert process.returncode == 0, error
    assert "stopping: 5" in out
    assert "  stopping: the loop is ending: fields to zero\n" in out
    assert "estimate off" not in out  # there is no model
