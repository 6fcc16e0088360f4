"""Of two speeds whose names differ in a letter or a number, one alone is no slip in silence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read
from tests.support.command import good

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(300) / 100
DRIVEN = 40 + 20 * np.sin(3 * TIME)
DRIVING = np.full(300, 65.0) + 0.1 * np.sin(40 * TIME)
FIELD = np.where(TIME < 1.5, 0.0, 1.0)
TORQUE = 0.3 + 1.5 * FIELD + 0.01 * (DRIVING - DRIVEN)


def written(path: Path, columns: dict[str, np.ndarray]) -> None:
    rows = zip(*columns.values(), strict=True)
    text = "\n".join(",".join(f"{value:.5g}" for value in row) for row in rows)
    path.write_text(",".join(columns) + "\n" + text + "\n")


@pytest.mark.slow
@pytest.mark.parametrize("letters", ["ev", "ab", "pt"])
def test_one_of_two_lettered_speeds_is_asked_about(tmp_path: Path, letters: str) -> None:
    """``omega_v`` was taken for the slip of a clutch between an engine and a vehicle."""
    first, second = (f"omega_{letter} [rad/s]" for letter in letters)
    columns = {"t [s]": TIME, first: DRIVING, second: DRIVEN, "T_c [Nm]": TORQUE}
    written(tmp_path / "log.csv", columns | {"coil current [A]": FIELD})
    good("inspect", "log.csv", cwd=tmp_path, code=1)


@pytest.mark.slow
def test_a_speed_and_the_one_that_it_was_told_are_not_asked_about(tmp_path: Path) -> None:
    speed = 20 * np.sin(3 * TIME)
    columns = {"t [s]": TIME, "speed [rad/s]": speed, "speed_r [rad/s]": 20 * np.sin(3 * TIME)}
    columns |= {"torque [Nm]": np.tanh(speed), "coil current [A]": FIELD}
    written(tmp_path / "log.csv", columns)
    assert read(tmp_path / "log.csv").signals["slip"] == pytest.approx(speed, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("has_units", [True, False])
def test_numbered_speeds_with_numbered_torques_differ_by_the_slip(
    tmp_path: Path, has_units: bool
) -> None:
    rpm, newton_metre = (" [1/min]", " [Nm]") if has_units else ("", "")
    columns = {"t [s]": TIME, f"n1{rpm}": 9.55 * DRIVING, f"n2{rpm}": 9.55 * DRIVEN}
    columns |= {f"M1{newton_metre}": TORQUE + 0.02, f"M2{newton_metre}": TORQUE, "I [A]": FIELD}
    written(tmp_path / "log.csv", columns)
    last = good("inspect", "log.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert '--slip "n1 - n2' in last


@pytest.mark.slow
def test_two_joints_with_torques_of_their_own_make_no_difference(tmp_path: Path) -> None:
    columns = {"t [s]": TIME, "dq1 [rad/s]": DRIVING, "dq2 [rad/s]": DRIVEN}
    columns |= {"tau1 [Nm]": TORQUE, "tau2 [Nm]": 3 * np.cos(5 * TIME)}
    written(tmp_path / "log.csv", columns)
    assert "dq1 - dq2" not in good("inspect", "log.csv", cwd=tmp_path, code=1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("motor", "load"), [("w_motor_rpm", "w_load_rpm"), ("omega_motor", "omega_load")]
)
def test_a_speed_in_front_of_a_gear_is_asked_about(tmp_path: Path, motor: str, load: str) -> None:
    # The motor's was the slip beside the torque at the load, in silence.
    columns = {"t [s]": TIME, motor: 5 * DRIVEN, load: DRIVEN}
    columns |= {"T_load [Nm]": TORQUE, "coil current [A]": FIELD}
    written(tmp_path / "log.csv", columns)
    last = good("inspect", "log.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert "0.2 times as fast, as behind a gear" in last
    assert f'erclutch inspect log.csv --slip "{load}"' in last


@pytest.mark.slow
@pytest.mark.parametrize(("effort", "times"), [("motor_torque_Nm", 5.0), ("torque_Nm", 1.0)])
def test_the_speed_of_the_same_shaft_is_taken(tmp_path: Path, effort: str, times: float) -> None:
    columns = {"t [s]": TIME, "omega_motor": times * DRIVEN, "omega_load": DRIVEN}
    columns |= {effort: TORQUE, "coil_current_A": FIELD}
    written(tmp_path / "log.csv", columns)
    turns = times * DRIVEN
    assert read(tmp_path / "log.csv").signals["slip"] == pytest.approx(turns, rel=1e-3)
