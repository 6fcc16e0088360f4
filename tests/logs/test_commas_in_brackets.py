"""A name whose brackets hold the delimiter is one name, where the cells of the rows say so."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from erclutch.logs import ColumnMap, plan_of, read_table


def written(folder: Path, header: str, row: str) -> Path:
    """A file of 300 rows, where {0} counts s and {1} and {2} go up and down."""
    rows = [row.format(0.01 * n, math.sin(0.07 * n), math.cos(0.05 * n)) for n in range(300)]
    path = folder / "run.csv"
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("Torque (filtered, mNm)", 1e-3),
        ("Torque (mNm, filtered)", 1e-3),
        ("Torque (kNm,raw)", 1e3),
        ("Torque [avg, N*m]", None),
    ],
)
@pytest.mark.parametrize("end", ["", ","])
def test_a_comma_in_brackets_parts_no_name(
    tmp_path: Path, name: str, factor: float | None, end: str
) -> None:
    header = f"time [s],{name},speed [rad/s]{end}"
    table = read_table(written(tmp_path, header, f"{{0:.3f}},{{1:.5f}},{{2:.5f}}{end}"))
    columns = [*table.columns]
    assert len(columns) == 3
    assert columns[1].startswith("Torque")
    assert table.columns["speed"][0] == 1.0
    effort = plan_of(table, ColumnMap.from_options({"field": "none"})).signal("effort")
    assert (effort and effort.factor) == factor


def test_brackets_that_each_cell_closes_stay_apart(tmp_path: Path) -> None:
    table = read_table(written(tmp_path, "t (s),x (mm),f (N)", "0.5,1.25,7.0"))
    assert [*table.units.values()] == ["s", "mm", "N"]


def test_cells_for_both_parts_of_a_name_keep_them_apart(tmp_path: Path) -> None:
    table = read_table(written(tmp_path, "t [s],x (left,right),f [N]", "0.5,1.25,2.5,7.0"))
    assert [values[0] for values in table.columns.values()] == [0.5, 1.25, 2.5, 7.0]
