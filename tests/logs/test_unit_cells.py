"""Cells that hold their unit are numbers in it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import ErclutchError, MappingError
from erclutch.logs import read, read_table
from erclutch.logs.readers.unit_cells import unit_in, without_units_in_cells

TIME = np.arange(60) * 0.01
FORCE = 50.0 * np.sin(9.0 * TIME)


def log(path: Path, header: str, row: str) -> Path:
    """A damper's log; `row` is a format of time, current, velocity and force."""
    lines = [
        row.format(t=t, i=0.5 * (k // 20), v=np.cos(9.0 * t), f=f)
        for k, (t, f) in enumerate(zip(TIME, FORCE, strict=True))
    ]
    path.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("header", "row", "ampere"),
    [
        ("time,current,velocity,force", "{t:.2f} s,{i:.1f} A,{v:.6f} m/s,{f:.6f} N", 1.0),
        ("time [s],current,velocity [m/s],force [N]", "{t:.2f},{i:.1f}A,{v:.6f},{f:.6f}", 1.0),
        (
            "time [s];current [mA];velocity [m/s];force [N]",
            "{t:.2f};{i:.1f}mA;{v:.6f};{f:.6f}",
            1e-3,
        ),
        ("time\tcurrent\tvelocity\tforce", "{t:.2f}s\t{i:.1f}A\t{v:.6f}m/s\t{f:.6f}N", 1.0),
    ],
)
def test_units_of_cells_are_those_of_the_column(
    tmp_path: Path, header: str, row: str, ampere: float
) -> None:
    path = log(tmp_path / "d.csv", header, row)
    assert any("cells hold their units" in note for note in read_table(path).notes)
    recording = read(path)
    assert recording.signals["effort"] == pytest.approx(FORCE, abs=1e-5)
    assert recording.signals["field"] == pytest.approx(ampere * 0.5 * (np.arange(60) // 20))


HEAD, ROW = "time [s],current,velocity [m/s],force [N]", "{t:.2f},{i:.1f} A,{v:.6f},{f:.6f}"


def test_a_cell_of_another_quantity_is_named(tmp_path: Path) -> None:
    path = log(tmp_path / "d.csv", HEAD, ROW)
    path.write_text(path.read_text().replace("0.5 A", "500 mV", 1))
    with pytest.raises(MappingError, match="'500 mV' where a number is expected"):
        read(path)


@pytest.mark.parametrize("count", [1, 20])
def test_a_meter_that_changes_its_range_is_read_in_one_unit(tmp_path: Path, count: int) -> None:
    path = log(tmp_path / "d.csv", HEAD, ROW)
    path.write_text(path.read_text().replace("0.5 A", "500 mA", count))
    assert read(path).signals["field"] == pytest.approx(0.5 * (np.arange(60) // 20))


def test_a_bare_number_among_cells_of_several_units_is_in_none(tmp_path: Path) -> None:
    path = log(tmp_path / "d.csv", HEAD, ROW)
    path.write_text(path.read_text().replace("0.5 A", "500 mA", 1).replace("0.5 A", "0.5", 1))
    with pytest.raises(ErclutchError):
        read(path)


@pytest.mark.parametrize("label", ["current [mA]", "current (mA)"])
def test_cells_know_their_unit_better_than_their_head(tmp_path: Path, label: str) -> None:
    path = log(tmp_path / "d.csv", HEAD.replace("current", label), ROW)
    assert read_table(path).units["current"] == "A"


@pytest.mark.parametrize(
    "cell", ["0.5", "1e3", "A", "", "0.5 nothing", "12:30", "0x1F", "nan", "1,5", "-", "2024-05-06"]
)
def test_other_cells_hold_no_unit(cell: str) -> None:
    assert unit_in(cell) is None


def test_numbers_of_samples_are_left_as_they_are(tmp_path: Path) -> None:
    text = "sample,x\n" + "\n".join(f"{k}{'AB'[k % 2]},{k}" for k in range(30))
    assert without_units_in_cells(text) == (text, "")


@pytest.mark.slow
@given(text=st.text(alphabet="0.5 AmN,;\n[]-e", max_size=200))
def test_any_text_is_taken(text: str) -> None:
    changed, note = without_units_in_cells(text)
    assert (changed == text) or note
