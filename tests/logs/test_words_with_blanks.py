"""A word with a blank, such as "step 2", is one cell of a row that is cut at tabs, as a workbook's rows are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from erclutch.logs import read_table

ROWS = np.arange(90)


@pytest.fixture(params=["step {}", "phase A {}", "steel 42 {}", "zone_{}"])
def log(request: pytest.FixtureRequest) -> pd.DataFrame:
    words = [request.param.format(row // 30) for row in ROWS]
    return pd.DataFrame({"speed [rad/s]": ROWS % 7, "torque [N*m]": ROWS % 5, "part": words})


def test_a_text_cut_at_tabs_keeps_its_names_beside_words_with_blanks(
    tmp_path: Path, log: pd.DataFrame
) -> None:
    log.to_csv(tmp_path / "log.txt", sep="\t", index=False)
    table = read_table(tmp_path / "log.txt")
    assert list(table.columns) == ["speed", "torque"]
    assert len(table.words["part"].words) == 3


@pytest.mark.slow
def test_a_workbook_keeps_its_names_beside_words_with_blanks(
    tmp_path: Path, log: pd.DataFrame, read_here: None
) -> None:
    log.to_excel(tmp_path / "log.xlsx", index=False)
    table = read_table(tmp_path / "log.xlsx")
    assert list(table.columns) == ["speed", "torque"]
    assert len(table.words["part"].words) == 3


@pytest.mark.parametrize(
    ("row", "columns"), [("{0} 1.5\t{0} 2.5", 4), ("{0} 1.5 \t 2.5 3.5", 4), ("{0}\t2.5\t3.5", 3)]
)
def test_numbers_between_blanks_and_tabs_stay_numbers_of_their_own(
    tmp_path: Path, row: str, columns: int
) -> None:
    rows = "\n".join(row.format(k) for k in ROWS)
    (tmp_path / "log.txt").write_text(f"{rows}\n", encoding="utf-8")
    assert len(read_table(tmp_path / "log.txt").columns) == columns
