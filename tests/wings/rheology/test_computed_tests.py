"""A regression below its points is no flow curve; a workbook says which of its columns are empty or hold text."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch import read
from erclutch.errors import LogError
from erclutch.logs.table import Table
from erclutch.wings.rheology.computed_tests import computed_tests
from erclutch.wings.rheology.flow_curve_file import read_flow_curves

RATES = np.logspace(-1.0, 2.0, 13)
NAMES = ["Point No.", "Shear Rate", "Shear Stress", "Temperature", "Torque", "Status"]
TABLE = Table("flow.csv", {"rate": RATES, "stress": RATES}, {}, digest="")
UNITS = [None, "[1/s]", "[Pa]", "[°C]", "[mN·m]", None]
Cells = list[list[object]]


def measured_rows() -> Cells:
    stress = 5.0 + 0.3 * RATES
    points = enumerate(zip(RATES, stress, strict=True), start=1)
    return [[place, rate, tau, 25.0, tau / 11.0, "Dy_auto"] for place, (rate, tau) in points]


def computed_rows() -> Cells:
    rates = np.linspace(0.1, 100.0, 40)
    return [[place, rate, 5.0 + 0.3 * rate] for place, rate in enumerate(rates, start=1)]


def workbook(path: Path, *sheets: Cells) -> Path:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.worksheets[0])
    for place, rows in enumerate(sheets, start=1):
        sheet = book.create_sheet(f"Sheet{place}")
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def with_below(*title: str) -> Cells:
    head: Cells = [["0.1-100"], [*NAMES], [], [*UNITS]]
    return [*head, *measured_rows(), [], *[[line] for line in title], *head[1:], *computed_rows()]


@pytest.mark.slow
@pytest.mark.parametrize("title", ["Regression:", "linear fit", "Fitted curve", "Ausgleichskurve"])
def test_a_regression_below_the_points_is_no_curve_by_its_title(tmp_path: Path, title: str) -> None:
    path = workbook(tmp_path / "oil.xlsx", with_below(title), with_below(title))
    file = read_flow_curves(path)
    assert [curve.rate.size for curve in file.curves] == [RATES.size, RATES.size]
    told = [note for note in file.notes if "a regression by its title" in note]
    assert len(told) == 2
    assert "--sheet" in told[0]


@pytest.mark.slow
def test_a_table_whose_torque_and_temperature_are_empty_below_one_with_them_is_no_curve(
    tmp_path: Path,
) -> None:
    path = workbook(tmp_path / "oil.xlsx", with_below("do not look at this", "not correct"))
    file = read_flow_curves(path)
    assert [curve.rate.size for curve in file.curves] == [RATES.size]
    assert any("torque are empty" in note for note in file.notes)


@pytest.mark.slow
def test_who_names_a_regression_gets_it(tmp_path: Path) -> None:
    path = workbook(tmp_path / "oil.xlsx", with_below("Regression:"))
    file = read_flow_curves(path, sheet=["Regression:"])
    assert [curve.rate.size for curve in file.curves] == [40]


@pytest.mark.parametrize("name", ["Sheet1, fit for use", "Sheet1, model 3", "Regressed", "Sample"])
def test_other_titles_are_measured(name: str) -> None:
    assert computed_tests({name: TABLE, "Sheet1, up": TABLE}) == {}


def test_a_file_of_regressions_alone_is_read_as_it_is() -> None:
    assert computed_tests({"Regression": TABLE, "Fit": TABLE}) == {}


def test_a_workbook_says_that_a_column_which_is_asked_for_holds_text(tmp_path: Path) -> None:
    rows: Cells = [["t [s]", "speed [rpm]", "torque [N*m]"]]
    rows += [[0.01 * row, 10.0 + row, "over range"] for row in range(50)]
    path = workbook(tmp_path / "log.xlsx", rows)
    with pytest.raises(LogError, match=r"column torque.* holds text"):
        read(path, field="none", effort="torque [N*m]")
