"""What a column is can be told by how its numbers go with others: rim speeds, phases, joints at rest, mixed rows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of, read_all
from erclutch.logs.plan import SignalPlan
from erclutch.signals.array import Array
from tests.support.command import good
from tests.support.plans_of_columns import planned
from tests.support.slow_params import slow_behind

pytestmark = pytest.mark.usefixtures("read_here")
ROWS = np.arange(600.0)
TIME = ROWS / 100
SLOW = np.sin(ROWS / 23)
TURN = np.cos(ROWS / 23)
NOISE = np.random.default_rng(5).normal(0.0, 0.01, ROWS.size)
DRAG = np.tanh(4 * TURN) + NOISE
STEPS = np.repeat([10.0, 50.0, 100.0, 150.0], 150)  # rad/s


def is_without_field(plan: Plan) -> bool:
    field = plan.signal("field")
    return not plan.questions and field is not None and not field.column


@pytest.mark.parametrize("turns", ["omega [rad/s]", "speed [rpm]", "rpm", "Drehzahl [1/min]"])
def test_a_v_in_proportion_to_turns_is_the_speed_of_a_rim_and_no_voltage(turns: str) -> None:
    plan = planned(
        {"t [s]": TIME, "v": 0.03 * STEPS, turns: STEPS, "T [N*m]": 0.2 + 1e-3 * STEPS + NOISE}
    )
    assert is_without_field(plan)


def test_a_v_of_its_own_beside_turns_is_asked_about() -> None:
    plan = planned(
        {"t [s]": TIME, "v": np.tile([5.0, 10.0], 300), "omega [rad/s]": STEPS, "T [N*m]": DRAG}
    )
    (question,) = plan.questions
    assert (question.signal, "voltage or velocity" in question.problem) == ("field", True)


def test_a_v_that_keeps_levels_beside_a_velocity_stays_a_voltage() -> None:
    field = planned(
        {"t [s]": TIME, "v": np.repeat([0.0, 5.0], 300), "velocity": TURN, "force": DRAG}
    ).signal("field")
    assert field is not None
    assert field.column == "v"


def field_of_a_machine(name: str, torque: Array, current: Array) -> tuple[Plan, SignalPlan]:
    plan = planned({"time [s]": TIME, "speed [rpm]": STEPS, "torque [N*m]": torque, name: current})
    field = plan.signal("field")
    assert field is not None
    return plan, field


@pytest.mark.parametrize(
    "name", ["load_current [A]", "generator_current", "Anker Strom [A]", "dut_current [A]"]
)
def test_the_current_of_a_machine_in_line_with_the_torque_is_proposed_as_no_field(
    name: str,
) -> None:
    current = 2 + SLOW
    plan, field = field_of_a_machine(name, 0.12 * current + 0.1 * NOISE, current)
    assert field.sureness == "doubtful"
    assert plan.command().endswith("--field none")


@pytest.mark.parametrize(
    "name",
    [
        "Ankerstrom",
        "Generatorstrom [A]",
        "courant d'induit",
        "Corriente en armadura [A]",
        "corrente di indotto",
        "ток якоря",
        "电枢电流",
        "发电机电流",
        "courant du moteur",
        "corrente motore",
        "ток двигателя",
        "电机电流",
        "モータ電流",
        "모터 전류",
    ],
)
def test_the_current_of_a_machine_is_no_field_in_other_languages(name: str) -> None:
    current = 2 + SLOW
    plan, field = field_of_a_machine(name, 0.12 * current + 0.1 * NOISE, current)
    assert field.sureness == "doubtful"
    assert plan.command().endswith("--field none")


@pytest.mark.parametrize(
    "name", ["courant", "corriente de freno", "制动电流", "电流", "Spulenstrom"]
)
def test_a_current_of_a_coil_or_of_nothing_else_stays_the_field(name: str) -> None:
    current = 2 + SLOW
    _, field = field_of_a_machine(name, 0.12 * current + 0.1 * NOISE, current)
    assert field.sureness != "doubtful"
    assert field.column == name


def beside_a_current(name: str, voltage: str, volts: Array) -> SignalPlan:
    current = 2 + SLOW
    columns = {"time [s]": TIME, "speed [rpm]": STEPS, "torque [N*m]": 0.12 * current}
    field = planned({**columns, voltage: volts, name: current}).signal("field")
    assert field is not None
    return field


@pytest.mark.parametrize(
    ("current", "voltage"),
    [
        ("armature current", "Voltage"),
        ("Ankerstrom", "Spannung"),
        ("corrente di armatura", "Tensione"),
        ("generator current", "Voltage"),
    ],
)
def test_the_voltage_of_a_machine_is_asked_about(current: str, voltage: str) -> None:
    field = beside_a_current(current, voltage, 12 + 3 * SLOW)
    assert (field.column, field.sureness) == (voltage, "doubtful")


@pytest.mark.parametrize(
    ("current", "voltage", "volts"),
    [
        ("armature current", "Voltage", 1200.0),  # across a fluid
        ("motor current", "Voltage", 12.0),  # of the drive that turns the device
    ],
)
def test_the_voltage_of_a_fluid_or_a_coil_beside_a_machine_is_the_field(
    current: str, voltage: str, volts: float
) -> None:
    field = beside_a_current(current, voltage, volts * (1 + 0.2 * SLOW))
    assert (field.column, field.sureness) == (voltage, "likely")


def test_the_load_current_of_an_eddy_current_brake_is_confirmed() -> None:
    current = np.tile(np.repeat([0.0, 1.0, 2.0], 25), 8)
    plan, field = field_of_a_machine("load_current [A]", 0.02 * STEPS * current**2 + NOISE, current)
    assert field.sureness == "doubtful"
    assert plan.command().endswith('--field "load_current [A]"')


def test_currents_of_both_machines_of_a_bench_are_asked_about_with_none_in_front() -> None:
    current = 2 + SLOW
    columns = {"time [s]": TIME, "speed [rpm]": STEPS, "torque [N*m]": 0.12 * current}
    plan = planned({**columns, "load_current [A]": current, "dut_current [A]": 1.3 * current})
    assert [question.signal for question in plan.questions] == ["field"]
    assert plan.command().endswith("--field none")


def command_for_two_currents(drives: str, brakes: str, of_the_brake: Array) -> str:
    torque = 2 + 8 * of_the_brake + 0.05 * NOISE
    columns = {"time [s]": TIME, "speed [rpm]": STEPS, "torque [N*m]": torque}
    plan = planned({**columns, drives: 0.3 + 0.2 * torque, brakes: of_the_brake})
    assert [question.signal for question in plan.questions] == ["field"]
    return plan.command()


@pytest.mark.parametrize(
    ("drives", "brakes"),
    [
        ("I_motor [A]", "I_brake [A]"),
        ("Motorstrom [A]", "Bremsstrom [A]"),
        ("电机电流 [A]", "制动电流 [A]"),
    ],
)
def test_of_the_currents_of_a_motor_and_a_brake_that_of_the_brake_is_proposed(
    drives: str, brakes: str
) -> None:
    levels = np.tile(np.repeat([0.0, 0.5, 1.0], 25), 8) + 0.001 * np.sign(NOISE)
    assert command_for_two_currents(drives, brakes, levels).endswith(f'--field "{brakes}"')


def test_a_current_of_a_brake_that_turns_its_sign_with_the_torque_is_a_machines() -> None:
    assert command_for_two_currents("I_motor [A]", "I_brake [A]", SLOW).endswith("--field none")


def test_of_the_currents_of_two_brakes_none_is_proposed() -> None:
    current = 2 + SLOW
    command = command_for_two_currents("brake_1_current [A]", "brake_2_current [A]", current)
    assert command.endswith("--field none")


def book_of(path: Path, names: list[str]) -> Path:
    with pd.ExcelWriter(path) as book:
        for place, name in enumerate(names):
            rows = {"Time (s)": TIME, "Displacement (mm)": SLOW, "Force (N)": (1 + place) * DRAG}
            pd.DataFrame(rows).to_excel(book, sheet_name=name, index=False)
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "letter"), slow_behind(1, [(["1A", "2A", "3A"], "A"), (["2V", "1V"], "V")])
)
def test_sheets_that_are_counted_may_be_specimens_and_are_asked_about(
    tmp_path: Path, names: list[str], letter: str
) -> None:
    book_of(tmp_path / "a.xlsx", names)
    said = good("inspect", "a.xlsx", cwd=tmp_path, code=1)
    assert f'--variable all --name-pattern "{{field}}{letter}"' in said
    assert (
        said.splitlines()[-1]
        == "What settles it: erclutch inspect a.xlsx --variable all --field none"
    )
    good("inspect", "a.xlsx", "--variable", "all", "--field", "none", cwd=tmp_path)
    of_fields = ColumnMap(name_pattern=f"{{field}}{letter}")
    fields = [log.signals["field"][0] for log in read_all(tmp_path / "a.xlsx", of_fields)]
    assert sorted(fields) == [*range(1, len(names) + 1)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "names",
    slow_behind(
        1, [["0A", "1A", "2A"], ["1 A", "2 A"], ["0.5A", "1A"], ["I_1A", "I_2A"], ["1A", "3A"]]
    ),
)
def test_sheets_that_are_not_counted_tell_their_fields(tmp_path: Path, names: list[str]) -> None:
    logs = read_all(book_of(tmp_path / "a.xlsx", names), ColumnMap())
    assert len({log.signals["field"][0] for log in logs}) == len(names)


def test_phases_that_a_power_analyser_shows_are_no_field() -> None:
    columns: dict[str, Array] = {"time [s]": TIME}
    for phase in (1, 2, 3):
        current = 1 + 0.2 * SLOW
        columns |= {f"U{phase}": 230 + NOISE, f"I{phase}": current, f"P{phase}": 160 * current}
        columns |= {f"Q{phase}": 150 * current, f"LAMBDA{phase}": 0.7 + NOISE}
    columns |= {"P_SIGMA": 480 + 100 * SLOW, "speed": 1500 - 100 * SLOW, "torque": 2 + SLOW}
    plan = planned(columns)
    assert is_without_field(plan)
    assert any(
        "each of the 16 columns U1 .. P_SIGMA belongs to the phases of a machine" in note
        for note in plan.notes
    )


def test_alternating_currents_by_their_names_are_no_field() -> None:
    columns = {
        "time [s]": TIME,
        "AC_Volt_L1_L2": 230 + NOISE,
        "AC_Curr_L1": 1 + SLOW**2,
        "AC_Curr_L2": 1 + SLOW**2,
    }
    assert is_without_field(planned({**columns, "Speed [rpm]": STEPS, "Torque [Nm]": 2 + SLOW}))


@pytest.mark.slow
def test_three_direct_currents_may_be_those_of_coils_and_are_asked_about() -> None:
    columns = {"time [s]": TIME} | {
        f"{letter}{k}": 1 + k * SLOW**2 for letter in "UI" for k in (1, 2, 3)
    }
    plan = planned({**columns, "speed [rpm]": STEPS, "torque [N*m]": 2 + SLOW})
    assert [question.signal for question in plan.questions] == ["field"]


def test_the_only_joint_whose_torque_changes_is_taken() -> None:
    joints = {
        "pos1": SLOW,
        "pos2": TURN,
        "vel1": TURN / 0.23,
        "vel2": -SLOW / 0.23,
        "tau1": 0 * ROWS,
        "tau2": DRAG,
    }
    plan = planned({"time": TIME, **joints})
    assert not plan.questions
    assert [each.column for each in plan.signals if each.column] == ["vel2", "pos2", "tau2"]
    first_free = {"pos3": SLOW**2, "vel3": SLOW * TURN, "tau3": DRAG[::-1].copy()}
    asked = planned(
        {"time": TIME, **joints, **first_free}
    )  # in another log of the robot the first may be meant
    assert {question.signal for question in asked.questions} >= {"slip", "effort"}


def test_a_motion_is_proposed_with_the_torque_of_its_own_joint() -> None:
    weights = {f"tau{joint}": 20 + 5 * SLOW**2 + joint for joint in range(4)}
    motions = {f"dq{joint}": (0.01 + joint) * TURN for joint in range(4)}
    plan = planned(
        {"time": TIME, **motions, **weights, "tau1": 30 * TURN}
    )  # along with every motion
    assert {question.signal for question in plan.questions} >= {"slip", "effort"}
    assert plan.command().endswith('--slip "dq3" --effort "tau3"')


def test_rows_that_follow_each_other_by_chance_need_no_time() -> None:
    speed = np.random.default_rng(3).normal(0.0, 10.0, ROWS.size)
    columns = {"velocity": speed, "torque": np.tanh(speed / 3)}
    plan = planned(columns)
    assert plan.clock is not None
    assert plan.clock.kind == "points"
    assert "velocity and torque are in no order" in plan.clock.sentence
    timed = plan_of(Table("a.csv", columns, {}, "0" * 64, path="a.csv"), ColumnMap(rate=100.0))
    assert timed.clock is not None
    assert timed.clock.kind != "points"


@pytest.mark.parametrize(
    "speed", [TURN, TURN + 0.3 * np.random.default_rng(3).normal(size=ROWS.size)]
)
def test_a_course_without_a_time_is_still_asked_for_its_rate(speed: Array) -> None:
    plan = planned({"velocity": speed, "torque": np.tanh(4 * speed)})
    assert "time" in {question.signal for question in plan.questions}


def test_the_separation_of_the_tools_of_a_testing_machine_is_no_field() -> None:
    travel = 5 * np.abs(SLOW)
    columns = {
        "Test time": TIME,
        "Standard travel": travel,
        "Tool separation": 26.8 - travel + NOISE,
    }
    assert is_without_field(planned({**columns, "Standard force": 20 * travel + NOISE}))


@pytest.mark.parametrize("name", ["yEst", "y_est", "x_estimate"])
def test_a_letter_that_is_estimated_is_no_position(name: str) -> None:
    plan = planned({"uEst": SLOW, "uVal": TURN, name: DRAG})
    assert not [each for each in plan.signals if each.column == name]


def test_a_position_that_a_drive_estimates_stays_one() -> None:
    position = planned({"time": TIME, "pos_estimate": SLOW, "torque": DRAG}).signal("position")
    assert position is not None
    assert position.column == "pos_estimate"


@pytest.mark.slow
def test_parts_of_rows_in_no_order_are_points_too(tmp_path: Path) -> None:
    speed = np.random.default_rng(3).normal(0.0, 10.0, 300)
    rows = [f"{'MLH'[k % 3]},{v:.4f},{np.tanh(v / 3):.4f}" for k, v in enumerate(speed)]
    text = "\n".join(["Type,speed [rad/s],torque [N*m]", *rows])
    (tmp_path / "a.csv").write_text(text + "\n", encoding="utf-8")
    asked = good("inspect", "a.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert asked.endswith('--variable "Type=all" --time none')
    good("inspect", "a.csv", "--variable", "Type=all", "--time", "none", cwd=tmp_path)


@pytest.mark.slow
def test_the_command_for_parts_says_that_what_numbers_all_rows_is_no_field(tmp_path: Path) -> None:
    speed = np.random.default_rng(3).normal(0.0, 10.0, 300)
    kinds = np.random.default_rng(4).integers(0, 3, 300)
    rows = [
        f"{k + 1},{'MLH'[kind]},{v:.4f},{np.tanh(v / 3):.4f}"
        for k, (kind, v) in enumerate(zip(kinds, speed, strict=True))
    ]
    text = "\n".join(["UDI,Type,speed [rad/s],torque [N*m]", *rows])
    (tmp_path / "a.csv").write_text(text + "\n", encoding="utf-8")
    asked = good("inspect", "a.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert asked.endswith('--variable "Type=all" --field none --time none')
    words = ("--variable", "Type=all", "--field", "none", "--time", "none")
    good("inspect", "a.csv", *words, cwd=tmp_path)


@pytest.mark.parametrize("name", ["", "row", "Unnamed: 0", "Sample"])
def test_the_number_of_a_row_is_no_input_that_helps_a_law(name: str) -> None:
    plan = planned(
        {
            name or "c1": ROWS,
            "time": TIME,
            "travel": SLOW,
            "force": DRAG,
            "pressure [bar]": 3 + SLOW**2,
        }
    )
    assert plan.spare == ("pressure",)


@pytest.mark.parametrize(
    ("name", "columns"),
    [
        ("predicted_torque", {"torque": DRAG, "predicted_torque": 0.9 * DRAG}),
        ("tau_2", {"tau_1": DRAG, "tau_2": 0.5 * SLOW, "dq_2": SLOW}),
        (
            "U1",
            {
                "torque": DRAG,
                **{f"{x}{k}": 2 + SLOW**2 for x in ("U", "I", "Q") for k in (1, 2, 3)},
            },
        ),
    ],
)
def test_computed_torques_torques_of_other_joints_and_phases_are_no_inputs(
    name: str, columns: dict[str, Array]
) -> None:
    labels = {"effort": "tau_1", "slip": "velocity"} if "tau_1" in columns else {}
    plan = planned({"time": TIME, "velocity": TURN, **columns}, field="none", **labels)
    assert name not in plan.spare


def test_a_drive_s_torque_that_is_a_current_times_a_number_gives_way_to_a_sensor() -> None:
    current = 3 * SLOW
    drive = {
        "motor_speed": TURN,
        "motor_measured_torque": 1.31 * current,
        "motor_measured_current": current,
    }
    effort = planned({"time": TIME, **drive, "adc_measured_torque": DRAG}).signal("effort")
    assert effort is not None
    assert effort.column == "adc_measured_torque"
    assert "motor_measured_torque is a current of its drive times a number" in effort.reason
    noisy = {**drive, "motor_measured_torque": 1.31 * current + NOISE}
    kept = planned({"time": TIME, **noisy, "adc_measured_torque": DRAG}).signal("effort")
    assert kept is None or kept.column != "adc_measured_torque"


@pytest.mark.slow
def test_the_command_for_one_of_several_joints_leads_to_no_second_question() -> None:
    joints: dict[str, Array] = {"time": TIME}
    for joint in range(1, 4):
        turned = np.sin(ROWS / 23 + joint)
        joints |= {
            f"q_{joint}": turned,
            f"dq_{joint}": np.cos(ROWS / 23 + joint),
            f"ddq_{joint}": -turned + NOISE,
        }
        joints[f"tau_{joint}"] = np.tanh(4 * np.cos(ROWS / 23 + joint)) + NOISE
    plan = planned(joints)
    assert plan.doubts
    assert plan.command().endswith('--field none --slip "dq_1" --effort "tau_1"')
    assert not planned(joints, slip="dq_1", effort="tau_1", field="none").questions
