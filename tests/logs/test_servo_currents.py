"""The current of a servo that was told a motion is no field in silence. SYNTHETIC."""

from __future__ import annotations

import numpy as np

from tests.support.plans_of_columns import planned

TIME = np.arange(2000) / 200.0
ANGLE = 2800.0 + 60.0 * np.sin(3.0 * TIME)
LOAD = 0.4 * np.cos(3.0 * TIME) + 0.15 * np.sin(11.0 * TIME)
#: Against the load, as a servo signs it, with what the drive needs for itself.
CURRENT = -1.5 * LOAD + 0.5 * np.sin(7.0 * TIME)
SERVO = {
    "Timestamp": TIME,
    "Goal_Position": np.roll(ANGLE, -20),
    "Position": ANGLE,
    "Speed": 180.0 * np.cos(3.0 * TIME),
    "Load": LOAD,
}


def test_a_current_of_both_signs_beside_a_told_motion_is_asked_about() -> None:
    plan = planned({**SERVO, "Current": CURRENT})
    assert "beside a motion that a drive was told" in " ".join(plan.doubts)
    assert "--field none" in plan.command()


def test_a_current_of_one_sign_is_still_the_field() -> None:
    coil = np.repeat([0.0, 1.0, 0.5, 1.5], 500)
    plan = planned({**SERVO, "Load": (0.1 + coil) * np.tanh(LOAD), "Current": coil})
    assert not plan.doubts
    field = plan.signal("field")
    assert field is not None
    assert field.column == "Current"
