"""Records of MCAP that are not as they say, one by one, and what a reader of another package must give."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
import pytest
from mcap import records as kinds
from mcap.opcode import Opcode

from erclutch.errors import PluginError
from erclutch.logs.log_reader import LogReader, LogSource, read_by, reader_of
from erclutch.logs.readers import mcap_records as records
from erclutch.logs.readers.mcap_records import Contents, DamageError
from erclutch.logs.table import Table
from erclutch.registry import Plugin


def record(kind: int, body: bytes) -> bytes:
    return struct.pack("<BQ", kind, len(body)) + body


def text(words: str) -> bytes:
    return struct.pack("<I", len(words)) + words.encode()


def message(number: int, data: bytes, channel: int = 1) -> bytes:
    return record(
        Opcode.MESSAGE, struct.pack("<HIQQ", channel, number, 10 * number, 10 * number) + data
    )


def chunk(
    packed: bytes, plain: bytes, name: str = "", crc: int | None = None, size: int | None = None
) -> kinds.Chunk:
    crc = zlib.crc32(plain) if crc is None else crc
    return kinds.Chunk(name, packed, 0, 0, crc, len(plain) if size is None else size)


CHANNEL = struct.pack("<HH", 1, 0) + text("/t") + text("json") + struct.pack("<I", 0)


@pytest.mark.parametrize("name", ["", "zstd", "lz4"])
def test_a_chunk_comes_out_as_it_went_in(name: str) -> None:
    import lz4.frame
    import zstandard

    plain = bytes(range(256)) * 3
    pack = {"": bytes, "zstd": zstandard.ZstdCompressor().compress, "lz4": lz4.frame.compress}[name]
    assert records.unpack_chunk(chunk(pack(plain), plain, name)) == plain
    assert records.unpack_chunk(chunk(pack(plain), plain, name, crc=0)) == plain
    for wrong, said in (
        (chunk(pack(plain), plain, name, crc=1), "the checksum of a chunk does not match"),
        (
            chunk(pack(plain), plain, name, crc=0, size=767),
            "the checksum of a chunk does not match",
        ),
        (
            chunk(pack(plain), plain, name, crc=0, size=769),
            "the checksum of a chunk does not match",
        ),
    ):
        with pytest.raises(DamageError, match=said):
            records.unpack_chunk(wrong)
    if name:
        with pytest.raises(DamageError, match="a chunk does not unpack"):
            records.unpack_chunk(chunk(b"\xff" * 40, plain, name))
    with pytest.raises(DamageError, match="packed by 'rar', which is neither zstd nor lz4"):
        records.unpack_chunk(chunk(plain, plain, "rar"))


def test_messages_of_one_length_are_one_array() -> None:
    body = b"".join(message(k, bytes([k, k, k])) for k in range(100)) + message(100, b"longer")
    body += record(Opcode.CHANNEL, CHANNEL) + message(101, b"")
    contents = Contents()
    runs = list(records.runs_of(body, contents))
    assert [run.array.size for run in runs] == [64, 36, 1, 1]
    assert [run.offset for run in runs] == [0, 64 * 34, 100 * 34, 100 * 34 + 37 + 9 + len(CHANNEL)]
    assert np.concatenate([run.array["seq"] for run in runs]).tolist() == list(range(102))
    assert runs[0].data.tolist() == [[k, k, k] for k in range(64)]
    assert [run.data.shape[1] for run in runs] == [3, 3, 6, 0]
    assert runs[1].array["log_time"].tolist() == [10 * k for k in range(64, 100)]
    assert contents.channels[1].topic == "/t"
    long = b"".join(message(k, b"x") for k in range(64 + 256 + 7))
    assert [run.array.size for run in records.runs_of(long, Contents())] == [64, 256, 7]


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (message(0, b"abc")[:8], "a chunk ends within a record"),
        (message(0, b"abc") + b"\x05", "a chunk ends within a record"),
        (message(0, b"abc")[:-1], "a record is longer than its chunk"),
        (record(Opcode.MESSAGE, b"\0" * 21), "a message is too short"),
        (record(Opcode.CHANNEL, CHANNEL + b"")[:9] + b"\xff" * len(CHANNEL), r"a record \(Channel\)"),
        (record(Opcode.CHANNEL, CHANNEL) + record(Opcode.CHANNEL, CHANNEL.replace(b"/t", b"/u")), "channel 1 in two"),
        (
            record(Opcode.SCHEMA, struct.pack("<H", 3) + text("A") + text("json") + text("{}"))
            + record(Opcode.SCHEMA, struct.pack("<H", 3) + text("B") + text("json") + text("{}")),
            "the messages of schema 3 in two ways",
        ),
    ],
)  # fmt: skip
def test_what_a_chunk_must_not_hold(body: bytes, said: str) -> None:
    with pytest.raises(DamageError, match=said):
        list(records.runs_of(body, Contents()))


def test_settings_are_kept_and_said_once_or_twice_alike() -> None:
    contents = Contents()
    records.note_record(kinds.Metadata("own", {"a": "1"}), contents)
    list(records.runs_of(2 * record(Opcode.CHANNEL, CHANNEL) + record(200, b"??"), contents))
    assert contents.metadata == {"own": {"a": "1"}}
    assert list(contents.channels) == [1]


# --- readers of other packages ----------------------------------------------------------------------------------------


class Given(Plugin):
    """A plug-in with a value of its own."""

    value: Any = None  # pyright: ignore[reportIncompatibleMethodOverride]


def of_another(read: Any) -> Plugin:
    plugin = Given("erclutch.readers", "odd", "odd:READER", "erclutch-odd", "1.2")
    object.__setattr__(
        plugin, "value", LogReader((".odd",), lambda head: False, read, tells_damage="never")
    )
    return plugin


def test_a_table_of_another_package_is_looked_at_and_named(tmp_path: Any) -> None:
    source = LogSource(tmp_path / "a.odd", b"", "")
    table = Table("a.odd", {"a": np.array([1, 2]), "b": np.array([3, 4])}, {}, "", notes=("own",))
    found = read_by(of_another(lambda _: table), source)
    assert found.notes == ("own", "read by 'odd' of erclutch-odd 1.2")
    assert found.columns["a"].dtype == np.float64
    assert found.damage == "never"
    for wrong, said in (
        ({"a": 1}, "returns a dict, it must be a Table"),
        (Table("a", {"a": np.ones(2), "b": np.ones(3)}, {}, ""), "no vectors of one length"),
        (Table("a", {"a": np.ones((2, 1))}, {}, ""), r"no vectors of one length: a \(2, 1\)"),
    ):
        with pytest.raises(PluginError, match=said):
            read_by(of_another(lambda _, wrong=wrong: wrong), source)


def test_content_goes_before_the_suffix_and_text_is_what_is_left() -> None:
    assert reader_of(records.MAGIC, ".csv")[0].name == "mcap"
    assert reader_of(b"a,b\n1,2\n", ".MCAP")[0].name == "mcap"
    assert reader_of(b"a,b\n1,2\n", ".unknown")[0].name == "text"
