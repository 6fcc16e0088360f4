"""Of several joints the first that moves is proposed with its own effort; sides of a device are asked about."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.signals.array import Array

TIME: Array = 0.01 * np.arange(600.0)
RATE = np.sin(3.0 * TIME)
NOISE = np.random.default_rng(3).standard_normal(TIME.size)
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
        ["motor", "load", "spring"],
        ["x", "y", "z"],
    ],
)
def test_sides_of_one_device_and_directions_are_asked_about(parts: list[str]) -> None:
    plan = planned(robot([f"{part}_speed" for part in parts], [f"{part}_torque" for part in parts]))
    assert plan.questions or plan.doubts
    assert not any("each a device of its own" in doubt for doubt in plan.doubts)


#: Speeds, torques and what tells two apart, in the languages that people write.
TWO = [
    ("vel{}", "tau{}", "12"),
    ("n{} [rpm]", "M{} [Nm]", "12"),
    ("{}_rpm", "Torque_{}", "BC"),
    ("rpm_{}", "torque_{}", "LR"),
    ("{} speed", "{} torque", ("left", "right")),
    ("Drehzahl {}", "Drehmoment {}", ("links", "rechts")),
    ("vitesse {}", "couple {}", ("gauche", "droite")),
    ("velocidad_{}", "torque_{}", ("izq", "der")),
    ("{}轮转速", "{}轮扭矩", "左右"),
]
#: The same of joints by name, of which the numbers need not tell.
LIMBS = [
    ("{}_vel", "{}_torque", ("knee", "ankle")),
    ("{} Drehzahl", "{} Drehmoment", ("Knie", "Hüfte")),
    ("vitesse {}", "couple {}", ("genou", "cheville")),
    ("{}关节速度", "{}关节力矩", "膝踝"),
    ("{}Vel", "{}Torque", ("shoulder", "elbow")),
]


def of_two(speed: str, effort: str, parts: Sequence[str], second: str = "apart") -> Plan:
    """A log of two motions, the second of which goes its own way or is joined to the first."""
    slow = np.sin(3.0 * TIME)
    torque = np.tanh(8.0 * slow) + 0.1 * slow
    courses: dict[str, tuple[Array, Array]] = {
        "apart": (np.cos(1.7 * TIME), 0.5 * np.tanh(8.0 * np.cos(1.7 * TIME))),
        "gear": (-0.2 * slow, 4.5 * torque),
        "clutch": (np.cos(1.7 * TIME), 0.98 * torque),
        "clutch behind a motor": (
            np.cos(1.7 * TIME),
            2.0 * np.tanh(8.0 * (slow - np.cos(1.7 * TIME))),
        ),
        "open clutch": (np.cos(1.7 * TIME), NOISE),
        "shaft": (slow + 1e-3 * NOISE, -torque),
        "one way": (1.5 + np.cos(1.7 * TIME), 0.5 * np.tanh(8.0 * np.cos(1.7 * TIME))),
    }
    names: dict[str, Array] = {"time": TIME}
    units: dict[str, str | None] = {"time": None}
    first = (slow, torque)
    if second == "clutch behind a motor":
        first = (slow, 30.0 * np.cos(3.0 * TIME) + courses[second][1])
    for part, (rate, effort_of) in zip(parts, (first, courses[second]), strict=True):
        for form, values in ((speed, rate), (effort, effort_of)):
            name, _, unit = form.format(part).partition(" [")
            names[name] = values
            units[name] = unit.rstrip("]") or None
    return plan_of(Table("log.csv", names, units, "x", path="log.csv"), ColumnMap())


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "effort", "parts"), [*TWO, *LIMBS])
def test_two_that_go_their_own_ways_are_devices_of_their_own(
    speed: str, effort: str, parts: Sequence[str]
) -> None:
    plan = of_two(speed, effort, parts)
    assert [joint.slip for joint in plan.joints] == [
        speed.format(part).partition(" [")[0] for part in parts
    ]
    assert not {"slip", "effort"} & {question.signal for question in plan.questions}


@pytest.mark.slow
@pytest.mark.parametrize(
    "joined", ["gear", "clutch", "clutch behind a motor", "open clutch", "shaft"]
)
@pytest.mark.parametrize(("speed", "effort", "parts"), TWO)
def test_two_that_one_transmission_may_join_are_asked_about(
    speed: str, effort: str, parts: Sequence[str], joined: str
) -> None:
    plan = of_two(speed, effort, parts, joined)
    assert not plan.joints
    assert plan.questions or plan.doubts


@pytest.mark.parametrize(
    ("speed", "effort"), [("v{}", "F{}"), ("x{}_dot", "F{}"), ("vel{}", "force{}")]
)
@pytest.mark.parametrize("parts", ["12", "123"])
def test_dampers_between_the_floors_of_a_frame_are_asked_about(
    speed: str, effort: str, parts: str
) -> None:
    """The second damper moves by what the speeds of two floors differ by."""
    plan = planned(robot([speed.format(k) for k in parts], [effort.format(k) for k in parts]))
    if speed != "vel{}" or len(parts) == 2:
        assert not plan.joints
    assert plan.questions or plan.doubts


def test_two_numbered_shafts_that_never_turn_back_are_asked_about() -> None:
    assert not of_two("n{}", "M{}", "12", "one way").joints
    assert of_two("rpm_{}", "torque_{}", "LR", "one way").joints


def test_three_shafts_that_share_one_torque_are_asked_about() -> None:
    """A planetary gear: its torques are in fixed ratios, its speeds are not."""
    columns = robot([f"n{k}" for k in (1, 2, 3)], [f"M{k}" for k in (1, 2, 3)])
    columns |= {"M2": 3.0 * columns["M1"], "M3": -4.0 * columns["M1"]}
    assert not planned(columns).joints


def test_two_motors_on_one_shaft_are_asked_about() -> None:
    plan = of_two("motor {} speed", "motor {} torque", "12", "shaft")
    assert not plan.joints
    assert of_two("motor {} speed", "motor {} torque", "12").joints


@pytest.mark.parametrize(
    ("name", "unit", "is_field"),
    [
        ("q{}", None, False),
        ("ddq{}", None, False),
        ("current{}", "A", False),
        ("pwm{}", None, False),
        ("temperature{}", None, False),
        ("q_des{}", None, False),
        ("field{}", "kV/mm", True),
        ("coil_current{}", "A", True),
        ("E{}", None, True),
    ],
)
def test_what_each_joint_has_besides_is_no_field_unless_a_fluid_has_it(
    name: str, unit: str | None, is_field: bool
) -> None:
    columns = robot([f"dq{k}" for k in (1, 2, 3)], [f"tau{k}" for k in (1, 2, 3)])
    besides = {name.format(k): np.cos((0.7 + 0.2 * k) * TIME) for k in (1, 2, 3)}
    units = dict.fromkeys(columns) | dict.fromkeys(besides, unit)
    plan = plan_of(Table("arm.csv", columns | besides, units, "x", path="arm.csv"), ColumnMap())
    assert len(plan.joints) == 3
    assert plan.leaves_open_which_joint != is_field


def test_currents_of_joints_that_keep_their_sign_may_be_those_of_coils() -> None:
    columns = robot([f"dq{k}" for k in (1, 2, 3)], [f"tau{k}" for k in (1, 2, 3)])
    for k in (1, 2, 3):
        columns[f"current{k}"] = 1.0 + np.cos((0.7 + 0.2 * k) * TIME)
    assert "field" in {question.signal for question in planned(columns).questions}


def test_speeds_on_the_side_of_the_torques_are_those_of_the_joints() -> None:
    """The motor in front of a gear turns faster, and its speed makes no power with the torque behind it."""
    joints = [f"joint_velocities_{k}" for k in (1, 2, 3)]
    columns = robot(joints, [f"joint_torques_{k}" for k in (1, 2, 3)])
    columns |= {name.replace("joint", "motor"): 100.0 * columns[name] for name in joints}
    assert [joint.slip for joint in planned(columns).joints] == joints


def test_raw_columns_stand_back_behind_those_of_the_bare_name() -> None:
    columns = robot([f"velocities_{k}" for k in (1, 2, 3)], [f"torques_{k}" for k in (1, 2, 3)])
    for name in [*columns]:
        signal, _, joint = name.partition("_")
        if joint:
            columns[f"{signal}_raw_{joint}"] = columns[name] + 0.01 * NOISE
    plan = planned(columns)
    assert [joint.slip for joint in plan.joints] == [f"velocities_{k}" for k in (1, 2, 3)]
    assert [joint.effort for joint in plan.joints] == [f"torques_{k}" for k in (1, 2, 3)]


def test_a_slow_joint_is_proposed_beside_a_fast_one() -> None:
    names = [f"vel{k}" for k in (1, 2, 3)], [f"torque{k}" for k in (1, 2, 3)]
    assert taken(planned(robot(*names, (0.05, 1.0, 0.4)))) == {"slip": "vel1", "effort": "torque1"}


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
