"""MCAP: what the reader takes, from whom, and that no damage gets through as numbers."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from erclutch.errors import ErclutchError, LogError
from erclutch.logs import read, read_table
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers.mcap_records import DamageError
from erclutch.logs.readers.mcap_table import layout, read_mcap
from tests.support.examples import examples

ROWS = 60
FLAT = b"float64 field\nfloat32 slip # rad/s\nint32 count\nfloat64 effort"
UNITS = {"unit.field": "V", "unit.slip": "rad/s", "unit.effort": "N*m"}


def ros1(i: int) -> bytes:
    return struct.pack("<dfid", 1.0, 0.5 * i, i, 2.0 * i)


def ros2(i: int) -> bytes:
    # float64 field, float32 slip, int32 count, float64 effort: no gap here, but four bytes ahead
    return b"\x00\x01\x00\x00" + struct.pack("<dfid", 1.0, 0.5 * i, i, 2.0 * i)


def as_json(i: int) -> bytes:
    return json.dumps(
        {"field": 1.0, "motion": {"slip": 0.5 * i}, "count": i, "effort": 2.0 * i, "note": "x"}
    ).encode()


def written(
    messages: Callable[[int], bytes] = ros1,
    encoding: tuple[str, str] = ("ros1", "ros1msg"),
    *,
    schema: bytes = FLAT,
    compression: CompressionType = CompressionType.ZSTD,
    topics: tuple[str, ...] = ("/rig",),
    chunked: bool = True,
    crc: bool = True,
    chunk_size: int = 500,
) -> bytes:
    out = io.BytesIO()
    writer = Writer(
        out,
        chunk_size=chunk_size,
        compression=compression,
        use_chunking=chunked,
        enable_crcs=crc,
        enable_data_crcs=crc,
    )
    writer.start()
    kind = writer.register_schema("rig/State", encoding[1], schema) if encoding[1] else 0
    channels = [writer.register_channel(topic, encoding[0], kind, UNITS) for topic in topics]
    for i in range(ROWS):
        for channel in channels:
            writer.add_message(
                channel, 10**18 + i * 2_000_000, messages(i), 10**18 + i * 2_000_000 + 7, i
            )
    writer.finish()
    return out.getvalue()


def table_of(data: bytes, variable: str | None = None) -> Any:
    return read_mcap(LogSource(Path("a.mcap"), data, "", variable))


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
def test_messages_of_ros_1_become_a_recording(
    tmp_path: Path, compression: CompressionType, chunked: bool
) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(written(compression=compression, chunked=chunked))
    recording = read(path)
    assert recording.rows == ROWS
    assert recording.period == pytest.approx(2e-3)
    assert recording.units == {"field": "V", "slip": "rad/s", "effort": "N*m"}
    assert np.array_equal(recording.signals["effort"], 2.0 * np.arange(ROWS))
    assert np.array_equal(recording.signals["slip"], 0.5 * np.arange(ROWS))


@pytest.mark.parametrize(
    ("messages", "encoding", "slip"),
    [(ros2, ("cdr", "ros2msg"), "slip"), (as_json, ("json", ""), "motion.slip")],
)
def test_messages_of_ros_2_and_json(
    messages: Callable[[int], bytes], encoding: tuple[str, str], slip: str
) -> None:
    table = table_of(written(messages, encoding))
    assert list(table.columns) == ["field", slip, "count", "effort"]
    assert np.array_equal(table.columns[slip], 0.5 * np.arange(ROWS))
    assert table.clock == pytest.approx(np.arange(ROWS) * 2e-3, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "aligned", "offsets", "size"),
    [
        ("uint8 a\nfloat64 b\nint16 c", False, [0, 1, 9], 11),
        ("uint8 a\nfloat64 b\nint16 c", True, [4, 12, 20], 22),
        (
            "# a comment\nuint8 LIMIT = 3\ntime t\nfloat32 x # [m]\n====\nMSG: other",
            False,
            [0, 4, 8],
            12,
        ),
    ],
)
def test_layout_of_a_message(text: str, aligned: bool, offsets: list[int], size: int) -> None:
    kind = layout(text, aligned=aligned)
    assert [kind.fields[name][1] for name in kind.names or ()] == offsets  # type: ignore[index]
    assert kind.itemsize == size


@pytest.mark.parametrize(
    "text", ["", "string name", "float64[] x", "float64[3] x", "Header header", "float64 x\nint8 x"]
)
def test_fields_that_are_no_plain_numbers(text: str) -> None:
    with pytest.raises(DamageError):
        layout(text)


def test_several_topics_need_a_choice(tmp_path: Path) -> None:
    data = written(topics=("/rig", "/other"))
    with pytest.raises(
        LogError, match=r"several recordings: /rig, /other. Choose one, such as --variable /rig"
    ):
        table_of(data)
    assert table_of(data, "/other").rows == ROWS
    with pytest.raises(LogError, match="no topic '/third' of numbers"):
        table_of(data, "/third")


def test_what_is_no_number_is_said() -> None:
    with pytest.raises(LogError, match="no topic of the file holds messages of numbers"):
        table_of(written(lambda i: b"x", ("protobuf", "protobuf")))


@pytest.mark.parametrize(
    ("change", "lost"),
    [
        (lambda d: d[: len(d) // 2], None),
        (lambda d: d[: len(d) // 2] + bytes(100_000), None),  # as a power cut leaves it
        (lambda d: d[:-8], 0),
        (lambda d: d[:-1], 0),
    ],
)
@pytest.mark.parametrize("chunked", [True, False])
def test_a_torn_file_is_read_as_far_as_it_is_whole(
    tmp_path: Path, change: Callable[[bytes], bytes], lost: int | None, chunked: bool
) -> None:
    path = tmp_path / "a.mcap.partial"
    path.write_bytes(change(written(chunked=chunked)))
    table = read_table(path)
    assert 5 < table.rows < ROWS if lost is None else table.rows == ROWS - lost
    assert np.array_equal(table.columns["effort"], 2.0 * np.arange(table.rows))
    assert any(
        "the recording was not closed: read as far as it is whole" in note for note in table.notes
    )
    assert any("no checksum" in note for note in table.notes) is not chunked


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d + b"more", "the MCAP file is damaged: bytes follow its end"),
        (lambda d: d[:8], "the MCAP file was not closed, and no message in it is whole"),
        (
            lambda d: d[:8] + bytes(100),
            "the MCAP file was not closed, and no message in it is whole",
        ),
        (
            lambda d: d[:8] + bytes(100) + b"x",
            "the MCAP file is damaged: at byte 8 a record has no kind",
        ),
        (
            lambda d: d[:8] + b"\x01" + b"\xff" * 8,
            "the MCAP file was not closed, and no message in it is whole",
        ),
    ],
)
def test_a_file_that_is_not_whole(
    tmp_path: Path, change: Callable[[bytes], bytes], message: str
) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(change(written()))
    with pytest.raises(LogError) as caught:
        read_table(path)
    assert str(caught.value).startswith(f"a.mcap: {message}")


def test_another_file_with_this_ending(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_text("t,field\n0,1\n", encoding="utf-8")
    with pytest.raises(LogError, match="damaged: it does not begin as one"):
        read_table(path)


@pytest.mark.slow
def test_a_chunk_that_claims_much_takes_little() -> None:
    """A zstd frame of 2 GiB of zeros is a few hundred kB: the size that the chunk states is all that is unpacked."""
    import zstandard

    bomb = zstandard.ZstdCompressor().compress(bytes(1 << 26))
    body = struct.pack("<QQQII4sQ", 0, 0, 1000, 0, 4, b"zstd", len(bomb)) + bomb
    data = b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, len(body)) + body
    with pytest.raises(LogError, match="the checksum of a chunk does not match"):
        table_of(data)
    body = struct.pack("<QQQII4sQ", 0, 0, 1 << 40, 0, 4, b"zstd", len(bomb)) + bomb
    with pytest.raises(LogError, match=r"unpacks to more than [\d,]+ numbers"):
        table_of(b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, len(body)) + body)


WHOLE = written()
COLUMNS = {name: values.copy() for name, values in table_of(WHOLE).columns.items()}


def require_a_part_or_all(table: Any) -> None:
    """All that was written; or rows of it, where a changed length makes a file look torn, and then it says so.

    Of a torn file a damaged chunk is left out as well: so many messages are missing before the last that is whole.
    """
    assert list(table.columns) == list(COLUMNS)
    read = np.isin(COLUMNS["count"], table.columns["count"])
    assert all(np.array_equal(table.columns[name], COLUMNS[name][read]) for name in COLUMNS)
    assert table.rows == ROWS or any("not closed" in note for note in table.notes)
    missing = int(np.flatnonzero(read).max()) + 1 - table.rows
    assert not missing or any(
        note.startswith(f"{missing} messages are missing") for note in table.notes
    )


@pytest.mark.slow
@settings(max_examples=examples(300), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.lists(st.tuples(st.integers(0, len(WHOLE) - 1), st.integers(1, 255)), min_size=1, max_size=4)
)
@example([(WHOLE.rindex(b"float64 field") + 8, 1)])  # the schema as the summary repeats it
def test_no_damage_gets_through(changes: list[tuple[int, int]]) -> None:
    """Every byte is under a checksum: a changed file is refused, or reads as it was, or says that it is torn."""
    data = bytearray(WHOLE)
    for place, flip in changes:
        data[place] ^= flip
    with suppress(ErclutchError):
        require_a_part_or_all(table_of(bytes(data)))


@pytest.mark.slow
@settings(max_examples=examples(150), deadline=None)
@given(
    st.binary(max_size=300).map(lambda tail: b"\x89MCAP0\r\n" + tail)
    | st.tuples(st.integers(0, len(WHOLE)), st.integers(0, len(WHOLE))).map(
        lambda ab: WHOLE[: ab[0]] + WHOLE[ab[1] :]
    )
)
def test_any_bytes_give_an_error_of_ours(data: bytes) -> None:
    with suppress(ErclutchError):
        assert table_of(data).rows


@pytest.mark.slow
@pytest.mark.parametrize("flip", [1, 128, 255])
def test_no_single_byte_gets_through(flip: int) -> None:
    for place in range(len(WHOLE)):
        data = bytearray(WHOLE)
        data[place] ^= flip
        with suppress(ErclutchError):
            require_a_part_or_all(table_of(bytes(data)))


def test_a_summary_that_says_otherwise_is_refused_without_checksums_too() -> None:
    data = bytearray(UNGUARDED)
    data[data.rindex(b"float64 field") + 8] ^= 1
    with pytest.raises(LogError, match="describes the messages of schema 1 in two ways"):
        table_of(bytes(data))


UNGUARDED = written(crc=False, compression=CompressionType.NONE)


@pytest.mark.slow
@settings(max_examples=examples(200), deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(8, len(UNGUARDED) - 1), st.integers(0, 255)), min_size=1, max_size=6
    )
)
def test_a_mutated_file_without_checksums_gives_a_table_or_an_error_of_ours(
    changes: list[tuple[int, int]],
) -> None:
    data = bytearray(UNGUARDED)
    for place, byte in changes:
        data[place] = byte
    with suppress(ErclutchError):
        assert table_of(bytes(data)).columns


@pytest.mark.slow
@settings(max_examples=examples(50), deadline=None)
@given(
    st.lists(st.tuples(*[st.floats(allow_nan=False, width=32)] * 3), min_size=1, max_size=40),
    st.integers(60, 4000),
)
def test_numbers_come_back_as_they_were(
    rows: list[tuple[float, float, float]], chunk_size: int
) -> None:
    out = io.BytesIO()
    writer = Writer(out, chunk_size=chunk_size)
    writer.start()
    kind = writer.register_schema("s", "ros1msg", b"float64 a\nfloat32 b\nfloat64 c")
    channel = writer.register_channel("/s", "ros1", kind)
    for i, row in enumerate(rows):
        writer.add_message(channel, i, struct.pack("<dfd", *row), i)
    writer.finish()
    found = table_of(out.getvalue()).columns
    assert np.array_equal(np.column_stack(list(found.values())), np.array(rows))
