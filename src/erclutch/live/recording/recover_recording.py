"""A file that was not closed or is damaged becomes a whole MCAP file: every chunk whose checksum holds is kept."""

from __future__ import annotations

import contextlib
import mmap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap import records as kinds
from mcap.opcode import Opcode
from numpy.typing import NDArray

from erclutch.files import whole_file
from erclutch.live.recording.mcap_file import RecordingError, chunk_index, seal, unwritable
from erclutch.logs.readers.mcap_records import (
    MAGIC,
    Contents,
    DamageError,
    Place,
    TornError,
    parse,
    places,
    require_channels,
    runs_of,
    unpack_chunk,
)

_KEPT = {Opcode.HEADER: kinds.Header, Opcode.SCHEMA: kinds.Schema, Opcode.CHANNEL: kinds.Channel}
_SIGNS = (b"\x04\x00\x00\x00zstd", b"\x03\x00\x00\x00lz4")
_SIGN_AT = 37  # bytes from the start of a chunk's record to the length of its compression's name


@dataclass(frozen=True)
class Recovered:
    """What came out.

    Attributes:
        path: the whole file.
        messages: how many are in it.
        last: sequence number of the last one, or None.
        missing: messages that the numbers of the kept ones show to be lost between them.
        damaged: bytes between whole records that could not be used.
        torn: bytes at the end that were no whole record.
        whole: the file was whole before.
    """

    path: Path
    messages: int
    last: int | None
    missing: int
    damaged: int
    torn: int
    whole: bool


def default_output(path: Path) -> Path:
    """Where a recovered file goes: ``X.mcap`` for ``X.mcap.partial``, ``X-recovered.mcap`` for ``X.mcap``."""
    if path.name.endswith(".mcap.partial"):
        return path.with_name(path.name.removesuffix(".partial"))
    return path.with_name(f"{path.stem}-recovered.mcap")


def recover(path: str | Path, output: str | Path | None = None) -> Recovered:
    """Write what is whole of an MCAP file as a whole file; the old one stays as it is.

    Args:
        path: the file.
        output: where to; None: see `default_output`. It must not exist.

    Raises:
        RecordingError: no MCAP file, nothing whole in it, the output exists or cannot be written.
    """
    source = Path(path)
    target = default_output(source) if output is None else Path(output)
    if target.exists():
        raise RecordingError("the file exists already", where=str(target), remedy="Give another name with --out")
    try:
        with open(source, "rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise RecordingError(
                    "this is no MCAP file (wrong first bytes)", where=str(source), remedy="Give an MCAP file"
                )
            with contextlib.closing(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)) as data:
                return _write(data, source, target)
    except OSError as error:
        problem = f"it cannot be read: {error.strerror or error}"
        raise RecordingError(problem, where=str(source), remedy="Check the path") from error


def _write(data: Any, source: Path, target: Path) -> Recovered:
    tally = _Tally()
    with whole_file(target, unwritable) as partial:
        with open(partial, "wb") as out:
            out.write(MAGIC)
            for place, body in _good(data, tally):
                if place.kind == Opcode.CHUNK:
                    _copy_chunk(data, place, body, out, tally)
                else:
                    out.write(data[place.start - 9 : place.stop])
        if not tally.messages:
            raise RecordingError(
                "no message of the recording is whole", where=str(source), remedy="There is nothing to recover"
            )
        seal(partial)
    return Recovered(
        target, tally.messages, tally.last, tally.missing, tally.damaged, tally.torn, tally.ended and not tally.damaged
    )


class _Tally:
    """What was met on the way through a file."""

    def __init__(self) -> None:
        self.contents = Contents()
        self.messages = 0
        self.missing = 0
        self.damaged = 0
        self.torn = 0
        self.ended = False
        self._last: dict[int, int] = {}

    @property
    def last(self) -> int | None:
        """Number of the last message of the channel that ran furthest."""
        return max(self._last.values(), default=None)

    def count(self, channel: int, sequence: NDArray[np.uint32]) -> None:
        """Count messages, and the gaps in their numbers where they are numbered (all zero: they are not)."""
        self.messages += int(sequence.size)
        joined = sequence.astype(np.int64)
        if channel in self._last:
            joined = np.concatenate(([self._last[channel]], joined))
        elif not sequence.any():
            return
        steps = np.diff(joined)
        self.missing += int((steps[steps > 1] - 1).sum())
        self._last[channel] = int(sequence[-1])


def _good(data: Any, tally: _Tally) -> Iterator[tuple[Place, bytes]]:
    """Records that hold, with the unpacked body of a chunk; after damage it goes on at the next chunk that holds."""
    at, size = len(MAGIC), len(data)
    while at < size:
        try:
            for place in places(data, at):
                if place.kind == Opcode.DATA_END:
                    tally.ended = True
                    return
                body = _checked(data, place, tally)
                if body is not None:
                    yield place, body
                at = place.stop
            return
        except DamageError as error:
            found = _next_chunk(data, at + 1)
            if found is None:
                torn = isinstance(error, TornError)
                tally.torn, tally.damaged = (size - at, tally.damaged) if torn else (0, tally.damaged + size - at)
                return
            tally.damaged += found - at
            at = found


def _checked(data: Any, place: Place, tally: _Tally) -> bytes | None:
    """The body of a record to keep, unpacked if it is a chunk; None for one that is made anew or means nothing here.

    Raises:
        DamageError: it does not hold.
    """
    if place.kind == Opcode.CHUNK:
        body = unpack_chunk(data[place.start : place.stop])
        for run in runs_of(body, tally.contents):
            require_channels(run, tally.contents)
        return body
    body = data[place.start : place.stop]
    if place.kind == Opcode.MESSAGE:
        for run in runs_of(data[place.start - 9 : place.stop], tally.contents):
            require_channels(run, tally.contents)
            tally.count(int(run.array["channel"][0]), run.array["seq"])
        return body
    if place.kind in _KEPT:
        record = parse(_KEPT[Opcode(place.kind)], body)
        if isinstance(record, kinds.Schema):
            tally.contents.schemas[record.id] = record
        elif isinstance(record, kinds.Channel):
            tally.contents.channels[record.id] = record
        return body
    if place.kind == Opcode.METADATA:
        parse(kinds.Metadata, body)
        return body
    return None


def _copy_chunk(data: Any, place: Place, body: bytes, out: Any, tally: _Tally) -> None:
    """A chunk as it is, and an index of it made anew."""
    out.write(data[place.start - 9 : place.stop])
    times: dict[int, list[NDArray[np.uint64]]] = {}
    offsets: dict[int, list[NDArray[np.int64]]] = {}
    for run in runs_of(body, Contents()):
        at = run.offset + np.arange(run.array.size, dtype=np.int64) * run.array.dtype.itemsize
        for channel in np.unique(run.array["channel"]).tolist():
            own = run.array["channel"] == channel
            times.setdefault(channel, []).append(run.array["log_time"][own])
            offsets.setdefault(channel, []).append(at[own])
            tally.count(channel, run.array["seq"][own])
    for channel in times:
        out.write(chunk_index(channel, np.concatenate(times[channel]), np.concatenate(offsets[channel])))


def _next_chunk(data: Any, start: int) -> int | None:
    """Where the next chunk begins that unpacks to its own checksum."""
    at = start
    while True:
        signs = [place for sign in _SIGNS if (place := data.find(sign, at + _SIGN_AT)) >= 0]
        if not signs:
            return None
        head = min(signs) - _SIGN_AT
        if data[head] == Opcode.CHUNK:
            with contextlib.suppress(DamageError):
                place = next(places(data, head))
                unpack_chunk(data[place.start : place.stop])
                return head
        at = head + 1
