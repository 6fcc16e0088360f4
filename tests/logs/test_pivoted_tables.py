"""Tables with one quantity down, another across and a third in the cells (SYNTHETIC)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import ErclutchError
from erclutch.logs import read_table
from erclutch.logs.readers.pivoted_tables import with_pivoted_heads
from erclutch.logs.table import Table

RATES = np.geomspace(0.1, 1000.0, 7)
FIELDS = (0.0, 0.5, 1.0)
STRESSES = np.array([[10.0 + 900.0 * field + rate**0.8 for field in FIELDS] for rate in RATES])


def written(folder: Path, head: str, mark: str = ",", decimal: str = ".") -> Table:
    lines = [head]
    for rate, row in zip(RATES, STRESSES, strict=True):
        lines.append(mark.join(f"{cell:.6g}".replace(".", decimal) for cell in (rate, *row)))
    path = folder / "log.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_table(path)


@pytest.mark.parametrize(
    ("head", "mark", "names", "unit"),
    [
        ("rate [1/s],stress [Pa] at flux density [T],,\n,0,0.5,1", ",", "stress {} T", "Pa"),
        ("rate [1/s];tau [Pa];I [A];\n;0;0,5;1", ";", "tau {} A", "Pa"),
        ("Sum of tau [Pa],I [A],,\nrate [1/s],0,0.5,1", ",", "Sum of tau {} A", "Pa"),
        ("Shear stress in Pa\nrate [1/s]\t0\t0.5\t1", "\t", "Shear stress at {}", "Pa"),
        ("Viscosity [Pa s]\nrate [1/s] \\ T [°C],0,0.5,1", ",", "Viscosity {} °C", "Pa s"),
        ("Current [A],0,0.5,1\nrate [1/s],,,", ",", "{} A", None),
        ("rate [1/s],Current [A],,\n,0,0.5,1", ",", "{} A", None),
        ("rate [1/s],0,0.5,1", ",", "at {}", None),
    ],
)
def test_numbers_across_are_in_the_names_of_their_columns(
    tmp_path: Path, head: str, mark: str, names: str, unit: str | None
) -> None:
    table = written(tmp_path, head, mark, "," if mark == ";" else ".")
    expected = [names.format(f"{field:g}") for field in FIELDS]
    assert list(table.columns) == ["rate", *expected]
    assert table.units["rate"] == "1/s"
    for column, name in enumerate(expected):
        assert table.units[name] == unit
        assert table.columns[name] == pytest.approx(STRESSES[:, column], rel=1e-5)


@pytest.mark.parametrize("total", ["Grand Total", "Gesamtergebnis"])
def test_the_totals_of_a_pivot_are_no_column_and_no_row(tmp_path: Path, total: str) -> None:
    lines = ["Average of tau [Pa],I [A],,,", f"rate [1/s],0,0.5,1,{total}"]
    for rate, row in zip(RATES, STRESSES, strict=True):
        lines.append(",".join(f"{cell:.6g}" for cell in (rate, *row, row.mean())))
    lines.append(
        f"{total}," + ",".join(f"{cell:.6g}" for cell in (*STRESSES.mean(axis=0), STRESSES.mean()))
    )
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    table = read_table(tmp_path / "log.csv")
    assert list(table.columns) == ["rate", *(f"Average of tau {field:g} A" for field in FIELDS)]
    assert table.rows == RATES.size


def test_rates_across_are_turned_down(tmp_path: Path) -> None:
    lines = [
        "Stress in Pa",
        "E (kV/mm) \\ shear rate (1/s)," + ",".join(f"{rate:.6g}" for rate in RATES),
    ]
    for field, row in zip(FIELDS, STRESSES.T, strict=True):
        lines.append(f"{field}," + ",".join(f"{cell:.6g}" for cell in row))
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    table = read_table(tmp_path / "log.csv")
    assert list(table.columns) == [
        "shear rate",
        "Stress 0 kV/mm",
        "Stress 0.5 kV/mm",
        "Stress 1 kV/mm",
    ]
    assert table.columns["shear rate"] == pytest.approx(RATES, rel=1e-5)
    assert table.columns["Stress 1 kV/mm"] == pytest.approx(STRESSES[:, 2], rel=1e-5)
    assert table.units["Stress 1 kV/mm"] == "Pa"


@pytest.mark.parametrize(
    "text",
    [
        "t,a,b,c\n,0,0.5,1\n1,2,3,4\n2,3,4,5\n3,4,5,6\n",  # the first row has no time yet
        "t,a,b\n0,1,2\n1,2,3\n2,3,4\n",
        "0,1,2\n1,2,3\n2,3,4\n3,4,5\n",
        "a,1,2,3,4\nb,2,3,4,5\nc,3,4,5,6\n",
        "rate,0,2,1\n1,2,3,4\n2,3,4,5\n3,4,5,6\n",  # nothing is set in such an order
    ],
)
def test_other_tables_stay_as_they_are(text: str) -> None:
    assert with_pivoted_heads(text) == (text, "")


@pytest.mark.usefixtures("read_here")
def test_merged_heads_of_a_workbook_are_read(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["Shear rate [1/s]", "Shear stress [Pa] at magnetic flux density [T]", None, None])
    sheet.append([None, *FIELDS])
    for rate, row in zip(RATES, STRESSES, strict=True):
        sheet.append([float(rate), *map(float, row)])
    sheet.merge_cells("B1:D1")
    sheet.merge_cells("A1:A2")
    book.save(tmp_path / "log.xlsx")
    table = read_table(tmp_path / "log.xlsx")
    assert list(table.columns) == [
        "Shear rate",
        "Shear stress 0 T",
        "Shear stress 0.5 T",
        "Shear stress 1 T",
    ]
    assert table.rows == RATES.size


@pytest.mark.slow
@given(text=st.text(alphabet="a0.5,;\t\n[]()\\ TD'e+", max_size=200))
def test_any_text_is_taken(text: str) -> None:
    changed, note = with_pivoted_heads(text)
    assert changed == text or note


@pytest.mark.slow
@given(
    heads=st.lists(
        st.sampled_from(["rate [1/s]", "", "tau [Pa]", "I [A]", "0", "0.5", "1"]),
        min_size=6,
        max_size=9,
    ),
    width=st.integers(2, 4),
)
def test_heads_in_any_order_give_a_table_or_an_error_of_ours(
    tmp_path_factory: pytest.TempPathFactory, heads: list[str], width: int
) -> None:
    lines = [",".join(heads[start : start + width]) for start in range(0, len(heads), width)]
    lines += [",".join(str(row + column) for column in range(width)) for row in range(5)]
    path = tmp_path_factory.mktemp("pivot") / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    try:
        table = read_table(path)
    except ErclutchError:
        return
    for values in table.columns.values():  # no number of a head is a row
        assert values.size <= 5 + len(lines)


@pytest.mark.parametrize(
    "line", ["rate [1/s];1\xa0000;2\xa0000;3\xa0000", "rate [1/s];1.0D+00;2.0D+00;3.0D+00"]
)
def test_numbers_across_in_any_spelling_raise_nothing(line: str) -> None:
    rows = "\n".join(f"{rate};1;2;3" for rate in (1, 2, 3, 4))
    text, _ = with_pivoted_heads(f"{line}\n{rows}\n")
    assert "rate [1/s]" in text


def test_a_remark_below_rates_across_leaves_the_table_as_it_is() -> None:
    rows = "\n".join(f"{field},1,2,3" for field in (0, 1, 2))
    text = f"E (kV/mm) \\ shear rate (1/s),1,10,100\n{rows}\nmean,1,2,3\n"
    assert with_pivoted_heads(text) == (text, "")


@pytest.mark.parametrize("row", [0, 1, 5])
@pytest.mark.parametrize("word", ["nan", "NA", "--", ""])
def test_a_row_whose_first_number_is_missing_is_no_line_of_numbers_across(
    tmp_path: Path, row: int, word: str
) -> None:
    rows = [f"{k / 100},{0.1 + k},{0.2 + k},{0.3 + k}" for k in range(40)]
    rows[row] = f"{word},0.1,0.2,0.3"
    (tmp_path / "log.csv").write_text("\n".join(["t,field,slip,torque", *rows]) + "\n")
    columns = read_table(tmp_path / "log.csv").columns
    assert list(columns) == ["t", "field", "slip", "torque"]
    assert columns["slip"].size == 40
    assert np.isnan(columns["t"][row])
