"""Telemetry of drives and robots: currents and supplies that are no field, told values, parts of one recording.

The data are SYNTHETIC.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, Plan, Table, plan_of, read_table
from erclutch.logs.planning.recording_choice import table_of_log
from erclutch.logs.readers.json_layout import cells_of

TIME = np.arange(600) / 100
ANGLE = np.sin(3 * TIME)
RATE = 3 * np.cos(3 * TIME)
TORQUE = np.tanh(8 * RATE) + 0.3 * RATE
LEVELS = np.repeat([0.0, 0.5, 1.0], 200)
SIGNALS = {"time": TIME, "position": ANGLE, "velocity": RATE, "torque": TORQUE}


def _plan(columns: dict[str, np.ndarray], **told: Any) -> Plan:
    return plan_of(
        Table("a.csv", columns, dict.fromkeys(columns), "x", path="a.csv"),
        ColumnMap.from_dict(told),
    )


def _columns(plan: Plan) -> dict[str, str]:
    return {each.signal: each.column for each in plan.signals}


def _upright(values: np.ndarray) -> np.ndarray:
    return np.reshape(values, (-1, 1))


@pytest.mark.parametrize("current", ["q_current", "Iq", "iq_measured", "motor_current", "mot_cur"])
@pytest.mark.parametrize("supply", ["voltage", "bus_voltage"])
def test_the_current_of_a_drive_and_its_supply_are_no_field(current: str, supply: str) -> None:
    plan = _plan({**SIGNALS, current: 12 * TORQUE, supply: np.full(TIME.size, 24.1)})
    assert plan.questions == plan.doubts == ()
    assert _columns(plan)["field"] == ""


def test_the_field_beside_the_current_of_a_drive_is_taken() -> None:
    plan = _plan({**SIGNALS, "motor_current": 12 * TORQUE, "coil_current": LEVELS})
    assert plan.questions == plan.doubts == ()
    assert _columns(plan)["field"] == "coil_current"


def test_a_high_voltage_beside_the_current_of_a_drive_is_the_field() -> None:
    plan = _plan({**SIGNALS, "motor_current": 12 * TORQUE, "voltage": np.full(TIME.size, 2000.0)})
    assert _columns(plan)["field"] == "voltage"


@pytest.mark.parametrize("word", ["des", "_des", "Des"])
def test_what_is_called_des_was_told(word: str) -> None:
    told = f"q{word}" if word != "des" else "des_q"
    plan = _plan(
        {"t": TIME, told: ANGLE, "q_meas": ANGLE + 0.01, "qd_meas": RATE, "tau_meas": TORQUE}
    )
    assert _columns(plan)["position"] == "q_meas"


def test_a_d_at_the_end_is_desired_beside_the_rate_itself() -> None:
    names = {"q": ANGLE, "q_d": ANGLE, "dq": RATE, "dq_d": RATE, "tau_J": TORQUE, "tau_J_d": TORQUE}
    assert _columns(_plan({"time": TIME, **names}))["slip"] == "dq"
    assert (
        _columns(_plan({"time": TIME, "q": ANGLE, "q_d": RATE, "torque": TORQUE}))["slip"] == "q_d"
    )


def test_what_a_drive_estimates_of_its_motion_is_the_motion_where_nothing_else_is() -> None:
    plan = _plan({"time": TIME, "pos_estimate": ANGLE, "vel_estimate": RATE, "torque": TORQUE})
    assert _columns(plan)["slip"] == "vel_estimate"
    plan = _plan({"time": TIME, "velocity": RATE, "vel_estimate": RATE, "torque": TORQUE})
    assert _columns(plan)["slip"] == "velocity"


@pytest.mark.slow
def test_numbers_of_joints_may_stand_within_names_and_behind_a_letter() -> None:
    inside: dict[str, np.ndarray] = {"time": TIME}
    behind: dict[str, np.ndarray] = {"time": TIME}
    for joint in range(3):
        share = 1.0 + joint
        inside |= {f"motors[{joint}].dq": share * RATE, f"motors[{joint}].tauEst": share * TORQUE}
        behind |= {
            f"MeasuredPosition_A{joint + 1}": share * ANGLE,
            f"MeasuredTorque_A{joint + 1}": share * TORQUE,
        }
    first = {each.signal: each.column for each in _plan(inside).signals if each.column}
    assert first == {"slip": "motors[0].dq", "effort": "motors[0].tauEst"}
    assert (
        _plan(behind)
        .command()
        .endswith('--position "MeasuredPosition_A3" --effort "MeasuredTorque_A3"')
    )


def test_the_load_of_a_spring_s_angle_is_no_effort() -> None:
    plan = _plan({"time": TIME, "theta_load": ANGLE, "omega_load": RATE, "tau_spring": TORQUE})
    assert plan.command().endswith('--effort "tau_spring"')


def _woven(joint: list[str], path: Path) -> Path:
    lines = [f"time,{joint[0]},position,velocity,effort"]
    for row, at in enumerate(TIME):
        for share, name in enumerate(joint[1:], start=1):
            lines.append(
                f"{at:.2f},{name},{share * ANGLE[row]:.6f},{share * RATE[row]:.6f},{share * TORQUE[row]:.6f}"
            )
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("joint", [["joint", "hip", "knee", "ankle"], ["motor_id", "1", "2", "3"]])
def test_rows_of_joints_that_take_turns_are_asked_about(tmp_path: Path, joint: list[str]) -> None:
    path = _woven(joint, tmp_path / "log.csv")
    plan = plan_of(read_table(path), ColumnMap())
    assert [question.signal for question in plan.questions] == ["variable"]
    variable = f"{joint[0]}={joint[3]}"
    assert plan.command().endswith(f'--variable "{variable}"')  # the joint that moves most
    chosen = plan_of(read_table(path, variable=variable), ColumnMap())
    assert chosen.questions == ()


@pytest.mark.slow
def test_words_in_turns_beside_one_course_of_time_ask_nothing(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = [
        f"{at:.2f},{'left' if v < 0 else 'right'},{v:.6f},{f:.6f}"
        for at, v, f in zip(TIME, RATE, TORQUE, strict=True)
    ]
    path.write_text("time,direction,velocity,torque\n" + "\n".join(rows) + "\n", encoding="utf-8")
    assert plan_of(read_table(path), ColumnMap()).questions == ()


@pytest.mark.usefixtures("read_here")
def test_structs_inside_of_a_struct_with_a_time_are_its_signals(tmp_path: Path) -> None:
    path = tmp_path / "log.mat"
    state = {"q": _upright(ANGLE), "dq": _upright(RATE), "tau": _upright(TORQUE)}
    savemat(path, {"data": {"time": _upright(TIME), "state": state, "info": {"robot": "elbow"}}})
    assert list(read_table(path).columns) == ["time", "q", "dq", "tau"]
    joints = {
        name: {"angle": ANGLE, "velocity": RATE, "torque": TORQUE} for name in ("hip", "knee")
    }
    savemat(path, {"exo": {"time": TIME, **joints}})
    assert "knee.torque" in read_table(path).columns


@pytest.mark.usefixtures("read_here")
def test_signals_to_the_workspace_with_one_time_are_one_recording(tmp_path: Path) -> None:
    path = tmp_path / "log.mat"
    signals = {"omega": RATE, "torque": TORQUE, "i_coil": LEVELS}
    structs = {
        name: {
            "time": _upright(TIME),
            "signals": {"values": _upright(values), "label": ""},
            "blockName": f"m/{name}",
        }
        for name, values in signals.items()
    }
    savemat(path, structs)
    plan = plan_of(read_table(path), ColumnMap())
    assert plan.questions == ()
    assert _columns(plan) == {"field": "i_coil", "slip": "omega", "effort": "torque"}
    structs["torque"]["time"] = _upright(TIME + 1e-3)
    savemat(path, structs)
    with pytest.raises(LogError, match="several recordings"):
        read_table(path)


@pytest.mark.usefixtures("read_here")
def test_a_struct_array_of_trials_with_structs_inside_is_opened(tmp_path: Path) -> None:
    trials = np.zeros(2, dtype=[("name", object), ("data", object)])
    for number in range(2):
        trials[number] = (
            f"trial{number}",
            {"time": TIME, "dq": (1 + number) * RATE, "tau": TORQUE},
        )
    path = tmp_path / "log.mat"
    savemat(path, {"S": trials})
    table = read_table(path, variable="S(2).data")
    assert np.array_equal(table.columns["dq"], 2 * RATE)


@pytest.mark.usefixtures("read_here")
def test_groups_under_one_time_are_one_recording(tmp_path: Path) -> None:
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as file:
        file["time"] = TIME
        for name, values in {
            "motor/velocity": RATE,
            "brake/current": LEVELS,
            "sensor/torque": TORQUE,
        }.items():
            file[name] = values
    plan = plan_of(read_table(path), ColumnMap())
    assert plan.questions == ()
    assert _columns(plan) == {"field": "current", "slip": "velocity", "effort": "torque"}


@pytest.mark.usefixtures("read_here")
def test_runs_of_one_test_stay_recordings_of_their_own(tmp_path: Path) -> None:
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as file:
        for run in ("run1", "run2"):
            for name, values in SIGNALS.items():
                file[f"{run}/{name}"] = values
    with pytest.raises(LogError, match="several recordings: run1, run2"):
        read_table(path)


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_a_field_in_another_recording_than_the_only_log_is_asked_about(tmp_path: Path) -> None:
    """It was left out, and the log was read at one field."""
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as file:
        for name, values in SIGNALS.items():
            file[f"fast/{name}"] = values
        file["slow/time"] = TIME[::10]
        file["slow/coil_current"] = LEVELS[::10]
    with pytest.raises(LogError, match="a log without a field, and slow may be the field"):
        table_of_log(path, ColumnMap(), None)
    plan = plan_of(table_of_log(path, ColumnMap(), None, "fast + slow"), ColumnMap())
    assert _columns(plan)["field"] == "coil_current"
    declined = ColumnMap.from_dict({"columns": {"field": "none"}})
    assert table_of_log(path, declined, None).rows == TIME.size


@pytest.mark.slow
def test_lists_beside_names_in_json_are_columns_of_joints(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    lines: list[str] = []
    for row in range(TIME.size):
        stamp = {"sec": int(TIME[row]), "nanosec": round((TIME[row] % 1) * 1e9)}
        state = {
            "name": ["hip", "knee"],
            "velocity": [RATE[row], 2 * RATE[row]],
            "effort": [TORQUE[row]] * 2,
        }
        lines.append(json.dumps({"header": {"stamp": stamp}, **state}))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    table = read_table(path)
    assert {"hip.velocity", "knee.effort"} <= {*table.columns}
    assert (
        plan_of(table, ColumnMap())
        .command()
        .endswith('--slip "knee.velocity" --effort "knee.effort"')
    )


def test_cells_of_a_row_have_names_for_each_place() -> None:
    row = {
        "t": 1,
        "q": [1, 2],
        "motors": [{"dq": 3}, {"dq": 4}],
        "arm": {"name": ["a", "b"], "tau": [5, 6]},
    }
    assert dict(cells_of(row)) == {
        "t": 1, "q_1": 1, "q_2": 2, "motors[0].dq": 3, "motors[1].dq": 4, "arm.a.tau": 5, "arm.b.tau": 6,
    }  # fmt: skip
    assert dict(cells_of({"name": ["a", "a"], "tau": [5, 6]})) == {
        "name_1": "a",
        "name_2": "a",
        "tau_1": 5,
        "tau_2": 6,
    }
