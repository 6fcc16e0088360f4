"""Cells such as ``12.3 ± 0.4``: the number is read, and what it scatters by is left out with a word."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.logs import read_table
from erclutch.logs.readers.spread_cells import without_spread_in_cells

NUMBERS = [21.7, 22.9, 23.1, 25.0, 31.6]


def written(folder: Path, lines: list[str]) -> Path:
    path = folder / "log.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("mark", ["±", " ± ", " +/- ", " +- "])
def test_the_number_in_front_of_a_spread_is_read(tmp_path: Path, mark: str) -> None:
    lines = [
        "t [s],Force ± SD [N],x [m]",
        *(f"{row},{number}{mark}0.7,{row}" for row, number in enumerate(NUMBERS)),
    ]
    table = read_table(written(tmp_path, lines))
    assert table.columns["Force"].tolist() == NUMBERS
    assert table.units["Force"] == "N"
    assert table.columns["x"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert any("5 cells hold what their numbers scatter by" in note for note in table.notes)


def test_both_numbers_may_have_decimal_commas(tmp_path: Path) -> None:
    lines = [
        "t [s];Force [N]",
        *(f"{row},5;{number} ± 0,7".replace(".", ",") for row, number in enumerate(NUMBERS)),
    ]
    assert read_table(written(tmp_path, lines)).columns["Force"].tolist() == NUMBERS


def test_a_comma_behind_a_spread_ends_its_cell(tmp_path: Path) -> None:
    lines = ["t [s],Force [N],x [m]", *(f"{row},2{row} ± 7,3" for row in range(5))]
    table = read_table(written(tmp_path, lines))
    assert table.columns["Force"].tolist() == [20.0, 21.0, 22.0, 23.0, 24.0]
    assert table.columns["x"].tolist() == [3.0] * 5


@pytest.mark.parametrize("form", ["{} (0.7)", "{}(0.7)", "{} (±0.7)", '"{} (0.7)"'])
def test_a_spread_may_stand_in_brackets(tmp_path: Path, form: str) -> None:
    lines = [
        "t [s],Force [N],x (2)",
        *(f"{row},{form.format(number)},{row}" for row, number in enumerate(NUMBERS)),
    ]
    table = read_table(written(tmp_path, lines))
    assert table.columns["Force"].tolist() == NUMBERS
    assert any(
        "5 cells hold in brackets what their numbers scatter by" in note for note in table.notes
    )


def test_what_is_as_large_as_its_number_in_brackets_is_another_quantity(tmp_path: Path) -> None:
    text = "\n".join(
        ["t [s],Force [N]", *(f"{row},{number} ({20 + row})" for row, number in enumerate(NUMBERS))]
    )
    assert without_spread_in_cells(text) == (text, "")


def test_a_remark_with_a_tolerance_changes_nothing(tmp_path: Path) -> None:
    lines = [
        "# gap 0.5 ± 0.02 mm",
        "t [s],Force [N]",
        *(f"{row},{number}" for row, number in enumerate(NUMBERS)),
    ]
    table = read_table(written(tmp_path, lines))
    assert table.columns["Force"].tolist() == NUMBERS
    assert not any("scatter" in note for note in table.notes)


@pytest.mark.slow
@given(
    st.lists(
        st.tuples(st.decimals(0, 999, places=2), st.decimals(0, 99, places=2)),
        min_size=3,
        max_size=20,
    ),
    st.sampled_from([",", "\t", ";"]),
    st.sampled_from(["±", " ± ", " +/- "]),
)
def test_any_numbers_stay_as_they_are(
    pairs: list[tuple[object, object]], delimiter: str, mark: str
) -> None:
    bare = "\n".join(f"{number}{delimiter}{number}" for number, _ in pairs)
    with_spread = "\n".join(
        f"{number}{mark}{spread}{delimiter}{number}{mark}{spread}" for number, spread in pairs
    )
    assert without_spread_in_cells(with_spread)[0] == bare
    assert without_spread_in_cells(bare) == (bare, "")
