"""Fields are told by their names and units: of a magnet, of a fluid, and as shares that a supply is told. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, plan_of, read_table

TIME = np.arange(400) / 200.0
LEVELS = np.repeat([0.0, 0.5, 1.0, 0.25], 100)
SPEED = 5.0 * np.sin(6.0 * TIME)
TORQUE = (0.3 + 1.7 * LEVELS) * np.tanh(4.0 * SPEED) + 0.02 * SPEED


def plan_with(path: Path, name: str) -> Plan:
    columns = {"time [s]": TIME, name: LEVELS, "speed [rad/s]": SPEED, "torque [Nm]": TORQUE}
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.6g")
    return plan_of(read_table(path), ColumnMap())


@pytest.mark.parametrize(
    ("name", "si", "factor"),
    [
        ("H_kAm", "A/m", 1e3),
        ("H (kA/m)", "A/m", 1e3),
        ("H_kA_per_m", "A/m", 1e3),
        ("H [A/m]", "A/m", 1.0),
        ("field_Oe", "A/m", 1000.0 / (4.0 * np.pi)),
        ("B_mT", "T", 1e-3),
        ("B [mT]", "T", 1e-3),
        ("B (G)", "T", 1e-4),
        ("E_kV_mm", "V/m", 1e6),
        ("Coil_pct", "", 0.01),
        ("coil %", "?", 1.0),
        ("coil", "?", 1.0),
        ("duty", "?", 1.0),
        ("PWM (0-255)", "?", 1.0),
    ],
)
def test_a_field_is_told_by_its_name_and_unit(
    tmp_path: Path, name: str, si: str, factor: float
) -> None:
    plan = plan_with(tmp_path / "brake.csv", name)
    plan.require_sureness()
    field = plan.signal("field")
    assert field is not None
    assert field.column
    assert field.si == si
    assert field.factor == pytest.approx(factor)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Load (%)", "Brake load [%]", "Drive (%)", "Valve [%]"])
def test_a_share_that_a_brake_may_be_told_is_asked_about(tmp_path: Path, name: str) -> None:
    plan = plan_with(tmp_path / "brake.csv", name)
    assert [each.signal for each in plan.questions] == ["field"]
    label = name.replace("(%)", "[%]")
    assert plan.command().endswith(f'--field "{label}"')


@pytest.mark.parametrize(
    "name", ["H [mm]", "coil temperature [°C]", "hardness", "Load [N]", "h_mm", "strain [%]"]
)
def test_other_quantities_are_no_field(tmp_path: Path, name: str) -> None:
    plan = plan_with(tmp_path / "brake.csv", name)
    field = plan.signal("field")
    assert field is None or not field.column
