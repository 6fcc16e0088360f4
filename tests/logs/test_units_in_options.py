"""The printed command has the unit at the end of a name, where a column is asked about."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of, read
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.planning.units_in_options import with_unit_of_name

TIME = np.arange(400) / 100.0
SPEED = 5.0 * np.sin(4.4 * TIME) + 0.2 * np.sin(19.0 * TIME)
CURRENT = np.repeat([0.0, 1.0, 2.0, 0.5], 100)
TORQUE = 2.0 * np.tanh(SPEED) * (1.0 + CURRENT) + 0.1 * SPEED


def planned(measured: str, moved: str, driven: str, **options: str) -> Plan:
    columns = {"time": TIME, driven: CURRENT, moved: SPEED, measured: TORQUE}
    table = Table("run.csv", columns, dict.fromkeys(columns), digest="")
    return plan_of(table, ColumnMap.from_options(options))


@pytest.mark.parametrize(
    ("name", "unit", "factor"),
    [
        ("Output_lbf-ft", "lbf-ft", 1.3558179),
        ("Output_µNm", "µNm", 1e-6),
        ("Output: mN.m", "mN.m", 1e-3),
        ("Output_raw_N-mm", "N-mm", 1e-3),
        ("Output_kgf-cm_filtered", "kgf-cm", 0.0980665),
    ],
)
def test_the_option_for_an_effort_has_the_unit_of_its_name(
    name: str, unit: str, factor: float
) -> None:
    assert f'--effort "{name} [{unit}]"' in planned(name, "speed", "current").command()
    effort = planned(name, "speed", "current", effort=f"{name} [{unit}]").signal("effort")
    assert effort is not None
    assert effort.factor == pytest.approx(factor)


@pytest.mark.parametrize(
    ("slip", "option"),
    [
        ("Velocity_knots_mean", "Velocity_knots_mean [knots]"),
        ("Speed (deg_per_s)", "Speed (deg_per_s) [deg/s]"),
    ],
)
def test_the_option_for_a_slip_has_the_unit_of_its_name(slip: str, option: str) -> None:
    assert f'--slip "{option}"' in planned("torque", slip, "current").command()


@pytest.mark.parametrize(
    ("field", "unit"), [("Coil_picoamperes", "picoamperes"), ("Voltage_decivolts", "decivolts")]
)
def test_the_option_for_a_field_has_the_unit_of_its_name(field: str, unit: str) -> None:
    assert f'--field "{field} [{unit}]"' in planned("torque", "speed", field).command()


@pytest.mark.parametrize(
    ("option", "columns"),
    [
        ("--effort tau_hat", ["tau_hat"]),
        ("--position angle_in", ["angle_in"]),
        ("--slip 'n_rpm - m_rpm'", ["n_rpm - m_rpm"]),
        ("--effort COLUMN", ["torque"]),
        ("--rate '100 Hz'", ["rate_Hz"]),
    ],
)
def test_a_word_at_the_end_of_a_name_is_no_unit(option: str, columns: list[str]) -> None:
    table = Table("run.csv", dict.fromkeys(columns, TIME), dict.fromkeys(columns), digest="")
    assert with_unit_of_name(seen_columns(table), option) == option


def test_a_given_unit_that_the_name_contradicts_is_told(tmp_path: Path) -> None:
    """A torque called torque_Nm and given in N*mm was converted without a word."""
    rows = np.arange(300)
    lines = [f"{k / 100},{np.sin(k / 20):.4f},{np.tanh(9 * np.sin(k / 20)):.4f}" for k in rows]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["time [s],speed [rad/s],torque_Nm", *lines, ""]), encoding="utf-8")
    other = read(path, effort="torque_Nm [N*mm]", field="none")
    assert any("though the file says N*m" in note for note in other.notes)
    same = read(path, effort="torque_Nm [N*m]", field="none")
    assert not any("though the file says" in note for note in same.notes)
