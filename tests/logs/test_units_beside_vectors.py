"""Units and names that a file states beside its vectors or above its table are those of its columns. SYNTHETIC."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from erclutch.errors import ErclutchError
from erclutch.logs import read, read_table
from erclutch.logs.readers.stated_units import column_of_unit, with_stated_units
from erclutch.logs.table import Table
from tests.support.pace import within

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


def test_units_of_numpy_vectors_by_name(tmp_path: Path) -> None:
    stated: dict[str, Any] = {f"{name}_unit": np.array(unit) for name, unit in UNITS.items()}
    np.savez(tmp_path / "log.npz", **LOGGED, **stated)
    assert_read_in_si(tmp_path / "log.npz")


def test_units_of_json_lists_by_name_and_by_place(tmp_path: Path) -> None:
    lists = {name: numbers.tolist() for name, numbers in LOGGED.items()}
    path = tmp_path / "log.json"
    path.write_text(json.dumps({**lists, **{f"{name}_unit": unit for name, unit in UNITS.items()}}))
    assert_read_in_si(path)
    rows = [list(row) for row in zip(*lists.values(), strict=True)]
    table = {"units": [*UNITS.values()], "columns": [*UNITS], "data": rows}
    path.write_text(json.dumps(table))
    assert_read_in_si(path)


@pytest.mark.parametrize(
    ("remark", "names"),
    [
        ("# units: t: ms, I: mA, v: mm/s, F: kN", "t,I,v,F"),
        ("# t_unit=ms; I_unit=mA; v_unit=mm/s; F_unit=kN", "t,I,v,F"),
        (
            "# Time in ms, current in mA, velocity in mm/s, force in kN",
            "Time,Current,Velocity,Force",
        ),
        (
            "# Times in ms, currents in mA, velocities in mm/s and all forces in kN",
            "time,current,velocity,force",
        ),
    ],
)
def test_units_that_a_remark_states(tmp_path: Path, remark: str, names: str) -> None:
    # They were passed over in silence.
    rows = "\n".join(
        ",".join(f"{x:.12g}" for x in row) for row in zip(*LOGGED.values(), strict=True)
    )
    (tmp_path / "log.csv").write_text(f"{remark}\n{names}\n{rows}\n", "utf-8")
    assert_read_in_si(tmp_path / "log.csv")


@pytest.mark.parametrize(
    "remark", ["# Setup in lab 3, force in the middle", "# fit in m, in in in"]
)
def test_words_that_are_no_units_state_none(tmp_path: Path, remark: str) -> None:
    rows = "\n".join(
        ",".join(f"{x:.6g}" for x in row) for row in zip(*LOGGED.values(), strict=True)
    )
    (tmp_path / "log.csv").write_text(f"{remark}\ntime,current,velocity,force\n{rows}\n", "utf-8")
    table = read_table(tmp_path / "log.csv")
    assert not any(table.units.values())


@pytest.mark.parametrize("sign", [*"[ _-a.", "a_", "a ", "units.", "a in "])
def test_a_long_remark_takes_no_long_time(sign: str) -> None:
    text = sign * 20_000
    table = Table("log.csv", {"force": FORCE}, {"force": None}, "")
    for pairs in ({text: text}, {"units": text}, {f"{text}unit": "m"}, {f"unit{text}": "m"}):
        began = process_time()
        column_of_unit(next(iter(pairs)))
        with_stated_units(table, pairs)
        assert within(process_time() - began, 1.0)
