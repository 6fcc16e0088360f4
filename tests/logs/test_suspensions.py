"""The slip of a damper between body and wheel is what their speeds differ by, and neither of them alone. SYNTHETIC."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.plans_of_columns import planned

TIME = np.arange(1500) / 250
BODY, WHEEL = 0.25 * np.cos(5 * TIME), 0.27 * np.cos(9 * TIME)
CURRENT = np.repeat([0.0, 1.0, 0.5, 1.5, 2.0], 300)
FORCE = (50.0 + 300.0 * CURRENT) * np.tanh(30.0 * (BODY - WHEEL))
SPEEDS = [
    ("dz_s", "dz_u"),
    ("dz_s [m/s]", "dz_us [m/s]"),
    ("zs_dot", "zus_dot"),
    ("xs_dot", "xu_dot"),
    ("v_body", "v_wheel"),
    ("Sprung velocity [m/s]", "Unsprung velocity [m/s]"),
    ("v_Aufbau [m/s]", "v_Rad [m/s]"),
    ("簧上速度 [m/s]", "簧下速度 [m/s]"),
]


def bare(label: str) -> str:
    return label.partition(" [")[0]


@pytest.mark.parametrize(("body", "wheel"), SPEEDS)
def test_the_difference_is_the_slip_where_the_force_keeps_to_its_sign(
    body: str, wheel: str
) -> None:
    columns = {"t [s]": TIME, body: BODY, wheel: WHEEL, "I [A]": CURRENT, "force [N]": FORCE}
    plan = planned(columns)
    slip = plan.signal("slip")
    assert not plan.questions
    assert slip is not None
    assert slip.column == f"{bare(body)} - {bare(wheel)}"


@pytest.mark.parametrize(("body", "wheel"), SPEEDS)
def test_the_difference_is_asked_about_where_the_force_does_not(body: str, wheel: str) -> None:
    force = FORCE + 400.0 * np.sin(31 * TIME)
    columns = {"t [s]": TIME, body: BODY, wheel: WHEEL, "I [A]": CURRENT, "force [N]": force}
    plan = planned(columns)
    assert [question.signal for question in plan.questions] == ["slip"]
    assert f'--slip "{bare(body)} - {bare(wheel)}' in plan.command()


@pytest.mark.parametrize(
    ("body", "wheel"),
    [
        ("x_s", "x_us"),
        ("z_s [m]", "z_u [m]"),
        ("zs [m]", "zus [m]"),
        ("Sprung mass displacement [m]", "Unsprung mass displacement [m]"),
        ("Body position [m]", "Wheel position [m]"),
    ],
)
def test_positions_of_both_masses_make_the_stroke(body: str, wheel: str) -> None:
    places = {body: np.sin(5 * TIME) / 20, wheel: 0.03 * np.sin(9 * TIME)}
    plan = planned({"t [s]": TIME, **places, "I [A]": CURRENT, "force [N]": FORCE})
    position = plan.signal("position")
    assert not plan.questions
    assert position is not None
    assert position.column == f"{bare(body)} - {bare(wheel)}"


@pytest.mark.parametrize(
    ("first", "second"), [("v_u [V]", "v_b [V]"), ("i_s", "i_u"), ("temp_s", "temp_u")]
)
def test_other_letters_make_no_difference(first: str, second: str) -> None:
    columns = {"t [s]": TIME, "v [m/s]": BODY, first: CURRENT, second: WHEEL, "force [N]": FORCE}
    assert not any(" - " in name for name in planned(columns, field=first).labels)
