"""Columns, units and what is left out, as written; a damaged file is an error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import read_table

LOG = """% a brake, run 1
@relation brake
@attribute 't [s]' numeric
@attribute 'F [N]' real
@attribute fluid {water, oil}
@data
0.0, 1.5, oil
0.1, ?, oil
0.2, -2.5, water
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "log.arff"
    path.write_text(text, encoding="utf-8")
    return path


def test_columns_units_and_what_is_left_out(tmp_path: Path) -> None:
    table = read_table(write(tmp_path, LOG))
    np.testing.assert_array_equal(table.columns["t"], [0.0, 0.1, 0.2])
    np.testing.assert_array_equal(table.columns["F"], [1.5, np.nan, -2.5])
    assert dict(table.units) == {"t": "s", "F": "N"}
    assert table.notes[0] == "attribute fluid is nominal: left out"
    assert "erclutch-reader-arff 0.1.0" in table.notes[-1]


@pytest.mark.parametrize(
    ("whole", "damaged"),
    [
        ("0.1, ?, oil", "0.1, ?"),
        ("1.5", "one"),
        ("real", "complex"),
        ("@attribute 't", "@attribute t"),
        ("oil\n0.1", "fat\n0.1"),
    ],
)
def test_damage_is_an_error(whole: str, damaged: str, tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no table of ARFF"):
        read_table(write(tmp_path, LOG.replace(whole, damaged, 1)))
