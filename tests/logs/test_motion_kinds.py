"""A torque turns and a force goes along a line: the position of that kind is taken or proposed. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, plan_of, read_table
from erclutch.logs.columns.labels import split_label

TIME = np.arange(400) / 200.0
CURRENT = np.repeat([0.0, 0.5, 1.0, 0.25], 100)
SPEED = 5.0 * np.sin(6.0 * TIME)
PLACE = -5.0 / 6.0 * np.cos(6.0 * TIME)
BESIDE = 2.0 + 0.3 * np.cos(3.0 * TIME)
EFFORT = (0.3 + 1.7 * CURRENT) * np.tanh(4.0 * SPEED) + 0.02 * SPEED


def plan_with(path: Path, names: str) -> Plan:
    """The plan of a log with the motion (M) that the effort (E) follows, and another motion (B), in any order."""
    values = {"M": PLACE, "B": BESIDE, "E": EFFORT}
    columns = {"time [s]": TIME, "current [A]": CURRENT}
    for label in names.split(","):
        which, _, name = label.partition(":")
        columns[name] = values[which]
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.6g")
    return plan_of(read_table(path), ColumnMap())


@pytest.mark.parametrize(
    ("names", "taken"),
    [
        (
            "B:Axial Displacement [mm],M:Rotary Displacement [deg],E:Torque [Nm]",
            "Rotary Displacement",
        ),
        ("B:Gap [mm],M:Angle,E:Torque [Nm]", "Angle"),
        ("B:Angle [deg],M:Travel [mm],E:Force [N]", "Travel"),
        ("M:Displacement [mm],B:Rotation [deg],E:Force [N]", "Displacement"),
    ],
)
def test_the_position_that_makes_a_power_with_the_effort_is_taken(
    tmp_path: Path, names: str, taken: str
) -> None:
    plan = plan_with(tmp_path / "machine.csv", names)
    plan.require_sureness()
    position = plan.signal("position")
    assert position is not None
    assert position.column == taken


@pytest.mark.parametrize(
    ("names", "proposed"),
    [
        ("B:Position [mm],M:Rotation [deg],E:Torque [Nm]", "Rotation [deg]"),
        ("B:Displacement [mm],M:Rotation,E:Torque [Nm]", "Rotation"),
        ("B:Crosshead [mm],M:Twist [rev],E:Torque [Nm]", "Twist [rev]"),
        (
            "B:Axial Displacement [mm],M:Rotary Displacement,E:Torque [Nm]",
            "Rotary Displacement",
        ),
        ("B:Axial displacement [mm],E:Torque [Nm]", "COLUMN [deg]"),
        ("B:Angle [deg],M:Stroke,E:Force [N]", "Stroke"),
    ],
)
def test_a_position_of_the_effort_s_kind_is_proposed(
    tmp_path: Path, names: str, proposed: str
) -> None:
    plan = plan_with(tmp_path / "machine.csv", names)
    assert plan.questions or plan.doubts
    assert plan.command().endswith(f'--position "{proposed}"')


@pytest.mark.slow
def test_a_speed_beside_a_torque_is_asked_for_in_turns(tmp_path: Path) -> None:
    assert plan_with(tmp_path / "a.csv", "M:c2,E:Torque [Nm]").command().endswith('"COLUMN [rpm]"')
    assert plan_with(tmp_path / "b.csv", "M:c2,E:Force [N]").command().endswith('"COLUMN [cm/s]"')


def test_rev_is_a_turn_behind_a_position_and_a_sense_behind_a_torque() -> None:
    assert split_label("Position (rev)") == ("Position", "rev")
    assert split_label("Torque (rev)") == ("Torque (rev)", None)
