"""Lists of a robot's joints, stamps in a unit that a motion tells, and names that mislead."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.names import spoken_name

ROWS = np.arange(400)
SECONDS = 0.02 * ROWS
MOVED = np.sin(1.7 * SECONDS)
SPEED = 1.7 * np.cos(1.7 * SECONDS)
RUBS = 0.4 * np.tanh(20.0 * SPEED) + 0.1 * SPEED


def _plan(columns: Mapping[str, Any], units: dict[str, str] | None = None, **told: str) -> Plan:
    return plan_of(Table("a", columns, units or {}, "0" * 64), ColumnMap.from_options(told))


def _asked(plan: Plan) -> list[str]:
    return [question.short for question in plan.questions] + list(plan.doubts)


@pytest.mark.parametrize(
    "words", [("positions", "velocities", "torques"), ("joint_pos", "joint_speeds", "efforts")]
)
def test_lists_of_joints_are_called_in_the_plural(words: tuple[str, str, str]) -> None:
    position, speed, effort = words
    log: dict[str, Any] = {"time": SECONDS}
    for joint in (1, 2, 3):
        log |= {
            f"{position}_{joint}": joint * MOVED,
            f"{speed}_{joint}": joint * SPEED,
            f"{effort}_{joint}": np.roll(RUBS, 40 * joint),
        }
    asked = _asked(_plan(log))
    assert f"slip is column {speed}_1 of one of 3 joints" in asked[0]
    assert asked[1] == f"effort is column {effort}_1 of the same joint"
    assert len(asked) == 2


@pytest.mark.slow
@pytest.mark.parametrize(("unit", "step"), [("ms", 20.0), ("us", 2e4), ("ns", 2e7)])
def test_stamps_without_a_unit_are_in_the_one_in_which_a_speed_is_the_rate_of_its_position(
    unit: str, step: float
) -> None:
    log = {"timestamp": 5.8 + step * ROWS, "position": MOVED, "velocity": SPEED, "torque": RUBS}
    plan = _plan(log)
    assert plan.clock is not None
    assert plan.clock.unit == unit
    assert _asked(plan) == []
    # A gripper in units of its own does not speak against two joints, and tells nothing alone.
    joints = {"timestamp": log["timestamp"], "torque": RUBS}
    for joint, scale in enumerate((1.0, 1.0, 2.3)):
        joints |= {f"position_{joint}": MOVED, f"velocity_{joint}": scale * SPEED}
    clock = _plan(joints).clock
    assert clock is not None
    assert clock.unit == unit
    alone = _plan({**log, "velocity": 2.3 * SPEED})
    assert any(doubt.startswith("time is column timestamp in s, though") for doubt in alone.doubts)


@pytest.mark.parametrize(("step", "times"), [(20.0, 1e-3), (2e4, 1e-3), (20.0, 1e3)])
def test_metres_beside_millimetres_tell_no_unit_of_the_stamps(step: float, times: float) -> None:
    # Stamps in ms or us, mm beside m/s or m beside mm/s: a thousand times apart, they look like another unit.
    log = {"timestamp": step * ROWS, "position": MOVED, "velocity": times * SPEED, "force": RUBS}
    assert any("timestamp in s, though" in doubt for doubt in _plan(log).doubts)
    units = (
        {"position": "mm", "velocity": "m/s"}
        if times < 1.0
        else {"position": "m", "velocity": "mm/s"}
    )
    clock = _plan(log, units).clock
    assert clock is not None
    assert clock.unit == ("ms" if step == 20.0 else "us")


def test_two_speeds_that_tell_two_units_of_the_stamps_tell_none() -> None:
    log = {"timestamp": 20.0 * ROWS, "torque": RUBS}
    log |= {
        "position_1": MOVED,
        "velocity_1": SPEED,
        "position_2": MOVED,
        "velocity_2": 1e3 * SPEED,
    }
    assert any("timestamp in s, though" in doubt for doubt in _plan(log).doubts)


@pytest.mark.parametrize("rate", [50.0, 250.0, 1000.0])
def test_the_rate_of_rows_without_stamps_is_told_by_a_speed_and_its_position(rate: float) -> None:
    at = ROWS / rate
    log = {
        "position": np.sin(0.1 * rate * at),
        "velocity": 0.1 * rate * np.cos(0.1 * rate * at),
        "torque": RUBS,
    }
    plan = _plan(log)
    assert f'--rate "{rate:g} Hz"' in plan.command()
    assert _asked(_plan(log, rate=f"{rate:g} Hz")) == []
    # In degrees beside radians a second, the units tell it; without units no rate that a logger is set to comes out.
    mixed = {**log, "position": np.degrees(log["position"])}
    assert (
        f'--rate "{rate:g} Hz"' in _plan(mixed, {"position": "deg", "velocity": "rad/s"}).command()
    )
    assert "--rate" not in _plan(mixed).command()


def test_seconds_since_1970_under_the_name_of_a_smaller_unit_are_doubted() -> None:
    log = {"timestamp": 1_767_109_211.446 + SECONDS, "velocity": SPEED, "torque": RUBS}
    assert [doubt.partition(",")[0] for doubt in _plan(log, {"timestamp": "ms"}).doubts] == [
        "time is column timestamp in ms"
    ]
    uptime = {
        **log,
        "timestamp": 1_767_109_211.0 + 20.0 * ROWS,
    }  # ms of a controller that ran for 20 days
    assert _plan(uptime, {"timestamp": "ms"}).doubts == ()
    assert _plan(log, {"timestamp": "s"}).doubts == ()


@pytest.mark.parametrize("label", ["Schlupf %", "slip %", "Slip [%]"])
def test_a_slip_in_per_cent_is_no_speed(label: str) -> None:
    name, _, unit = label.partition(" [")
    share = 0.3 + 0.1 * MOVED
    log = {"time": SECONDS, name: share, "Force": 20.0 + MOVED}
    plan = _plan(log, {name: "%"} if unit else {})
    assert plan.signal("slip") is None
    assert any(question.signal in ("slip", "position") for question in plan.questions)


@pytest.mark.parametrize("name", ["curr_motor", "current motor"])
def test_the_number_of_a_motor_is_no_current(name: str) -> None:
    log = {"time": SECONDS, name: np.full(400, 2.0), "rpm": 90.0 * SPEED, "torque": RUBS}
    log |= {"curr_target_A": np.sign(SPEED), "i_q_XY12_A": 3.0 * RUBS, "i_q_XY14_A": 2.0 * MOVED}
    plan = _plan(log)
    field = plan.signal("field")
    assert field is None or field.column != name
    assert any("taken for the number of a motor" in note for note in plan.notes)
    # A magnet's current that is held is the field of the log.
    held = _plan(
        {"time": SECONDS, "current": np.full(400, 2.0), "rpm": 90.0 * SPEED, "torque": RUBS}
    ).signal("field")
    assert held is not None
    assert held.column == "current"


@pytest.mark.parametrize("name", ["squared meters", "area square meters", "cubic meters"])
def test_an_area_is_no_position(name: str) -> None:
    log = {"time": SECONDS, name: 1.0 + MOVED, "Force": RUBS}
    assert _plan(log).signal("position") is None


@pytest.mark.parametrize(
    ("strain", "stress"), [("Dehnung 1", "Zugspannung"), ("Deformacion", "Contrainte")]
)
def test_strain_and_stress_beside_a_force_are_no_field(strain: str, stress: str) -> None:
    ramp = 0.01 * ROWS
    columns = {
        "Zeit": SECONDS,
        "Traversenweg": ramp,
        "Last": np.tanh(ramp),
        strain: 0.02 * ramp,
        stress: np.tanh(ramp),
    }
    units = {"Zeit": "s", "Traversenweg": "mm", "Last": "kN", strain: "%", stress: "MPa"}
    assert _asked(_plan(columns, units)) == []


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("Angle_Degrees", "deg"),
        ("ANGLE_RADIANS", "rad"),
        ("Travel_Millimeters", "mm"),
        ("Wheel_Rad", None),
    ],
)
def test_a_unit_that_is_written_out_is_read_in_letters_of_any_size(
    name: str, unit: str | None
) -> None:
    assert split_end(name)[1] == unit


@pytest.mark.parametrize(
    "name", ["rho_vs_delta_theta", "slope torque vs speed", "r force versus displacement"]
)
def test_what_was_made_of_two_quantities_is_neither_of_them(name: str) -> None:
    assert not any(spoken_name(name).heads.values())
    assert spoken_name("delta_theta").heads["position"] == "theta"
