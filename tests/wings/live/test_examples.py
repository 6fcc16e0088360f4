"""The example peers are rigs: the loop tracks with each of them; and the C is clean under sanitizers."""

from __future__ import annotations

import random
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.wings.live.c_build import SOURCES, build
from erclutch.wings.live.orders import Order, order_bytes
from erclutch.wings.live.ring import RingInfo, RingReader, State, make_ring
from erclutch.wings.live.session import Session, SessionOptions
from erclutch.wings.live.settings import LoopProgram, LoopSettings, Mode, Waveform, config_of
from erclutch.wings.rig.rig_plugins import UdpRig

pytestmark = pytest.mark.timed

HERE = Path(__file__).parent
PEERS = HERE.parents[2] / "examples" / "udp_rig"
SINE = LoopProgram("sine", Mode.TRACK, Waveform.SINE, 5.0, 1.0, motor_torque=0.1)


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def _taken(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as tried:
        try:
            tried.bind(("127.0.0.1", port))
        except OSError:
            return True
    return False


@contextmanager
def peer(words: list[str]) -> Iterator[int]:
    port = _free_port()
    with subprocess.Popen([*words, str(port), "42"]) as process:
        try:
            limit = time.monotonic() + 30.0
            while not _taken(port):
                assert time.monotonic() < limit, "the peer does not listen"
                time.sleep(0.02)
            yield port
        finally:
            process.kill()


def _with_peer(words: list[str]) -> tuple[RingReader, Any]:
    with peer(words) as port:
        rig = UdpRig("peer", "127.0.0.1", port, 42)
        with Session(
            rig, LoopSettings(programs=(SINE,), late_trip=5.0), None, SessionOptions(seconds=3.0)
        ) as session:
            reader = session.reader()
            while session.running:
                if reader.state is State.TRIPPED:
                    session.run_again()
                time.sleep(0.01)
            assert session.wait(20.0) == 0
            return reader, reader.read()


def _tracked(frames: Any, settling: int = 800) -> Any:
    """Frames that follow on so many without a trip: it takes that long to follow the reference."""
    running = np.isfinite(frames["reference"]).astype(int)
    before = np.convolve(running, np.ones(settling, int))[: len(frames)]
    return frames[before == settling]


@pytest.mark.slow
@pytest.mark.parametrize("language", ["C", "Python"])
def test_the_loop_tracks_with_a_peer(language: str) -> None:
    if language == "C":
        program = build(
            "peer",
            [PEERS / "peer.c", SOURCES / "erc_packet.c"],
            flags=("-Wextra", "-Werror", f"-I{SOURCES}"),
        )
        words = [str(program)]
    else:
        words = [sys.executable, str(PEERS / "peer.py")]
    settled: list[Any] = []
    for _ in range(
        10
    ):  # a machine that holds the peer up for 20 ms trips the loop: it is reset, and follows anew
        reader, frames = _with_peer(words)
        settled.append(_tracked(frames))
        if sum(map(len, settled)) > 1000:  # one period of the reference
            break
    assert reader.info.origin == "HARDWARE"
    followed = np.concatenate(settled)
    assert len(followed) > 1000, reader.counts
    together = np.corrcoef(followed["reference"], followed["alpha"])[0, 1]
    assert together > 0.9
    assert 3.0 < np.ptp(followed["alpha"]) / 2 < 8.0  # of an amplitude of 5 rad
    assert np.nanstd(followed["torque"]) > 0.001


@pytest.mark.slow
def test_loop_under_sanitizers(bingham: Path) -> None:
    """Address and undefined-behaviour sanitizers; the rig sends noise and damaged packets as well as good ones."""
    flags = (
        "-g",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
        "-Wextra",
        "-Wsign-conversion",
        "-Werror",
    )
    program = build(
        "loop-sanitized", sorted(SOURCES.glob("*.c")), libraries=("-lm", "-ldl"), flags=flags
    )
    from erclutch.wings.rig.packet import SensorPacket, pack_sensors

    rng = random.Random(1)
    with (
        tempfile.TemporaryDirectory() as name,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as rig,
    ):
        folder = Path(name)
        rig.bind(("127.0.0.1", 0))
        rig.setblocking(False)
        torque = LoopProgram("torque", Mode.TORQUE, Waveform.SQUARE, 0.1, 50.0, motor_torque=0.1)
        (folder / "config").write_bytes(
            config_of(LoopSettings(programs=(SINE, torque), theta_wrap=1.0))[0]
        )
        ring = make_ring(folder / "ring", RingInfo(capacity=64))
        words = [
            "--config",
            f"{folder}/config",
            "--ring",
            str(ring),
            "--udp",
            "127.0.0.1",
            str(rig.getsockname()[1]),
        ]
        loop = subprocess.Popen(
            [
                str(program),
                *words,
                "0",
                "5",
                "--model",
                str(bingham),
                "0" * 63 + "1",
                "--orders",
                "0",
            ],
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        assert loop.stdin is not None
        reader, seq = RingReader(ring), 0
        try:
            limit = time.monotonic() + 60.0
            while (
                (reader.head < 2500 or seq < 2000)
                and time.monotonic() < limit
                and loop.poll() is None
            ):
                time.sleep(0.0005)
                try:
                    _, sender = rig.recvfrom(100)
                except BlockingIOError:
                    continue
                seq += rng.choice((1, 1, 1, 1, 0, 2, 3))
                angle = rng.choice(
                    (0.04 * seq, 0.04 * seq % 1.0, float("nan"), 1e308, -float("inf"))
                )
                good = pack_sensors(
                    SensorPacket(
                        5, seq, rng.randrange(2**64), angle, rng.gauss(0, 1), 0.1, rng.randrange(4)
                    )
                )
                bad = bytearray(good)
                bad[rng.randrange(64)] ^= rng.randrange(1, 256)
                for data in rng.choice(
                    ((good,), (bytes(bad), good), (good, rng.randbytes(rng.randrange(200))))
                ):
                    rig.sendto(data, sender)
                loop.stdin.write(order_bytes(Order(rng.randrange(2, 6)), rng.uniform(-3, 3)))
                loop.stdin.flush()
            loop.stdin.write(order_bytes(Order.STOP))
            loop.stdin.flush()
            _, said = loop.communicate(timeout=10)
        finally:
            loop.kill()
    assert loop.returncode == 0, said.decode()
    assert reader.state is State.STOPPED
    assert reader.head > 1000
    assert reader.counts["bad-packet"] > 50
    assert reader.counts["order"] > 50
