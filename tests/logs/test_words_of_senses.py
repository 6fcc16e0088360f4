"""A column of words may tell which way a drive moves, or the time, and then no field. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, plan_of, read_table

TIME = np.arange(1200) / 100.0
SPEED = np.sin(1.5 * TIME)
TORQUE = np.where(SPEED > 0.0, 1.0, -0.5) * np.tanh(SPEED / 0.1)  # with a weight on one side
FORTH = np.where(SPEED > 0.0, "FORWARD", "BACKWARD")
HALVES = np.where(TIME < 6.0, "FORWARD", "BACKWARD")


def _questions(folder: Path, name: str, words: np.ndarray, torque: np.ndarray, **told: str) -> str:
    path = folder / "log.csv"
    is_time = name == "Timestamp"
    lines = [f"{'' if is_time else 'Time [s],'}Speed [rad/s],Torque [N*m],{name}"]
    for t, v, f, word in zip(TIME, SPEED, torque, words, strict=True):
        lines.append(f"{'' if is_time else f'{t:.3f},'}{v:.6f},{f:.6f},{word}")
    path.write_text("\n".join([*lines, ""]), "utf-8")
    return str(plan_of(read_table(path), ColumnMap.from_options(told)).questions)


def test_words_that_tell_the_way_of_the_motion_tell_no_field(tmp_path: Path) -> None:
    assert "may tell it" not in _questions(tmp_path, "Direction", FORTH, TORQUE)


STRONGER = np.where(HALVES == "FORWARD", 2.0, 1.0) * np.tanh(SPEED / 0.1)


@pytest.mark.parametrize(
    ("name", "words", "torque"),
    [
        ("Direction", HALVES, STRONGER),  # both ways in the rows of each word
        ("Mode", FORTH, TORQUE),  # a field that is switched with the motion
    ],
)
def test_other_words_are_asked_about(
    tmp_path: Path, name: str, words: np.ndarray, torque: np.ndarray
) -> None:
    assert "may tell it" in _questions(tmp_path, name, words, torque)


def test_seconds_of_a_date_tell_no_field(tmp_path: Path) -> None:
    dates = np.array([f"2024-06-03 18:32:{int(t):02d}" for t in TIME])
    growing = (1.0 + TIME) * np.tanh(SPEED / 0.1)
    assert "may tell it" in _questions(tmp_path, "Mode", np.char.add("m", dates), growing)
    assert "may tell it" not in _questions(tmp_path, "Timestamp", dates, growing)
    assert "may tell it" not in _questions(tmp_path, "Timestamp", dates, growing, time="none")
