"""The command that `inspect` prints was tried on the log: what is asked behind the first question stands in it too."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.command import good

pytestmark = pytest.mark.slow

ROWS = 400
SPEED = 3.0 * np.sin(np.arange(ROWS) / 15.0)  # rad/s
TORQUE = 0.2 * np.tanh(4.0 * SPEED)  # N m
STEADY = np.arange(ROWS) / 100.0  # s


def _coarse(time: np.ndarray) -> np.ndarray:
    """Whole seconds over unlike numbers of rows."""
    return np.floor(time**1.1)


def _swapped(time: np.ndarray) -> np.ndarray:
    """A few rows that changed places."""
    swapped = time.copy()
    for row in (20, 80, 150, 320):
        swapped[[row, row + 2]] = swapped[[row + 2, row]]
    return swapped


def _written(folder: Path, names: str, *columns: np.ndarray) -> None:
    rows = [",".join(f"{value:.6g}" for value in row) for row in zip(*columns, strict=True)]
    (folder / "log.csv").write_text(f"{names}\n" + "\n".join(rows) + "\n", encoding="utf-8")


def _printed(folder: Path) -> str:
    last = good("inspect", "log.csv", cwd=folder, code=1).splitlines()[-1]
    _, _, command = last.partition("erclutch ")
    return command


@pytest.mark.parametrize("stamps", [_coarse, _swapped])
@pytest.mark.parametrize(
    "names", ["time [s],vel1,vel2,tau1,tau2", "t [s],speed a,speed b,torque a,torque b"]
)
def test_stamps_that_make_no_clock_are_answered_with_the_first_question(
    tmp_path: Path, names: str, stamps: Callable[[np.ndarray], np.ndarray]
) -> None:
    _written(tmp_path, names, stamps(STEADY), SPEED, 0.7 * SPEED**2, TORQUE, np.abs(TORQUE) + 0.1)
    command = _printed(tmp_path)
    assert command.endswith("--time none")
    assert "Understood" in good(*shlex.split(command), cwd=tmp_path)


def test_a_steady_clock_is_not_answered_away(tmp_path: Path) -> None:
    names = "time [s],vel1,vel2,tau1,tau2"
    _written(tmp_path, names, STEADY, SPEED, 0.7 * SPEED**2, TORQUE, np.abs(TORQUE) + 0.1)
    assert "--time" not in _printed(tmp_path)


def test_a_position_whose_stamps_make_no_clock_gets_no_answer_that_drops_its_speed(
    tmp_path: Path,
) -> None:
    _written(tmp_path, "time [s],position [m],force [N]", _coarse(STEADY), SPEED, TORQUE)
    out = good("inspect", "log.csv", cwd=tmp_path, code=1)
    assert "--time none" not in out.splitlines()[-1].partition("settles it")[2]


@pytest.mark.parametrize("name", ["voltage", "U [V]", "Spannung"])
def test_volts_of_a_bridge_are_no_field_in_the_command(tmp_path: Path, name: str) -> None:
    random = np.random.default_rng(5)
    faint = 2e-5 + 1e-6 * random.standard_normal(ROWS)
    _written(tmp_path, f"time [s],speed [rad/s],torque [N*m],{name}", STEADY, SPEED, TORQUE, faint)
    command = _printed(tmp_path)
    assert "--field none" in command
    assert "Understood" in good(*shlex.split(command), cwd=tmp_path)


ENDS = (17, 65, 98, 150, 181, 232, 270, 311, 352)  # rows of one time each, by a busy logger


def _with_times(folder: Path, seconds_between: int) -> None:
    """Rows of which many have one time, as a logger writes that counts whole seconds."""
    rows: list[str] = []
    for row in range(ROWS):
        second = int(np.searchsorted(ENDS, row, side="right")) * seconds_between
        stamp = f"2024-06-03 {18 + second // 3600}:{second // 60 % 60:02d}:{second % 60:02d}"
        rows.append(f"{stamp},{SPEED[row]:.6g},{TORQUE[row]:.6g}")
    text = "Timestamp,speed,torque\n" + "\n".join(rows) + "\n"
    (folder / "log.csv").write_text(text, encoding="utf-8")


@pytest.mark.parametrize("seconds_between", [1, 5])
def test_times_of_one_course_part_no_rows(tmp_path: Path, seconds_between: int) -> None:
    _with_times(tmp_path, seconds_between)
    assert "Understood" in good("inspect", "log.csv", "--time", "none", cwd=tmp_path)


def test_times_of_tests_long_after_each_other_are_asked_about(tmp_path: Path) -> None:
    _with_times(tmp_path, 300)
    out = good("inspect", "log.csv", "--time", "none", cwd=tmp_path, code=1)
    assert "column Timestamp parts the rows into 10" in out


def test_a_position_whose_stamps_make_no_clock_leaves_the_rate_open(tmp_path: Path) -> None:
    """Rows with a position alone are no points: what its rate is tells the rate of the rows alone."""
    position = -45.0 * np.cos(np.arange(ROWS) / 15.0)
    _written(tmp_path, "time [s],position [mm],force [N]", _coarse(STEADY), position, TORQUE)
    command = _printed(tmp_path)
    assert command.endswith("--rate 'RATE Hz'") or command.endswith('--rate "RATE Hz"')
    answered = command.replace("RATE Hz", "100 Hz")
    assert "Understood" in good(*shlex.split(answered), cwd=tmp_path)
