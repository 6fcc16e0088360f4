"""A number that stands for the effort, where a model estimates it, says nothing against the unit of the slip."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Table, plan_of

TIME = np.arange(400) / 100.0
TURNS = 300.0 + 90.0 * np.sin(4.4 * TIME)


@pytest.mark.parametrize("told", ["0 N", "0 N*m"])
def test_turns_beside_a_force_that_no_column_holds_are_not_doubted(told: str) -> None:
    columns = {"time": TIME, "Rotary.Velocity": TURNS}
    table = Table("run.csv", columns, {"time": "s", "Rotary.Velocity": "rpm"}, digest="")
    plan = plan_of(table, ColumnMap(constants={"field": "0 A", "effort": told}))
    assert not plan.doubts
    plan.require_sureness()
