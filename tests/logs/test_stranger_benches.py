"""Logs of benches that nobody prepared for us: what a careful reader would be sure of is read, the rest is asked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, apply, plan_of, read_table
from erclutch.logs.readers.loose_text import without_matrix
from tests.support.plans_of_columns import planned

ROWS = np.arange(400.0)
SLOW = np.sin(ROWS / 23)
TURN = np.cos(ROWS / 23)
DRAG = np.tanh(4 * TURN) + 0.1 * np.sin(ROWS / 5)


def read(path: Path, text: str) -> Plan:
    path.write_text(text, encoding="utf-8")
    return plan_of(read_table(path), ColumnMap())


@pytest.mark.parametrize(
    "label", ["Load [40.0 N]", "Load [10 N]", "Force [100 N]", "Torque [5 N*m]"]
)
def test_a_number_before_a_unit_may_be_the_range_of_a_sensor(label: str) -> None:
    plan = planned({"Time [s]": ROWS / 100, "Position [mm]": SLOW, label: DRAG})
    (question,) = (each for each in plan.questions if each.signal == "effort")
    name, _, unit = label.rstrip("]").partition(" [")
    assert f'--effort "{name} [{unit.split()[1]}]"' in plan.command().replace("'", '"')
    assert "range of its sensor" in question.problem
    given = planned(
        {"Time [s]": ROWS / 100, "Position [mm]": SLOW, label: DRAG}, effort=label, field="none"
    )
    effort = given.signal("effort")
    assert effort is not None
    assert effort.factor == pytest.approx(float(unit.split()[0]))


@pytest.mark.parametrize(
    ("label", "factor"),
    [("Force [0.1 N]", 0.1), ("Force [10^3 N]", 1000.0), ("Force [kN]", 1000.0)],
)
def test_what_a_count_is_worth_and_a_power_of_ten_are_factors(label: str, factor: float) -> None:
    effort = planned({"Time [s]": ROWS / 100, "Position [mm]": SLOW, label: DRAG}).signal("effort")
    assert effort is not None
    assert effort.factor == pytest.approx(factor)


@pytest.mark.parametrize(
    ("step", "unit"), [(9e6, "ns"), (4.0e6, "ns"), (9000.0, "us"), (20.0, "ms")]
)
def test_whole_stamps_without_a_unit_are_proposed_in_the_unit_of_a_usual_rate(
    step: float, unit: str
) -> None:
    stamps = 3.0 + step * ROWS + ROWS % 7
    plan = planned({"time": stamps, "pos [deg]": SLOW, "torque [N*m]": DRAG})
    assert plan.clock is not None
    assert f"as {unit} do" in plan.clock.doubt
    assert f"time [{unit}]" in plan.command()


def test_no_logger_takes_a_row_in_less_than_10_ns(tmp_path: Path) -> None:
    columns = {"time_us": ROWS * 5e-4, "w [rad/s]": TURN, "torque [N*m]": DRAG}
    plan = planned(columns)
    assert plan.clock is not None
    assert "no logger is fast" in plan.clock.doubt
    assert "time_us [s]" in plan.command()
    fast = planned({**columns, "time_us": ROWS * 0.5}).clock  # 2 MHz, as an oscilloscope takes
    assert fast is not None
    assert not fast.doubt
    assert fast.factor == pytest.approx(1e-6)


@pytest.mark.parametrize("name", ["time elapsed", "Time_Elapsed", "elapsed time"])
def test_elapsed_time_beside_a_time_since_1970_is_no_field(name: str) -> None:
    since_1970 = 1763923998329966879.0 + 6e6 * ROWS
    plan = planned(
        {"system time": since_1970, name: 6e6 * ROWS, "drive_pos": SLOW, "drive_torque": DRAG}
    )
    assert not plan.questions
    assert not plan.doubts
    assert plan.clock is not None
    assert plan.clock.column == "system time"
    assert plan.clock.factor == pytest.approx(1e-9)


@pytest.mark.parametrize(
    ("name", "factor"),
    [("Velocity_rot_s", 2 * np.pi), ("vel_degps", np.pi / 180), ("speed_rot_min", np.pi / 30)],
)
def test_turns_and_degrees_a_time_end_the_names_of_speeds(name: str, factor: float) -> None:
    slip = planned({"t [s]": ROWS / 100, name: TURN, "torque [N*m]": DRAG}).signal("slip")
    assert slip is not None
    assert slip.factor == pytest.approx(factor)


def test_a_column_without_its_sign_is_no_field() -> None:
    columns = {"t [s]": ROWS / 100, "pos [mm]": SLOW, "LoadCell1_N": DRAG, "ABS LC1": np.abs(DRAG)}
    plan = planned(columns)
    assert not plan.questions
    assert any("ABS LC1 is LoadCell1_N without its sign" in note for note in plan.notes)
    assert planned({**columns, "ABS X1": np.abs(SLOW) ** 3}).questions


def test_a_spare_input_that_goes_straight_with_the_force_is_an_output_of_its_sensor() -> None:
    columns = {
        "Time [s]": ROWS / 100,
        "Displacement [mm]": SLOW,
        "Force [kN]": DRAG,
        "Aux Input 5 [V]": 8 * DRAG,
    }
    plan = planned(columns)
    assert not plan.questions
    assert any("taken for another output of its sensor, left out" in note for note in plan.notes)
    scatter = DRAG.std() * np.random.default_rng(1).normal(size=DRAG.size)
    plan = planned({**columns, "Aux Input 5 [V]": 8 * DRAG + 2 * scatter})
    assert [each.signal for each in plan.questions] == ["field"]
    assert plan.command().endswith("--field none")
    del columns["Aux Input 5 [V]"]
    drive = planned(
        {**columns, "Current [A]": 8 * DRAG}
    )  # a name of a field: a motor's, or the coil's
    assert any('--field "Current"' in doubt for doubt in drive.doubts)
    assert drive.command().endswith("--field none")


BLUEHILL = """Results Table 1,,,
,,,
Results Table 2,,,
,,,
{number},Time,{motion},{force}
,(s),(mm),(kN)
"""


@pytest.mark.parametrize("number", ["1", "12"])
def test_bluehill_numbers_the_specimen_in_the_line_of_names(tmp_path: Path, number: str) -> None:
    rows = "\n".join(f",{k},{SLOW[k]:.4f},{DRAG[k]:.4f}" for k in range(60))
    head = BLUEHILL.format(number=number, motion="Displacement", force="Force")
    plan = read(tmp_path / "a.csv", head + rows + "\n")
    assert not plan.questions
    assert plan.clock is not None
    position = plan.signal("position")
    effort = plan.signal("effort")
    assert plan.clock.column == "Time"
    assert position is not None
    assert effort is not None
    assert (position.factor, effort.factor) == (0.001, 1000.0)
    recording = apply(plan, read_table(tmp_path / "a.csv"))
    assert recording.rows == 60


def test_more_names_than_values_in_a_row_are_told(tmp_path: Path) -> None:
    rows = "\n".join(f"{k / 100},{SLOW[k]:.4f},{DRAG[k]:.4f}," for k in range(60))
    plan = read(
        tmp_path / "a.csv",
        "time, drive_pos, drive_torque, test_pos, test_torque, sensor\n" + rows + "\n",
    )
    assert plan.doubts  # a name that fell apart at a comma would move the others
    assert any("names 6 columns, the rows have 3 cells" in note for note in plan.notes)


@pytest.mark.parametrize(
    "name", ["Control Effort", "control_effort", "controllerEffort", "pid_effort"]
)
def test_the_effort_of_a_control_loop_is_no_effort_of_a_device(name: str) -> None:
    plan = planned({"Time": ROWS / 100, "Encoder 1 Pos": SLOW, name: DRAG})
    assert "effort" in {each.signal for each in plan.questions}
    assert name not in plan.command()
    effort = planned({"Time": ROWS / 100, "elbow.position": SLOW, "elbow.effort": DRAG}).signal(
        "effort"
    )
    assert effort is not None


NAMES = ("Sample", "Time", "Encoder 1 Pos", "Torque")


@pytest.mark.parametrize(
    ("head", "between", "end"),
    [
        (f"{'   '.join(NAMES)}\n\n[    ", "    ", "];\n"),
        ("\t".join(NAMES) + "\n[", "\t", "]\n"),
        (f"% {', '.join(NAMES)}\ndata = [\n", ", ", ";\n];\n"),
    ],
)
def test_a_matrix_of_matlab_has_its_first_row_below_its_names(
    tmp_path: Path, head: str, between: str, end: str
) -> None:
    cells = [(str(k), f"{k / 100:.3f}", f"{SLOW[k]:.4f}", f"{DRAG[k]:.4f}") for k in range(60)]
    path = tmp_path / "a.txt"
    path.write_text(head + ";\n   ".join(map(between.join, cells)) + end, encoding="utf-8")
    table = read_table(path)
    assert tuple(table.columns) == NAMES
    assert table.rows == 60
    assert np.allclose(table.columns["Time"], ROWS[:60] / 100)
    assert np.allclose(table.columns["Torque"], DRAG[:60], atol=1e-4)
    assert any("a matrix of MATLAB" in note for note in table.notes)


@pytest.mark.parametrize(
    "text",
    ["a [N];b [m];\n1;2;\n3;4;\n", "x\n[1.5];\n[2.5];\n", "t,v\n0,1\n1,2 ]\n", "[1, 2]\n[3, 4]\n"],
)
def test_other_brackets_and_semicolons_are_no_matrix(text: str) -> None:
    assert without_matrix(text) == (text, "")


@pytest.mark.parametrize(
    ("name", "first", "told"),
    [("Time", 45_000.0, ""), ("Time", 738_000.4, ""), ("Date", 45_000.0, "d")],
)
def test_numbers_of_days_are_dates_of_spreadsheets_and_of_matlab(
    name: str, first: float, told: str
) -> None:
    days = first + ROWS * 0.005 / 86_400
    columns = {name: days, "pos [mm]": SLOW, "force [N]": DRAG}
    plan = planned(columns)
    if told:
        assert f"--time '{name} [{told}]'" in plan.command().replace('"', "'")
        plan = planned(columns, time=f"{name} [{told}]")
    assert plan.clock is not None
    assert plan.clock.factor == 86_400.0
    assert not plan.clock.doubt


def test_a_few_thousand_seconds_are_no_days() -> None:
    columns = {"time": 30_000.0 + ROWS * 0.01, "pos [mm]": SLOW, "force [N]": DRAG}
    clock = planned(columns).clock
    assert clock is not None
    assert clock.factor == 1.0
