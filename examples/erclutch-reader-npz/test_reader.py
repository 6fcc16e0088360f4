"""Columns, units and what is left out, as written; a damaged file is an error, and so is a pickle."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import read_table

TIME = np.arange(5) / 10


def write(folder: Path, **arrays: object) -> Path:
    path = folder / "log.npz"
    np.savez(path, **arrays)  # type: ignore[arg-type]
    return path


def test_columns_units_and_what_is_left_out(tmp_path: Path) -> None:
    table = read_table(write(tmp_path, **{"t [s]": TIME, "F [N]": 2 * TIME, "picture": np.zeros((2, 2))}))
    np.testing.assert_array_equal(table.columns["F"], 2 * TIME)
    assert dict(table.units) == {"t": "s", "F": "N"}
    assert table.notes[0] == "array picture has the shape (2, 2): left out"
    assert "erclutch-reader-npz 0.1.0" in table.notes[-1]


def test_damage_and_pickles_are_errors(tmp_path: Path) -> None:
    path = write(tmp_path, **{"t [s]": TIME})
    path.write_bytes(path.read_bytes().replace(TIME.tobytes()[8:16], bytes(8)))
    with pytest.raises(LogError, match="no arrays of numbers"):
        read_table(path)
    with pytest.raises(LogError, match="no arrays of numbers"):
        read_table(write(tmp_path, who=np.array([{"a": 1}], dtype=object)))
