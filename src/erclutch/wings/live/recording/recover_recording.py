"""A file that was not closed or is damaged becomes a whole MCAP file: every chunk whose checksum holds is kept."""

from __future__ import annotations

import contextlib
import mmap
import re
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap import records as kinds
from mcap.opcode import Opcode
from numpy.typing import NDArray

from erclutch.files import whole_file
from erclutch.files.places import nothing
from erclutch.logs.readers.mcap_records import (
    MAGIC,
    Contents,
    DamageError,
    Place,
    TornError,
    note_record,
    parse,
    places,
    require_channels,
    require_checksum,
    runs_of,
    unpack_chunk,
)
from erclutch.wings.live.recording.mcap_file import OWN, RecordingError, chunk_index, record_bytes, seal, unwritable

_KEPT = {
    Opcode.HEADER: kinds.Header,
    Opcode.SCHEMA: kinds.Schema,
    Opcode.CHANNEL: kinds.Channel,
    Opcode.METADATA: kinds.Metadata,
}
_SIGN = re.compile(rb"\x04\x00\x00\x00zstd|\x03\x00\x00\x00lz4")
_SIGN_AT = 37  # bytes from the start of a chunk's record to the length of its compression's name
_CRC_AT = 24  # bytes from the start of a chunk's body to its checksum
_FOOTER = 20  # bytes of its body


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
        unsure: no checksum covers what the file says of its columns, their names and units.
        coaxial: its columns are those of the pair.
    """

    path: Path
    messages: int
    last: int | None
    missing: int
    damaged: int
    torn: int
    whole: bool
    unsure: bool
    coaxial: bool


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
    sure = _described(data)
    tally = _Tally(sure)
    ahead = record_bytes(*sure.schemas.values(), *sure.channels.values())
    with whole_file(target, unwritable, nothing) as partial:
        with open(partial, "wb") as out:
            out.write(MAGIC)
            for place, body in _good(data, tally):
                if place.kind in (Opcode.CHUNK, Opcode.MESSAGE):
                    out.write(ahead)
                    ahead = b""
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
        target,
        tally.messages,
        tally.last,
        tally.missing,
        tally.damaged,
        tally.torn,
        whole=tally.ended and not tally.damaged,
        unsure=not tally.sound and not tally.channels <= set(sure.channels),
        coaxial=any(b" field2" in schema.data for schema in tally.contents.schemas.values()),
    )


def _described(data: Any) -> Contents:
    """Schemas and channels that a checksum covers: those inside chunks, and those of a whole summary."""
    found = Contents()
    for place, body in _chunks(data, len(MAGIC)):
        if struct.unpack_from("<I", data, place.start + _CRC_AT)[0]:
            with contextlib.suppress(DamageError):
                for _ in runs_of(body, found):
                    pass
    end = len(data) - len(MAGIC)
    with contextlib.suppress(DamageError):
        footer = parse(kinds.Footer, data[max(0, end - _FOOTER) : end])
        require_checksum(footer.summary_crc, data, footer.summary_start, end - 4, "summary")
        if footer.summary_crc:
            for place in places(data, footer.summary_start):
                note_record(place.kind, data[place.start : place.stop], found)
    return found


class _Tally:
    """What was met on the way through a file; what is sure of it was known before."""

    def __init__(self, sure: Contents) -> None:
        self.sure = sure
        self.contents = Contents(dict(sure.schemas), dict(sure.channels))
        self.channels: set[int] = set()
        self.messages = 0
        self.missing = 0
        self.damaged = 0
        self.torn = 0
        self.ended = False
        self.sound = False
        self._last: dict[int, int] = {}

    @property
    def last(self) -> int | None:
        """Number of the last message of the channel that ran furthest."""
        return max(self._last.values(), default=None)

    def count(self, channel: int, sequence: NDArray[np.uint32]) -> None:
        """Count messages, and the gaps in their numbers where they are numbered (all zero: they are not)."""
        self.messages += int(sequence.size)
        self.channels.add(channel)
        joined = sequence.astype(np.int64)
        if channel in self._last:
            joined = np.concatenate(([self._last[channel]], joined))
        elif not sequence.any():
            return
        steps = np.diff(joined)
        self.missing += int((steps[steps > 1] - 1).sum())
        self._last[channel] = int(sequence[-1])


def _good(data: Any, tally: _Tally) -> Iterator[tuple[Place, bytes]]:
    """Records that hold, with the unpacked body of a chunk; after damage it goes on at the next chunk that holds.

    A record that nothing checks may have had a wrong length: the search begins behind the last record that holds.
    """
    at, size, sure = len(MAGIC), len(data), len(MAGIC)
    while at < size:
        before = at
        try:
            for place in places(data, at):
                if place.kind in (Opcode.DATA_END, Opcode.FOOTER):
                    if next(_chunks(data, place.start), None) is not None:
                        raise DamageError("chunks follow the end")
                    if place.kind == Opcode.DATA_END:
                        stated = parse(kinds.DataEnd, data[place.start : place.stop]).data_section_crc
                        tally.sound = zlib.crc32(memoryview(data)[: place.start - 9]) == stated
                        tally.ended = tally.sound or not stated
                    return
                body = _checked(data, place, tally)
                if body is not None:
                    yield place, body
                    sure = place.stop
                before, at = at, place.stop
            return
        except DamageError as error:
            found = next((place.start - 9 for place, _ in _chunks(data, sure + (sure == at))), None)
            if found is None:
                torn = isinstance(error, TornError)
                tally.torn, tally.damaged = (size - at, tally.damaged) if torn else (0, tally.damaged + size - at)
                return
            tally.damaged += found - (at if found > at else before)
            at = sure = found


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
        if _agrees(record, tally):
            return body
        tally.damaged += place.stop - place.start + 9
    return None


def _agrees(record: kinds.McapRecord, tally: _Tally) -> bool:
    """Whether a record that no checksum covers says what a copy says that one does, or else the first."""
    if isinstance(record, kinds.Schema):
        return tally.contents.schemas.setdefault(record.id, record) == record
    if isinstance(record, kinds.Channel):
        return tally.contents.channels.setdefault(record.id, record) == record
    if isinstance(record, kinds.Metadata) and record.name == OWN:
        copies = [channel.metadata.items() for channel in tally.sure.channels.values() if OWN in channel.metadata]
        return not copies or any(record.metadata.items() <= copy for copy in copies)
    return True


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


def _chunks(data: Any, start: int) -> Iterator[tuple[Place, bytes]]:
    """The chunks from a byte on that unpack to their own checksum, wherever they begin, and what they unpack to."""
    at = start
    while (sign := _SIGN.search(data, at + _SIGN_AT)) is not None:
        head = sign.start() - _SIGN_AT
        at = head + 1
        if data[head] != Opcode.CHUNK:
            continue
        try:
            place = next(places(data, head))
            body = unpack_chunk(data[place.start : place.stop])
        except DamageError:
            continue
        yield place, body
        at = place.stop
