"""A device between two moving ends slips by what they differ by, or by one of them, as its effort tells. SYNTHETIC."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.plans_of_columns import planned

TIME = np.arange(2000) / 250
FIELD = np.repeat([0.0, 1.0, 0.5, 1.5], 500)
FIRST = 0.2 * np.sin(7 * TIME)
SECOND = 0.15 * np.sin(5 * TIME + 1.0)


@pytest.mark.parametrize("unit", ["", " [m/s]"])
@pytest.mark.parametrize("names", [("x1_dot", "x2_dot"), ("dx1", "dx2"), ("v1", "v2")])
@pytest.mark.parametrize("both", [True, False])
def test_what_moves_a_device_is_told_by_the_sign_of_its_effort(
    names: tuple[str, str], unit: str, *, both: bool
) -> None:
    slip = FIRST - SECOND if both else SECOND
    force = (40.0 + 200.0 * FIELD) * np.tanh(slip / 0.01)
    first, second = names
    columns = {f"{first}{unit}": FIRST, f"{second}{unit}": SECOND}
    plan = planned({"t [s]": TIME, **columns, "F [N]": force, "I [A]": FIELD})
    wanted = f"{first} - {second}{unit}" if both else f"{second}{unit}"
    slip_of_plan = plan.signal("slip")
    if slip_of_plan is not None:
        assert slip_of_plan.column == wanted.removesuffix(unit)
    else:
        assert f'--slip "{wanted}"' in plan.command()


def test_joints_of_a_robot_are_no_ends_of_a_device() -> None:
    torque = 3.0 * np.tanh(FIRST)
    columns = {"dq1": FIRST, "dq2": SECOND, "tau1": torque, "tau2": 2.0 * np.tanh(SECOND)}
    plan = planned({"t [s]": TIME, **columns, "I [A]": FIELD})
    assert "dq1 - dq2" not in plan.command()
