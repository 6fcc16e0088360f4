"""A flow curve is read in the units behind its quantities, in any form; a unit that nobody knows is asked about."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError, UnitError
from erclutch.wings.rheology.flow_curve_file import read_flow_curves

RATE = np.geomspace(0.1, 500.0, 25)  # 1/s
STRESS = 12.0 + 3.0 * RATE**0.6  # Pa
MARKS = ["{} [{}]", "{} ({})", "{}, {}", "{}: {}", "{} - {}", "{} {}", "{}_{}", "{}.{}"]


def written(path: Path, rate: str, stress: str, values: np.ndarray) -> Path:
    columns = np.column_stack([RATE, values])
    np.savetxt(path, columns, "%.9g", ";", header=f"{rate};{stress}", comments="", encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("mark", MARKS)
@pytest.mark.parametrize(
    ("quantity", "unit", "pascals"),
    [
        ("Shear stress", "mPa", 1e-3),  # was Pa behind a point
        ("Напряжение сдвига", "мПа", 1e-3),  # was Pa
        ("Напряжение сдвига", "кгс/см²", 98066.5),  # was Pa
        ("Schubspannung", "mbar", 100.0),  # was Pa behind a point
        ("Shear stress", "N/m^2", 1.0),
        ("Viscosity", "mPa.s", 1e-3),
        ("Viscosity", "Pa s", 1.0),
        ("Viskosität", "mPa s", 1e-3),
        ("粘度", "kg/m/s", 1.0),
        ("Viscosité", "N·s/m²", 1.0),
    ],
)
def test_a_flow_curve_is_read_in_the_unit_behind_its_quantity(
    quantity: str, unit: str, pascals: float, mark: str, tmp_path: Path
) -> None:
    is_viscosity = quantity.lower().startswith(("vis", "粘"))
    values = (STRESS / RATE if is_viscosity else STRESS) / pascals
    path = written(
        tmp_path / "curve.csv",
        mark.format("Shear rate", "1/s"),
        mark.format(quantity, unit),
        values,
    )
    (curve,) = read_flow_curves(path).curves
    np.testing.assert_allclose(curve.rate, RATE, rtol=1e-6)
    np.testing.assert_allclose(curve.stress, STRESS, rtol=1e-6)


@pytest.mark.parametrize("unit", ["xyz/abc", "скПа", "дин/л", "kPaa/b"])
def test_a_unit_in_brackets_that_nobody_knows_is_asked_about(unit: str, tmp_path: Path) -> None:
    path = written(tmp_path / "curve.csv", "Shear rate [1/s]", f"Shear stress ({unit})", STRESS)
    with pytest.raises(UnitError, match="unit"):
        read_flow_curves(path)


@pytest.mark.parametrize("remark", ["average", "measured", "run 1"])
def test_a_remark_in_brackets_is_no_unit(remark: str, tmp_path: Path) -> None:
    path = written(tmp_path / "curve.csv", "Shear rate [1/s]", f"Shear stress ({remark})", STRESS)
    (curve,) = read_flow_curves(path).curves
    np.testing.assert_allclose(curve.stress, STRESS, rtol=1e-6)


def swept_pairs(path: Path, second: np.ndarray) -> Path:
    """Three pairs without any name, the rates of each a little off the others."""
    columns = np.column_stack(
        [column for k in range(3) for column in (RATE * (1.0 + 0.01 * k), second * (1.0 + k))]
    )
    np.savetxt(path, columns, "%.9g", ",")
    return path


def test_pairs_without_names_are_asked_about_where_their_first_columns_are_swept(
    tmp_path: Path,
) -> None:
    path = swept_pairs(tmp_path / "curves.csv", STRESS)
    with pytest.raises(MappingError, match="goes through decades") as asked:
        read_flow_curves(path)
    assert "--stress '[Pa]'" in asked.value.answers
    curves = read_flow_curves(path, stress=["[Pa]"]).curves
    assert [curve.label for curve in curves] == ["curve 1", "curve 2", "curve 3"]
    np.testing.assert_allclose(curves[1].stress, 2.0 * STRESS, rtol=1e-6)
    of_viscosities = swept_pairs(tmp_path / "viscosities.csv", 1e3 * STRESS / RATE)
    curves = read_flow_curves(of_viscosities, stress=["[mPa*s]"]).curves
    np.testing.assert_allclose(curves[0].stress, STRESS, rtol=1e-6)


def test_pairs_without_names_whose_first_columns_are_no_sweeps_are_no_curves(
    tmp_path: Path,
) -> None:
    path = tmp_path / "other.csv"
    rows = np.column_stack([np.arange(25.0), STRESS, np.arange(25.0) + 1.0, 2.0 * STRESS])
    np.savetxt(path, rows, "%.9g", ",")
    with pytest.raises(MappingError) as asked:
        read_flow_curves(path)
    assert "goes through decades" not in str(asked.value)


@pytest.mark.parametrize(
    ("rate", "stress"),
    [
        ("Shear rate [1/s]", "Shear stress 10 Pa"),
        ("Shear rate [1/s]", "Stress run 2 Pa"),
        ("Shear rate 2 1/s", "Shear stress [Pa]"),
        ("Shear rate [1/s]", "Shear stress_3_Pa"),
    ],
)
def test_a_number_of_a_run_in_front_of_a_unit_is_no_factor(
    rate: str, stress: str, tmp_path: Path
) -> None:
    (curve,) = read_flow_curves(written(tmp_path / "curve.csv", rate, stress, STRESS)).curves
    np.testing.assert_allclose(curve.rate, RATE, rtol=1e-6)
    np.testing.assert_allclose(curve.stress, STRESS, rtol=1e-6)


@pytest.mark.parametrize("stress", ["Shear stress (25 Pa)", "Shear stress [2 Pa]", "τ [1.5 Pa]"])
def test_a_number_in_front_of_a_unit_in_brackets_is_asked_about(
    stress: str, tmp_path: Path
) -> None:
    """It was a factor, in silence; it may be a level or the range of a sensor."""
    path = written(tmp_path / "curve.csv", "Shear rate [1/s]", stress, STRESS)
    with pytest.raises(UnitError, match="or steps of it") as asked:
        read_flow_curves(path)
    assert len(asked.value.answers) == 2
