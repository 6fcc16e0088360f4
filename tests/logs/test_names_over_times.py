"""A drive records pairs of a time and a value with the name over the time: the name is that of the value.

The data are SYNTHETIC.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, plan_of, read_table
from erclutch.signals.array import Array

COUNT = np.arange(400.0)
ANGLE = np.sin(COUNT / 40)
SPEED = np.cos(COUNT / 40) / 0.04  # rad/s, where the count is one of milliseconds
TORQUE = 2.0 * np.tanh(SPEED / 5) + 0.02 * SPEED


def written(path: Path, names: tuple[str, ...], below: str, *times_and_values: Array) -> Path:
    head = ",".join(f"{name}," for name in names) + "\n"
    below = ",".join([below] * len(names)) + "\n"
    rows = np.column_stack(times_and_values)
    body = "".join(",".join(f"{cell:.7g}" for cell in row) + "\n" for row in rows)
    path.write_text(head + below + body, encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("below", ["X,Y", "x,y"])
@pytest.mark.parametrize(
    "names",
    [
        ("Position actual value", "Velocity actual value", "Torque actual value"),
        ("Angle [rad]", "Speed [rad/s]", "Torque [Nm]"),
        ("q", "dq", "joint torque"),
    ],
)
def test_the_name_over_x_is_that_of_y(tmp_path: Path, names: tuple[str, ...], below: str) -> None:
    path = written(tmp_path / "a.csv", names, below, COUNT, ANGLE, COUNT, SPEED, COUNT, TORQUE)
    table = read_table(path)
    plan = plan_of(table, ColumnMap())
    taken = {each.signal: table.columns[each.column] for each in plan.signals if each.column}
    np.testing.assert_allclose(taken["position"], ANGLE, rtol=1e-6)
    np.testing.assert_allclose(taken["slip"], SPEED, rtol=1e-6)
    np.testing.assert_allclose(taken["effort"], TORQUE, rtol=1e-6)
    assert plan.clock is not None
    assert plan.clock.factor == pytest.approx(1e-3)


@pytest.mark.parametrize("names", [("0x2201/31", "0x6077"), ("Par 7", "Par 9"), ("A[1]", "A[2]")])
def test_names_that_say_nothing_are_those_of_the_values_too(
    tmp_path: Path, names: tuple[str, str]
) -> None:
    table = read_table(written(tmp_path / "a.csv", names, "X,Y", COUNT, ANGLE, COUNT, TORQUE))
    time, first, second = table.columns.values()
    np.testing.assert_array_equal(time, COUNT)
    np.testing.assert_allclose(first, ANGLE, rtol=1e-6)
    np.testing.assert_allclose(second, TORQUE, rtol=1e-6)


def test_curves_that_were_read_off_a_picture_keep_their_names_over_x(tmp_path: Path) -> None:
    rates = np.geomspace(0.1, 100.0, 12)
    names = ("Xanthan 0.5 %", "Xanthan 1 %")
    stresses = 3.0 + rates**0.5, 7.0 + rates**0.5
    path = written(tmp_path / "wpd.csv", names, "X,Y", rates, stresses[0], 2 * rates, stresses[1])
    first, *_ = read_table(path).columns.values()
    np.testing.assert_allclose(first, rates, rtol=1e-6)
