"""What a drive computes, raw numbers of a converter and the current of a propeller are asked about. SYNTHETIC."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.plans_of_columns import planned

TIME = np.arange(1500) / 250
FIELD = np.repeat([0.0, 1.0, 0.5, 1.5, 2.0], 300)
SPEED = 12.0 * np.sin(5 * TIME)
TORQUE = (0.2 + 1.5 * FIELD) * np.tanh(SPEED / 0.3)
BESIDE = {"t [s]": TIME, "angle [rad]": -2.4 * np.cos(5 * TIME), "brake current [A]": FIELD}


@pytest.mark.parametrize(
    ("own", "sensor"),
    [
        ("motor_torque [N*m]", "force_sensor [mV]"),
        ("motor torque [N*m]", "torque sensor [V]"),
        ("drive_torque [N*m]", "load cell [counts]"),
        ("servo_torque [N*m]", "torque transducer [V]"),
    ],
)
def test_a_torque_of_a_drive_beside_the_output_of_a_sensor_is_asked_about(
    own: str, sensor: str
) -> None:
    noise = 0.05 * np.sin(77 * TIME)
    columns = {**BESIDE, own: TORQUE + noise, sensor: 4.0 * TORQUE}
    plan = planned(columns)
    assert not plan.questions
    assert f'--effort "{sensor}" --scale "effort=NUMBER N*m/' in " ".join(plan.doubts)
    assert plan.command().endswith(f'--effort "{own}"')
    assert not planned(columns, effort=own).doubts


@pytest.mark.parametrize(
    ("own", "sensor"),
    [
        ("torque [N*m]", "force_sensor [mV]"),
        ("motor_torque [N*m]", "supply [V]"),
        ("motor_torque [N*m]", "temperature sensor [V]"),
    ],
)
def test_another_effort_or_another_sensor_is_not_asked_about(own: str, sensor: str) -> None:
    plan = planned({**BESIDE, own: TORQUE, sensor: 4.0 + 0.1 * np.sin(TIME)})
    assert "a drive may compute" not in " ".join(plan.doubts)


PROPELLER = {
    "t [s]": TIME,
    "speed [rpm]": 3000.0 + 900.0 * np.sin(TIME),
    "torque [N*m]": 2.0 + np.sin(TIME),
    "current [A]": 10.0 + 5.0 * np.sin(TIME),
}


@pytest.mark.parametrize(
    "beside",
    [
        {"thrust [N]": 50.0 + 40.0 * np.sin(TIME), "voltage [V]": 24.0 - 0.1 * np.sin(TIME)},
        {"Schub [N]": 50.0 + 40.0 * np.sin(TIME), "Spannung [V]": 24.0 - 0.1 * np.sin(TIME)},
        {"ESC signal [us]": 1500.0 + 300.0 * np.sin(TIME)},
        {"throttle [%]": 50.0 + 30.0 * np.sin(TIME)},
    ],
)
def test_the_current_of_a_propeller_s_motor_is_no_field_in_silence(
    beside: dict[str, np.ndarray],
) -> None:
    doubts = " ".join(planned({**PROPELLER, **beside}).doubts)
    assert "current which stands beside" in doubts
    assert "as that of a motor under test" in doubts


def test_a_thrust_of_a_bearing_beside_a_current_is_no_propeller() -> None:
    thrust = 50.0 + 40.0 * np.sin(TIME)
    assert "motor under test" not in " ".join(planned({**PROPELLER, "thrust [N]": thrust}).doubts)


@pytest.mark.parametrize("name", ["adc_force", "ADC Torque", "force_adc", "adc_torque_1"])
def test_whole_numbers_of_a_converter_are_no_effort_in_silence(name: str) -> None:
    counts = np.round(2048.0 + 300.0 * TORQUE)
    columns = {**BESIDE, name: counts}
    plan = planned(columns)
    assert "in whole numbers of a converter" in " ".join(plan.doubts)
    assert plan.command().replace('"', "").endswith(f"--effort {name}")
    assert not planned(columns, effort=name).doubts
    # What was converted already has digits.
    assert not planned({**BESIDE, name: TORQUE}).doubts


def test_an_effort_that_stays_about_the_zero_of_a_converter_is_none_in_silence() -> None:
    counts = np.round(2110.0 + 60.0 * TORQUE / np.abs(TORQUE).max())
    plan = planned({**BESIDE, "TorqueValue": counts})
    assert "in whole numbers of a converter" in " ".join(plan.doubts)
    assert "N*m/count" in " ".join(plan.doubts)
    assert not planned({**BESIDE, "TorqueValue [mNm]": counts}).doubts
    # A load cell that shows whole newtons comes near to zero, and a pump does not run at 1500.4 rpm.
    assert not planned({**BESIDE, "force": np.round(600.0 * TORQUE)}).doubts
    speed = np.round(1500.0 + 30.0 * np.sin(TIME))
    assert "converter" not in " ".join(planned({**BESIDE, "torque": TORQUE, "speed": speed}).doubts)
