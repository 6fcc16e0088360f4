"""A file without a torque or a force: no option can settle it, and the answer says what to do."""

from __future__ import annotations

from pathlib import Path

import pytest

from erclutch.cli import main

COASTS = "\n".join(f"{0.01 * k:.2f},{900 - 2 * k},{k // 50},{k % 7}" for k in range(100))


def _answer(tmp_path: Path, names: str, capsys: pytest.CaptureFixture[str]) -> str:
    path = tmp_path / "log.csv"
    path.write_text(f"{names}\n{COASTS}\n", "utf-8")
    assert main(["inspect", str(path)]) == 1
    return " ".join(capsys.readouterr().out.split())


@pytest.mark.slow
def test_of_a_rotor_that_coasts_the_answer_says_how_to_make_the_torque(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = _answer(tmp_path, "Time (s),Speed (RPM),Coil Current (A),Temperature (°C)", capsys)
    assert "No other column can be a force or a torque: log it." in said
    assert "moment of inertia times the rate at which its speed falls" in said
    assert said.endswith('--effort "COLUMN [N*m]"')  # and not N: the motion turns


def test_along_a_line_the_place_to_fill_in_is_a_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = _answer(tmp_path, "Time (s),Velocity (mm/s),Coil Current (A),Temperature (°C)", capsys)
    assert said.endswith('--effort "COLUMN [N]"')


@pytest.mark.slow
@pytest.mark.parametrize("last", ["CH4 (V)", "CH4 (%)", "CH4", "bridge (counts)"])
def test_a_column_that_may_be_a_sensor_s_is_not_passed_over(
    last: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = _answer(tmp_path, f"Time (s),Speed (RPM),Coil Current (A),{last}", capsys)
    assert "No other column can be" not in said
