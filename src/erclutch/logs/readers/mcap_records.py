"""The records of an MCAP file are walked strictly: lengths, checksums and counts, before anything is believed.

MCAP (mcap.dev/spec): magic, then records of one byte of kind, eight of length and a body; messages stand in compressed
chunks with a checksum. Messages of one length in a row are taken as one array, so an hour at 1 kHz reads in seconds.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any

import numpy as np
from mcap import records as kinds
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from numpy.typing import NDArray

MAGIC = b"\x89MCAP0\r\n"
LARGEST = 8 << 30  # bytes that all chunks together may take when unpacked
LARGEST_CHUNK = 1 << 30
_HEAD = struct.Struct("<BQ")
_CHUNK_HEAD = 40  # bytes ahead of a chunk's data, without the name of its compression
#: Ahead of each message's data.
MESSAGE = [("op", "u1"), ("size", "<u8"), ("channel", "<u2"), ("seq", "<u4"), ("log_time", "<u8"), ("pub_time", "<u8")]
_MESSAGE_FIELDS = 22


class DamageError(Exception):
    """The bytes are not what the format says; the text is a phrase for a message."""


class TornError(DamageError):
    """The file ends before it should."""


@dataclass(frozen=True)
class Place:
    """A record in a file: its kind, and where its body starts and stops."""

    kind: int
    start: int
    stop: int


@dataclass(frozen=True)
class MessageRun:
    """Messages of one length that follow each other.

    Attributes:
        offset: of the first in its chunk.
        array: the messages, shape (n,); fields as in `MESSAGE`, and ``data`` as bytes of shape (n, length).
    """

    offset: int
    array: NDArray[Any]

    @property
    def data(self) -> NDArray[np.uint8]:
        """The messages' bytes, shape (n, length)."""
        return self.array.view(np.uint8).reshape(-1, self.array.dtype.itemsize)[:, _HEAD.size + _MESSAGE_FIELDS :]


@dataclass
class Contents:
    """What a file holds.

    Attributes:
        schemas, channels: by number.
        metadata: records of settings, name -> pairs.
        runs: all messages, in the order of the file.
        statistics: what the file says of itself at its end.
    """

    schemas: dict[int, kinds.Schema] = field(default_factory=dict[int, kinds.Schema])
    channels: dict[int, kinds.Channel] = field(default_factory=dict[int, kinds.Channel])
    metadata: dict[str, Mapping[str, str]] = field(default_factory=dict[str, Mapping[str, str]])
    runs: list[MessageRun] = field(default_factory=list[MessageRun])
    statistics: kinds.Statistics | None = None


def places(data: Any, start: int = len(MAGIC), *, ended: bool = True) -> Iterator[Place]:
    """The records of a file up to its footer.

    Args:
        data: the file's bytes, or a memory map of them.
        start: byte to begin at.
        ended: the file must have a footer; else it may end after any record.

    Raises:
        TornError: the file ends within a record, or without a footer.
        DamageError: a record of a kind that there is not.
    """
    at, size = start, len(data)
    while at + _HEAD.size <= size:
        kind, length = _HEAD.unpack_from(data, at)
        if kind == 0:
            raise DamageError(f"at byte {at} a record has no kind")
        stop = at + _HEAD.size + length
        if stop > size:
            raise TornError(f"the record at byte {at} ends {stop - size} bytes after the file")
        yield Place(kind, at + _HEAD.size, stop)
        if kind == Opcode.FOOTER:
            return
        at = stop
    if ended or at != size:
        raise TornError("it has no end")


def parse(kind: type[kinds.McapRecord], body: bytes) -> Any:
    """A record's body as mcap's record class; DamageError where it does not fit the kind."""
    stream = ReadDataStream(BytesIO(body))
    reader: Any = kind
    try:
        record = reader.read(stream)
    except Exception as error:  # mcap raises struct.error, EndOfFile, UnicodeDecodeError, MemoryError on damage
        raise DamageError(f"a record ({kind.__name__}) cannot be read") from error
    if stream.count > len(body):
        raise DamageError(f"a record ({kind.__name__}) is longer than it says")
    return record


def unpack_chunk(body: bytes, room: int = LARGEST_CHUNK) -> bytes:
    """The records inside a chunk, unpacked and checked.

    Args:
        body: of the chunk's record.
        room: most bytes that it may take.

    Raises:
        DamageError: it does not unpack to the size and checksum that it states, or needs more room.
    """
    chunk = parse(kinds.Chunk, body)
    data_at = _CHUNK_HEAD + len(chunk.compression.encode())
    if struct.unpack_from("<Q", body, data_at - 8)[0] != len(body) - data_at:
        raise DamageError("a chunk is shorter than it says")
    if chunk.uncompressed_size > room:
        raise DamageError(f"a chunk has {chunk.uncompressed_size / 1e6:.0f} MB, more than a reader should take")
    unpacked = _decompress(chunk.compression, chunk.data, chunk.uncompressed_size)
    wrong = chunk.uncompressed_crc and zlib.crc32(unpacked) != chunk.uncompressed_crc
    if len(unpacked) != chunk.uncompressed_size or wrong:
        raise DamageError("the checksum of a chunk does not match")
    return unpacked


def _decompress(name: str, packed: bytes, size: int) -> bytes:
    """At most ``size`` bytes and one more, whatever the packed data say of themselves."""
    if name == "":
        return packed
    if name not in ("zstd", "lz4"):
        raise DamageError(f"a chunk is packed by {name[:20]!r}, which is neither zstd nor lz4")
    try:
        if name == "zstd":
            import zstandard

            return zstandard.ZstdDecompressor().stream_reader(packed).read(size + 1)
        from lz4.frame import LZ4FrameDecompressor

        return LZ4FrameDecompressor().decompress(packed, max_length=size + 1)
    except Exception as error:  # each library has its own error, and MemoryError, RuntimeError
        raise DamageError("a chunk does not unpack") from error


def runs_of(body: bytes, contents: Contents) -> Iterator[MessageRun]:
    """Messages of an unpacked chunk; its schemas and channels go into ``contents``. DamageError for wrong lengths."""
    at, size, step = 0, len(body), 64
    while at < size:
        if at + _HEAD.size > size:
            raise DamageError("a chunk ends within a record")
        kind, length = _HEAD.unpack_from(body, at)
        if length > size - at - _HEAD.size:
            raise DamageError("a record is longer than its chunk")
        if kind != Opcode.MESSAGE:
            note_record(kind, body[at + _HEAD.size : at + _HEAD.size + length], contents)
            at += _HEAD.size + length
            continue
        if length < _MESSAGE_FIELDS:
            raise DamageError("a message is too short")
        kept = _equal_messages(body, at, length, step)
        yield MessageRun(at, kept)
        # Longer and longer looks ahead while lengths stay equal, so that mixed lengths cost no more than their number.
        step = step * 4 if kept.size == step else 64
        at += kept.size * (_HEAD.size + length)


def _equal_messages(body: bytes, at: int, length: int, most: int) -> NDArray[Any]:
    kind = np.dtype([*MESSAGE, ("data", f"V{length - _MESSAGE_FIELDS}")] if length > _MESSAGE_FIELDS else MESSAGE)
    count = min(most, (len(body) - at) // kind.itemsize)
    found = np.frombuffer(body, kind, count, at)
    equal = (found["op"] == Opcode.MESSAGE) & (found["size"] == length)
    return found if equal.all() else found[: int(np.argmin(equal))]


def note_record(kind: int, body: bytes, contents: Contents) -> None:
    """Keep what a record says of the messages; skip kinds that say nothing of them.

    Raises:
        DamageError: it cannot be read, or says something else than an earlier record.
    """
    if kind == Opcode.SCHEMA:
        schema = parse(kinds.Schema, body)
        if contents.schemas.setdefault(schema.id, schema) != schema:
            raise DamageError(f"it describes the messages of schema {schema.id} in two ways")
    elif kind == Opcode.CHANNEL:
        channel = parse(kinds.Channel, body)
        if contents.channels.setdefault(channel.id, channel) != channel:
            raise DamageError(f"it describes channel {channel.id} in two ways")
    elif kind == Opcode.METADATA:
        record = parse(kinds.Metadata, body)
        contents.metadata[record.name] = record.metadata
    elif kind == Opcode.STATISTICS:
        contents.statistics = parse(kinds.Statistics, body)


def read_contents(data: bytes) -> Contents:
    """Everything in a whole file.

    Raises:
        TornError: the file has no end.
        DamageError: a length, a checksum or a count is wrong.
    """
    if data[: len(MAGIC)] != MAGIC:
        raise DamageError("it does not begin as one")
    contents, room, end = Contents(), LARGEST, 0
    for place in places(data):
        body = data[place.start : place.stop]
        if place.kind == Opcode.CHUNK:
            unpacked = unpack_chunk(body, min(room, LARGEST_CHUNK))
            room -= len(unpacked)
            contents.runs.extend(runs_of(unpacked, contents))
        elif place.kind == Opcode.MESSAGE:
            contents.runs.extend(runs_of(data[place.start - _HEAD.size : place.stop], contents))
        elif place.kind == Opcode.DATA_END:
            require_checksum(parse(kinds.DataEnd, body).data_section_crc, data, 0, end, "data")
        elif place.kind == Opcode.FOOTER:  # its own checksum ends inside it
            footer = parse(kinds.Footer, body)
            start = footer.summary_start or place.start - _HEAD.size
            require_checksum(footer.summary_crc, data, start, place.start + 16, "summary")
        else:
            note_record(place.kind, body, contents)
        end = place.stop
    if data[end:] != MAGIC:
        raise TornError("its last bytes are missing")
    _check_counts(contents)
    return contents


def require_checksum(stated: int, data: bytes, start: int, stop: int, what: str) -> None:
    """A checksum of part of the file, where the file states one."""
    if stated and zlib.crc32(memoryview(data)[start:stop]) != stated:
        raise DamageError(f"the checksum of its {what} does not match")


def _check_counts(contents: Contents) -> None:
    """Whether all messages are there that the file's own statistics know of."""
    there = sum(int(run.array.size) for run in contents.runs)
    known = contents.statistics
    if known is not None and known.message_count != there:
        raise DamageError(f"it says {known.message_count} messages and holds {there}")
    for run in contents.runs:
        require_channels(run, contents)


def require_channels(run: MessageRun, contents: Contents) -> None:
    """Raise a DamageError for messages of a channel that no record describes."""
    if not set(np.unique(run.array["channel"]).tolist()) <= set(contents.channels):
        raise DamageError("messages of a channel that is not described")
