"""A brake beside its motor, a model beside a sensor, monitors and levers are told apart, or asked about."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, Plan, Table, plan_of, read
from erclutch.logs.columns.labels import name_columns
from erclutch.logs.columns.senses import with_senses
from erclutch.logs.readers.header_pairs import header_pairs
from erclutch.signals.array import Array

N = 800
ROWS = np.arange(float(N))
TIME = ROWS / 100  # s
LEVELS = 0.5 * (ROWS // 60 % 3)
TURN = np.sin(ROWS / 9)
DRAG = np.tanh(10 * TURN) * (1 + LEVELS)


def table_of(columns: Mapping[str, Array], **said: str) -> Table:
    names, own_units, _ = name_columns(list(columns))
    values = dict(zip(names, columns.values(), strict=True))
    known = dict(zip(names, own_units, strict=True))
    return Table("a.csv", values, known, "0" * 64, path="a.csv", metadata=said)


def planned(columns: Mapping[str, Array], **said: str) -> Plan:
    return plan_of(table_of({"Time (s)": TIME, **columns}, **said), ColumnMap())


def taken(plan: Plan) -> dict[str, str]:
    return {each.signal: each.column for each in plan.signals}


# --- the device and its drive -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("device", "drive"), [("brake", "motor"), ("Bremse", "Antrieb"), ("damper", "actuator")]
)
def test_the_torque_of_the_device_goes_before_that_of_its_drive(device: str, drive: str) -> None:
    torques = {f"{drive} torque (Nm)": 1.1 * DRAG + 0.1 * TURN, f"{device} torque (Nm)": DRAG}
    plan = planned({**torques, "speed (rad/s)": TURN, "current (A)": LEVELS})
    assert taken(plan)["effort"] == f"{device} torque"
    assert not plan.questions


def test_the_speed_of_the_brake_goes_before_that_of_a_motor_in_front_of_a_gear() -> None:
    plan = planned(
        {"motor_rpm": 20 * TURN, "brake_rpm": TURN, "torque_Nm": DRAG, "current_A": LEVELS}
    )
    assert taken(plan)["slip"] == "brake_rpm"


def test_of_two_torques_without_such_names_the_user_is_asked() -> None:
    plan = planned(
        {
            "torque A1 (Nm)": DRAG,
            "torque B1 (Nm)": 1.1 * DRAG,
            "speed (rad/s)": TURN,
            "current (A)": LEVELS,
        }
    )
    assert [question.signal for question in plan.questions] == ["effort"]


def test_a_motor_stands_behind_others_in_what_is_proposed() -> None:
    torques = {"motor torque (Nm)": 1.1 * DRAG, "flange torque (Nm)": DRAG}
    plan = planned({**torques, "speed (rad/s)": TURN, "current (A)": LEVELS})
    assert plan.examples == ('--effort "flange torque [Nm]"',)


def test_a_current_that_goes_along_with_the_torque_gives_way_to_that_of_a_coil() -> None:
    currents = {"Drive Current (A)": 3 * DRAG, "Brake Current (A)": LEVELS}
    plan = planned({**currents, "speed (rad/s)": TURN, "torque (Nm)": DRAG})
    assert taken(plan)["field"] == "Brake Current"
    assert not plan.doubts


@pytest.mark.parametrize("name", ["current (A)", "Current actual (A)"])
def test_a_current_of_a_drive_alone_is_proposed_as_no_field(name: str) -> None:
    plan = planned({name: 3 * DRAG, "speed (rad/s)": TURN, "torque (Nm)": DRAG})
    assert plan.doubts
    assert plan.command().endswith("--field none")
    assert "--field" in plan.doubts[0]


# --- models and sensors -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["F_BoucWen (N)", "F_dahl (N)", "Force LuGre (N)"])
def test_the_force_of_a_model_gives_way_to_that_of_an_experiment(model: str) -> None:
    plan = planned({"v (m/s)": TURN, "F_exp (N)": DRAG, model: 0.9 * DRAG, "i (A)": LEVELS})
    assert taken(plan)["effort"] == "F_exp"


@pytest.mark.parametrize("name", ["force_sim", "force_model", "predicted_force"])
def test_a_model_alone_is_named_and_not_proposed(name: str) -> None:
    plan = planned(
        {"displacement (mm)": TURN, "velocity (mm/s)": TURN, name: DRAG, "current (A)": LEVELS}
    )
    (question,) = plan.questions
    assert name in question.problem.partition(";")[2].partition(";")[0]
    assert "COLUMN" in plan.command()


@pytest.mark.parametrize("name", ["HV monitor (V)", "Vmon (V)", "HV (V)"])
def test_a_monitor_of_some_volts_is_doubted_with_a_scale(name: str) -> None:
    plan = planned({name: LEVELS, "speed (rad/s)": TURN, "torque (Nm)": DRAG})
    assert plan.doubts
    assert "field=1 kV/V" in plan.command()


def test_a_high_voltage_of_hundreds_of_volts_is_itself() -> None:
    plan = planned({"HV (V)": 1000 * LEVELS, "speed (rad/s)": TURN, "torque (Nm)": DRAG})
    assert not plan.doubts


@pytest.mark.parametrize("key", ["arm", "lever arm", "Hebelarm"])
def test_a_force_at_a_stated_arm_is_proposed_as_a_torque(key: str) -> None:
    plan = planned(
        {"force (N)": 5 * DRAG, "speed (rad/s)": TURN, "current (A)": LEVELS}, **{key: "20 cm"}
    )
    assert plan.doubts
    assert "effort=0.2 N*m/N" in plan.command()


def test_an_arm_beside_a_torque_changes_nothing() -> None:
    plan = planned({"torque (Nm)": DRAG, "speed (rad/s)": TURN, "current (A)": LEVELS}, arm="20 cm")
    assert not plan.doubts


def test_a_remark_may_end_in_a_quantity() -> None:
    assert header_pairs(["# lever arm 0.15 m", "gap 1 mm", "run 3 done", "made in 2021"]) == {
        "lever arm": "0.15 m",
        "gap": "1 mm",
    }


@pytest.mark.parametrize(
    ("name", "scale"),
    [
        ("hx711_raw", "effort=NUMBER N*m/count"),
        ("encoder_pulses", "position=NUMBER rad/count"),
        ("erpm", "slip=NUMBER rpm/count"),
    ],
)
def test_raw_numbers_are_asked_for_their_scale(name: str, scale: str) -> None:
    columns = {
        "angle (deg)": TURN,
        "torque (Nm)": DRAG,
        "current (A)": LEVELS,
        name: np.round(1000 * DRAG),
    }
    left_out = "torque (Nm)" if name.startswith("hx") else "angle (deg)"
    del columns[left_out]
    assert scale in planned(columns).command()


def test_a_scale_that_is_asked_anew_stands_once_in_the_command() -> None:
    told = ColumnMap.from_labels({"slip": "erpm"})
    columns = {"Time (s)": TIME, "torque (Nm)": DRAG, "current (A)": LEVELS, "erpm": TURN}
    from dataclasses import replace

    told = replace(told, scales={"slip": "NUMBER rpm/count"}, source="given")
    assert plan_of(table_of(columns), told).command().count("--scale") <= 1


# --- shafts, letters, directions --------------------------------------------------------------------------------------


def test_a_slip_in_percent_says_that_two_shafts_are_those_of_a_clutch() -> None:
    driving = 80.0 + 0.01 * np.sin(ROWS / 31)
    apart = 20.0 + 5.0 * TURN
    columns = {
        "motor_rpm": driving,
        "output_rpm": driving - apart,
        "slip_pct": 100 * apart / driving,
    }
    plan = planned({**columns, "torque_Nm": 1 + LEVELS, "current_A": LEVELS})
    assert taken(plan)["slip"] == "motor_rpm - output_rpm"


def test_another_share_beside_two_shafts_leaves_the_question() -> None:
    driving = 80.0 + 0.01 * np.sin(ROWS / 31)
    columns = {
        "motor_rpm": driving,
        "output_rpm": driving - 20.0 - 5.0 * TURN,
        "slip_pct": 50 + TURN,
    }
    plan = planned({**columns, "torque_Nm": 1 + LEVELS, "current_A": LEVELS})
    assert [question.signal for question in plan.questions] == ["slip"]


def test_what_a_drive_was_told_may_be_called_an_input_speed() -> None:
    told = np.roll(TURN, -3)
    plan = planned({"input_speed": told, "output_speed": TURN, "torque": DRAG, "current": LEVELS})
    assert plan.examples == ("--slip output_speed",) or plan.examples == ('--slip "output_speed"',)


@pytest.mark.parametrize("index", ["p", "d", "mr"])
def test_letters_with_an_index_are_told_by_their_course(index: str) -> None:
    place = np.cumsum(TURN) / 100
    plan = planned(
        {f"x_{index}": place, f"v_{index}": TURN, f"F_{index}": DRAG, f"i_{index}": LEVELS}
    )
    found = taken(plan)
    assert found["slip"] == f"v_{index}"
    assert found["effort"] == f"F_{index}"
    assert "--field none" not in plan.command()


@pytest.mark.parametrize(
    ("name", "numbers"),
    [("direction", (-1.0, 1.0)), ("dir", (0.0, 1.0)), ("Drehrichtung", (2.0, 1.0))],
)
def test_a_direction_in_numbers_gives_a_speed_its_sign(
    name: str, numbers: tuple[float, float]
) -> None:
    senses = np.where(TURN < 0, *numbers)
    table = with_senses(
        table_of({"speed_rpm": np.abs(TURN), name: senses, "torque_Nm": DRAG, "current_A": LEVELS})
    )
    np.testing.assert_allclose(table.columns["speed_rpm"], TURN)
    assert name not in table.columns


def test_a_direction_that_the_torque_does_not_keep_to_is_doubted() -> None:
    senses = np.where(np.sin(ROWS / 31) < 0, -1.0, 1.0)
    plan = planned(
        {"speed_rpm": np.abs(TURN), "direction": senses, "torque_Nm": DRAG, "current_A": LEVELS}
    )
    assert any("direction" in doubt for doubt in plan.doubts)


@pytest.mark.parametrize("name", ["speed_rpm", "omega (rad/s)"])
def test_a_speed_without_a_sign_beside_a_torque_with_one_is_doubted(name: str) -> None:
    plan = planned({name: np.abs(TURN), "torque (Nm)": DRAG, "current (A)": LEVELS})
    assert any("no sign" in doubt for doubt in plan.doubts)


@pytest.mark.parametrize("offset", [0.0, -0.02])
def test_a_speed_of_one_sense_with_a_torque_of_one_sense_is_not_doubted(offset: float) -> None:
    plan = planned(
        {"speed_rpm": np.abs(TURN), "torque (Nm)": np.abs(DRAG) + offset, "current (A)": LEVELS}
    )
    assert not plan.doubts


def test_of_six_components_that_which_goes_along_with_the_turns_is_proposed() -> None:
    noise = np.random.default_rng(1).normal(size=(5, N))
    others = dict(zip(("Fx (N)", "Fy (N)", "Fz (N)", "Tx (Nm)", "Ty (Nm)"), noise, strict=True))
    plan = planned({**others, "Tz (Nm)": DRAG, "omega (rad/s)": TURN, "current (A)": LEVELS})
    assert plan.examples == ('--effort "Tz [Nm]"',)


def test_of_six_components_beside_a_turn_that_goes_one_way_the_largest_torque_is_proposed() -> None:
    noise = np.random.default_rng(1).normal(size=(5, N))
    others = dict(zip(("Fx (N)", "Fy (N)", "Fz (N)", "Tx (Nm)", "Ty (Nm)"), noise, strict=True))
    brake = 5.0 + 20.0 * LEVELS
    columns = {**others, "Tz (Nm)": brake, "omega (rad/s)": 30.0 + 0.1 * TURN}
    assert planned({**columns, "current (A)": LEVELS}).examples == ('--effort "Tz [Nm]"',)


# --- supplies in other languages, efforts at rest ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("told", "measured"),
    [("励磁电流设定", "励磁电流反馈"), ("電流指令", "電流"), ("목표전류", "측정전류")],
)
def test_a_current_that_was_told_gives_way_to_that_which_was_measured(
    told: str, measured: str
) -> None:
    currents = {f"{told} (A)": np.round(LEVELS), f"{measured} (A)": LEVELS}
    plan = planned({**currents, "转速 (rpm)": TURN, "扭矩 (Nm)": DRAG})
    assert taken(plan)["field"] == measured


def test_efforts_at_rest_are_asked_for_no_rate() -> None:
    levels = np.linspace(0, 2, 21)
    plan = plan_of(
        table_of({"Current (A)": levels, "Holding torque (Nm)": 1 + levels}), ColumnMap()
    )
    assert "--rate" not in plan.command()


# --- decimal marks and milliseconds -----------------------------------------------------------------------------------


def text_of(*columns: Array) -> list[str]:
    return [";".join(f"{each:.5g}" for each in row) for row in zip(*columns, strict=True)]


@pytest.mark.slow
def test_rows_with_decimal_commas_below_rows_with_points_are_read(tmp_path: Path) -> None:
    lines = text_of(TIME, DRAG, TURN, LEVELS)
    half = [line.replace(".", ",") for line in lines[N // 2 :]]
    path = tmp_path / "a.csv"
    path.write_text(
        "\n".join(["Zeit [s];M [Nm];n [1/min];I [A]", *lines[: N // 2], *half, ""]),
        encoding="utf-8",
    )
    recording = read(path)
    np.testing.assert_allclose(recording.signals["effort"], DRAG, rtol=1e-4)
    assert any("decimal comma" in note for note in recording.notes)


@pytest.mark.slow
@pytest.mark.parametrize("row", ["1.5;2,5;0,1;0,5", "1,500.5;2.5;0.1;0.5"])
def test_a_row_with_both_marks_is_refused(tmp_path: Path, row: str) -> None:
    lines = text_of(TIME, DRAG, TURN, LEVELS)
    half = [line.replace(".", ",") for line in lines[N // 2 :]]
    path = tmp_path / "a.csv"
    path.write_text(
        "\n".join(["Zeit [s];M [Nm];n [1/min];I [A]", *lines[: N // 2], row, *half, ""]),
        encoding="utf-8",
    )
    with pytest.raises(LogError):
        read(path)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ms", "Millisecond"])
def test_milliseconds_beside_a_date_and_whole_seconds_are_one_time(
    tmp_path: Path, name: str
) -> None:
    lines: list[str] = []
    for time, *others in zip(TIME, DRAG, TURN, LEVELS, strict=True):
        whole = int(time + 1e-9)
        cells = ",".join(f"{each:.6g}" for each in others)
        lines.append(f"2024-03-01,10:00:{whole:02d},{round(1000 * (time - whole))},{cells}")
    path = tmp_path / "a.csv"
    head = f"Date,Time,{name},Torque (Nm),Speed (rad/s),Current (A)"
    path.write_text("\n".join([head, *lines, ""]), encoding="utf-8")
    recording = read(path)
    assert recording.period == pytest.approx(0.01)
    assert len(recording.segments) == 1
