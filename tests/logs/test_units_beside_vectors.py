"""Units and names that a MATLAB or an HDF5 file states beside its vectors are those of the vectors. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from erclutch.errors import ErclutchError
from erclutch.logs import read

pytestmark = pytest.mark.usefixtures("read_here")

TIME = np.arange(400) / 100
CURRENT = np.repeat([0.0, 0.5, 1.0, 0.25], 100)
VELOCITY = 0.3 * np.sin(10.7 * TIME)
FORCE = (80 + 420 * CURRENT) * np.tanh(VELOCITY / 0.02) + 900 * VELOCITY

#: In ms, mA, mm/s and kN.
LOGGED = {"t": 1e3 * TIME, "I": 1e3 * CURRENT, "v": 1e3 * VELOCITY, "F": FORCE / 1e3}
UNITS = {"t": "ms", "I": "mA", "v": "mm/s", "F": "kN"}


def assert_read_in_si(path: Path) -> None:
    log = read(path)
    assert log.period == pytest.approx(0.01)
    assert log.units == {"field": "A", "slip": "m/s", "effort": "N"}
    for signal, numbers in (("field", CURRENT), ("slip", VELOCITY), ("effort", FORCE)):
        np.testing.assert_allclose(log.signals[signal], numbers, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    "variables",
    [
        {"log": {**LOGGED, "units": UNITS}},
        {**LOGGED, "Units": UNITS},
        {"log": {"data": LOGGED, "units": UNITS}},
        {**LOGGED, **{f"{name}_unit": unit for name, unit in UNITS.items()}},
        {**LOGGED, **{f"units_{name}": unit for name, unit in UNITS.items()}},
    ],
)
def test_units_of_a_matlab_file_by_name(tmp_path: Path, variables: dict[str, Any]) -> None:
    # They were passed over in silence, and numbers in mm/s and kN taken as logged.
    savemat(tmp_path / "log.mat", variables)
    assert_read_in_si(tmp_path / "log.mat")


def test_of_two_units_of_one_name_none_is_taken(tmp_path: Path) -> None:
    runs = {"first": {**LOGGED, "units": UNITS}, "second": {**LOGGED, "units": {**UNITS, "F": "N"}}}
    savemat(tmp_path / "log.mat", runs)
    log = read(tmp_path / "log.mat", variable="first")
    assert log.units["slip"] == "m/s"
    assert log.units["effort"] == "?"


def attributes_of_the_matrix(file: Any, matrix: Any) -> None:
    data = file.create_dataset("data", data=matrix)
    data.attrs["columns"] = [*UNITS]
    data.attrs["units"] = [*UNITS.values()]


def attributes_of_its_group(file: Any, matrix: Any) -> None:
    group = file.create_group("log")
    group.attrs["names"] = [*UNITS]
    group.attrs["units"] = [*UNITS.values()]
    group["data"] = matrix


def lists_beside_it(file: Any, matrix: Any) -> None:
    file["data"] = matrix
    file["columns"] = [*UNITS]
    file["units"] = [*UNITS.values()]


@pytest.mark.parametrize(
    "written", [attributes_of_the_matrix, attributes_of_its_group, lists_beside_it]
)
@pytest.mark.parametrize("in_rows", [False, True])
def test_names_and_units_of_a_matrix_in_hdf5(
    tmp_path: Path, written: Callable[[Any, Any], None], in_rows: bool
) -> None:
    matrix = np.column_stack([*LOGGED.values()])
    with h5py.File(tmp_path / "log.h5", "w") as file:
        written(file, matrix.T if in_rows else matrix)
    assert_read_in_si(tmp_path / "log.h5")


def test_lists_of_another_length_name_no_column(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["data"] = np.column_stack([*LOGGED.values()])
        file["names"] = ["t", "I", "v"]
    with pytest.raises(ErclutchError, match="data_1"):
        read(tmp_path / "log.h5")
