"""Each joint of a robot's log is read by its own columns, where which joint is meant is all that is open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, Table, apply, plan_of
from erclutch.logs.joints_of_log import plans_of_joints
from erclutch.signals.array import Array

TIME: Array = 0.01 * np.arange(600.0)
NAMES = {
    "numbers": ("joint_{}_vel", "joint_{}_torque", ["1", "2", "3"]),
    "words": ("{}_vel", "{}_effort", ["waist", "shoulder", "elbow"]),
    "places": ("velocity[{}]", "effort[{}]", ["0", "1"]),
}


def robot(form: str, units: tuple[str, str] = ("", ""), joints: int = 3) -> Table:
    """A log of joints that move at the same time, each by its own size and with its own friction."""
    speed, effort, names = NAMES[form]
    columns: dict[str, Array] = {"time": TIME}
    known: dict[str, str | None] = {"time": "s"}
    for place, joint in enumerate(names[:joints], start=1):
        rate = place * np.sin((3.0 + 0.4 * place) * TIME)
        torque = place * np.tanh(8.0 * rate) + 0.1 * rate
        columns |= {speed.format(joint): rate, effort.format(joint): torque}
        known |= {speed.format(joint): units[0] or None, effort.format(joint): units[1] or None}
    return Table("arm.csv", columns, known, "seen", path="arm.csv")


def with_column(table: Table, name: str, values: Array, unit: str | None) -> Table:
    """The table with a further column, or with other numbers in a column."""
    return replace(
        table, columns={**table.columns, name: values}, units={**table.units, name: unit}
    )


@pytest.mark.slow
@pytest.mark.parametrize("form", NAMES)
def test_each_joint_is_read_by_its_own_columns(form: str) -> None:
    table = robot(form)
    speed, effort, names = NAMES[form]
    plan = plan_of(table, ColumnMap())
    joints = plans_of_joints(plan, table)
    read = [apply(each, table).signals for each in joints.values()]
    for signals, name in zip(read, names, strict=True):
        np.testing.assert_array_equal(signals["slip"], table.columns[speed.format(name)])
        np.testing.assert_array_equal(signals["effort"], table.columns[effort.format(name)])
        assert not signals["field"].any()
    assert [joint.name for joint in joints] == [
        f"joint {name}" if name.isdecimal() else name for name in names
    ]


@pytest.mark.slow
def test_units_of_each_joint_are_converted() -> None:
    table = robot("numbers", ("deg/s", "N*cm"))
    joints = plans_of_joints(plan_of(table, ColumnMap()), table)
    for plan, name in zip(joints.values(), "123", strict=True):
        signals = apply(plan, table).signals
        torque = table.columns[f"joint_{name}_torque"]
        np.testing.assert_allclose(signals["effort"], 0.01 * torque, rtol=1e-12)
        speed = table.columns[f"joint_{name}_vel"]
        np.testing.assert_allclose(signals["slip"], np.deg2rad(speed), rtol=1e-12)


@pytest.mark.slow
def test_nothing_is_read_where_more_than_the_joint_is_open() -> None:
    """Stamps that grow by 1 a row may be ms; a column of volts may be the field."""
    counted = with_column(robot("numbers"), "time", np.arange(600.0), None)
    plan = plan_of(counted, ColumnMap())
    assert plan.joints
    assert plans_of_joints(plan, counted) == {}

    levels = np.repeat([0.0, 1.0, 2.0], TIME.size // 3)
    drive = with_column(robot("numbers"), "level", levels, "V")
    plan = plan_of(drive, ColumnMap.from_options({"field": "none"}))
    assert plans_of_joints(plan, drive)
    plan = plan_of(drive, ColumnMap.from_options({"field": "level"}))
    for each in plans_of_joints(plan, drive).values():
        assert each.sure_field == "level"


def test_a_log_of_one_joint_has_none_to_choose() -> None:
    table = robot("numbers", joints=1)
    assert plans_of_joints(plan_of(table, ColumnMap()), table) == {}


@pytest.mark.slow
def test_a_fit_of_such_a_log_is_refused_with_both_ways_on() -> None:
    table = robot("words")
    with pytest.raises(MappingError) as refused:
        plan_of(table, ColumnMap()).require_sureness()
    remedy = refused.value.remedy
    assert '--slip "waist_vel" --effort "waist_effort"' in remedy
    assert "erclutch fit-many arm.csv --by joint" in remedy
