"""What a drive computes, raw numbers of a converter and the current of a propeller are asked about. SYNTHETIC."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, plan_of, read, read_table
from erclutch.logs.saved_plan import mapping_text
from tests.support.plans_of_columns import planned, table

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
    assert plan.command().replace('"', "").endswith(f"--effort {name} --zero effort=NUMBER")
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


@pytest.mark.slow
def test_a_zero_is_taken_from_what_a_column_reads(tmp_path: Path) -> None:
    counts = np.round(2110.0 + 60.0 * TORQUE)
    path = tmp_path / "log.csv"
    labels = ["t [s]", "angle [rad]", "brake current [A]", "torque"]
    np.savetxt(
        path,
        np.column_stack([*BESIDE.values(), counts]),
        delimiter=",",
        header=",".join(labels),
        comments="",
        fmt="%.9g",
    )
    log = read(path, effort="torque", scale="effort=0.02 N*m/count", zero="effort=2110")
    np.testing.assert_allclose(log.signals["effort"], 0.02 * (counts - 2110.0), atol=1e-9)
    assert "zero at 2110" in " ".join(log.notes)
    turned = read(path, effort="-torque", scale="effort=0.02 N*m/count", zero="effort=2110 counts")
    np.testing.assert_allclose(turned.signals["effort"], -0.02 * (counts - 2110.0), atol=1e-9)
    # A mapping file keeps it, and a command that asks further repeats it.
    told = ColumnMap.from_options({"effort": "torque", "zero": ("effort=2110",)})
    plan = plan_of(read_table(path), told)
    (tmp_path / "log.csv.toml").write_text(mapping_text(plan), encoding="utf-8")
    np.testing.assert_allclose(read(path).signals["effort"], counts - 2110.0, atol=1e-9)
    assert "--zero effort=2110" in plan.command().replace('"', "")


@pytest.mark.parametrize(
    ("zero", "said"),
    [
        ("effort=none", "the zero of effort is 'none'"),
        ("effort=nan", "the zero of effort is 'nan'"),
        ("effort=2 V", "has no unit, and the zero of effort is 2 V"),
        ("torque=2", "--zero 'torque' is no signal"),
    ],
)
def test_a_zero_that_is_none_is_refused(zero: str, said: str) -> None:
    with pytest.raises(MappingError, match=re.escape(said)):
        plan_of(
            table({**BESIDE, "torque": TORQUE}),
            ColumnMap.from_options({"effort": "torque", "zero": (zero,)}),
        ).require_answers()


def test_a_zero_in_volts_is_converted_and_one_of_no_column_is_told() -> None:
    columns = {**BESIDE, "torque [mV]": 100.0 * TORQUE + 500.0}
    said = {"effort": "torque", "scale": ("effort=2 N*m/V",), "zero": ("effort=0.5 V",)}
    effort = plan_of(table(columns), ColumnMap.from_options(said)).signal("effort")
    assert effort is not None
    assert effort.offset == pytest.approx(-500.0 * effort.factor)
    plan = plan_of(
        table({**BESIDE, "torque [N*m]": TORQUE}),
        ColumnMap.from_options({"field": "none", "zero": ("field=2048",)}),
    )
    assert any("zero of field, 2048, is not used" in note for note in plan.notes)


def test_a_zero_that_the_file_states_is_offered() -> None:
    counts = np.round(2110.0 + 60.0 * TORQUE / np.abs(TORQUE).max())
    columns = {**BESIDE, "TorqueValue": counts}
    assert "--zero effort=NUMBER" in planned(columns).command().replace('"', "")
    stated = replace(table(columns), metadata={"torque zero": "2110"})
    command = plan_of(stated, ColumnMap()).command().replace('"', "")
    assert command.endswith("--effort TorqueValue --zero effort=2110")
    # Whoever scales counts about a zero wants that zero too; who named the column is told.
    scaled = ColumnMap.from_options({"scale": ("effort=0.02 N*m/count",)})
    assert "about its zero" in " ".join(plan_of(table(columns), scaled).doubts)
    notes = " ".join(planned(columns, effort="TorqueValue").notes)
    assert "as about the zero of a converter" in notes
