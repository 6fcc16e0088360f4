"""Flow curves as strangers write them: a unit that nobody wrote is asked for, a steady temperature parts no curve."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from openpyxl import Workbook

from erclutch.errors import UnitError
from erclutch.wings.rheology.flow_curve import fit_flow_curve
from erclutch.wings.rheology.flow_curve_file import read_flow_curves
from tests.support.command import good

RATES = np.geomspace(0.1, 1000.0, 24)


def written(folder: Path, text: str, name: str = "flow.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_viscosity_without_a_unit_makes_stresses_in_an_unknown_unit(tmp_path: Path) -> None:
    body = "".join(f"{k},{rate:.4g},{1000 + 5000 / rate:.6g}\n" for k, rate in enumerate(RATES))
    path = written(tmp_path, f"Point No.,Shear Rate,Viscosity\n{body}")
    file = read_flow_curves(path)
    (curve,) = file.curves
    assert curve.stress_unit == "?"
    assert curve.stress[-1] == pytest.approx(1005.0 * 1000.0, rel=1e-3)
    said = 'stresses are in an unknown unit: --stress "Viscosity [mPa*s]" says it'
    assert any(said in note for note in file.notes)
    (curve,) = read_flow_curves(path, stress=["Viscosity [mPa*s]"]).curves
    assert curve.stress_unit == "Pa"
    assert curve.stress[-1] == pytest.approx(1.005 * 1000.0, rel=1e-3)  # 1.005 Pa s at 1000 1/s


def test_stresses_in_an_unknown_unit_are_nowhere_in_pascals(tmp_path: Path) -> None:
    body = "".join(f"{rate:.4g},{1000 + 5000 / rate:.6g}\n" for rate in RATES)
    written(tmp_path, f"Shear Rate [1/s],Viscosity\n{body}")
    laws = ("--laws", "bingham", "herschel-bulkley")
    told = good(
        "flowcurve", "flow.csv", *laws, "--parameters", "--figure", "drawn.svg", cwd=tmp_path
    )
    drawn = [(tmp_path / name).read_text(encoding="utf-8") for name in ("drawn.csv", "drawn.svg")]
    json = good("flowcurve", "flow.csv", *laws, "--json", cwd=tmp_path)
    assert "yield stress [?]" in told
    assert '"stress_unit": "?"' in json
    without_the_option = told.replace("[mPa*s]", "").replace("or Pa*s in its place", "")
    for text in (without_the_option, *drawn, json):
        assert "Pa" not in text.replace("Path", "").replace("Parameter", "")
    (curve,) = read_flow_curves(tmp_path / "flow.csv").curves
    assert "Pa" not in repr(curve) + repr(fit_flow_curve(curve, "bingham"))


def test_one_viscosity_without_a_unit_beside_one_with_a_unit_is_asked_about(tmp_path: Path) -> None:
    body = "".join(f"{rate:.4g},{9 + 5 / rate:.6g},{7 + 5 / rate:.6g}\n" for rate in RATES)
    path = written(tmp_path, f"Shear Rate [1/s],Viscosity A [mPa*s],Viscosity B\n{body}")
    with pytest.raises(UnitError, match=r"'Viscosity B' has no unit.*\[mPa\*s\]\", or --stress"):
        read_flow_curves(path)


@pytest.mark.parametrize("law", ["Casson viscosity", "Viscosity (fit)", "Viscosity predicted"])
def test_a_viscosity_without_a_unit_beside_the_viscosity_of_a_law_is_asked_about(
    tmp_path: Path, law: str
) -> None:
    body = "".join(f"{rate:.4g},{9 + 5 / rate:.6g},{7 + 5 / rate:.6g}\n" for rate in RATES)
    path = written(tmp_path, f"Shear Rate [1/s],Viscosity,{law}\n{body}")
    with pytest.raises(UnitError, match="have no unit"):
        read_flow_curves(path)


def test_sheets_with_a_unit_and_without_a_unit_are_asked_about(tmp_path: Path) -> None:
    book = Workbook()
    for head in ("Viscosity [mPa*s]", "Viscosity"):
        sheet = book.create_sheet()
        sheet.append(["Shear rate [1/s]", head])
        for rate in RATES:
            sheet.append([rate, 9 + 5 / rate])
    book.remove(book.worksheets[0])
    book.save(tmp_path / "tests.xlsx")
    with pytest.raises(UnitError, match="have no unit, and other curves are in Pa"):
        read_flow_curves(tmp_path / "tests.xlsx")


def test_a_viscosity_without_a_unit_beside_a_stress_asks_for_nothing(tmp_path: Path) -> None:
    body = "".join(f"{rate:.4g},{5 + rate:.6g},{5000 / rate + 1000:.6g}\n" for rate in RATES)
    (curve,) = read_flow_curves(
        written(tmp_path, f"Shear Rate [1/s],Shear Stress [Pa],Viscosity\n{body}")
    ).curves
    assert curve.rate.size == 24


@pytest.mark.parametrize(
    ("levels", "curves"), [((30.0, 30.01), 1), ((19.99, 20.0, 20.3), 1), ((20.0, 40.0), 2)]
)
def test_a_temperature_that_wanders_is_one_condition(
    tmp_path: Path, levels: tuple[float, ...], curves: int
) -> None:
    text = "Shear Rate [1/s],Shear Stress [Pa],Temperature [°C]\n"
    for k in range(len(levels) * RATES.size):
        place = k // RATES.size if curves > 1 else k % len(levels)
        text += f"{RATES[k % RATES.size]:.4g},{5 + RATES[k % RATES.size]:.6g},{levels[place]}\n"
    assert len(read_flow_curves(written(tmp_path, text)).curves) == curves


@pytest.mark.slow
def test_inspect_sends_points_of_shear_to_flowcurve_whatever_stands_before_their_names(
    tmp_path: Path,
) -> None:
    text = "fluid,rpm,wb_force_N,wb_shear_rate_1s,wb_shear_stress_Pa\n"
    for fluid in ("oil", "soap"):
        text += "".join(f"{fluid},{10 * k},{0.01 * k},{11.3 * k},{3.1 * k}\n" for k in range(1, 9))
    written(tmp_path, text)
    last = good("inspect", "flow.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == "What settles it: erclutch flowcurve flow.csv --sheet fluid=all"
    assert "2 of 2" in good(
        "flowcurve", "flow.csv", "--sheet", "fluid=all", "--laws", "bingham", cwd=tmp_path
    )


@pytest.mark.slow
def test_inspect_sends_stresses_that_are_called_by_their_field_alone_to_flowcurve(
    tmp_path: Path,
) -> None:
    text = "Shear rate [1/s],0 kV/mm,1 kV/mm,2 kV/mm\n"
    text += "".join(f"{k},{3 * k},{50 + 3 * k},{150 + 3 * k}\n" for k in range(1, 20))
    written(tmp_path, text)
    last = good("inspect", "flow.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == "What settles it: erclutch flowcurve flow.csv"
    assert "2 kV/mm" in good("flowcurve", "flow.csv", "--laws", "bingham", cwd=tmp_path)


@pytest.mark.slow
def test_inspect_sends_a_workbook_of_tests_to_flowcurve(tmp_path: Path) -> None:
    book = Workbook()
    for number in range(3):
        sheet = book.create_sheet(f"test {number}")
        sheet.append(
            [
                "Meas. Pts.",
                "Shear Rate [1/s]",
                "Shear Stress [Pa]",
                "Viscosity [Pa*s]",
                "Torque [µN*m]",
            ]
        )
        for k, rate in enumerate(RATES):
            sheet.append([k, rate, 5 + rate, (5 + rate) / rate, 20 + 4 * rate])
    book.remove(book.worksheets[0])
    book.save(tmp_path / "tests.xlsx")
    last = good("inspect", "tests.xlsx", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == "What settles it: erclutch flowcurve tests.xlsx"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "with_a_unit"),
    [
        ("Shear Rate,Viscosity", "Viscosity [UNIT]"),
        ("gamma-dot,eta", "eta [UNIT]"),
        ("Scherrate [1/s],Viskosität", "Viskosität [UNIT]"),
    ],
)
def test_inspect_sends_a_viscosity_without_a_unit_to_flowcurve(
    tmp_path: Path, names: str, with_a_unit: str
) -> None:
    body = "".join(f"{rate:.4g},{1000 + 5000 / rate:.6g}\n" for rate in RATES)
    written(tmp_path, f"{names}\n{body}")
    last = good("inspect", "flow.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == "What settles it: erclutch flowcurve flow.csv"
    filled_in = with_a_unit.replace("UNIT", "mPa*s")
    out = good("flowcurve", "flow.csv", "--stress", filled_in, "--laws", "bingham", cwd=tmp_path)
    assert "1 of 1" in out


@pytest.mark.slow
def test_a_viscosity_with_its_unit_at_the_end_of_its_name_leaves_nothing_open(
    tmp_path: Path,
) -> None:
    body = "".join(f"{rate:.4g},{1000 + 5000 / rate:.6g}\n" for rate in RATES)
    written(tmp_path, f"Shear Rate,Viscosity_cP\n{body}")
    last = good("inspect", "flow.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == "What settles it: erclutch flowcurve flow.csv"


def test_a_unit_that_was_not_filled_in_is_asked_for_as_a_viscosity_s(tmp_path: Path) -> None:
    body = "".join(f"{rate:.4g},{1000 + 5000 / rate:.6g}\n" for rate in RATES)
    path = written(tmp_path, f"Shear Rate,Viscosity\n{body}")
    with pytest.raises(UnitError, match=r"'UNIT', which is no unit of a viscosity.*\[mPa\*s\]"):
        read_flow_curves(path, stress=["Viscosity [UNIT]"])
