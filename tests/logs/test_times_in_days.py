"""Dates as numbers of days, without a unit: fast rows are taken as days, rows a minute apart are asked about."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.signals.array import Array

ROWS = np.arange(800.0)
SPEED = 5.0 * np.sin(0.31 * ROWS) + 2.0 * np.sin(0.11 * ROWS)
TORQUE = 3.0 * np.tanh(SPEED) + 0.2 * SPEED


def planned(
    stamps: Array, name: str = "time", others: tuple[str, str] = ("speed", "torque")
) -> Plan:
    columns = {name: stamps, others[0]: SPEED, others[1]: TORQUE}
    table = Table("run.csv", columns, dict.fromkeys(columns), digest="")
    return plan_of(table, ColumnMap.from_options({"field": "none"}))


@pytest.mark.parametrize("first", [43_920.61, 738_000.51, 2_459_000.51, 59_000.51])
@pytest.mark.parametrize("step", [0.01, 0.5, 1.0])
def test_days_of_fast_rows_are_taken_as_days(first: float, step: float) -> None:
    clock = planned(first + ROWS * step / 86_400.0).clock
    assert clock is not None
    assert clock.factor == 86_400.0
    assert not clock.doubt


@pytest.mark.parametrize("first", [43_920.61, 738_000.51, 2_459_000.51])
@pytest.mark.parametrize("step", [2.0, 10.0, 60.0, 900.0])
def test_days_of_slow_rows_are_asked_about(first: float, step: float) -> None:
    plan = planned(first + ROWS * step / 86_400.0)
    assert plan.clock is not None
    assert "may be dates" in plan.clock.doubt
    assert plan.clock.likely == "d"


@pytest.mark.parametrize(
    ("first", "step"),
    [
        (43_920.61, 0.01),
        (43_920.61, 0.001),
        (43_920.0, 0.005),
        (30_000.0, 0.00125),
        (12.5, 1 / 1440),
    ],
)
def test_a_clock_that_runs_for_hours_is_in_seconds(first: float, step: float) -> None:
    clock = planned(first + ROWS * step).clock
    assert clock is not None
    assert clock.factor == 1.0
    assert not clock.doubt


@pytest.mark.parametrize(
    ("step", "unit"), [(0.01 / 86_400.0, "d"), (60.0 / 86_400.0, "d"), (0.01, "s")]
)
def test_the_option_for_columns_without_names_has_days(step: float, unit: str) -> None:
    command = planned(43_920.61 + ROWS * step, "c1", ("c2", "c3")).command().replace('"', "'")
    assert f"--time 'c1 [{unit}]'" in command


def test_the_answer_for_slow_rows_is_in_days() -> None:
    plan = planned(43_920.61 + ROWS / 1440.0)
    with pytest.raises(MappingError, match=r'or --time "time \[d\]"'):
        plan.require_sureness()
