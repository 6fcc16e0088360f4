"""One frame a control step, and the ring in shared memory through which everybody but the loop reads them.

The loop is the only writer: frame first, then the head counter (release order). A reader polls the head, copies, and
looks again: what the writer may have reached meanwhile counts as lost. Each frame carries its own number, so a copy
that was torn in spite of that is found. The same layouts in C: ``c/erc_frame.h``; a test compares them.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ErclutchError

#: What the loop writes each step. NaN where there is no torque meter or no reference.
FRAME = np.dtype(
    [
        ("seq", "<u8"),  # number of the step, from 0
        ("time_ns", "<u8"),  # monotonic clock at the wake-up
        ("theta", "<f8"),  # motor, rad, unwrapped
        ("alpha", "<f8"),  # output, rad, unwrapped
        ("theta_dot", "<f8"),  # rad/s, by the causal filter
        ("alpha_dot", "<f8"),
        ("field1", "<f8"),  # applied: after the interlock
        ("field2", "<f8"),
        ("motor_torque", "<f8"),  # command, N m
        ("torque", "<f8"),  # measured, N m
        ("estimate", "<f8"),  # by the model, N m
        ("reference", "<f8"),  # of the trajectory: rad (tracking) or N m (torque control)
        ("flags", "<u4"),  # the model's, see FLAGS
        ("events", "<u4"),  # of this step, see EVENTS
        ("lateness_ns", "<i4"),  # wake-up after its deadline
        ("step_ns", "<u4"),  # from the wake-up to the command sent
    ]
)
#: Units of the columns of `FRAME`; empty where a number has none.
UNITS: Mapping[str, str] = {
    "seq": "",
    "time_ns": "ns",
    "theta": "rad",
    "alpha": "rad",
    "theta_dot": "rad/s",
    "alpha_dot": "rad/s",
    "field1": "",
    "field2": "",
    "motor_torque": "N*m",
    "torque": "N*m",
    "estimate": "N*m",
    "reference": "",
    "flags": "",
    "events": "",
    "lateness_ns": "ns",
    "step_ns": "ns",
}

#: Bits of ``events`` from bit 0 on: name, meaning. The header counts each over the whole session.
EVENTS: tuple[tuple[str, str], ...] = (
    ("sample-lost", "no new sample from the rig in this step"),
    ("sample-invalid", "a sensor value was not finite"),
    ("glitch", "an encoder jumped further than the device can move; the sample was not used"),
    ("wrap", "an encoder went over its range and was unwrapped"),
    ("bad-packet", "a packet with a wrong size, checksum, version or session was dropped"),
    ("stale-packet", "a duplicated or reordered packet was dropped"),
    ("clock-jump", "the rig's time stamps jumped"),
    ("overrun", "a deadline was missed by a whole period or more"),
    ("hold", "the last command was held for want of a sample"),
    ("degrade", "the command was reduced for want of samples"),
    ("trip", "fields went to zero and stay there until a reset"),
    ("both-fields", "both fields were asked for; the smaller gave way"),
    ("beyond-limit", "a field or motor torque beyond its limit was asked for and clipped"),
    ("rate-limited", "the field was held to the supply's rate"),
    ("command-not-finite", "control asked for a number that is not finite; it counts as zero"),
    ("rig-watchdog", "the rig itself had set the fields to zero: commands did not reach it in time"),
    ("rig-fault", "the rig reported a fault"),
    ("order", "an operator's order was carried out"),
    ("order-refused", "an operator's order was out of range or unknown"),
    ("unreachable", "the wanted torque is out of the model's reach"),
    ("send-failed", "the command could not be sent to the rig"),
    ("stopping", "the loop is ending: fields to zero"),
    ("guard", "the table came near an end stop: fields that drive it outward were refused"),
)
EVENT_BITS: Mapping[str, int] = {name: 1 << i for i, (name, _) in enumerate(EVENTS)}

#: Bits of ``flags``: what the model says of this step.
FLAGS: tuple[tuple[str, str], ...] = (
    ("outside", "outside the training range: the estimate is a guess"),
    ("not-finite", "an input was not finite: the estimate is that of the last good input"),
    ("both-fields", "both fields on"),
    ("limited", "output limited"),
    ("out-of-reach", "wanted effort out of reach"),
)

MAGIC = b"ERCRING1"
VERSION = 1
#: Frames start at this byte.
HEADER_SIZE = 4096
#: 65.5 s at 1 kHz, 7.3 MB.
CAPACITY = 1 << 16


class State(IntEnum):
    """How the loop is: ``running`` also while tripped (fields are then zero)."""

    STARTING = 0
    RUNNING = 1
    TRIPPED = 2
    STOPPED = 3


#: The ring's header. The loop writes what stands after ``head``; all else is set when the ring is made.
HEADER = np.dtype(
    {
        "names": [
            *("magic", "version", "frame_size", "capacity", "period_ns", "start_ns", "start_unix_ns"),
            *("rig", "origin", "model", "digest", "note", "field_limit", "motor_limit"),
            *("head", "state", "pid", "mode", "program", "trip_reason", "counts", "sensor_seq", "realtime"),
        ],
        "formats": [
            *("S8", "<u4", "<u4", "<u8", "<u8", "<u8", "<u8"),
            *("S64", "S16", "S64", "S64", "S256", "<f8", "<f8"),
            *("<u8", "<u4", "<u4", "<u4", "<u4", "<u4", ("<u8", (32,)), "<u8", "S128"),
        ],
        "offsets": [
            *(0, 8, 12, 16, 24, 32, 40),
            *(64, 128, 144, 208, 272, 528, 536),
            *(1024, 1032, 1036, 1040, 1044, 1048, 1088, 1344, 1408),
        ],
        "itemsize": HEADER_SIZE,
    }
)
ORIGINS = ("TWIN", "RECORDING", "HARDWARE")


class RingError(ErclutchError):
    """A ring cannot be made or is none."""


@dataclass(frozen=True)
class RingInfo:
    """What a session is, from the ring's header; set when the ring is made.

    Attributes:
        period_ns: of the loop.
        rig, origin: name of the rig, and TWIN, RECORDING or HARDWARE.
        model, digest: name and SHA-256 of the model; empty without one.
        field_limit, motor_limit: largest field and motor torque [N m] that the interlock lets through.
        start_ns, start_unix_ns: monotonic and wall clock at the same moment, so that frames can be dated.
        note: what the session was asked to do.
        capacity: frames that the ring holds.
    """

    period_ns: int = 1_000_000
    rig: str = "twin"
    origin: str = "TWIN"
    model: str = ""
    digest: str = ""
    field_limit: float = 0.5
    motor_limit: float = 0.95
    start_ns: int = 0
    start_unix_ns: int = 0
    note: str = ""
    capacity: int = CAPACITY


_TEXTS = ("rig", "origin", "model", "digest", "note")
_NUMBERS = ("period_ns", "start_ns", "start_unix_ns", "field_limit", "motor_limit", "capacity")


def ring_folder() -> Path:
    """Where rings live: memory, where the system has a folder of it."""
    memory = Path("/dev/shm")
    return memory if memory.is_dir() and os.access(memory, os.W_OK) else Path(tempfile.gettempdir())


def make_ring(path: str | Path, info: RingInfo) -> Path:
    """Make an empty ring: a header and room for the frames.

    Raises:
        RingError: it exists already, or there is no room for it.
    """
    target = Path(path)
    header = np.zeros((), HEADER)
    header["magic"], header["version"], header["frame_size"] = MAGIC, VERSION, FRAME.itemsize
    for name in _TEXTS:
        # A cut in the middle of a character must not make the header unreadable.
        size = HEADER[name].itemsize - 1
        header[name] = str(getattr(info, name)).encode()[:size].decode(errors="ignore").encode()
    for name in _NUMBERS:
        header[name] = getattr(info, name)
    try:
        file = os.open(target, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            # Every page is written, so that a full memory shows here and not as a signal in the loop.
            os.write(file, header.tobytes())
            room = bytes(1 << 20)
            left = info.capacity * FRAME.itemsize
            while left > 0:
                left -= os.write(file, room[: min(left, len(room))])
        finally:
            os.close(file)
    except OSError as error:
        if not isinstance(error, FileExistsError):
            target.unlink(missing_ok=True)
        raise RingError(
            f"the ring cannot be made: {error.strerror or error}",
            where=str(target),
            remedy="Free memory, or give another place",
        ) from error
    return target


class Ring:
    """A mapped ring. `RingReader` and `RingWriter` are what to use.

    Args:
        path: file of the ring.
        write: map it for writing.

    Raises:
        RingError: the file is no ring of this version.
    """

    def __init__(self, path: str | Path, *, write: bool = False) -> None:
        self.path = Path(path)
        self._map = _mapped(self.path, write)
        self._header: NDArray[Any] = np.frombuffer(self._map, HEADER, count=1)
        self.info = self._checked()
        self._head: NDArray[np.uint64] = np.frombuffer(
            self._map,
            "<u8",
            count=1,
            offset=int(HEADER.fields["head"][1]),  # type: ignore[index]
        )
        self._frames: NDArray[Any] = np.frombuffer(self._map, FRAME, count=self.info.capacity, offset=HEADER_SIZE)

    def _checked(self) -> RingInfo:
        header = self._header[0]
        size = HEADER_SIZE + int(header["capacity"]) * FRAME.itemsize
        found = (bytes(header["magic"]), int(header["version"]), int(header["frame_size"]), len(self._map))
        if found != (MAGIC, VERSION, FRAME.itemsize, size) or int(header["capacity"]) < 2:
            raise RingError(
                f"this is no ring of version {VERSION} (magic, version, size of a frame, bytes: {found})",
                where=str(self.path),
                remedy="Give the ring of a session of this version of erclutch",
            )
        texts = {name: bytes(header[name]).decode(errors="replace") for name in _TEXTS}
        return RingInfo(**texts, **{name: header[name].item() for name in _NUMBERS})

    @property
    def head(self) -> int:
        """How many frames the loop has written."""
        return int(self._head[0])

    @property
    def state(self) -> State:
        """How the loop is."""
        return State(min(int(self._header["state"][0]), int(State.STOPPED)))

    @property
    def pid(self) -> int:
        """Process of the loop; 0 before it started."""
        return int(self._header["pid"][0])

    @property
    def mode(self) -> int:
        """Kind of control of the running program."""
        return int(self._header["mode"][0])

    @property
    def program(self) -> int:
        """Index of the running program."""
        return int(self._header["program"][0])

    @property
    def sensor_seq(self) -> int:
        """Number of the rig's last sample; 0 before the first."""
        return int(self._header["sensor_seq"][0])

    @property
    def realtime(self) -> str:
        """What the loop could get of real-time priority and locked memory, in words."""
        return bytes(self._header["realtime"][0]).decode(errors="replace")

    @property
    def counts(self) -> dict[str, int]:
        """How often each event of `EVENTS` came up since the start."""
        return {name: int(n) for (name, _), n in zip(EVENTS, self._header["counts"][0], strict=False)}

    @property
    def trip_reason(self) -> str:
        """Why the fields are held at zero: the event that tripped; empty if they are not."""
        bit = int(self._header["trip_reason"][0])
        return EVENTS[bit - 1][0] if 0 < bit <= len(EVENTS) else ""

    def close(self) -> None:
        """Unmap. Frames that were read stay: they are copies."""
        for name in ("_header", "_head", "_frames"):
            self.__dict__.pop(name, None)
        with contextlib.suppress(BufferError):  # somebody still holds a view; the map goes with it
            self._map.close()


class RingReader(Ring):
    """One observer of the frames; the loop knows nothing of it.

    Args:
        path: file of the ring.
        start: "now" for frames from now on, "oldest" for all that the ring still holds.

    Attributes:
        lost: frames that were overwritten before this reader took them.
    """

    def __init__(self, path: str | Path, start: str = "now") -> None:
        super().__init__(path)
        self.lost = 0
        self._next = self.head if start == "now" else max(0, self.head - self._safe)

    @property
    def _safe(self) -> int:
        """Frames that a reader may take: the slot after the newest one is being written, one more for order."""
        return self.info.capacity - 2

    def read(self, limit: int | None = None) -> NDArray[Any]:
        """The frames since the last call, oldest first, at most ``limit``; a copy, shape (n,), dtype `FRAME`."""
        head = self.head
        self._skip_to(head - self._safe)
        stop = head if limit is None else min(head, self._next + limit)
        index = np.arange(self._next, stop, dtype=np.uint64)
        frames = self._frames[index % np.uint64(self.info.capacity)]
        self._next = stop
        # What the writer may have reached while we copied is not kept.
        good = (index >= max(0, self.head - self._safe)) & (frames["seq"] == index)
        self.lost += int(good.size - np.count_nonzero(good))
        return frames[good]

    def latest(self, count: int) -> NDArray[Any]:
        """The newest frames, at most ``count``, without taking them from `read`."""
        head = self.head
        index = np.arange(max(0, head - min(count, self._safe)), head, dtype=np.uint64)
        frames = self._frames[index % np.uint64(self.info.capacity)]
        return frames[(index >= max(0, self.head - self._safe)) & (frames["seq"] == index)]

    def _skip_to(self, oldest: int) -> None:
        if self._next < oldest:
            self.lost += oldest - self._next
            self._next = oldest


class RingWriter(Ring):
    """The writer's side in Python, for the loop that runs without a compiler and for tests. One a ring."""

    def __init__(self, path: str | Path) -> None:
        super().__init__(path, write=True)

    def write(self, frame: Any) -> None:
        """Append one frame (a record or 0-d array of dtype `FRAME`); its number is set here."""
        head = self.head
        slot = head % self.info.capacity
        self._frames[slot] = frame
        self._frames["seq"][slot] = head
        self._head[0] = head + 1
        events = int(self._frames["events"][slot])
        for bit in range(events.bit_length()):
            if events >> bit & 1:
                self._header["counts"][0][bit] += 1

    def put(self, **values: Any) -> None:
        """Set entries of the header that are the loop's: state, pid, mode, program, realtime, trip_reason."""
        for name, value in values.items():
            self._header[name][0] = value.encode() if isinstance(value, str) else value


def _mapped(path: Path, write: bool) -> mmap.mmap:
    try:
        with open(path, "r+b" if write else "rb") as file:
            if os.fstat(file.fileno()).st_size < HEADER_SIZE:
                raise RingError("too short for a ring", where=str(path), remedy="Give the ring of a session")
            return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_WRITE if write else mmap.ACCESS_READ)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RingError(
            f"the ring cannot be opened: {reason}", where=str(path), remedy="Is the session still running?"
        ) from error
