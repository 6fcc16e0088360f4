"""What a stranger's table is by its numbers: a faint voltage, a smoothed quotient, a steady clock, an empty column."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import LogError, MappingError
from erclutch.logs import ColumnMap, Plan, Table, plan_of, read


def _signals(columns: Mapping[str, Any], units: dict[str, str] | None = None) -> Plan:
    return plan_of(Table("a", columns, units or {}, "0" * 64), ColumnMap())


SPAN = np.arange(300) * 0.01
SWING = np.sin(9.0 * SPAN)


@pytest.mark.parametrize("name", ["voltage", "current", "Spannung", "电压"])
def test_an_output_of_a_sensor_is_no_field_without_a_word(name: str) -> None:
    faint = {"time": SPAN, "velocity": SWING, "force": SWING, name: 2e-5 + 1e-6 * SWING}
    assert [doubt.partition(",")[0] for doubt in _signals(faint).doubts] == [
        f"field is column {name} which never exceeds 2.1e-05"
    ]
    strong = {**faint, name: 2.0 + SWING}
    assert _signals(strong).doubts == ()


@pytest.mark.parametrize("unit", ["mA", "kV"])
def test_a_faint_field_is_told_in_its_own_unit(unit: str) -> None:
    log = {"time": SPAN, "velocity": SWING, "force": SWING, "voltage": 2e-5 + 1e-6 * SWING}
    plan = _signals(log, {"voltage": "kV"} if unit == "kV" else {})
    assert bool(plan.doubts) == (unit != "kV")


def test_a_smoothed_coefficient_of_friction_tells_which_force_is_the_friction() -> None:
    rng = np.random.default_rng(0)
    pressed = 9.0 + 0.01 * rng.standard_normal(SPAN.size)
    rubbed = 1.4 + 0.1 * SWING + 0.05 * rng.standard_normal(SPAN.size)
    smoothed = np.convolve(rubbed / pressed, np.full(9, 1 / 9), mode="same")
    smoothed[:5] = smoothed[-5:] = np.nan
    columns = {"Timestamp": SPAN, "Fz": pressed, "Fx": rubbed, "COF": smoothed, "Velocity": SWING}
    units = {"Timestamp": "s", "Fz": "N", "Fx": "N", "Velocity": "mm/s"}
    effort = _signals(columns, units).signal("effort")
    assert effort is not None
    assert effort.column == "Fx"
    # Numbers that are no quotient of the two tell nothing: the user is asked.
    plan = _signals({**columns, "COF": 3.0 * smoothed}, units)
    assert "effort" in {question.signal for question in plan.questions}


def test_of_several_columns_in_seconds_the_steady_one_is_the_time() -> None:
    columns = {"delay": SWING, "storage_t": SPAN, "stop": np.cumsum(1.0 + SWING), "velocity": SWING, "force": SWING}
    units = {"delay": "s", "storage_t": "s", "stop": "s"}
    clock = _signals(columns, units).clock
    assert clock is not None
    assert clock.column == "storage_t"
    # Two samples side by side, of which the second has fewer rows, have two times.
    shorter = np.where(SPAN < 1.0, 2.0 * SPAN, np.nan)
    for other in (2.0 * SPAN, shorter):
        assert _signals({**columns, "other_t": other}, {**units, "other_t": "s"}).clock is None


def test_a_table_that_lies_on_its_side_is_refused() -> None:
    columns = {f"c{i}": np.zeros(20) for i in range(1001)}
    with pytest.raises(LogError, match="20 rows of 1,001 columns: a log has one row a sample"):
        _signals(columns)


def test_the_motion_that_makes_a_power_with_an_effort_is_proposed() -> None:
    columns = {"U": SWING, "V_FZG": SWING, "PA1_Spd": SWING, "M_HM": SWING, "PA1_Trq": SWING**3, "P": SPAN}
    units = {"U": "V", "V_FZG": "km/h", "PA1_Spd": "rpm", "M_HM": "Nm", "PA1_Trq": "Nm", "P": "s"}
    command = _signals(columns, units).command()
    assert '--slip "PA1_Spd [rpm]"' in command
    assert '--effort "PA1_Trq [Nm]"' in command


@pytest.mark.parametrize("reader", ["csv", "json"])
def test_a_column_without_a_number_says_so_where_it_is_named(tmp_path: Path, reader: str) -> None:
    path = tmp_path / f"log.{reader}"
    names = ("t", "V [cm/s]", "F [N]", "I [A]")
    rows = [(time, swing, swing, None) for time, swing in zip(SPAN.tolist(), SWING.tolist(), strict=True)]
    if reader == "csv":
        lines = (",".join("" if cell is None else f"{cell:.4f}" for cell in row) for row in rows)
        path.write_text("\n".join([",".join(names), *lines]), encoding="utf-8")
    else:
        path.write_text(json.dumps([dict(zip(names, row, strict=True)) for row in rows]), encoding="utf-8")
    with pytest.raises(MappingError, match="column 'I' holds no number in any row"):
        read(path, field="I")


def test_a_signal_s_word_within_a_name_is_proposed_and_never_taken() -> None:
    plan = _signals({"time": SPAN, "act_vel_se": SWING, "act_torque_abs": SWING**3, "torque_limit": 2.0 + SWING})
    assert {question.signal for question in plan.questions} >= {"slip", "effort"}
    assert '--slip "act_vel_se"' in plan.command()
    assert '--effort "act_torque_abs"' in plan.command()


@pytest.mark.parametrize(
    ("time", "unit", "constants", "told"),
    [
        (SPAN, None, {}, "100 Hz"),
        (1e3 * SPAN, "ms", {}, "100 Hz"),
        (None, None, {"fs": 3004.8}, "3004.8 Hz"),
        (1e3 * SPAN, None, {}, ""),  # ms, or seconds: nobody says it
    ],
)
def test_a_rate_that_is_not_that_of_the_file_is_told(
    time: Any, unit: str | None, constants: dict[str, float], told: str
) -> None:
    columns = {"current": 1.0 + SWING, "velocity": SWING, "force": SWING}
    if time is not None:
        columns = {"time": time, **columns}
    table = Table("a", columns, {"time": unit} if unit else {}, "0" * 64, constants=constants)
    clock = plan_of(table, ColumnMap(rate=128.0)).clock
    assert clock is not None
    assert clock.sentence.endswith(f", though the file says {told}" if told else "(given)")


def test_a_rate_that_is_that_of_the_file_is_told_without_a_doubt() -> None:
    columns = {"time": SPAN, "current": 1.0 + SWING, "velocity": SWING, "force": SWING}
    clock = plan_of(Table("a", columns, {}, "0" * 64), ColumnMap(rate=100.0)).clock
    assert clock is not None
    assert "though" not in clock.sentence
