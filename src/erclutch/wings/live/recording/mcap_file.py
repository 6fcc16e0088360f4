"""Frames go into an MCAP file that no crash can spoil: small whole records, written at once, no index in memory.

A message is a frame of the ring with the numbers that the device's channels name. Its description makes it a ROS 1
message of numbers, so Foxglove and PlotJuggler read it as well as `erclutch.logs`. Log time is the step's deadline (so
rows are evenly spaced, as the loop's filters assume), publish time the wake-up. The index is made when the file is
closed, by walking it. Until then the file has ``.partial`` behind its name.
"""

from __future__ import annotations

import contextlib
import errno
import mmap
import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import zstandard
from mcap import records as kinds
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from numpy.typing import NDArray

from erclutch import files
from erclutch._version import __version__
from erclutch.errors import ErclutchError
from erclutch.files.places import put_beside
from erclutch.logs.readers.mcap_records import (
    MAGIC,
    MESSAGE,
    Contents,
    DamageError,
    parse,
    runs_of,
    unpack_chunk,
)
from erclutch.logs.readers.mcap_table import UNIT_KEY, UNSAMPLED_KEY
from erclutch.signals.units import UNKNOWN
from erclutch.wings.live.layout import EVENT_BITS, frames_of
from erclutch.wings.live.ring import RingInfo

TOPIC = "/frames"
SCHEMA = "erclutch/Frame"
CHANNEL = 1
#: Name of the record of settings; the channel holds the same pairs.
OWN = "erclutch"
#: Schema and channel stand ahead of the first chunk, and inside a chunk after this many: there a checksum covers them.
_REPEAT = 16
_SUMMARY = (
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.STATISTICS,
    Opcode.CHUNK_INDEX,
    Opcode.METADATA_INDEX,
)
_HEAD = struct.Struct("<BQ")
_INDEX = struct.Struct("<BQHI")
_INDEX_ENTRY = np.dtype([("time", "<u8"), ("offset", "<u8")])


class RecordingError(ErclutchError):
    """A recording cannot be written, or holds nothing whole."""


_REMEDY = "Give a folder that can be written and has space"
#: The error of a recording that the disk does not take.
unwritable = partial(
    files.unwritable, problem="the recording cannot be written", remedy=_REMEDY, kind=RecordingError
)


class FrameFile:
    """One recording that is being written.

    Args:
        path: the finished file, which does not exist yet; written as `partial_of` it.
        info: the session, from the ring.
        reserved: `partial_of` the path is there already, empty and kept for this recording.

    Attributes:
        frames: how many are in the file.
        size: bytes of whole records in the file.

    Raises:
        RecordingError: the file exists already, or cannot be made.
    """

    def __init__(self, path: str | Path, info: RingInfo, *, reserved: bool = False) -> None:
        self.path = Path(path)
        self.frames = 0
        self.size = 0
        self._chunks = 0
        self._to_unix = info.start_unix_ns - info.start_ns
        self._description = record_bytes(*description(info))
        self._message = np.dtype([*MESSAGE, ("frame", _packed(info))])
        self._packer = zstandard.ZstdCompressor(level=1)
        try:
            if self.path.exists():
                raise FileExistsError(errno.EEXIST, "the file exists already")
            how = 0 if reserved else os.O_CREAT | os.O_EXCL
            self._file = os.open(
                partial_of(self.path), os.O_WRONLY | how | getattr(os, "O_BINARY", 0), 0o666
            )
        except OSError as error:
            raise unwritable(self.path, error) from error
        about = kinds.Metadata(OWN, about_session(info))
        header = record_bytes(kinds.Header("ros1", f"erclutch {__version__}"), about)
        self._append(MAGIC + header)

    def write(self, frames: NDArray[Any]) -> None:
        """Append frames as one chunk. Whole or not at all: after an error the file ends with the chunk before.

        Raises:
            OSError: the disk is full, or the file cannot be written.
        """
        if not frames.size:
            return
        messages = np.zeros(frames.size, self._message)
        messages["op"] = Opcode.MESSAGE
        messages["size"] = self._message.itemsize - 9
        messages["channel"] = CHANNEL
        messages["seq"] = frames["seq"] & 0xFFFFFFFF
        wake = frames["time_ns"].astype(np.int64) + self._to_unix
        messages["log_time"] = wake - frames["lateness_ns"]
        messages["pub_time"] = wake
        messages["frame"] = frames
        ahead = b"" if self._chunks else self._description
        inside = b"" if self._chunks % _REPEAT else self._description
        body = inside + messages.tobytes()
        times = messages["log_time"]
        chunk = kinds.Chunk(
            compression="zstd",
            data=self._packer.compress(body),
            message_end_time=int(times.max()),
            message_start_time=int(times.min()),
            uncompressed_crc=zlib.crc32(body),
            uncompressed_size=len(body),
        )
        offsets = len(inside) + np.arange(messages.size) * messages.dtype.itemsize
        index = chunk_index(CHANNEL, times, offsets)
        self._append(ahead + record_bytes(chunk) + index)
        self._chunks += 1
        self.frames += int(frames.size)

    def sync(self) -> None:
        """Have the system put what was written on the disk, where it can: a power cut then costs only what follows."""
        with contextlib.suppress(OSError):
            getattr(os, "fdatasync", os.fsync)(self._file)

    def close(self) -> None:
        """End the file with its index and give it its name; on a full disk without one, or the last chunks.

        A name that was taken meanwhile stays another's: the file gets the next one that is free.

        Raises:
            OSError: not even that can be written; the frames are in the file, which is read as far as it is whole.
        """
        os.close(self._file)
        seal(partial_of(self.path))
        self.path = put_beside(partial_of(self.path), self.path)

    def _append(self, data: bytes) -> None:
        try:
            _write_all(self._file, data)
        except OSError:
            os.ftruncate(self._file, self.size)
            os.lseek(self._file, self.size, os.SEEK_SET)
            raise
        self.size += len(data)


def partial_of(path: Path) -> Path:
    """The name of a recording that is not finished."""
    return path.with_name(f"{path.name}.partial")


def _packed(info: RingInfo) -> np.dtype[Any]:
    """The columns of a session's frames, one after another."""
    frame = frames_of(info.channels)
    return np.dtype([(name, frame[name]) for name in frame.names or ()])


def description(info: RingInfo) -> tuple[kinds.Schema, kinds.Channel]:
    """Schema and channel of the frames: fields, units, and where they come from."""
    types = {"u8": "uint64", "f8": "float64", "u4": "uint32", "i4": "int32"}
    plain = {"": "-"}  # a number without a dimension, said: no unit would mean an unknown one
    frame = _packed(info)
    names = frame.names or ()
    units: dict[str, str] = {}
    for each in info.channels:
        if each.unit != UNKNOWN and each.role != "reference":
            units[each.name] = plain.get(each.unit, each.unit)
    units |= {name: "ns" for name in names if name.endswith("_ns")}
    lines: list[str] = []
    for name in names:
        line = f"{types[frame[name].str[1:]]} {name}"
        lines.append(f"{line}  # {units[name]}" if name in units else line)
    named_units = {f"{UNIT_KEY}{name}": unit for name, unit in units.items()}
    unsampled = sum(EVENT_BITS[name] for name in ("sample-lost", "sample-invalid", "glitch"))
    schema = kinds.Schema(
        id=1,
        data="\n".join(lines).encode(),
        encoding="ros1msg",
        name=SCHEMA,
    )
    channel = kinds.Channel(
        id=CHANNEL,
        topic=TOPIC,
        message_encoding="ros1",
        metadata={
            **about_session(info),
            UNSAMPLED_KEY: str(unsampled),
            **named_units,
        },
        schema_id=1,
    )
    return schema, channel


def about_session(info: RingInfo) -> dict[str, str]:
    """What a recording says of its session. ``label`` is there unless hardware was measured."""
    label = {} if info.origin == "HARDWARE" else {"label": info.origin}
    return {
        **label,
        "origin": info.origin,
        "rig": info.rig,
        "model": info.model,
        "model_digest": info.digest,
        "period_ns": str(info.period_ns),
        "start_ns": str(info.start_ns),
        "start_unix_ns": str(info.start_unix_ns),
        "note": info.note,
        **{f"channel.{channel.name}": channel.label for channel in info.channels},
        "erclutch": __version__,
    }


def record_bytes(*records: kinds.McapRecord) -> bytes:
    """Records as they stand in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()


def chunk_index(
    channel: int,
    times: NDArray[np.uint64],
    offsets: NDArray[np.int64],
) -> bytes:
    """The record that says where in a chunk a channel's messages begin."""
    entries = np.zeros(times.size, _INDEX_ENTRY)
    entries["time"], entries["offset"] = times, offsets
    return (
        _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + entries.nbytes, channel, entries.nbytes)
        + entries.tobytes()
    )


@dataclass(frozen=True)
class Place:
    """A record in a file: its kind, and where its body starts and stops."""

    kind: int
    start: int
    stop: int


def places(data: Any, start: int = len(MAGIC)) -> Iterator[Place]:
    """The whole records of a file that has no footer yet, up to its end or to a record that is not whole.

    Args:
        data: the file's bytes, or a memory map of them.
        start: byte to begin at.
    """
    at = start
    size = len(data)
    while at + _HEAD.size <= size:
        kind, length = _HEAD.unpack_from(data, at)
        stop = at + _HEAD.size + length
        if kind == 0 or stop > size:
            return
        yield Place(kind, at + _HEAD.size, stop)
        at = stop


def finish_torn(left: Path, path: Path) -> tuple[Path, int]:
    """Give a file that a killed recorder left an end behind its last whole chunk, and its name.

    Returns:
        The file, and the sequence number of its last frame.

    Raises:
        RecordingError: no chunk of it is whole, or it cannot be read or written.
    """
    try:
        with left.open("r+b") as file:
            with contextlib.closing(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)) as data:
                chunk, last, end = None, None, 0
                for place in places(data):
                    if place.kind == Opcode.CHUNK:
                        chunk = place
                    elif place.kind == Opcode.MESSAGE_INDEX:
                        last = chunk  # a chunk counts with the index behind it
                        end = place.stop
                if last is None:
                    raise RecordingError(
                        "no chunk is whole", where=str(left), remedy="There is nothing to keep"
                    )
                unpacked = unpack_chunk(parse(kinds.Chunk, data[last.start : last.stop]))
                last_run = [*runs_of(unpacked, Contents())][-1]
                sequence = int(last_run.array["seq"][-1])
            file.truncate(end)
        seal(left)
        return put_beside(left, path), sequence
    except (OSError, ValueError) as error:  # mmap refuses an empty file with a ValueError
        raise RecordingError(
            f"it cannot be finished: {error}", where=str(left), remedy=_REMEDY
        ) from error
    except DamageError as error:
        raise RecordingError(
            f"its last chunk is damaged: {error}", where=str(left), remedy=_REMEDY
        ) from error


def seal(path: str | Path) -> None:
    """End a file of whole records: end of data with a checksum, index, footer.

    Where the disk is full: an end without an index, if need be in the place of the last chunks.

    Raises:
        OSError: it cannot be written.
    """
    with open(path, "r+b", buffering=0) as file:
        with contextlib.closing(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)) as data:
            size = len(data)
            records = list(places(data))
            checksum = zlib.crc32(memoryview(data))
            end = record_bytes(kinds.DataEnd(checksum))
            summary = _summary(data, records, size + len(end))
        try:
            file.seek(size)
            _write_all(file.fileno(), end + summary)
        except OSError as error:
            if error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
                raise
            # Chunks are given up from the last on until an end fits; each frees a block or two.
            chunks = [place.start - 9 for place in records if place.kind == Opcode.CHUNK]
            end = record_bytes(kinds.DataEnd(0), kinds.Footer(0, 0, 0)) + MAGIC
            for stop in (size, *reversed(chunks)):
                os.ftruncate(file.fileno(), stop)
                file.seek(stop)
                try:
                    _write_all(file.fileno(), end)
                except OSError:
                    continue
                return
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)) from error


def _summary(data: Any, records: list[Place], start: int) -> bytes:
    """Schemas, channels, statistics and index of a file's records, and the footer, as they stand from ``start`` on."""
    groups: dict[Opcode, dict[bytes, None]] = {kind: {} for kind in _SUMMARY}
    counts: dict[int, int] = {}
    chunks: list[kinds.ChunkIndex] = []
    for place in records:
        head = place.start - 9
        if place.kind in (Opcode.SCHEMA, Opcode.CHANNEL):
            groups[Opcode(place.kind)][data[head : place.stop]] = None
        elif place.kind == Opcode.METADATA:
            name = parse(kinds.Metadata, data[place.start : place.stop]).name
            entry = kinds.MetadataIndex(head, place.stop - head, name)
            groups[Opcode.METADATA_INDEX][record_bytes(entry)] = None
        elif place.kind == Opcode.CHUNK:
            chunk: kinds.Chunk = parse(kinds.Chunk, data[place.start : place.stop])
            chunks.append(
                kinds.ChunkIndex(
                    chunk_length=place.stop - head,
                    chunk_start_offset=head,
                    compression=chunk.compression,
                    compressed_size=len(chunk.data),
                    message_end_time=chunk.message_end_time,
                    message_index_length=0,
                    message_index_offsets={},
                    message_start_time=chunk.message_start_time,
                    uncompressed_size=chunk.uncompressed_size,
                )
            )
        elif place.kind == Opcode.MESSAGE_INDEX and chunks:
            number, size = struct.unpack_from("<HI", data, place.start)
            counts[number] = counts.get(number, 0) + size // _INDEX_ENTRY.itemsize
            chunks[-1].message_index_offsets[number] = head
            chunks[-1].message_index_length += place.stop - head
        elif place.kind == Opcode.MESSAGE:
            (number,) = struct.unpack_from("<H", data, place.start)
            counts[number] = counts.get(number, 0) + 1
    groups[Opcode.CHUNK_INDEX] = {record_bytes(chunk): None for chunk in chunks}
    statistics = kinds.Statistics(
        attachment_count=0,
        channel_count=len(groups[Opcode.CHANNEL]),
        channel_message_counts=counts,
        chunk_count=len(chunks),
        message_count=sum(counts.values()),
        message_end_time=max((chunk.message_end_time for chunk in chunks), default=0),
        message_start_time=min((chunk.message_start_time for chunk in chunks), default=0),
        metadata_count=len(groups[Opcode.METADATA_INDEX]),
        schema_count=len(groups[Opcode.SCHEMA]),
    )
    groups[Opcode.STATISTICS] = {record_bytes(statistics): None}

    # The groups one after another, then where each of them begins.
    parts: list[bytes] = []
    offsets: list[bytes] = []
    at = start
    for kind, of_kind in groups.items():
        group = b"".join(of_kind)
        if group:
            parts.append(group)
            offset = kinds.SummaryOffset(kind, at, len(group))
            offsets.append(record_bytes(offset))
            at += len(group)
    body = b"".join((*parts, *offsets))
    footer = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, at)
    return body + footer + struct.pack("<I", zlib.crc32(body + footer)) + MAGIC


def _write_all(file: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(file, view) :]
