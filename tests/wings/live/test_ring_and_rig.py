"""What the loop's C makes of a ring file and of packets, without the loop: each check by itself."""

from __future__ import annotations

import ctypes
import os
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.wings.live import session
from erclutch.wings.live.c_build import SOURCES, build
from erclutch.wings.live.layout import COMMAND, CONSTANTS, FRAME, HEADER, SAMPLE

_OPENS = """#include <stdio.h>
#include "erc_ring.h"
int main(int count, char **words) {
    erc_ring ring = erc_ring_open(words[count - 1]);
    erc_frame frame = {0};
    frame.events = 5u;
    erc_ring_write(&ring, &frame);
    printf("%u %u %u", (unsigned)ring.capacity, (unsigned)ring.head, (unsigned)ring.frames[0].events);
    return 0;
}
"""


@pytest.fixture(scope="module")
def opens(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A program that opens a ring and writes a frame."""
    source = tmp_path_factory.mktemp("ring") / "opens_a_ring.c"
    source.write_text(_OPENS)
    own = [SOURCES / f"erc_{name}.c" for name in ("ring", "start")]
    return build("erclutch-test-ring", [source, *own], libraries=("-ldl",), flags=(f"-I{SOURCES}",))


def ring(path: Path, frames: int = 4, **other: int) -> Path:
    header = np.zeros(1, HEADER)
    named = {"magic": CONSTANTS["ERC_RING_MAGIC"], "version": CONSTANTS["ERC_RING_VERSION"]}
    for name, value in {**named, "frame_size": FRAME.itemsize, "capacity": frames, **other}.items():
        header[name] = value
    path.write_bytes(header.tobytes() + bytes(frames * FRAME.itemsize))
    return path


@pytest.mark.slow
def test_a_ring_is_opened_and_written(opens: Path, tmp_path: Path) -> None:
    for frames in (2, 4):
        path = ring(tmp_path / "ring", frames)
        done = subprocess.run([opens, path], capture_output=True, text=True, check=True)
        assert done.stdout == f"{frames} 1 5"
        header = np.frombuffer(path.read_bytes()[: HEADER.itemsize], HEADER)[0]
        assert header["head"] == 1
        assert header["counts"][:4].tolist() == [1, 0, 1, 0]


@pytest.mark.parametrize(
    "wrong",
    [
        {"magic": 1},
        {"version": 1},
        {"frame_size": FRAME.itemsize - 8},
        {"capacity": 5},
        {"frames": 1},
        {"cut": 1},
    ],
)
def test_another_file_is_no_ring(opens: Path, tmp_path: Path, wrong: dict[str, int]) -> None:
    path = ring(tmp_path / "ring", **{k: v for k, v in wrong.items() if k != "cut"})
    if "cut" in wrong:
        path.write_bytes(path.read_bytes()[: HEADER.itemsize - 1])
    done = subprocess.run([opens, path], capture_output=True, text=True, check=False)
    assert done.returncode > 0
    assert "is no ring of version" in done.stderr


class Rig(ctypes.Structure):
    """As `erc_rig` in C."""

    _fields_ = (
        *(
            (name, ctypes.c_int if name == "socket" else ctypes.c_uint32)
            for name in ("socket", "session", "device")
        ),
        *((name, ctypes.c_void_p) for name in ("itself", "read", "write", "close")),
    )


@pytest.fixture(scope="module")
def library() -> ctypes.CDLL:
    own = [SOURCES / f"erc_{name}.c" for name in ("rig", "packet", "start")]
    made = ctypes.CDLL(str(build("erclutch-test-rig.so", own, shared=True, libraries=("-ldl",))))
    made.erc_rig_udp.restype = Rig
    return made


@pytest.fixture
def there() -> Iterator[socket.socket]:
    """A rig that answers."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.bind(("127.0.0.1", 0))
        made.settimeout(5.0)
        yield made


@pytest.mark.slow
def test_packets_of_another_rig_are_dropped_and_counted(
    library: ctypes.CDLL, there: socket.socket
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = [str(word).encode() for word in ("127.0.0.1", there.getsockname()[1], port, 7)]
    rig = library.erc_rig_udp(*words, ctypes.c_uint32(1))
    samples, events = np.zeros(CONSTANTS.get("ERC_MOST_SAMPLES", 64), SAMPLE), ctypes.c_uint32(0)

    def received() -> int:
        events.value = 0
        return int(
            library.erc_rig_receive(
                ctypes.byref(rig), ctypes.c_void_p(samples.ctypes.data), ctypes.byref(events)
            )
        )

    def packet(seq: int, session: int = 7, device: int = 1) -> bytes:
        sample, out = np.zeros(1, SAMPLE), ctypes.create_string_buffer(64)
        sample["seq"], sample["device"] = seq, device
        library.erc_put_sample(out, ctypes.c_uint32(session), ctypes.c_void_p(sample.ctypes.data))
        return out.raw

    command = np.zeros(1, COMMAND)
    assert library.erc_rig_send(ctypes.byref(rig), ctypes.c_void_p(command.ctypes.data)) == 0
    asked, back = there.recvfrom(100)
    assert len(asked) == 64
    assert (received(), events.value) == (0, 0)
    for data in (packet(3), packet(4)):
        there.sendto(data, back)
    assert (received(), events.value) == (2, 0)
    assert samples["seq"][:2].tolist() == [3, 4]
    bad = CONSTANTS["ERC_BAD_PACKET"]
    for wrong in (
        packet(5, session=8),
        packet(5, device=0),
        packet(5)[:-1],
        packet(5) + b"0",
        bytes(64),
    ):
        there.sendto(wrong, back)
        there.sendto(packet(6), back)
        assert (received(), events.value) == (1, bad)
        assert samples["seq"][0] == 6
    for seq in range(70):
        there.sendto(packet(seq), back)
    assert [received(), received(), received()] == [64, 6, 0]
    address = there.getsockname()
    there.close()  # the next command is refused, and a packet behind that is still read
    library.erc_rig_send(ctypes.byref(rig), ctypes.c_void_p(command.ctypes.data))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as again:
        again.bind(address)
        again.sendto(packet(9), back)
        assert (received(), events.value) == (1, 0)
        assert samples["seq"][0] == 9
    library.erc_rig_end(ctypes.byref(rig))


def test_a_folder_that_another_session_takes_for_left_over_is_made_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of two sessions that began at one moment one ended with "No such file", its folder not yet locked."""
    make, made = tempfile.mkdtemp, list[str]()

    def mkdtemp(**options: Any) -> str:
        made.append(make(**options))
        if len(made) == 1:
            os.rmdir(made[0])
        return made[-1]

    monkeypatch.setattr(tempfile, "mkdtemp", mkdtemp)
    folder, lock = session.own_folder()
    os.close(lock)
    folder.rmdir()
    assert [str(folder)] == made[1:]
