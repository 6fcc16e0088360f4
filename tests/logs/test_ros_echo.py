"""What echo of ROS prints is read as rows: messages in YAML with ``---`` between them, and the form with ``-p``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, plan_of, read_table
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers.ros_echo import READER
from tests.support.examples import examples

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(400) / 200.0
SPEED = np.round(5.0 * np.sin(6.0 * TIME), 6)
PLACE = np.round(-5.0 / 6.0 * np.cos(6.0 * TIME), 6)
TORQUE = np.round(np.tanh(4.0 * SPEED) + 0.02 * SPEED, 6)
BEGIN = 1_700_000_000


def ros_1(row: int) -> str:
    nanoseconds = row % 200 * 5_000_000
    return (
        f"header: \n  seq: {row}\n  stamp: \n    secs: {BEGIN + row // 200}\n    nsecs: {nanoseconds:9d}\n"
        f"  frame_id: ''\nname: \n  - elbow\nposition: [{PLACE[row]}]\nvelocity: [{SPEED[row]}]\n"
        f"effort: [{TORQUE[row]}]\n"
    )


def ros_2(row: int) -> str:
    nanoseconds = row % 200 * 5_000_000
    return (
        f"header:\n  stamp:\n    sec: {BEGIN + row // 200}\n    nanosec: {nanoseconds}\n  frame_id: base\n"
        f"name:\n- elbow\nposition:\n- {PLACE[row]}\nvelocity:\n- {SPEED[row]}\neffort:\n- {TORQUE[row]}\n"
    )


def nested(row: int) -> str:
    return (
        f"time: {TIME[row]}\njoint:\n  position: {PLACE[row]}\n  velocity: {SPEED[row]}\n  ok: true\n"
        f"wrench:\n  effort: {TORQUE[row]}\n"
    )


def wrapped(row: int) -> str:
    return (
        f"time: {TIME[row]}\nname: [elbow,\n  knee]\nposition: [{PLACE[row]},\n  0.0]\n"
        f"velocity: [{SPEED[row]}, 0.0]\neffort: [{TORQUE[row]}, 0.0]\n"
    )


def written(path: Path, message: Callable[[int], str], end: str = "---\n") -> Path:
    path.write_text("---\n".join(map(message, range(TIME.size))) + end, encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("message", [ros_1, ros_2, nested])
@pytest.mark.parametrize("end", ["---\n", ""])
def test_each_message_is_a_row(tmp_path: Path, message: Callable[[int], str], end: str) -> None:
    table = read_table(written(tmp_path / "echo.txt", message, end))
    plan = plan_of(table, ColumnMap())
    plan.require_sureness()
    taken = {each.signal: each.column for each in plan.signals}
    np.testing.assert_array_equal(table.columns[taken["slip"]], SPEED)
    np.testing.assert_array_equal(table.columns[taken["effort"]], TORQUE)
    assert plan.clock is not None
    stamps = table.columns[plan.clock.column]
    np.testing.assert_allclose(stamps - stamps[0], TIME, atol=1e-6)
    assert "400 messages as an echo of ROS prints them, a row each" in table.notes


@pytest.mark.slow
def test_lists_that_go_on_in_the_next_line_are_whole(tmp_path: Path) -> None:
    table = read_table(written(tmp_path / "echo.yaml", wrapped))
    np.testing.assert_array_equal(table.columns["elbow.effort"], TORQUE)
    assert not np.any(table.columns["knee.position"])


@pytest.mark.slow
def test_the_form_of_a_table_is_read(tmp_path: Path) -> None:
    head = "%time,field.header.seq,field.header.stamp,field.name0,field.velocity0,field.effort0"
    lines = [head]
    for row in range(TIME.size):
        stamp = BEGIN * 10**9 + row * 5_000_000
        lines.append(f"{stamp},{row},{stamp},elbow,{SPEED[row]},{TORQUE[row]}")
    (tmp_path / "echo.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    plan = plan_of(read_table(tmp_path / "echo.csv"), ColumnMap())
    plan.require_sureness()
    taken = {each.signal: each.column for each in plan.signals}
    assert (taken["slip"], taken["effort"]) == ("velocity0", "effort0")


@pytest.mark.slow
def test_a_last_message_that_was_cut_is_left_out_with_a_word(tmp_path: Path) -> None:
    table = read_table(written(tmp_path / "echo.txt", ros_2, "---\nheader:\n  stamp:\n"))
    assert table.rows == TIME.size
    assert "the last message was cut: left out" in table.notes


def test_a_message_of_another_kind_is_named(tmp_path: Path) -> None:
    path = written(tmp_path / "echo.txt", ros_2)
    path.write_text(path.read_text("utf-8") + "WARNING, no values\n---\n", encoding="utf-8")
    with pytest.raises(LogError, match="message 401: 'WARNING, no values' is no value"):
        read_table(path)


@pytest.mark.parametrize(
    "head",
    [
        b"---\ntitle: A page\n---\n# Words\n",
        b"t,w,T\n" + b"1,2,3\n" * 20,
        b"a: 1\nb: 2\n---\nc: 3\n---\nd: 4\n---\n",
        b"a:1, b:2\n" * 20,
        b"--- run 1 ---\n1 2 3\n--- run 2 ---\n1 2 3\n",
    ],
)
def test_other_texts_are_not_claimed(head: bytes) -> None:
    assert not READER.claims(head)


_PIECES = ["a: 1\n", "b:\n", "  - 2\n", "- [1,\n", "]\n", "  c: x\n", "---\n", "9" * 30, "[", "\n"]


@pytest.mark.slow
@settings(max_examples=examples(200))
@given(st.lists(st.sampled_from(_PIECES), max_size=30).map("".join))
def test_any_text_is_read_or_refused(text: str) -> None:
    READER.claims(text.encode())
    try:
        data = f"a: 1\n---\na: 2\n---\n{text}".encode()
        table = READER.read(LogSource(Path("echo.txt"), data, ""))
    except LogError:
        return
    assert table.rows


def test_a_list_in_lists_ends(tmp_path: Path) -> None:
    first = "a: 1\n---\n" * 3
    deep = f"a: 1\nb: {'[' * 100_000}{']' * 100_000}\n---\n"
    (tmp_path / "echo.txt").write_text(first + deep * 3, encoding="utf-8")
    assert [*read_table(tmp_path / "echo.txt").columns] == ["a"]
