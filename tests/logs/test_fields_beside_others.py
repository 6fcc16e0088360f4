"""The measured field is chosen beside what was told, beside a motor's current, and where a Hall sensor tells it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, plan_of, read, read_table

TIME = np.arange(2000) / 250.0
SPEED = 6.0 * np.sin(5.0 * TIME) + 2.0 * np.sin(13.2 * TIME + 1.0)  # rad/s
CURRENT = np.repeat([0.0, 1.0, 0.5, 2.0, 1.5, 0.0, 2.0, 1.0], 250)  # A
TORQUE = (0.2 + CURRENT) * np.tanh(3.0 * SPEED) + 0.05 * SPEED  # N m
#: What was told is followed some rows later.
TOLD = np.concatenate([CURRENT[20:], CURRENT[:20]])
MOTOR = 0.4 * TORQUE + 0.02 * np.cos(90.0 * TIME)


def written(path: Path, fields: dict[str, np.ndarray]) -> Path:
    columns = {"t [s]": TIME, "w [rad/s]": SPEED, "T [N*m]": TORQUE, **fields}
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, "%.7g", ",", header=",".join(columns), comments="", encoding="utf-8")
    return path


@pytest.mark.parametrize("told", ["Command [A]", "Cmd_A", "Current command [mA]", "Sollstrom [A]"])
def test_of_what_was_told_and_measured_in_amperes_the_measured_is_the_field(
    told: str, tmp_path: Path
) -> None:
    numbers = 1e3 * TOLD if "mA" in told else TOLD
    recording = read(written(tmp_path / "log.csv", {"Current [A]": CURRENT, told: numbers}))
    assert recording.signals["field"] == pytest.approx(CURRENT)


def test_a_command_of_something_else_is_asked_about(tmp_path: Path) -> None:
    other = np.repeat([1.0, 0.0, 2.0, 0.0, 1.0, 2.0, 0.5, 1.5], 250)
    with pytest.raises(MappingError, match="field may be any of"):
        read(written(tmp_path / "log.csv", {"Current [A]": CURRENT, "Command [A]": other}))


@pytest.mark.parametrize(
    ("coil", "motor"),
    [
        ("Erregerstrom [A]", "Motorstrom [A]"),
        ("Excitation current [A]", "Motor current [A]"),
        ("Magnet current [A]", "Motor current [A]"),
        ("Field Current", "Motor Current"),
        ("I_brake", "I_motor"),
        ("Clutch current (A)", "Drive current (A)"),
        ("Courant bobine [A]", "Courant moteur [A]"),
        ("Solenoid current [A]", "Servo current [A]"),
    ],
)
def test_the_current_that_was_set_in_a_coil_is_the_field_beside_a_motors(
    coil: str, motor: str, tmp_path: Path
) -> None:
    """Of a device that turned one way the motor's current was read as the field, in silence."""
    for drive in (np.abs(MOTOR), MOTOR):
        recording = read(written(tmp_path / "log.csv", {motor: drive, coil: CURRENT}))
        assert recording.signals["field"] == pytest.approx(CURRENT)


def test_a_current_of_nobody_knows_what_beside_a_motors_is_asked_about(tmp_path: Path) -> None:
    currents = {"Motor current [A]": np.abs(MOTOR), "Unit 7 current [A]": CURRENT}
    with pytest.raises(MappingError, match="field may be any of"):
        read(written(tmp_path / "log.csv", currents))


@pytest.mark.parametrize("sensor", ["Hall sensor", "Hall", "Hall probe", "Hallsensor"])
def test_a_hall_sensor_in_units_of_a_flux_density_tells_the_field(
    sensor: str, tmp_path: Path
) -> None:
    recording = read(written(tmp_path / "log.csv", {f"{sensor} [mT]": 300.0 * CURRENT}))
    assert recording.signals["field"] == pytest.approx(0.3 * CURRENT)
    with pytest.raises(MappingError, match="no column for field"):
        read(written(tmp_path / "log.csv", {f"{sensor} [V]": 2.5 + CURRENT}))


def test_the_time_of_labview_is_its_x_value(tmp_path: Path) -> None:
    path = written(tmp_path / "log.csv", {"I [A]": CURRENT})
    path.write_text(path.read_text(encoding="utf-8").replace("t [s]", "X_Value"), encoding="utf-8")
    assert read(path).duration == pytest.approx(TIME[-1], abs=0.01)


def test_a_stress_beside_the_speed_of_a_rotor_is_no_effort_by_a_word(tmp_path: Path) -> None:
    """The fluid of a rheometer shears at another rate than its rotor turns: a column of such a kind is asked for."""
    path = tmp_path / "log.csv"
    rows = np.column_stack([TIME, 10.0 * SPEED, TORQUE])
    header = "Время [с],Скорость [об/мин],Напряж сдвига [мН/м²]"
    np.savetxt(path, rows, "%.7g", ",", header=header, comments="", encoding="utf-8")
    plan = plan_of(read_table(path), ColumnMap())
    assert any("makes no power" in doubt for doubt in plan.doubts)
    assert "COLUMN [" in plan.command()
