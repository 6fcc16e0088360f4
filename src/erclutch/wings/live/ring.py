"""The ring lies in shared memory: the loop writes one frame a control step, and everybody else reads the frames there.

The loop is the only writer: frame first, then the head counter (release order). A reader polls the head, copies, and
looks again: what the writer may have reached meanwhile counts as lost. Each frame carries its own number, so a copy
that was torn in spite of that is found.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import re
import tempfile
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ErclutchError
from erclutch.files import unwritable
from erclutch.signals.channels import ROLES, LiveChannel, channels_of
from erclutch.signals.units import is_written_well
from erclutch.wings.live.layout import CONSTANTS, EVENT_BITS, EVENTS, FRAME, HEADER, frames_of

#: 65.5 s at 1 kHz, 7.3 MB.
CAPACITY = 1 << 16
_MAGIC = CONSTANTS["ERC_RING_MAGIC"]
_VERSION = CONSTANTS["ERC_RING_VERSION"]
_FIXED = tuple(name for name in FRAME.names or () if FRAME[name] != np.float64)
_NAME = re.compile(r"[a-z][a-z0-9_]{0,22}")
_REMEDY = "Give the ring of a session of this version of erclutch"
_NO_CHANNELS = "its table of channels is none"
_HEAD_AT = (HEADER.fields or {})["head"][1]
_SENSORS = {
    "torque-doubted": "torque meter",
    "theta-doubted": "drive encoder",
    "alpha-doubted": "output encoder",
}
_FAULTS = {
    "sample-invalid": "gives no number",
    "out-of-range": "reads what cannot be",
    "glitch": "jumps",
    "stuck": "is stuck",
    "disagrees": "disagrees with the model",
}


def doubt_in_words(trip: str) -> str:
    """A trip by a sensor as a sentence, from the names of its events; empty for every other trip."""
    names = trip.split(": ")
    sensors = [f"the {sensor}" for name, sensor in _SENSORS.items() if name in names]
    faults = [fault for name, fault in _FAULTS.items() if name in names]
    if not sensors:
        return ""
    # Torque and motion of the output are compared.
    if {"torque-doubted", "alpha-doubted", "disagrees"} <= {*names}:
        return "The torque meter and the output encoder contradict each other, and one of them is wrong"
    fault = " or ".join(faults) or "is in doubt"
    sentence = f"{' or '.join(sensors)} {fault}"
    return sentence[:1].upper() + sentence[1:]


class State(IntEnum):
    """How the loop is. Fields and motor torque are zero in all states but ``RUNNING``."""

    STARTING = CONSTANTS["ERC_STARTING"]
    RUNNING = CONSTANTS["ERC_RUNNING"]
    TRIPPED = CONSTANTS["ERC_TRIPPED"]
    STOPPED = CONSTANTS["ERC_STOPPED"]
    READY = CONSTANTS["ERC_READY"]  # after a reset, until a program is run


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
        channels: what the numbers of a frame are called.
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
    channels: tuple[LiveChannel, ...] = channels_of("coaxial")


_TEXTS = ("rig", "origin", "model", "digest", "note")
_NUMBERS = ("period_ns", "start_ns", "start_unix_ns", "field_limit", "motor_limit", "capacity")


def ring_folder() -> Path:
    """Where rings live: memory, where the system has a folder of it."""
    memory = Path("/dev/shm")
    if memory.is_dir() and os.access(memory, os.W_OK):
        return memory
    return Path(tempfile.gettempdir())


def make_ring(path: str | Path, info: RingInfo) -> Path:
    """Make an empty ring: a header and room for the frames.

    Raises:
        RingError: it exists already, or there is no room for it.
    """
    target = Path(path)
    header = np.zeros((), HEADER)
    header["magic"] = _MAGIC
    header["version"] = _VERSION
    header["frame_size"] = FRAME.itemsize
    _write_texts(header, info, _TEXTS)
    header["channels"] = len(info.channels)
    for at, channel in zip(header["channel"], info.channels, strict=False):
        _write_texts(at, channel, at.dtype.names)
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
        remedy = "Free memory, or give another place"
        raise unwritable(target, error, "the ring cannot be made", remedy, RingError) from error
    return target


def _write_texts(record: Any, source: object, names: tuple[str, ...]) -> None:
    for name in names:
        # A cut in the middle of a character must not make the header unreadable.
        size = record.dtype[name].itemsize - 1
        cut = str(getattr(source, name)).encode()[:size]
        record[name] = cut.decode(errors="ignore").encode()


class RingReader:
    """One observer of the frames; the loop knows nothing of it.

    Args:
        path: file of the ring.
        start: "now" for frames from now on, "oldest" for all that the ring still holds.

    Attributes:
        info: what the session is.
        dtype: of its frames: the numbers have the names of the device's channels.
        lost: frames that were overwritten before this reader took them.

    Raises:
        RingError: the file is no ring of this version.
    """

    def __init__(self, path: str | Path, start: str = "now") -> None:
        self.path = Path(path)
        try:
            with open(self.path, "rb") as file:
                if os.fstat(file.fileno()).st_size < HEADER.itemsize:
                    raise RingError(
                        "too short for a ring",
                        where=str(self.path),
                        remedy="Give the ring of a session",
                    )
                self._map = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise RingError(
                f"the ring cannot be opened: {reason}",
                where=str(self.path),
                remedy="Is the session still running?",
            ) from error
        self._header: NDArray[Any] = np.frombuffer(self._map, HEADER, count=1)
        self.info = self._checked()
        self._head: NDArray[np.uint64] = np.frombuffer(self._map, "<u8", count=1, offset=_HEAD_AT)
        self.dtype = frames_of(self.info.channels)
        self._frames: NDArray[Any] = np.frombuffer(
            self._map, self.dtype, count=self.info.capacity, offset=HEADER.itemsize
        )
        self.lost = 0
        self._next = self.head if start == "now" else max(0, self.head - self._safe)

    def _checked(self) -> RingInfo:
        header = self._header[0]
        size = HEADER.itemsize + int(header["capacity"]) * FRAME.itemsize
        marks = (
            int(header["magic"]),
            int(header["version"]),
            int(header["frame_size"]),
            len(self._map),
        )
        if marks != (_MAGIC, _VERSION, FRAME.itemsize, size) or int(header["capacity"]) < 2:
            raise RingError(
                f"this is no ring of version {_VERSION} (magic, version, size of a frame, bytes: {marks})",
                where=str(self.path),
                remedy=_REMEDY,
            )
        texts = {name: bytes(header[name]).decode(errors="replace") for name in _TEXTS}
        numbers = {name: header[name].item() for name in _NUMBERS}
        return RingInfo(**texts, **numbers, channels=self._channels(header))

    def _channels(self, header: Any) -> tuple[LiveChannel, ...]:
        """The table of channels.

        Raises:
            RingError: it is none.
        """
        table = header["channel"]
        count = int(header["channels"])
        if count > len(table):
            raise RingError(_NO_CHANNELS, where=str(self.path), remedy=_REMEDY)
        channels: list[LiveChannel] = []
        for entry in table[:count]:
            texts = {
                name: bytes(entry[name]).decode(errors="replace") for name in table.dtype.names
            }
            channels.append(LiveChannel(**texts))
        try:
            frames_of(channels)
        except ValueError as error:  # a slot that is none, or a name twice
            raise RingError(_NO_CHANNELS, where=str(self.path), remedy=_REMEDY) from error
        for channel in channels:
            named = _NAME.fullmatch(channel.name) and channel.name not in (
                *_FIXED,
                "time",
                "lateness",
                "step",
            )
            if not named or channel.role not in ROLES or not is_written_well(channel.unit):
                raise RingError(_NO_CHANNELS, where=str(self.path), remedy=_REMEDY)
        return tuple(channels)

    @property
    def head(self) -> int:
        """How many frames the loop has written."""
        return int(self._head[0])

    @property
    def state(self) -> State:
        """How the loop is."""
        number = int(self._header["state"][0])
        return State(number) if number in tuple(State) else State.STOPPED

    @property
    def pid(self) -> int:
        """Process of the loop; 0 before it started."""
        return int(self._header["pid"][0])

    @property
    def program(self) -> int:
        """Index of the running program."""
        return int(self._header["program"][0])

    @property
    def sensor_seq(self) -> int:
        """Number of the rig's last sample; 0 before the first."""
        return int(self._header["sensor_seq"][0])

    @property
    def missed(self) -> int:
        """How many deadlines the loop has skipped since its start."""
        return int(self._header["missed"][0])

    @property
    def realtime(self) -> str:
        """What the loop could get of real-time priority and locked memory, in words."""
        return bytes(self._header["realtime"][0]).decode(errors="replace")

    @property
    def counts(self) -> dict[str, int]:
        """How often each event of `EVENTS` came up since the start."""
        counts = self._header["counts"][0]
        return {name: int(count) for (name, _), count in zip(EVENTS, counts, strict=False)}

    @property
    def trip_reason(self) -> str:
        """Why the fields are held at zero: an event, or a sensor and what is wrong with it; empty if they are not."""
        bits = int(self._header["trip_reason"][0])
        names = [name for name, bit in EVENT_BITS.items() if bits & bit]
        return ": ".join(sorted(names, key=lambda name: not name.endswith("-doubted")))

    @property
    def doubt(self) -> str:
        """A trip by a sensor as a sentence; empty for every other trip."""
        return doubt_in_words(self.trip_reason)

    def close(self) -> None:
        """Unmap. Frames that were read stay: they are copies."""
        for name in ("_header", "_head", "_frames"):
            self.__dict__.pop(name, None)
        with contextlib.suppress(BufferError):  # somebody still holds a view; the map goes with it
            self._map.close()

    @property
    def _safe(self) -> int:
        """Frames that a reader may take: the slot after the newest one is being written, one more for order."""
        return self.info.capacity - 2

    def read(self, limit: int | None = None) -> NDArray[Any]:
        """The frames since the last call, oldest first, at most ``limit``: a copy of shape (n,), as `dtype` says."""
        head = self.head
        oldest = head - self._safe
        if self._next < oldest:
            self.lost += oldest - self._next
            self._next = oldest
        stop = head if limit is None else min(head, self._next + limit)
        frames = self._copied(self._next, stop)
        self.lost += max(0, stop - self._next) - int(frames.size)
        self._next = stop
        return frames

    def latest(self, count: int) -> NDArray[Any]:
        """The newest frames, at most ``count``, without taking them from `read`."""
        head = self.head
        most = min(count, self._safe)
        return self._copied(max(0, head - most), head)

    def _copied(self, first: int, stop: int) -> NDArray[Any]:
        """Frames of these numbers, without what the writer may have reached meanwhile."""
        numbers = np.arange(first, stop, dtype=np.uint64)
        frames = self._frames[numbers % np.uint64(self.info.capacity)]
        untouched = numbers >= max(0, self.head - self._safe)
        whole = frames["seq"] == numbers
        return frames[untouched & whole]
