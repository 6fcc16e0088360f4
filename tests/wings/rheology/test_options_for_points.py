"""The command that `inspect` prints for points of a rheometer has each option that `flowcurve` asks for."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest
from openpyxl import Workbook

from erclutch.errors import MappingError
from erclutch.wings.rheology.flow_curve_file import read_flow_curves
from tests.support.command import good

RATES = np.geomspace(0.1, 500, 12)  # 1/s


def _printed(folder: Path, name: str) -> str:
    """The command in the last line of `inspect`."""
    last = good("inspect", name, cwd=folder, code=1).splitlines()[-1]
    return last.removeprefix("What settles it: ")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "options"),
    [
        ("Shear Rate,Viscosity,Particle Size", "--sheet 'Particle Size=all'"),
        ("Scherrate [1/s],Viskosität,Charge", "--sheet Charge=all"),
        (
            "Shear Rate,Viscosity,Charge,Viscosity (fit)",
            "--stress 'Viscosity [UNIT]' 'Viscosity (fit) [UNIT]' --sheet Charge=all",
        ),
    ],
)
def test_what_is_asked_one_after_another_stands_in_one_command(
    tmp_path: Path, names: str, options: str
) -> None:
    text = f"{names}\n"
    more = ",7" if "fit" in names else ""
    for size in (100, 300, 500):
        text += "".join(f"{rate:.4g},{size + 5000 / rate:.6g},{size}{more}\n" for rate in RATES)
    (tmp_path / "flow.csv").write_text(text, encoding="utf-8")
    command = _printed(tmp_path, "flow.csv")
    assert command == f"erclutch flowcurve flow.csv {options}"
    words = shlex.split(command.replace("UNIT", "mPa*s"))[1:]
    assert "of 3" in good(*words, "--laws", "bingham", cwd=tmp_path)


@pytest.mark.slow
def test_points_that_speak_for_themselves_need_no_option(tmp_path: Path) -> None:
    text = "Shear Rate [1/s],Viscosity [mPa*s],Temperature [°C]\n"
    for temperature in (20, 40, 60):
        text += "".join(f"{rate:.4g},{5000 / rate:.6g},{temperature}\n" for rate in RATES)
    (tmp_path / "flow.csv").write_text(text, encoding="utf-8")
    assert _printed(tmp_path, "flow.csv") == "erclutch flowcurve flow.csv"


@pytest.mark.slow
@pytest.mark.parametrize("times", [("00:05", "00:10"), ("00:00:05", "00:01:00")])
def test_times_that_an_instrument_notes_part_no_curves(
    tmp_path: Path, times: tuple[str, str]
) -> None:
    book = Workbook()
    info = book.worksheets[0]
    info.append(["Operator", "somebody"])
    sheet = book.create_sheet("Raw Data")
    sheet.append(["Data Interval", "Viscosity", "Shear Stress", "Shear Rate"])
    for k, rate in enumerate([*RATES, *RATES[::-1]]):
        sheet.append([times[k % 2], 300.0, 3 * rate, rate])  # mPa s, dyn/cm2, 1/s
    book.save(tmp_path / "flow.xlsx")
    options = "--shear-rate 'Shear Rate [1/s]' --stress 'Shear Stress [dyn/cm^2]'"
    assert _printed(tmp_path, "flow.xlsx") == f"erclutch flowcurve flow.xlsx {options}"
    (curve,) = read_flow_curves(
        tmp_path / "flow.xlsx", shear_rate="Shear Rate [1/s]", stress=["Shear Stress [dyn/cm^2]"]
    ).curves
    assert np.allclose(curve.stress, 0.3 * curve.rate)


@pytest.mark.slow
def test_stresses_against_their_rates_are_offered_as_a_log(tmp_path: Path) -> None:
    text = "t [s],gamma_dot,tau,state\n"
    rows = [f"{0.1 * k:.1f},{320 + k % 7},{-0.085 - 1e-4 * (k % 7):.5f},{k % 3}" for k in range(60)]
    (tmp_path / "log.csv").write_text(text + "\n".join(rows) + "\n", encoding="utf-8")
    command = _printed(tmp_path, "log.csv")
    assert command.startswith("erclutch inspect log.csv --field")
    assert "Understood" in good(*shlex.split(command)[1:], cwd=tmp_path)


def _slow_ramp(column: str, *, moves_the_stress: bool, ways: int = 2, rows: int = 240) -> str:
    """Rates that rise slowly, and fall again, beside a column that steps to and fro between four numbers."""
    levels = (0.78, 0.79, 0.80, 0.81)
    random = np.random.default_rng(3)
    text = f"Shear rate [1/s],Shear stress [Pa],{column}\n"
    up = np.geomspace(1, 100, rows)
    for rate in [*up, *up[::-1]][: ways * rows]:
        level = levels[random.integers(4)]
        factor = level**9 if moves_the_stress else 1.0
        text += f"{rate:.6g},{(5 + rate) * factor:.6g},{level}\n"
    return text


@pytest.mark.parametrize("column", ["cr", "probe", "Kanal 3"])
def test_a_reading_that_wobbles_between_its_last_digits_parts_no_curves(
    tmp_path: Path, column: str
) -> None:
    (tmp_path / "flow.csv").write_text(_slow_ramp(column, moves_the_stress=False), "utf-8")
    (curve,) = read_flow_curves(tmp_path / "flow.csv").curves
    assert curve.rate.size == 480


@pytest.mark.parametrize("column", ["cr", "probe", "Kanal 3"])
@pytest.mark.parametrize(("ways", "rows"), [(2, 240), (1, 240), (1, 120)])
def test_a_column_whose_steps_move_the_stress_is_asked_about(
    tmp_path: Path, column: str, ways: int, rows: int
) -> None:
    text = _slow_ramp(column, moves_the_stress=True, ways=ways, rows=rows)
    (tmp_path / "flow.csv").write_text(text, "utf-8")
    with pytest.raises(MappingError, match="parts the points into 4 sweeps"):
        read_flow_curves(tmp_path / "flow.csv")


@pytest.mark.slow
@pytest.mark.parametrize("axes", ["X,Y", "x,y"])
def test_pairs_that_are_called_by_their_axes_are_flow_curves(tmp_path: Path, axes: str) -> None:
    text = f"oil,oil,soap,soap\n{axes},{axes}\n"
    text += "".join(f"{rate:.4g},{5 + rate:.6g},{rate:.4g},{9 + rate:.6g}\n" for rate in RATES)
    (tmp_path / "figure.csv").write_text(text, encoding="utf-8")
    curves = read_flow_curves(tmp_path / "figure.csv").curves
    assert [curve.label for curve in curves] == ["oil", "soap"]
    assert [curve.stress[0] for curve in curves] == pytest.approx([5.1, 9.1])
    assert _printed(tmp_path, "figure.csv") == "erclutch flowcurve figure.csv"


def test_axes_the_other_way_round_are_asked_about(tmp_path: Path) -> None:
    rows = "".join(f"{5 + 0.2 * rate:.6g},{rate:.4g}\n" for rate in RATES)
    (tmp_path / "figure.csv").write_text(f"X,Y\n{rows}", encoding="utf-8")
    with pytest.raises(MappingError, match="no column is surely the shear rate"):
        read_flow_curves(tmp_path / "figure.csv")


@pytest.mark.parametrize("head", ["X,Y", "oil,"])
def test_the_unit_of_a_viscosity_beside_an_axis_is_left_open(tmp_path: Path, head: str) -> None:
    rows = "".join(f"{rate:.4g},{1 + 5000 / rate:.6g}\n" for rate in RATES)
    (tmp_path / "figure.csv").write_text(f"{head}\n{rows}", encoding="utf-8")
    with pytest.raises(MappingError, match="as a viscosity does"):
        read_flow_curves(tmp_path / "figure.csv")


@pytest.mark.slow
def test_inspect_sends_viscosities_below_labels_to_flowcurve(tmp_path: Path) -> None:
    rows = "".join(f"{rate:.4g},{9 / rate:.6g},{rate:.4g},{7 / rate:.6g}\n" for rate in RATES)
    (tmp_path / "figure.csv").write_text(f"Hct16,,Hct33,\nX,Y,X,Y\n{rows}", encoding="utf-8")
    command = _printed(tmp_path, "figure.csv")
    assert command == "erclutch flowcurve figure.csv"


@pytest.mark.slow
def test_points_of_a_force_over_a_displacement_are_not_sent_to_flowcurve(tmp_path: Path) -> None:
    rows = "".join(f"{k},{30 * k},{k},{40 * k}\n" for k in range(1, 30))
    (tmp_path / "figure.csv").write_text(f"a,a,b,b\nX,Y,X,Y\n{rows}", encoding="utf-8")
    assert "flowcurve" not in _printed(tmp_path, "figure.csv")


@pytest.mark.slow
@pytest.mark.parametrize("head", ["log Shear stress", "lg shear stress"])
def test_logarithms_are_never_offered_as_stresses(tmp_path: Path, head: str) -> None:
    rows = "".join(f"{rate:.4g},{np.log10(5 + rate):.6g}\n" for rate in RATES)
    (tmp_path / "flow.csv").write_text(f"Shear Rate [1/s],{head}\n{rows}", encoding="utf-8")
    assert _printed(tmp_path, "flow.csv") == "erclutch flowcurve flow.csv"
    with pytest.raises(MappingError, match="holds logarithms or roots"):
        read_flow_curves(tmp_path / "flow.csv")
