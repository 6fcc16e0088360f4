"""Rows, units and missing numbers as written; a wrong line is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import read_table


def write(folder: Path, text: str) -> Path:
    path = folder / "log.txt"  # the content decides, not the suffix
    path.write_text(text, encoding="utf-8")
    return path


def test_rows_units_and_what_is_missing(tmp_path: Path) -> None:
    table = read_table(write(tmp_path, '{"t [s]": 0, "F [N]": 1.5}\n\n{"t [s]": 0.1}\n'))
    np.testing.assert_array_equal(table.columns["t"], [0.0, 0.1])
    np.testing.assert_array_equal(table.columns["F"], [1.5, np.nan])
    assert dict(table.units) == {"t": "s", "F": "N"}
    assert "erclutch-reader-jsonl 0.1.0" in table.notes[-1]


@pytest.mark.parametrize("line", ["{", "[1]", '{"F": "x"}', '{"F": true}', '{"F": 1' + "0" * 400 + "}", "{" * 10**5])
def test_a_wrong_line_is_named(tmp_path: Path, line: str) -> None:
    with pytest.raises(LogError, match="line 2"):
        read_table(write(tmp_path, '{"F": 1}\n' + line))
