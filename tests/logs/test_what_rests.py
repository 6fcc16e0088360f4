"""Of several columns that may be a signal, the command of `inspect` offers none that rests, nor two of unlike axes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.signals.array import Array

TIME = np.arange(400) / 100.0
SWING = np.sin(6.0 * TIME)
FORCE = 3.0 * SWING + 0.2 * np.cos(6.0 * TIME)
REST = np.zeros_like(TIME)


def _planned(columns: Mapping[str, Array]) -> Plan:
    return plan_of(Table("log.csv", {"t": TIME, **columns}, {}, "0" * 64), ColumnMap())


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("force", ["F_{}", "F{}", "f{}"])
def test_a_force_goes_with_the_motion_along_its_own_axis(axis: str, force: str) -> None:
    columns: dict[str, Array] = {}
    for each in "xyz":
        moves = each == axis
        columns[each] = 0.1 * SWING if moves else REST
        columns[force.format(each)] = FORCE if moves else REST
    examples = _planned(columns).examples
    position = [example for example in examples if example.startswith("--position")]
    assert position in ([], [f'--position "{axis}"'])
    chosen = [example for example in examples if "force" in example or "effort" in example]
    assert chosen in ([], [f'--effort "{force.format(axis)}"'])


@pytest.mark.parametrize(
    "names",
    [
        ("speed a", "speed b", "torque a", "torque b"),
        ("Drehzahl A", "Drehzahl B", "Drehmoment A", "Drehmoment B"),
        ("v_a", "v_b", "f_a", "f_b"),
    ],
)
def test_what_rests_is_neither_taken_nor_offered_where_another_moves(
    names: tuple[str, str, str, str],
) -> None:
    rests, moves, of_rest, of_motion = names
    columns = {rests: REST, moves: SWING, of_rest: REST + 2.0, of_motion: FORCE}
    plan = _planned(columns)
    taken = [each.column for each in plan.signals]
    assert not {rests, of_rest} & {*taken}
    assert moves in taken or f'--slip "{moves}"' in plan.examples


def test_a_speed_at_rest_is_asked_about_beside_a_moving_speed_of_another_part() -> None:
    plan = _planned({"shaft speed": REST, "disc speed": SWING, "torque": FORCE})
    assert [question.signal for question in plan.questions] == ["slip"]


def test_a_device_at_rest_is_still_read() -> None:
    slip = _planned({"speed": REST, "torque": FORCE}).signal("slip")
    assert slip is not None
    assert slip.column == "speed"


@pytest.mark.parametrize("mark", ["TRAJECTORY_COMPLETE", "move finished", "target_reached"])
def test_a_mark_of_a_motion_s_end_is_no_field(mark: str) -> None:
    ended = (TIME > 3.0).astype(float)
    plan = _planned({"velocity": SWING, "torque": FORCE, mark: ended})
    assert plan.questions == ()
    field = plan.signal("field")
    assert field is not None
    assert field.column == ""


@pytest.mark.parametrize("mark", ["magnet", "coil on", "brake"])
def test_a_switch_of_a_coil_is_asked_about_still(mark: str) -> None:
    switched = (TIME > 3.0).astype(float)
    plan = _planned({"velocity": SWING, "torque": FORCE, mark: switched})
    field = plan.signal("field")
    assert plan.questions or (field is not None and field.column == mark)
