"""An MCAP file is read by the library ``mcap``, a chunk at a time; a chunk's messages of one length are one array.

The library makes a Python object of each message, and believes what a file says of its sizes. So chunks are unpacked
here, within limits, and their messages are taken as arrays: an hour at 1 kHz reads in seconds.
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
from mcap.exceptions import InvalidMagic
from mcap.opcode import Opcode
from mcap.stream_reader import CRCValidationError, StreamReader
from numpy.typing import NDArray

from erclutch.errors import LogError
from erclutch.logs.readers.budget import Budget

MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
#: Ahead of each message's data.
MESSAGE = [
    ("op", "u1"),
    ("size", "<u8"),
    ("channel", "<u2"),
    ("seq", "<u4"),
    ("log_time", "<u8"),
    ("pub_time", "<u8"),
]


class DamageError(Exception):
    """The bytes are not what the format says; the text is a phrase for a message."""


class TornError(DamageError):
    """The file ends within a record."""


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
        whole = self.array.view(np.uint8).reshape(-1, self.array.dtype.itemsize)
        heads = _HEAD.size + _MESSAGE_HEAD.size
        return whole[:, heads:]


@dataclass
class Contents:
    """What a file holds.

    Attributes:
        schemas, channels: by number.
        metadata: records of settings, name -> pairs.
        runs: all messages, in the order of the file.
        statistics: what the file says of itself at its end.
        torn: bytes at its end that are no whole record, where it was not closed.
        checked: channels whose description stands in a chunk with a checksum.
    """

    schemas: dict[int, kinds.Schema] = field(default_factory=dict[int, kinds.Schema])
    channels: dict[int, kinds.Channel] = field(default_factory=dict[int, kinds.Channel])
    metadata: dict[str, Mapping[str, str]] = field(default_factory=dict[str, Mapping[str, str]])
    runs: list[MessageRun] = field(default_factory=list[MessageRun])
    statistics: kinds.Statistics | None = None
    torn: int | None = None
    checked: set[int] = field(default_factory=set[int])


class _WholeReads(BytesIO):
    """A file's bytes for the library, which takes a read that gives less than it asked for without a word."""

    def read(self, size: int | None = -1, /) -> bytes:
        start = self.tell()
        try:
            part = super().read(size)
        except OverflowError as error:  # a length of 2^63 and more
            raise TornError(f"the record at byte {start} ends after the file") from error
        if size is not None and len(part) < size:
            raise TornError(f"it ends within the record at byte {start}")
        if size == 1 and part == b"\0":  # the library reads a kind, and nothing else, as one byte
            raise DamageError(f"at byte {start} a record has no kind")
        return part


def read_contents(data: bytes) -> Contents:
    """Everything in a file, as far as it is whole.

    Raises:
        DamageError: a length, a checksum or a count is wrong.
        LogError: it unpacks to more than its `Budget` allows.
    """
    if not data.startswith(MAGIC):
        raise DamageError("it does not begin as one")
    stream = _WholeReads(data)
    reader = StreamReader(
        stream,
        emit_chunks=True,
        validate_crcs=True,
        record_size_limit=None,
    )
    contents = Contents()
    budget = Budget(len(data))
    alone = bytearray()  # messages outside of chunks
    kept = 0  # bytes of them without the last one
    end = len(MAGIC)  # of the last whole record
    try:
        for record in reader.records:
            if isinstance(record, kinds.Chunk):
                budget.take_cells(-(-record.uncompressed_size // 8))
                unpacked = unpack_chunk(record)
                described = Contents()
                contents.runs.extend(runs_of(unpacked, described))
                for each in (*described.schemas.values(), *described.channels.values()):
                    note_record(each, contents)
                if record.uncompressed_crc:
                    contents.checked |= set(described.channels)
            elif isinstance(record, kinds.Message):
                fields = _MESSAGE_HEAD.pack(
                    record.channel_id, record.sequence, record.log_time, record.publish_time
                )
                head = _HEAD.pack(Opcode.MESSAGE, len(fields) + len(record.data))
                kept = len(alone)
                alone += head + fields + record.data
            else:
                note_record(record, contents)
            end = stream.tell()
    except (TornError, InvalidMagic):
        contents.torn = len(data) - end
    except DamageError:
        rest = stream.read()
        if not rest or rest.strip(b"\0"):
            raise
        # A power cut leaves zeros where the last blocks of a file were to be; the last message may end in them.
        contents.torn = len(data) - end
        del alone[kept:]
    except CRCValidationError as error:
        raise DamageError("the checksum of its data does not match") from error
    except (MemoryError, LogError):
        raise
    # Damage leads the library to struct.error, EndOfFile, UnicodeDecodeError or any other.
    except Exception as error:
        raise DamageError(f"the record at byte {end} cannot be read") from error
    if contents.torn is None and stream.read():
        raise DamageError("bytes follow its end")
    contents.runs.extend(runs_of(bytes(alone), contents))
    _check_counts(contents)
    return contents


def unpack_chunk(chunk: kinds.Chunk) -> bytes:
    """The records inside a chunk, unpacked and checked.

    Raises:
        DamageError: it does not unpack to the size and checksum that it states.
    """
    packing = chunk.compression
    # So many bytes are unpacked, whatever the packed data say of themselves.
    most = chunk.uncompressed_size + 1
    if packing not in ("", "zstd", "lz4"):
        problem = f"a chunk is packed by {packing[:20]!r}, which is neither zstd nor lz4"
        raise DamageError(problem)
    try:
        if packing == "zstd":
            import zstandard

            unpacked = zstandard.ZstdDecompressor().stream_reader(chunk.data).read(most)
        elif packing == "lz4":
            from lz4.frame import LZ4FrameDecompressor

            unpacked = LZ4FrameDecompressor().decompress(chunk.data, max_length=most)
        else:
            unpacked = chunk.data
    except Exception as error:  # each library has its own error, and MemoryError, RuntimeError
        raise DamageError("a chunk does not unpack") from error
    wrong = chunk.uncompressed_crc and zlib.crc32(unpacked) != chunk.uncompressed_crc
    if len(unpacked) != chunk.uncompressed_size or wrong:
        raise DamageError("the checksum of a chunk does not match")
    return unpacked


def runs_of(body: bytes, contents: Contents) -> Iterator[MessageRun]:
    """Messages of an unpacked chunk; its schemas and channels go into ``contents``. DamageError for wrong lengths."""
    at = 0
    size = len(body)
    step = 64
    while at < size:
        if at + _HEAD.size > size:
            raise DamageError("a chunk ends within a record")
        kind, length = _HEAD.unpack_from(body, at)
        if length > size - at - _HEAD.size:
            raise DamageError("a record is longer than its chunk")
        if kind != Opcode.MESSAGE:
            described = _DESCRIBING.get(kind)
            begin = at + _HEAD.size
            at = begin + length
            if described is not None:
                note_record(parse(described, body[begin:at]), contents)
            continue
        if length < _MESSAGE_HEAD.size:
            raise DamageError("a message is too short")
        # The messages of one length from here on, of at most so many.
        fields = MESSAGE
        if length > _MESSAGE_HEAD.size:
            fields = [*MESSAGE, ("data", f"V{length - _MESSAGE_HEAD.size}")]
        layout = np.dtype(fields)
        count = min(step, (size - at) // layout.itemsize)
        messages = np.frombuffer(body, layout, count, at)
        equal = (messages["op"] == Opcode.MESSAGE) & (messages["size"] == length)
        kept = messages if equal.all() else messages[: int(np.argmin(equal))]
        yield MessageRun(at, kept)
        # Longer and longer looks ahead while lengths stay equal, so that mixed lengths cost no more than their number.
        step = step * 4 if kept.size == step else 64
        at += kept.size * (_HEAD.size + length)


#: Kinds of records in a chunk that say something of its messages.
_DESCRIBING: Mapping[int, type[kinds.McapRecord]] = {
    Opcode.SCHEMA: kinds.Schema,
    Opcode.CHANNEL: kinds.Channel,
}


def parse(kind: type[kinds.McapRecord], body: bytes) -> Any:
    """A record's body as mcap's record class; DamageError where it does not fit the kind."""
    stream = ReadDataStream(BytesIO(body))
    reader: Any = kind
    try:
        record = reader.read(stream)
    # On damage mcap raises struct.error, EndOfFile, UnicodeDecodeError, MemoryError.
    except Exception as error:
        raise DamageError(f"a record ({kind.__name__}) cannot be read") from error
    if stream.count > len(body):
        raise DamageError(f"a record ({kind.__name__}) is longer than it says")
    return record


def note_record(record: kinds.McapRecord, contents: Contents) -> None:
    """Keep what a record says of the messages; skip kinds that say nothing of them.

    Raises:
        DamageError: it says something else than an earlier record.
    """
    if isinstance(record, kinds.Schema):
        if contents.schemas.setdefault(record.id, record) != record:
            raise DamageError(f"it describes the messages of schema {record.id} in two ways")
    elif isinstance(record, kinds.Channel):
        if contents.channels.setdefault(record.id, record) != record:
            raise DamageError(f"it describes channel {record.id} in two ways")
    elif isinstance(record, kinds.Metadata):
        contents.metadata[record.name] = record.metadata
    elif isinstance(record, kinds.Statistics):
        contents.statistics = record


def _check_counts(contents: Contents) -> None:
    """Whether all messages are there that the file's own statistics know of, and each channel is described."""
    there = sum(int(run.array.size) for run in contents.runs)
    known = contents.statistics
    if known is not None and known.message_count != there:
        raise DamageError(f"it says {known.message_count} messages and holds {there}")
    for run in contents.runs:
        channels = np.unique(run.array["channel"]).tolist()
        if not contents.channels.keys() >= {*channels}:
            raise DamageError("messages of a channel that is not described")
