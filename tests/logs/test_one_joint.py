"""Of several joints the first that moves is proposed with its own effort; sides of a device are asked about."""

from __future__ import annotations

import shlex

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of

TIME = 0.01 * np.arange(600)
RATE = np.sin(3.0 * TIME)
SIZES = (0.5, 1.0, 0.4, 0.7, 0.3, 0.6)


def planned(columns: dict[str, np.ndarray], name: str = "arm.csv") -> Plan:
    return plan_of(Table(name, columns, dict.fromkeys(columns), "x", path=name), ColumnMap())


def robot(
    speeds: list[str], efforts: list[str], sizes: tuple[float, ...] = SIZES
) -> dict[str, np.ndarray]:
    """A robot whose joints move at the same time, each by its own size and with its own friction."""
    columns = {"time": TIME}
    for place, (speed, effort) in enumerate(zip(speeds, efforts, strict=True)):
        rate = sizes[place] * np.sin((3.0 + 0.4 * place) * TIME)
        columns |= {speed: rate, effort: (1 + place) * np.tanh(8.0 * rate) + 0.1 * rate}
    return columns


def taken(plan: Plan) -> dict[str, str]:
    return {each.signal: each.column for each in plan.signals if each.column}


def assert_one_command_settles(plan: Plan, columns: dict[str, np.ndarray]) -> None:
    """What is printed leaves nothing open: it says too that there is no field, where that was asked."""
    words = shlex.split(plan.command())[3:]
    told = dict(zip((word.removeprefix("--") for word in words[::2]), words[1::2], strict=True))
    log = Table("arm.csv", columns, dict.fromkeys(columns), "x", path="arm.csv")
    settled = plan_of(log, ColumnMap.from_options(told))
    assert not settled.questions
    assert not settled.doubts


def test_speeds_that_nobody_filled_in_are_no_slip_beside_a_position_that_moves() -> None:
    """ROS writes velocities of zero where a driver gives none: no model can be fitted to them."""
    columns = {
        "time": TIME,
        "position0": -np.cos(3.0 * TIME) / 3.0,
        "position1": np.full(TIME.size, 0.7),
        "velocity0": np.zeros(TIME.size),
        "velocity1": np.zeros(TIME.size),
        "effort0": np.tanh(8.0 * RATE) + 0.1 * RATE,
        "effort1": 0.01 * np.sin(40.0 * TIME),
    }
    plan = planned(columns)
    assert taken(plan)["position"] == "position0"
    assert "velocity0" not in plan.command()
    assert_one_command_settles(plan, columns)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speed", "effort", "joints"),
    [
        ("joint_{}_vel", "joint_{}_torque", ["1", "2", "3"]),
        ("qd_{}", "tau_{}", ["0", "1", "2", "3"]),
        ("vel{}", "torque{}", ["1", "2", "3"]),
        ("{}_vel", "{}_effort", ["waist", "shoulder", "elbow", "wrist_rotate"]),
        ("panda_joint{}.velocity", "panda_joint{}.effort", ["1", "2"]),
        ("q{}_dot", "tau{}", ["1", "2", "3"]),
    ],
)
def test_the_first_joint_is_proposed_with_its_own_effort(
    speed: str, effort: str, joints: list[str]
) -> None:
    columns = robot(
        [speed.format(each) for each in joints], [effort.format(each) for each in joints]
    )
    plan = planned(columns)
    assert {question.signal for question in plan.questions} <= {"field"}
    assert taken(plan) == {"slip": speed.format(joints[0]), "effort": effort.format(joints[0])}
    assert_one_command_settles(plan, columns)
    other = f"another is --slip {speed.format(joints[1])} --effort {effort.format(joints[1])}"
    assert other in plan.doubts[0].replace('"', "")
    confirmed = f"--slip {speed.format(joints[0])} --effort {effort.format(joints[0])}"
    assert confirmed in plan.command().replace('"', "")


def test_the_joint_that_the_file_is_called_after_is_proposed() -> None:
    columns = robot([f"vel{k}" for k in (1, 2, 3)], [f"torque{k}" for k in (1, 2, 3)])
    assert taken(planned(columns, "friction_joint_3.csv")) == {"slip": "vel3", "effort": "torque3"}


@pytest.mark.slow
def test_logs_of_one_robot_give_the_same_joint_whichever_moves_most() -> None:
    names = [f"vel{k}" for k in (1, 2, 3)], [f"torque{k}" for k in (1, 2, 3)]
    assert taken(planned(robot(*names, (0.5, 1.0, 0.4)))) == taken(
        planned(robot(*names, (0.5, 0.3, 2.0)))
    )


def test_a_first_joint_at_rest_is_asked_about_with_the_liveliest_proposed() -> None:
    columns = robot(
        [f"vel{k}" for k in (1, 2, 3)], [f"torque{k}" for k in (1, 2, 3)], (0.001, 1.0, 0.4)
    )
    plan = planned(columns)
    assert {question.signal for question in plan.questions} == {"slip", "effort"}
    assert '--slip "vel2" --effort "torque2"' in plan.command()


@pytest.mark.parametrize(
    "parts",
    [
        ["motor", "load"],
        ["input", "output"],
        ["drive", "test"],
        ["1", "2"],
        ["motor", "load", "spring"],
        ["x", "y", "z"],
    ],
)
def test_sides_of_one_device_and_directions_are_asked_about(parts: list[str]) -> None:
    plan = planned(robot([f"{part}_speed" for part in parts], [f"{part}_torque" for part in parts]))
    assert plan.questions or plan.doubts
    assert not any("each a device of its own" in doubt for doubt in plan.doubts)


def test_joints_of_which_few_have_an_effort_are_asked_about() -> None:
    columns = robot([f"vel{k}" for k in range(1, 7)], [f"torque{k}" for k in range(1, 7)])
    for k in (3, 4, 5, 6):
        del columns[f"torque{k}"]
    assert planned(columns).questions


@pytest.mark.slow
def test_positions_and_accelerations_of_the_joints_are_no_field() -> None:
    columns = robot([f"q{k}_dot" for k in (1, 2)], [f"tau{k}" for k in (1, 2)])
    for k, size in ((1, 2.0), (2, 3.0)):
        columns |= {f"q{k}": size * np.cos(TIME), f"q{k}_dot_dot": np.sign(np.sin(size * TIME))}
    plan = planned(columns)
    assert "field" not in taken(plan)
    assert_one_command_settles(plan, columns)


def test_a_column_of_amperes_beside_joints_is_still_the_field() -> None:
    columns = robot([f"vel{k}" for k in (1, 2, 3)], [f"torque{k}" for k in (1, 2, 3)])
    columns["Coil current [A]"] = np.repeat([0.0, 1.0, 2.0], TIME.size // 3)
    plan = planned({name.replace(" [A]", ""): values for name, values in columns.items()})
    assert taken(plan)["field"] == "Coil current"
    assert taken(plan)["slip"] == "vel1"


@pytest.mark.parametrize("form", ["velocity[{}] position[{}] effort[{}]"])
@pytest.mark.parametrize("joint", ["0", "1"])
def test_a_position_is_that_of_the_joint_whose_speed_was_named(form: str, joint: str) -> None:
    columns: dict[str, np.ndarray] = {"time": TIME}
    for place in (0, 1):
        speed, position, effort = form.format(place, place, place).split()
        rate = SIZES[place] * np.sin((3.0 + 0.4 * place) * TIME)
        columns |= {position: np.cumsum(rate) * 0.01, speed: rate}
        columns[effort] = np.tanh(8.0 * rate)
    log = Table("arm.csv", columns, dict.fromkeys(columns), "x", path="arm.csv")
    told = {"slip": f"velocity[{joint}]", "effort": f"effort[{joint}]"}
    plan = plan_of(log, ColumnMap.from_labels(told))
    assert taken(plan)["position"] == f"position[{joint}]"


def test_a_current_that_each_of_two_actuators_has_is_no_field() -> None:
    columns: dict[str, np.ndarray] = {"time": TIME}
    for place in (1, 2):
        rate = SIZES[place] * np.sin((3.0 + 0.4 * place) * TIME)
        torque = place * np.tanh(8.0 * rate) + 0.1 * rate
        columns |= {f"Actuator {place} Velocity": rate, f"Actuator {place} Torque": torque}
        columns[f"Actuator {place} Current"] = 2.0 * torque
    plan = planned(columns)
    assert taken(plan) == {"slip": "Actuator 1 Velocity", "effort": "Actuator 1 Torque"}
    assert "--field none" in plan.command()
    assert not plan.questions
    assert_one_command_settles(plan, columns)


def test_the_speed_of_another_joint_is_not_offered_as_the_field() -> None:
    switched = np.random.default_rng(1).choice((0.2, 1.0), TIME.size // 25 + 1)
    # The other joint moves one way, and the first one's effort is larger where that is fast.
    other = np.repeat(switched, 25)[: TIME.size] + 0.02 * np.sin(9.0 * TIME)
    first = np.sin(3.0 * TIME)
    efforts = ((1.0 + 2.0 * other) * np.tanh(5.0 * first), 0.4 + 0.1 * np.sin(5.0 * TIME))
    columns: dict[str, np.ndarray] = {"time": TIME}
    for joint, (speed, effort) in enumerate(zip((first, other), efforts, strict=True), 1):
        columns |= {f"vela{joint}.txt": speed, f"trq{joint}.txt": effort}
    log = Table("arm.csv", columns, dict.fromkeys(columns), "x", path="arm.csv")
    told = ColumnMap.from_labels({"slip": "vela1.txt", "effort": "trq1.txt"})
    assert "--field none" in plan_of(log, told).command()
