"""States of joints in MCAP files, in Parquet files of LeRobot, and in Feather files.

The data are SYNTHETIC.
"""

from __future__ import annotations

import io
import shlex
import struct
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
import pyarrow.feather as feather
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, plan_of, read, read_table
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers.mcap_records import DamageError
from erclutch.logs.readers.mcap_table import read_mcap
from erclutch.logs.readers.ros_messages import columns_of
from tests.support.examples import examples

pa: Any = pyarrow
ROWS = 300
TIME = np.arange(ROWS) / 200
RATE = 3 * np.cos(3 * TIME)
ANGLE = np.sin(3 * TIME)
EFFORT = np.tanh(RATE / 0.2) + 0.1 * RATE
HEADER = "builtin_interfaces/Time stamp\nstring frame_id"
STATE = "std_msgs/Header header\n\nstring[] name\nfloat64[] position  # [rad]\nfloat64[] velocity\nfloat64[] effort\n"
BREAK = "\n" + 80 * "=" + "\n"
ROS_2 = STATE + BREAK + "MSG: std_msgs/Header\n" + HEADER + BREAK
ROS_2 += "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec"
ROS_1 = STATE.replace("std_msgs/Header", "Header") + BREAK
ROS_1 += "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id"


class _Message:
    """A message that is written field by field, as ROS 2 (CDR) or as ROS 1."""

    def __init__(self, *, aligned: bool) -> None:
        self.aligned = aligned
        self.body = b""

    def put(self, kind: str, *numbers: float) -> None:
        for number in numbers:
            size = struct.calcsize(kind)
            self.body += bytes(-len(self.body) % size if self.aligned else 0)
            self.body += struct.pack(f"<{kind}", number)

    def text(self, text: str) -> None:
        own = text.encode() + (b"\0" if self.aligned else b"")
        self.put("I", len(own))
        self.body += own

    def numbers(self, values: Any) -> None:
        self.put("I", len(values))
        self.put("d", *values)

    def whole(self) -> bytes:
        return (b"\0\1\0\0" if self.aligned else b"") + self.body


def state(row: int, names: list[str], *, aligned: bool = True) -> bytes:
    message = _Message(aligned=aligned)
    if not aligned:
        message.put("I", row)
    stamp = round(TIME[row] * 1e9)
    message.put("i", 1_700_000_000 + stamp // 10**9)
    message.put("I", stamp % 10**9)
    message.text("base")
    message.put("I", len(names))
    for name in names:
        message.text(name)
    share = np.arange(1, len(names) + 1)
    for course in (ANGLE, RATE, EFFORT):
        message.numbers(course[row] * share)
    return message.whole()


def bag(messages: list[bytes], *, aligned: bool = True) -> bytes:
    out = io.BytesIO()
    writer = Writer(out)
    writer.start()
    text = ROS_2 if aligned else ROS_1
    schema = writer.register_schema(
        "sensor_msgs/JointState", "ros2msg" if aligned else "ros1msg", text.encode()
    )
    channel = writer.register_channel("/joint_states", "cdr" if aligned else "ros1", schema)
    for row, data in enumerate(messages):
        stamp = 10**18 + round(TIME[row] * 1e9) + 1000 * (row % 3)
        writer.add_message(channel, stamp, data, stamp)
    writer.finish()
    return out.getvalue()


def table_of(data: bytes) -> Any:
    return read_mcap(LogSource(Path("a.mcap"), data, "", None))


@pytest.mark.slow
@pytest.mark.parametrize("aligned", [True, False])
def test_the_state_of_a_joint_is_read_at_once_on_its_stamps(tmp_path: Path, aligned: bool) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(
        bag([state(row, ["elbow"], aligned=aligned) for row in range(ROWS)], aligned=aligned)
    )
    recording = read(path)
    assert recording.period == pytest.approx(5e-3)
    assert np.array_equal(recording.signals["slip"], RATE)
    assert np.array_equal(recording.signals["effort"], EFFORT)
    plan = plan_of(read_table(path), ColumnMap())
    assert plan.clock is not None
    assert plan.clock.column == "header.stamp"


def test_of_several_joints_each_has_its_columns(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(bag([state(row, ["hip", "knee"]) for row in range(ROWS)]))
    table = read_table(path)
    assert np.array_equal(table.columns["knee.effort"], 2 * EFFORT)
    plan = plan_of(table, ColumnMap())
    assert shlex.split(plan.command())[3:] == ["--slip", "knee.velocity", "--effort", "knee.effort"]


@pytest.mark.slow
def test_joints_that_come_in_another_order_keep_their_columns() -> None:
    names = [["hip", "knee"], ["knee", "hip"]]
    table = table_of(bag([state(row, names[row % 2]) for row in range(ROWS)]))
    share = np.where(np.arange(ROWS) % 2, 2, 1)
    assert np.array_equal(table.columns["hip.effort"], EFFORT * share)
    assert np.array_equal(table.columns["knee.effort"], EFFORT * (3 - share))


@pytest.mark.slow
def test_a_joint_that_some_messages_lack_is_missing_there() -> None:
    table = table_of(
        bag([state(row, ["hip", "knee"] if row % 2 else ["hip"]) for row in range(ROWS)])
    )
    assert np.array_equal(np.isnan(table.columns["knee.effort"]), np.arange(ROWS) % 2 == 0)
    assert np.array_equal(table.columns["hip.effort"], EFFORT)


@pytest.mark.parametrize(
    ("definition", "body", "said"),
    [
        ("float64[] x", struct.pack("<I", 900) + bytes(7200), "900 items, above 500"),
        ("float64[] x", struct.pack("<I", 3) + bytes(8), "not as long"),
        (
            "float64 x\nstring s",
            bytes(8) + struct.pack("<I", 99) + b"a",
            "a text in its messages is longer",
        ),
        ("geometry/Pose pose", bytes(8), "which nothing describes"),
        ("float64[] x", struct.pack("<I", 1) + bytes(40), "not as long"),
        ("float64 x, y", bytes(8), "is no field of a message"),
    ],
)
def test_what_a_message_must_not_be(definition: str, body: bytes, said: str) -> None:
    block = np.frombuffer(body, np.uint8).reshape(1, -1)
    with pytest.raises(DamageError, match=said):
        columns_of(definition, [block], aligned=False)


def test_messages_inside_of_messages_that_call_themselves_end() -> None:
    definition = "a/Loop x" + BREAK + "MSG: a/Loop\na/Loop x\nfloat64 y"
    with pytest.raises(DamageError, match="too deep"):
        columns_of(definition, [np.zeros((1, 8), np.uint8)], aligned=False)


def test_messages_of_fixed_lists_and_of_lists_of_messages() -> None:
    definition = (
        "float32[2] q\nm/Motor[] motors\nbool on" + BREAK + "MSG: m/Motor\nint16 mode\nfloat64 tau"
    )
    body = (
        struct.pack("<ffI", 0.5, 1.5, 2)
        + struct.pack("<hd", 3, 0.25)
        + struct.pack("<hd", 4, 0.75)
        + b"\1"
    )
    columns = columns_of(definition, [np.frombuffer(body, np.uint8).reshape(1, -1)], aligned=False)
    assert {name: float(values[0]) for name, values in columns.items()} == {
        "q[0]": 0.5,
        "q[1]": 1.5,
        "motors[0].mode": 3.0,
        "motors[0].tau": 0.25,
        "motors[1].mode": 4.0,
        "motors[1].tau": 0.75,
        "on": 1.0,
    }


@settings(max_examples=examples(60), deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 150), st.integers(0, 255)), min_size=1, max_size=6),
    st.booleans(),
)
def test_any_bytes_of_a_message_give_columns_or_an_error_of_ours(
    changes: list[tuple[int, int]], aligned: bool
) -> None:
    message = bytearray(state(3, ["hip", "knee"], aligned=aligned))
    for place, value in changes:
        message[place % len(message)] = value
    with suppress(DamageError):
        columns_of(
            ROS_2 if aligned else ROS_1,
            [np.frombuffer(message, np.uint8).reshape(1, -1)],
            aligned=aligned,
        )


@settings(max_examples=examples(40), deadline=None)
@given(st.text(alphabet="ab/[]<=# \n1float64string", max_size=60))
def test_any_definition_gives_columns_or_an_error_of_ours(text: str) -> None:
    with suppress(DamageError):
        columns_of(text, [np.zeros((2, 16), np.uint8)], aligned=True)


def effort_of(joint: int) -> np.ndarray:
    """The effort of a joint, each of which moves in its own time."""
    rate = 3 * joint * np.cos(3 * joint * TIME)
    return np.tanh(rate / 0.2) + 0.1 * rate


def lerobot(joints: int, kind: Any) -> Any:
    numbers = range(1, joints + 1)
    lists = {
        "observation.state": [np.sin(3 * joint * TIME) for joint in numbers],
        "observation.velocity": [3 * joint * np.cos(3 * joint * TIME) for joint in numbers],
        "observation.effort": [effort_of(joint) for joint in numbers],
    }
    columns: dict[str, Any] = {
        name: pa.array([list(values) for values in np.column_stack(courses)], kind)
        for name, courses in lists.items()
    }
    return pa.table(
        {
            **columns,
            "timestamp": TIME,
            "frame_index": np.arange(ROWS),
            "episode_index": np.zeros(ROWS),
        }
    )


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize(
    "kind", [pa.list_(pa.float64()), pa.list_(pa.float64(), 3), pa.large_list(pa.float64())]
)
def test_lists_of_joints_in_parquet_are_columns_and_the_first_joint_is_proposed(
    tmp_path: Path, kind: Any
) -> None:
    path = tmp_path / "episode_000000.parquet"
    pq.write_table(lerobot(3, kind), path, row_group_size=100)
    table = read_table(path)
    assert np.array_equal(table.columns["observation.effort_3"], effort_of(3))
    plan = plan_of(table, ColumnMap())
    assert {question.signal for question in plan.questions} <= {"field"}
    assert "slip is column observation.velocity_1 of one of 3 joints" in plan.doubts[0]
    words = shlex.split(plan.command())
    assert words[-4:] == ["--slip", "observation.velocity_1", "--effort", "observation.effort_1"]


@pytest.mark.usefixtures("read_here")
def test_lists_of_several_lengths_are_left_out_with_a_note(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    ragged = pa.array([[1.0] * (1 + row % 2) for row in range(ROWS)])
    pq.write_table(pa.table({"t": TIME, "torque": EFFORT, "path": ragged}), path)
    table = read_table(path)
    assert list(table.columns) == ["t", "torque"]
    assert any(note.startswith("column path holds list") for note in table.notes)


@pytest.mark.usefixtures("read_here")
def test_checksums_of_lists_are_looked_for_too(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    pq.write_table(lerobot(2, pa.list_(pa.float64())).select(["observation.effort"]), path)
    assert any("no checksums" in note for note in read_table(path).notes)
    pq.write_table(lerobot(2, pa.list_(pa.float64())), path, write_page_checksum=True)
    assert not any("no checksums" in note for note in read_table(path).notes)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("compression", ["lz4", "zstd", "uncompressed"])
def test_feather_is_read_as_parquet_is(tmp_path: Path, compression: str) -> None:
    path = tmp_path / "log.feather"
    columns = {"time": TIME, "q": ANGLE, "dq": RATE, "tau": EFFORT, "note": ["a"] * ROWS}
    feather.write_feather(pa.table(columns), str(path), compression=compression)
    recording = read(path)
    assert np.array_equal(recording.signals["effort"], EFFORT)
    assert recording.period == pytest.approx(5e-3)


@pytest.mark.usefixtures("read_here")
def test_damaged_feather_is_named(tmp_path: Path) -> None:
    path = tmp_path / "log.feather"
    feather.write_feather(
        pa.table({"t": TIME, "tau": EFFORT}), str(path), compression="uncompressed"
    )
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(LogError, match="the Feather data is damaged"):
        read_table(path)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("name", ["timestamp_ns", "time_ns", "t_ns", "time_nanoseconds"])
def test_times_in_ns_need_no_word(tmp_path: Path, name: str) -> None:
    path = tmp_path / "log.npz"
    stamps = 1_710_000_000_000_000_000 + np.arange(ROWS) * 5_000_000
    np.savez(
        path,
        allow_pickle=False,
        **{name: stamps, "position": ANGLE, "velocity": RATE, "effort": EFFORT},
    )
    recording = read(path)
    assert recording.period == pytest.approx(5e-3, rel=1e-3)
    assert np.array_equal(recording.signals["slip"], RATE)
