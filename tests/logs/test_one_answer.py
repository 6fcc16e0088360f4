"""One command answers all that is asked about a stranger's log, and what is plain is not asked."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import SeveralColumnsError, UnitError
from erclutch.logs import ColumnMap, Plan, Table, apply, plan_of, read_table
from erclutch.logs.columns.labels import split_label
from erclutch.signals import units
from erclutch.signals.array import Array

ROWS = np.arange(200.0)
TIME = ROWS / 100
ANGLE = np.sin(TIME * 7)
SPEED = 7 * np.cos(TIME * 7)
LEVELS = 0.5 * (ROWS // 20 % 3)


def planned(columns: dict[str, Array]) -> Plan:
    return plan_of(
        Table("a.csv", columns, dict.fromkeys(columns), "0" * 64, path="a.csv"), ColumnMap()
    )


def chosen(plan: Plan) -> dict[str, str]:
    return {signal: str(choice.column) for signal, choice in plan.choices.items()}


@pytest.mark.parametrize("name", ["Machine_Time", "OSL:timestamp", "C_1_Temps", "Log Zeit"])
def test_a_name_that_ends_in_a_time_and_rises_is_the_time(name: str) -> None:
    plan = planned({name: TIME, "velocity": SPEED, "force": SPEED**3})
    assert chosen(plan)["time"] == name
    assert not plan.questions


@pytest.mark.parametrize("name", ["rise_time", "dead time", "cycle_time", "exposure time"])
def test_a_span_is_no_time(name: str) -> None:
    assert "time" not in chosen(planned({name: TIME, "velocity": SPEED, "force": SPEED**3}))


def test_a_time_by_its_end_that_falls_is_none() -> None:
    assert "time" not in chosen(
        planned({"Machine_Time": TIME[::-1], "velocity": SPEED, "force": SPEED**3})
    )


@pytest.mark.slow
def test_numbered_joints_are_told_by_their_rate() -> None:
    plan = planned({"time": TIME, "q3": ANGLE, "dq3": SPEED, "tau_J": SPEED**3})
    assert (chosen(plan)["slip"], chosen(plan)["effort"]) == ("dq3", "tau_J")
    assert "slip" not in chosen(
        planned({"time": TIME, "q3": ANGLE, "dq3": ANGLE**2, "torque": SPEED**3})
    )


def test_of_several_joints_one_is_proposed_with_its_own_effort() -> None:
    columns = {"time": TIME}
    for joint in ("pitch", "roll"):
        columns |= {f"{joint}/velocity": SPEED, f"{joint}/effort": SPEED**3}
    del columns["pitch/effort"]
    columns["pitch/effort"] = SPEED**3  # comes last
    assert (
        planned(columns).command()
        == 'erclutch inspect a.csv --slip "pitch/velocity" --effort "pitch/effort"'
    )


def test_the_error_of_the_only_question_has_its_answers() -> None:
    """They were lost between the rule that asks and the error that says so."""
    two = {"position 1": ANGLE, "position 2": np.cos(TIME * 7)}
    plan = planned({"t": TIME, "current": LEVELS, **two, "force": SPEED**3})
    (question,) = plan.questions
    with pytest.raises(SeveralColumnsError) as asked:
        plan.require_answers()
    assert asked.value.answers == question.answers != ()


def test_a_proposed_command_invents_no_unit() -> None:
    command = planned(
        {"time": TIME, "inner_speed": SPEED, "outer_speed": SPEED / 2, "torque": SPEED**3}
    ).command()
    assert command == 'erclutch inspect a.csv --slip "inner_speed"'


def test_a_proposed_command_drops_what_is_missing() -> None:
    torque = np.where(ROWS % 7 == 0, np.nan, SPEED**3)
    command = planned(
        {"time": TIME, "inner_speed": SPEED, "outer_speed": SPEED / 2, "torque": torque}
    ).command()
    assert command.endswith('--slip "inner_speed" --invalid drop')


def test_a_proposed_command_says_nothing_of_a_few_missing_values() -> None:
    torque = np.where(ROWS == 7, np.nan, SPEED**3)
    command = planned(
        {"time": TIME, "inner_speed": SPEED, "outer_speed": SPEED / 2, "torque": torque}
    ).command()
    assert command.endswith('--slip "inner_speed"')


def test_one_motion_from_two_zeros_is_one_position() -> None:
    travel = 0.01 * ANGLE
    plan = planned(
        {
            "time": TIME,
            "Standard travel": travel,
            "Crosshead travel": travel - 0.755,
            "force": SPEED**3,
        }
    )
    assert chosen(plan)["position"] == "Standard travel"
    other = planned(
        {"time": TIME, "Standard travel": travel, "Crosshead travel": 2 * travel, "force": SPEED**3}
    )
    assert [question.signal for question in other.questions] == ["slip"]


@pytest.mark.parametrize(
    ("label", "name", "unit"),
    [
        ("轉速rpm", "轉速", "rpm"),
        ("電壓V", "電壓", "V"),
        ("位移mm", "位移", "mm"),
        ("轉矩n-m", "轉矩", "n-m"),
    ],
)
def test_a_unit_stands_right_behind_a_chinese_name(label: str, name: str, unit: str) -> None:
    assert split_label(label) == (name, unit)


@pytest.mark.parametrize("label", ["轉差drpm", "电流B", "电压A", "力矩"])
def test_a_letter_behind_a_chinese_name_may_be_no_unit(label: str) -> None:
    assert split_label(label) == (label, None)


@pytest.mark.parametrize("text", ["drpm", "dV", "dA", "drad/s"])
def test_a_difference_is_no_tenth(text: str) -> None:
    with pytest.raises(UnitError, match="not a unit"):
        units.parse(text)


def test_newton_metres_are_written_with_small_letters_and_points() -> None:
    assert units.parse("n-m").factor == units.parse("N*m").factor
    assert (
        units.parse("N・m").factor == units.parse("N･m").factor == units.parse("N*m").factor
    )  # Japanese points
    assert (
        units.parse("N?m").factor
        == units.parse("mN\ufffdm").factor * 1e3
        == units.parse("N*m").factor
    )
    assert units.parse("kgf.m").factor == pytest.approx(9.80665 * units.parse("N*m").factor)


def test_names_are_said_again_in_chinese_with_units(tmp_path: Path) -> None:
    rows = "\n".join(f"{t:.2f},{700 * v:.2f},{v**3:.4f}" for t, v in zip(TIME, SPEED, strict=True))
    path = tmp_path / "a.csv"
    path.write_text(f"time,speed,torque\n时间s,轉速rpm,轉矩kgf.m\n{rows}\n", encoding="utf-8")
    table = read_table(path)
    assert (list(table.columns), list(table.units.values())) == (
        ["time", "speed", "torque"],
        ["s", "rpm", "kgf.m"],
    )
    assert apply(plan_of(table, ColumnMap()), table).rows == 200


def test_numbers_are_quoted_with_their_line_end(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        "t,I,w,M\n"
        + "".join(
            f'{t:.2f},"{v:.3E}\n",{v:.3f},{v**3:.3f}\n' for t, v in zip(TIME, SPEED, strict=True)
        )
    )
    table = read_table(path)
    assert table.rows == 200
    assert table.columns["I"][:2] == pytest.approx(SPEED[:2], rel=1e-3)
    assert any("line end" in note for note in table.notes)


def test_a_quote_in_the_header_joins_no_rows(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        'disk 3.5" wide\n'
        + "t,w,M\n"
        + "".join(f'"{t:.2f}","{v:.3f}",1\n' for t, v in zip(TIME, SPEED, strict=True))
    )
    assert read_table(path).rows == 200


def test_what_windows_writes_for_no_number_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        "t,w,M\n"
        + "".join(
            f"{t:.2f},{v:.3f},{'-1.#IO' if t == 0.07 else f'{v:.2f}'}\n"
            for t, v in zip(TIME, SPEED, strict=True)
        )
    )
    assert np.flatnonzero(np.isnan(read_table(path).columns["M"])).tolist() == [7]


def test_a_bare_slip_beside_a_speed_with_a_unit_is_asked_about() -> None:
    values = {"time": TIME, "speed": SPEED, "slip": ANGLE, "torque": SPEED**3}
    table = Table(
        "a.csv", values, {"time": "s", "speed": "rpm", "slip": None, "torque": "N*m"}, "0" * 64
    )
    (question,) = plan_of(table, ColumnMap()).questions
    assert "slip may be any of the columns slip, speed" in question.problem


def test_the_rate_is_asked_for_where_no_column_can_be_the_time() -> None:
    plan = planned({"Index": ROWS, "displacement": ANGLE, "force": SPEED})
    assert plan.command() == 'erclutch inspect a.csv --rate "RATE Hz"'
    # Two that may be the position, and two efforts: none of them rises, so none of them is the time.
    several = {
        "Index": ROWS,
        "displacement_1": ANGLE,
        "displacement_2": 2.0 * ANGLE + SPEED,
        "Fx": SPEED,
        "Fy": -ANGLE,
    }
    command = planned(several).command()
    assert '--rate "RATE Hz" ' in command
    assert "--position" in command
    assert "COLUMN" not in command


@pytest.mark.parametrize(
    ("name", "unit", "option"),
    [
        ("Machine_N_cycles", None, '--rate "RATE Hz"'),
        ("wear", "um", '--rate "RATE Hz"'),
        ("counted", None, '--time "COLUMN [s]"'),  # it may be the time
    ],
)
def test_a_rising_column_of_another_quantity_is_no_time(
    name: str, unit: str | None, option: str
) -> None:
    columns = {name: np.floor(ROWS / 7), "displacement": ANGLE, "force": SPEED}
    plan = plan_of(Table("a.csv", columns, {name: unit}, "0" * 64, path="a.csv"), ColumnMap())
    assert option in plan.command()


@pytest.mark.parametrize("name", ["orient_x", "tool orientation", "quaternion w"])
def test_an_orientation_that_is_left_over_is_proposed_for_no_effort(name: str) -> None:
    plan = planned({"t": TIME, "velocity": SPEED, name: 0.1 * ANGLE})
    assert [each for each in plan.examples if each.startswith("--effort")] == [
        '--effort "COLUMN [N]"'
    ]


def test_the_command_for_a_sensor_of_a_position_holds_no_remark() -> None:
    columns = {"time": TIME, "E1": np.sin(TIME), "E2": np.cos(TIME), "LVDT": ANGLE, "torque": SPEED}
    told = {"time": "s", "E1": "V", "E2": "V", "LVDT": "V", "torque": "N*m"}
    table = Table("a.csv", columns, told, "0" * 64, path="a.csv")
    *_, position, scale, number = shlex.split(plan_of(table, ColumnMap()).command())
    assert (position, scale, number) == ("LVDT", "--scale", "position=NUMBER m/V")


@pytest.mark.parametrize("name", ["z_meas", "Z_actual", "z ist"])
def test_a_measured_axis_is_the_position_before_a_raw_sensor(name: str) -> None:
    columns = {"time": TIME, "Force_data": SPEED**3, "LVDT_raw": 2.0 + ANGLE, name: ANGLE}
    words = shlex.split(planned(columns).command())
    assert words[words.index("--position") + 1] == name


@pytest.mark.parametrize(
    "columns",
    [
        {"z_meas": ANGLE, "z_actual": SPEED},  # which of them?
        {"z_meas": np.zeros(200)},
        {"z_meas": ROWS},
        {"z_set": ANGLE},
    ],
)
def test_an_axis_that_may_be_none_is_not_offered(columns: dict[str, Array]) -> None:
    command = planned(
        {"time": TIME, "Force_data": SPEED**3, "LVDT_raw": 2.0 + ANGLE, **columns}
    ).command()
    assert '--position "z' not in command


@pytest.mark.parametrize(
    "names", [("y1",), ("i1",), ("v", "p"), ("rpm_2", "y"), ("u", "y1"), ("q", "y"), ("force", "y")]
)
def test_a_command_names_no_column_for_two_signals(names: tuple[str, ...]) -> None:
    courses = [SPEED + ANGLE, LEVELS, np.exp(-TIME)]
    columns = {"time": TIME, "V1": 6.0 + ANGLE, "V2": 2.0 * SPEED}
    columns |= dict(zip(names, courses, strict=False))
    words = shlex.split(planned(columns).command())[3:]
    named: list[str] = []
    for label in words[1::2]:
        name, _ = split_label(label)
        named += [part for part in name.split(" - ") if part not in ("none", "COLUMN")]
    assert len(named) == len({*named}), words


@pytest.mark.parametrize("name", ["signal1", "xyz", "Out 3"])
def test_a_column_that_is_left_over_is_called_so_where_it_is_offered_as_the_effort(
    name: str,
) -> None:
    plan = planned({"time": TIME, "velocity": SPEED, name: 3.0 * SPEED + ANGLE})
    (question,) = (each for each in plan.questions if each.signal == "effort")
    assert f"{name} may be it, as the column that is left over" in question.problem
    assert plan.command().endswith(f'--effort "{name}"')


@pytest.mark.parametrize("letter", ["h", "z", "l"])
def test_a_letter_for_a_length_that_is_left_over_is_offered_as_the_position(letter: str) -> None:
    plan = planned({"F": ANGLE**3, letter: ANGLE, "t": TIME})
    assert f'--position "{letter}"' in plan.command()
    assert letter not in chosen(plan).values()


@pytest.mark.parametrize("columns", [{"h": ANGLE, "k": SPEED}, {"h": 0.0 * ANGLE}, {"k": ANGLE}])
def test_a_letter_that_may_be_no_position_is_not_offered(columns: dict[str, Array]) -> None:
    assert "--position" not in planned({"F": ANGLE**3, **columns, "t": TIME}).command()
