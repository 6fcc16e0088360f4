"""A lone matrix of a MATLAB file that --variable names has the names of the cell of texts beside it. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from erclutch.logs import read_table

pytestmark = pytest.mark.usefixtures("read_here")
NAMES = ["time", "current", "speed", "torque"]
ROWS = np.random.default_rng(0).normal(size=(50, 4))


@pytest.mark.parametrize("shape", [(4,), (1, 4), (4, 1)])
def test_a_matrix_that_is_named_has_the_names_beside_it(
    tmp_path: Path, shape: tuple[int, ...]
) -> None:
    names = np.array(NAMES, dtype=object).reshape(shape)
    other = np.arange(6.0).reshape(2, 3)
    savemat(tmp_path / "log.mat", {"header": names, "data": ROWS, "calibration": other})
    table = read_table(tmp_path / "log.mat", variable="data")
    assert [*table.columns] == NAMES
    np.testing.assert_array_equal(table.columns["torque"], ROWS[:, 3])


def test_names_of_another_number_name_no_columns(tmp_path: Path) -> None:
    names = np.array(NAMES[:3], dtype=object)
    savemat(tmp_path / "log.mat", {"header": names, "data": ROWS})
    table = read_table(tmp_path / "log.mat", variable="data")
    assert [*table.columns] == [f"data_{number}" for number in range(1, 5)]
