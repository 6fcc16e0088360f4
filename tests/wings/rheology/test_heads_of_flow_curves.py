"""Heads of columns that speak of powers of ten, odd units and quantities that are no shear (SYNTHETIC)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError, UnitError
from erclutch.wings.rheology.flow_curve_file import read_flow_curves

RATES = np.geomspace(0.1, 1000.0, 9)
STRESSES = 900.0 + 1.1 * RATES**0.8  # Pa


def written(folder: Path, *names: str, factor: float = 1.0, mark: str = ";") -> Path:
    """A file of rates, of stresses over a factor, and of viscosities where there is a third name."""
    lines = [mark.join(names)]
    for rate, stress in zip(RATES, STRESSES, strict=True):
        lines.append(
            mark.join(
                [f"{rate:.6g}", f"{stress / factor:.6g}", f"{stress / rate:.6g}"][: len(names)]
            )
        )
    path = folder / "curve.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("Shear stress (×10³ Pa)", 1e3),
        ("τ (10^3 Pa)", 1e3),
        ("Shear stress [x10^-3 MPa]", 1e3),
        ("Schubspannung [Pa ×10²]", 1e2),
        ("Shear stress (100 Pa)", 1e2),
        ("Shear stress (10⁻³ Pa)", 1e-3),
    ],
)
def test_a_power_of_ten_within_the_unit_is_of_the_unit(
    tmp_path: Path, name: str, factor: float
) -> None:
    (curve,) = read_flow_curves(written(tmp_path, "Shear rate (1/s)", name, factor=factor)).curves
    assert curve.stress == pytest.approx(STRESSES, rel=1e-5)


@pytest.mark.parametrize(
    ("name", "multiplied"),
    [
        ("Shear stress ×10³ (Pa)", "Shear stress ×10³ [0.001 Pa]"),
        ("Shear stress x 10^3 [Pa]", "Shear stress x 10^3 [0.001 Pa]"),
        ("1000*tau [Pa]", "1000*tau [0.001 Pa]"),
        ("τ·10⁻³ (Pa)", "τ·10⁻³ [1000 Pa]"),
    ],
)
def test_a_power_of_ten_beside_the_name_is_asked_about(
    tmp_path: Path, name: str, multiplied: str
) -> None:
    factor = 1000.0 if "0.001" not in multiplied else 1e-3
    path = written(tmp_path, "Shear rate (1/s)", name, factor=factor)
    with pytest.raises(UnitError, match="may be times it, or over it") as asked:
        read_flow_curves(path)
    assert multiplied in asked.value.remedy
    (curve,) = read_flow_curves(path, stress=[multiplied]).curves
    assert curve.stress == pytest.approx(STRESSES, rel=1e-5)


@pytest.mark.parametrize(
    "name",
    [
        "Shear stress (Pa abs)",
        "Shear stress (g cm-1 s-2 ?)",
        "Shear stress (psi gauge)",
        "Stress (scale units)",
    ],
)
def test_a_unit_in_brackets_that_nobody_knows_is_not_taken_for_pascals(
    tmp_path: Path, name: str
) -> None:
    with pytest.raises(UnitError, match="no unit that erclutch knows"):
        read_flow_curves(written(tmp_path, "Shear rate (1/s)", name))


@pytest.mark.parametrize(
    "name", ["Shear stress (mean)", "Shear stress (sample 2)", "Shear stress (run A)"]
)
def test_words_in_brackets_are_no_unit(tmp_path: Path, name: str) -> None:
    (curve,) = read_flow_curves(written(tmp_path, "Shear rate (1/s)", name)).curves
    assert curve.stress == pytest.approx(STRESSES, rel=1e-5)


@pytest.mark.parametrize(
    "names",
    [
        ("Extension rate [1/s]", "Tensile stress [Pa]", "Extensional viscosity [Pa s]"),
        ("Dehnrate [1/s]", "Zugspannung [Pa]"),
        ("shear rate [1/s]", "relative viscosity"),
        ("shear rate [1/s]", "reduced viscosity [-]"),
        ("shear rate [1/s]", "specific viscosity"),
        ("shear rate [1/s]", "N1 [Pa]"),
        ("shear rate [1/s]", "tau/tau_y"),
        ("shear rate [1/s]", "τ / τ0"),
        ("shear rate [1/s]", "Δτ [Pa]"),
        ("shear rate [1/s]", "shear stress increase [Pa]"),
        ("Scherrate [1/s]", "Zunahme der Schubspannung [Pa]"),
        ("strain rate amplitude [1/s]", "stress amplitude [Pa]"),
    ],
)
def test_quantities_that_are_no_shear_are_refused_and_none_is_offered(
    tmp_path: Path, names: tuple[str, ...]
) -> None:
    with pytest.raises(MappingError, match="each is of another quantity") as refused:
        read_flow_curves(written(tmp_path, *names))
    assert "[Pa" not in refused.value.remedy


def test_a_normal_stress_beside_the_viscosity_is_no_shear_stress(tmp_path: Path) -> None:
    (curve,) = read_flow_curves(
        written(tmp_path, "Shear rate [1/s]", "N1 [Pa]", "Viscosity [Pa s]", factor=9.0)
    ).curves
    assert curve.stress == pytest.approx(STRESSES, rel=1e-5)


def test_a_speed_in_turns_gives_way_to_the_rate_of_shear(tmp_path: Path) -> None:
    lines = ["t [s]\tGP [1/s]\tTau [Pa]\tn [1/min]"]
    lines += [
        f"{k}\t{g:.6g}\t{s:.6g}\t{g / 12:.6g}"
        for k, (g, s) in enumerate(zip(RATES, STRESSES, strict=True))
    ]
    (tmp_path / "curve.txt").write_text("\n".join(lines) + "\n")
    (curve,) = read_flow_curves(tmp_path / "curve.txt").curves
    assert curve.rate == pytest.approx(RATES, rel=1e-5)


def test_all_readings_of_a_dial_are_asked_for_in_one_command(tmp_path: Path) -> None:
    lines = [
        "RPM,Mud A dial,Mud B dial",
        *(f"{n},{10 + n / 10:g},{8 + n / 10:g}" for n in (600, 300, 200, 100, 6, 3)),
    ]
    (tmp_path / "curve.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(MappingError) as asked:
        read_flow_curves(tmp_path / "curve.csv")
    assert '"Mud A dial [0.511 Pa]" "Mud B dial [0.511 Pa]"' in asked.value.remedy


@pytest.mark.parametrize(
    ("name", "unit"), [("current_A", "A"), ("E_kV_mm", "kV/mm"), ("sample_A", "")]
)
def test_a_unit_at_the_end_of_a_name_tells_the_field_where_the_name_is_of_one(
    tmp_path: Path, name: str, unit: str
) -> None:
    lines = [f"shear_rate_1_s,shear_stress_Pa,{name}"]
    lines += [
        f"{g:.6g},{s * (1 + level):.6g},{level}"
        for level in (0, 1)
        for g, s in zip(RATES, STRESSES, strict=True)
    ]
    (tmp_path / "curve.csv").write_text("\n".join(lines) + "\n")
    curves = read_flow_curves(tmp_path / "curve.csv", sheet=[f"{name}=all"]).curves
    assert [curve.field_unit for curve in curves] == [unit, unit]


def test_headings_over_pairs_of_a_short_table_between_tabs_name_the_curves(tmp_path: Path) -> None:
    lines = ["20 °C\t\t40 °C\t", "D\tτ\tD\tτ", "1/s\tPa\t1/s\tPa"]
    lines += [
        f"{g:.6g}\t{s:.6g}\t{2 * g:.6g}\t{s / 2:.6g}" for g, s in zip(RATES, STRESSES, strict=True)
    ]
    (tmp_path / "curve.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    assert [curve.label for curve in read_flow_curves(tmp_path / "curve.txt").curves] == [
        "20 °C",
        "40 °C",
    ]


@pytest.mark.slow
def test_points_that_a_brookfield_could_not_measure_are_left_out(tmp_path: Path) -> None:
    lines = ["Shear Rate (1/s);Shear Stress (N/m²);Torque (%)"]
    for k, (g, s) in enumerate(zip(RATES, STRESSES, strict=True)):
        lines.append(f"{g:.6g};EEEE;EEEE" if k < 2 else f"{g:.6g};{s:.6g};20")
    (tmp_path / "curve.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (curve,) = read_flow_curves(tmp_path / "curve.csv").curves
    assert curve.stress == pytest.approx(STRESSES[2:], rel=1e-5)


@pytest.mark.parametrize(("decay", "is_told"), [(0.3, True), (0.02, False)])
def test_steps_of_the_rate_with_what_comes_before_the_steady_stress_are_told(
    tmp_path: Path, decay: float, is_told: bool
) -> None:
    lines = ["Time [s],Shear Rate [1/s],Shear Stress [Pa]"]
    for step, (rate, stress) in enumerate(zip(RATES, STRESSES, strict=True)):
        for k in range(10):
            lines.append(f"{30 * step + 3 * k},{rate:.6g},{stress * (1 + decay * np.exp(-k)):.6g}")
    (tmp_path / "curve.csv").write_text("\n".join(lines) + "\n")
    notes = read_flow_curves(tmp_path / "curve.csv").notes
    assert any("while a rate is held" in note for note in notes) == is_told


def test_a_line_of_units_in_brackets_names_nothing(tmp_path: Path) -> None:
    lines = [
        "Shear rate,Shear stress",
        "(s⁻¹),(Pa)",
        *(f"{g:.6g},{s:.6g}" for g, s in zip(RATES, STRESSES, strict=True)),
    ]
    (tmp_path / "curve.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    file = read_flow_curves(tmp_path / "curve.csv")
    assert "shear rate: column 'Shear rate' [1/s]" in file.notes
