"""`ros2 topic echo --csv` writes joint states without names: they are read by the places in the message."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read, read_table

pytestmark = pytest.mark.slow

TIME = np.arange(400) / 200.0
SPEED = np.round(5.0 * np.sin(6.0 * TIME), 6)
PLACE = np.round(-5.0 / 6.0 * np.cos(6.0 * TIME), 6)
TORQUE = np.round(np.tanh(4.0 * SPEED) + 0.02 * SPEED, 6)
BEGIN = 1_700_000_000


def echo(path: Path, frame: str, joints: list[str], *, more: str = "", unit: float = 1e9) -> Path:
    """Joint states whose first joint moves while the others rest."""
    lines: list[str] = []
    at_rest = ["0.0"] * (len(joints) - 1)
    for time, place, speed, torque in zip(TIME, PLACE, SPEED, TORQUE, strict=True):
        whole = int(time)
        cells = [str(BEGIN + whole), str(round((time - whole) * unit)), frame, *joints]
        for value in (place, speed, torque):
            cells += [str(value), *at_rest]
        lines.append(",".join(cells) + more)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("frame", ["", "base_link"])
@pytest.mark.parametrize("joints", [["elbow"], ["elbow", "wrist", "gripper"]])
def test_an_echo_of_joint_states_is_a_log(tmp_path: Path, frame: str, joints: list[str]) -> None:
    recording = read(echo(tmp_path / "joints.csv", frame, joints))
    assert recording.signals["slip"] == pytest.approx(SPEED)
    assert recording.signals["position"] == pytest.approx(PLACE)
    assert recording.signals["effort"] == pytest.approx(TORQUE)
    assert recording.time - BEGIN == pytest.approx(TIME, abs=1e-6)
    assert any("joint states without names" in note for note in recording.notes)


@pytest.mark.parametrize(
    ("more", "unit"),
    [
        (",1.0", 1e9),  # a number too many: it may be any message
        ("", 1e10),  # no nanoseconds
    ],
)
def test_another_table_without_names_stays_as_it_is(tmp_path: Path, more: str, unit: float) -> None:
    table = read_table(echo(tmp_path / "joints.csv", "base", ["elbow"], more=more, unit=unit))
    assert [*table.columns][:2] == ["c1", "c2"]
