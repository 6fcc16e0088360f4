"""What stands beside a measured stress is no stress, and a series of stresses is taken whole (SYNTHETIC)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError, UnitError
from erclutch.wings.rheology.flow_curve_file import FlowFile, read_flow_curves
from erclutch.wings.rheology.flow_law import flow_laws

RATES = np.logspace(-1.0, 3.0, 12)
STRESSES = 10.0 + 0.5 * RATES**0.8


def written(folder: Path, head: str, *columns: object, name: str = "curve.csv") -> Path:
    """A file of columns below a head, each an array or one text for all rows."""
    cells: list[list[str]] = []
    for column in columns:
        cells.append(
            [str(column)] * RATES.size
            if isinstance(column, str)
            else [f"{x:.6g}" for x in np.asarray(column)]
        )
    lines = [",".join(row) for row in zip(*cells, strict=True)]
    path = folder / name
    path.write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
    return path


def assert_is_the_curve(file: FlowFile) -> None:
    (curve,) = file.curves
    assert curve.rate == pytest.approx(RATES, rel=1e-5)
    assert curve.stress == pytest.approx(STRESSES, rel=1e-5)


@pytest.mark.parametrize(
    "beside",
    [
        "Shear stress SD (Pa)",
        "s.d. (Pa)",
        "Stress stdev (Pa)",
        "Standardabweichung (Pa)",
        "Stress min (Pa)",
        "écart-type (Pa)",
    ],
)
def test_what_replicates_scatter_by_is_no_stress(tmp_path: Path, beside: str) -> None:
    path = written(
        tmp_path,
        f"Shear rate (1/s),Shear stress mean (Pa),{beside}",
        RATES,
        STRESSES,
        0.03 * STRESSES,
    )
    assert_is_the_curve(read_flow_curves(path))


@pytest.mark.parametrize(
    "beside", ["Herschel-Bulkley fit [Pa]", "Stress model [Pa]", "tau predicted [Pa]"]
)
def test_what_a_law_gives_is_no_measured_stress(tmp_path: Path, beside: str) -> None:
    head = f"Shear rate [1/s],Shear stress [Pa],{beside},Residual [Pa]"
    path = written(tmp_path, head, RATES, STRESSES, 1.01 * STRESSES, -0.01 * STRESSES)
    assert_is_the_curve(read_flow_curves(path))


@pytest.mark.parametrize("law", flow_laws())
def test_a_stress_that_is_called_after_one_of_our_laws_is_no_measured_stress(
    tmp_path: Path, law: str
) -> None:
    head = f"Shear rate [1/s],Shear stress [Pa],Stress {law.title()} [Pa]"
    path = written(tmp_path, head, RATES, STRESSES, 1.01 * STRESSES)
    assert_is_the_curve(read_flow_curves(path))


@pytest.mark.parametrize(
    "names",
    [
        "log shear rate (1/s),log viscosity (Pa.s)",
        "lg_gamma_dot [1/s],ln_eta [Pa s]",
        "sqrt(shear rate),sqrt(shear stress)",
    ],
)
def test_logarithms_are_asked_about(tmp_path: Path, names: str) -> None:
    path = written(tmp_path, names, np.log10(RATES), np.log10(STRESSES / RATES))
    with pytest.raises(MappingError, match="holds logarithms"):
        read_flow_curves(path)


@pytest.mark.parametrize(
    ("above", "names", "unit"),
    [
        ("Carbopol: tau is given in kPa", "rate,stress", "kPa"),
        ("Units: 1/min and Pa", "rate,stress", "1/min"),
    ],
)
def test_a_unit_in_the_lines_above_is_asked_about(
    tmp_path: Path, above: str, names: str, unit: str
) -> None:
    path = written(tmp_path, f"{above}\n\n{names}", RATES, STRESSES)
    with pytest.raises(UnitError, match="the lines above the table speak of") as asked:
        read_flow_curves(path)
    assert f"[{unit}]" in asked.value.remedy


def test_units_that_a_line_above_gives_each_column_are_read(tmp_path: Path) -> None:
    head = "stress in dyn/cm^2; rate in 1/s\n\nrate,stress"
    assert_is_the_curve(read_flow_curves(written(tmp_path, head, RATES, 10 * STRESSES)))


def test_a_viscosity_over_all_columns_is_proposed_for_all(tmp_path: Path) -> None:
    head = ",Viscosity (mPa·s),\nShear rate (1/s),0 kV/mm,1 kV/mm"
    path = written(tmp_path, head, RATES, STRESSES / RATES, 2 * STRESSES / RATES)
    with pytest.raises(MappingError) as asked:
        read_flow_curves(path)
    assert 'stress="0 kV/mm [mPa*s]" "1 kV/mm [mPa*s]"' in asked.value.remedy.replace(
        "--stress ", "stress="
    )


def test_units_in_columns_of_their_own_are_those_of_the_columns_before(tmp_path: Path) -> None:
    head = "Shear rate,Unit,Shear stress,Unit"
    path = written(tmp_path, head, RATES, "1/s", 10 * STRESSES, "dyn/cm²")
    assert_is_the_curve(read_flow_curves(path))


def test_cells_may_hold_a_rate_with_its_unit(tmp_path: Path) -> None:
    lines = [
        f"{rate:.6g} 1/s;{stress:.6g} Pa" for rate, stress in zip(RATES, STRESSES, strict=True)
    ]
    (tmp_path / "curve.csv").write_text("\n".join(["Shear rate;Shear stress", *lines]) + "\n")
    assert_is_the_curve(read_flow_curves(tmp_path / "curve.csv"))


def test_a_name_may_be_a_unit(tmp_path: Path) -> None:
    assert_is_the_curve(read_flow_curves(written(tmp_path, "SR,cP", RATES, 1e3 * STRESSES / RATES)))


@pytest.mark.parametrize("names", ["rate_1/s,eta_25C_cP", "shear_rate_s-1,eta_cP"])
def test_a_unit_may_end_the_name(tmp_path: Path, names: str) -> None:
    assert_is_the_curve(read_flow_curves(written(tmp_path, names, RATES, 1e3 * STRESSES / RATES)))


def test_a_series_is_taken_whole_where_a_strong_field_hides_the_growth(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).permutation(RATES.size)  # the rate has no say in it
    strong = 13000.0 + 50.0 * noise - 80.0 * np.arange(RATES.size)
    path = written(
        tmp_path, "Shear rate (1/s),0 mT,200 mT,400 mT", RATES, STRESSES, 50 * STRESSES, strong
    )
    file = read_flow_curves(path)
    assert [curve.label for curve in file.curves] == ["0 mT", "200 mT", "400 mT"]
    assert file.curves[2].stress == pytest.approx(strong, rel=1e-4)


def test_no_count_and_no_percentage_is_taken_for_a_stress(tmp_path: Path) -> None:
    path = written(tmp_path, "SR,c,%,1 T", RATES, np.arange(RATES.size), 0.1 * STRESSES, STRESSES)
    assert_is_the_curve(read_flow_curves(path))


@pytest.mark.slow
@pytest.mark.parametrize(
    "column", ["gap [mm]", "concentration (wt%)", "volume fraction", "Konzentration"]
)
def test_what_is_set_by_hand_is_asked_about(tmp_path: Path, column: str) -> None:
    rows = [
        f"{level},{rate:.6g},{(1 + level) * (10 + rate):.6g}"
        for level in (0.5, 1.0)
        for rate in RATES
    ]
    (tmp_path / "f.csv").write_text(
        "\n".join([f"{column},Shear rate [1/s],Shear stress [Pa]", *rows]) + "\n"
    )
    with pytest.raises(MappingError, match="parts the points into 2 sweeps") as asked:
        read_flow_curves(tmp_path / "f.csv")
    choice = asked.value.remedy.split('"')[1]
    assert len(read_flow_curves(tmp_path / "f.csv", sheet=[choice]).curves) == 2


@pytest.mark.parametrize(("high", "count"), [(40.0, 2), (25.6, 1)])
def test_two_regulated_temperatures_without_a_unit_are_two_curves(
    tmp_path: Path, high: float, count: int
) -> None:
    wander = np.random.default_rng(2)
    rows: list[str] = []
    for level in (25.0, high):
        for rate in RATES:
            rows.append(
                f"{level + 0.03 * wander.normal():.3f},{rate:.6g},{level * (10 + rate):.6g}"
            )
    (tmp_path / "f.csv").write_text(
        "\n".join(["Temp,Shear rate [1/s],Shear stress [Pa]", *rows]) + "\n"
    )
    assert len(read_flow_curves(tmp_path / "f.csv").curves) == count


def test_what_a_stress_scatters_by_in_its_own_cell_is_left_out_and_told(tmp_path: Path) -> None:
    lines = [f"{rate:.6g},{stress:.5g} ± 0.3" for rate, stress in zip(RATES, STRESSES, strict=True)]
    (tmp_path / "f.csv").write_text(
        "\n".join(["Shear rate (1/s),Shear stress (Pa)", *lines]) + "\n", encoding="utf-8"
    )
    file = read_flow_curves(tmp_path / "f.csv")
    assert file.curves[0].stress == pytest.approx(STRESSES, rel=1e-4)
    assert any(
        "12 cells hold what their numbers scatter by (± 0.3): left out" in note
        for note in file.notes
    )


def test_torque_and_speed_need_the_geometry(tmp_path: Path) -> None:
    path = written(tmp_path, "Torque (µNm),Speed (1/min)", STRESSES, RATES)
    with pytest.raises(MappingError, match="speed of a rotor") as asked:
        read_flow_curves(path)
    assert "Torque [FACTOR Pa]" in asked.value.remedy
    file = read_flow_curves(path, shear_rate="Speed [1.29 1/s]", stress=["Torque [2 Pa]"])
    assert file.curves[0].stress == pytest.approx(2 * STRESSES, rel=1e-5)
    assert file.curves[0].rate == pytest.approx(1.29 * RATES, rel=1e-5)


def test_a_concentration_is_offered_as_no_rate(tmp_path: Path) -> None:
    path = written(tmp_path, "concentration_pct,viscosity_Pas", RATES, STRESSES)
    with pytest.raises(MappingError) as refused:
        read_flow_curves(path)
    assert "concentration_pct [1/s]" not in refused.value.remedy
