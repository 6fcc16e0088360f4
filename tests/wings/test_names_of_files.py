"""A name that says another kind of file than a command of a wing writes is refused before any work."""

from __future__ import annotations

from pathlib import Path

import pytest

from erclutch.logs.synthetic import write_synthetic_log
from tests.support.command import refused


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("simulate", "training", "--out", "x.xls"), "x.xls: its name cannot end in '.xls'"),
        (("align", "log.csv", "log.csv", "--out", "x"), "ends in .csv, .parquet or .mat"),
        (("excite", "--out", "x"), "ends in .csv, .parquet, .mat or .h"),
        (("excite", "--sequence", "paper", "--out", "x.h"), "ends in .csv, .parquet or .mat"),
    ],
)
def test_a_name_that_says_another_kind_of_file_is_refused(
    words: tuple[str, ...], said: str, tmp_path: Path
) -> None:
    write_synthetic_log(tmp_path / "log.csv", seconds=1.0)
    assert said in refused(*words, cwd=tmp_path)
