"""A file that is called a plan or a simulation is asked about; a log of a test is not. The data are SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, Plan, plan_of, read_table
from erclutch.signals.array import Array
from tests.support.command import good
from tests.support.slow_params import slow_behind

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(1000) / 200.0
CURRENT = np.repeat([0.0, 0.5, 1.0, 0.25, 0.75], 200)
SPEED = 5.0 * np.sin(6.0 * TIME)
TORQUE = (0.3 + 1.7 * CURRENT) * np.tanh(4.0 * SPEED) + 0.02 * SPEED
NOISE = np.random.default_rng(1).normal(0.0, 0.02, (2, TIME.size))
BARE = {"time": TIME, "current": CURRENT, "velocity": SPEED, "torque": TORQUE}
NOISY = {**BARE, "velocity": SPEED + NOISE[0], "torque": TORQUE + NOISE[1]}
BOTH = {
    "time": TIME,
    "current": CURRENT,
    "velocity_ref": 1.1 * SPEED,
    "velocity_act": SPEED,
    "torque_ref": 1.1 * TORQUE,
    "torque_act": TORQUE,
}


def planned(path: Path, columns: dict[str, Array], told: ColumnMap | None = None) -> Plan:
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.6g")
    return plan_of(read_table(path), told or ColumnMap())


@pytest.mark.parametrize(
    ("name", "how"),
    slow_behind(
        5,
        [
            ("BF_traj.csv", "planned"),
            ("sim_run1.csv", "computed"),
            ("FEM-120rpm.csv", "computed"),
            ("reference.csv", "planned"),
            ("desired_trajectory.txt", "planned"),
            ("setpoints.csv", "planned"),
            ("cmd_3.csv", "planned"),
            ("plannedElbow2.csv", "planned"),
            ("Sollwerte.csv", "planned"),
            ("期望轨迹.csv", "planned"),
            ("simulation_test.csv", "computed"),
            ("仿真结果.csv", "computed"),
        ],
    ),
)
def test_an_effort_of_a_file_that_is_called_a_plan_or_a_simulation_is_asked_about(
    tmp_path: Path, name: str, how: str
) -> None:
    plan = planned(tmp_path / name, BARE)
    assert f"whose name says that it was {how}, not measured" in "; ".join(plan.doubts)
    with pytest.raises(MappingError, match="if a sensor measured it"):
        plan.require_sureness()
    assert plan.command().endswith('--effort "torque"')
    said = ColumnMap.from_options({"effort": "torque"})
    planned(tmp_path / name, BARE, said).require_sureness()


@pytest.mark.parametrize(
    ("name", "columns"),
    [
        ("reference_test.csv", BARE),  # a test that others are held against
        ("ref_brake_02.csv", BARE),
        ("reference.csv", BOTH),
        ("trajectory_2.csv", BOTH),
        ("trajectory_2.csv", NOISY),  # no plan has the noise of a sensor
        ("measured_trajectory.csv", BARE),
        ("mesure des couples.csv", BARE),
        ("brake_1.csv", BARE),
    ],
)
def test_a_log_that_was_measured_is_read_at_once(
    tmp_path: Path, name: str, columns: dict[str, Array]
) -> None:
    plan = planned(tmp_path / name, columns)
    plan.require_sureness()


def test_a_simulation_with_noise_is_asked_about_all_the_same(tmp_path: Path) -> None:
    assert "computed, not measured" in planned(tmp_path / "sim_3.csv", NOISY).doubts[0]


def test_what_is_asked_about_for_another_reason_says_too_that_it_was_planned(
    tmp_path: Path,
) -> None:
    columns = {"time": TIME, "velocity": SPEED, "torque_1": TORQUE, "torque_2": 2.0 * TORQUE}
    plan = planned(tmp_path / "traj_1.csv", columns)
    questions = [each.short for each in plan.questions]  # as they stand beside other questions
    assert "name says that it was planned, not measured" in "; ".join([*questions, *plan.doubts])


@pytest.mark.slow
def test_the_command_that_is_printed_settles_it(tmp_path: Path) -> None:
    planned(tmp_path / "BF_traj.csv", BARE)
    said = good("inspect", "BF_traj.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert said.endswith('erclutch inspect BF_traj.csv --effort "torque"')
    good("inspect", "BF_traj.csv", "--effort", "torque", cwd=tmp_path)


@pytest.mark.parametrize("name", ["model_torque_nm", "torque_sim", "tau_hat"])
def test_the_effort_of_a_model_is_offered_in_a_simulation(tmp_path: Path, name: str) -> None:
    plan = planned(
        tmp_path / "simulation_results.csv", {"time": TIME, "velocity": SPEED, name: TORQUE}
    )
    (question,) = (each for each in plan.questions if each.signal == "effort")
    assert "was not measured, by its name" in question.problem
    assert plan.command().endswith(f'--effort "{name}"')


@pytest.mark.parametrize(
    ("file", "columns"),
    [
        ("log_4.csv", {"model_torque": TORQUE}),  # beside measured columns it was not measured
        ("simulation.csv", {"torque_cmd": TORQUE}),  # what a drive was told moves the model
        ("simulation.csv", {"model_torque": TORQUE, "estimated_torque": 0.9 * TORQUE}),
    ],
)
def test_the_effort_of_a_model_is_not_offered_elsewhere(
    tmp_path: Path, file: str, columns: dict[str, Array]
) -> None:
    plan = planned(tmp_path / file, {"time": TIME, "velocity": SPEED, **columns})
    assert plan.command().endswith('--effort "COLUMN [N]"')
