"""MATLAB files with cells and structs inside of structs; signals with times of their own are joined where asked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from erclutch.errors import ErclutchError, LogError
from erclutch.logs import read_table
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.planning.recording_choice import table_of_log
from erclutch.logs.readers import mat_layout, mat_tree
from erclutch.logs.table import Table

TIME = np.arange(200) / 100
SPEED = np.sin(9 * TIME)
TORQUE = SPEED**3
SLOW = TIME[::5]
CURRENT = np.repeat([0.0, 1.0], 20)


def cell(*items: Any) -> np.ndarray:
    held = np.empty(len(items), dtype=object)
    for place, item in enumerate(items):
        held[place] = item
    return held


def matrix_of_cells(rows: int = 200) -> np.ndarray:
    cells = np.empty((rows + 1, 3), dtype=object)
    cells[0] = ["time", "speed", "torque"]
    for row in range(rows):
        cells[row + 1] = [TIME[row], SPEED[row], TORQUE[row]]
    return cells


def found_in(path: Path, variable: str | None = None) -> Table:
    """What the reader's child makes of a file, in this process."""
    return mat_layout.choose(mat_tree.load_v5(str(path)), variable).table()


MEASURED = {"time": TIME, "speed": SPEED, "torque": TORQUE}
#: Variables of a file that hold the three columns.
FORMS: dict[str, dict[str, Any]] = {
    "structs in a struct": {"data": {"meas": MEASURED, "info": "bench", "fs": 100.0}},
    "four levels": {"a": {"b": {"c": {"d": MEASURED}}}},
    "a cell of vectors with a cell of names": {
        "data": cell(TIME, SPEED, TORQUE),
        "names": cell("time", "speed", "torque"),
    },
    "a cell matrix with a row of names": {"T": matrix_of_cells()},
}


@pytest.mark.parametrize("form", FORMS)
def test_a_layout_is_read(tmp_path: Path, form: str) -> None:
    savemat(tmp_path / "a.mat", FORMS[form])
    table = found_in(tmp_path / "a.mat")
    for name, right in MEASURED.items():
        np.testing.assert_array_equal(table.columns[name], right)


WITH_UNITS: dict[str, Any] = {
    "time": {"data": TIME, "units": "s"},
    "speed": {"data": SPEED, "units": "rad/s"},
    "torque": {"data": TORQUE, "units": "N*m"},
}


@pytest.mark.parametrize(
    "variables", [{"Dyno": WITH_UNITS}, WITH_UNITS, {"a": {"run": WITH_UNITS, "by": "us"}}]
)
def test_structs_of_a_signal_and_its_unit_are_the_columns_of_one_recording(
    tmp_path: Path, variables: dict[str, Any]
) -> None:
    savemat(tmp_path / "a.mat", variables)
    table = found_in(tmp_path / "a.mat")
    for name, right in MEASURED.items():
        np.testing.assert_array_equal(table.columns[name], right)
        assert table.units[name] == WITH_UNITS[name]["units"]


@pytest.mark.parametrize("numbers", ["data", "values"])
def test_structs_of_a_time_a_signal_and_its_unit_keep_the_unit(
    tmp_path: Path, numbers: str
) -> None:
    signals = {"speed": (SPEED, "rpm"), "torque": (TORQUE, "mN*m")}
    savemat(
        tmp_path / "a.mat",
        {"m": {name: {"time": TIME, numbers: v, "units": u} for name, (v, u) in signals.items()}},
    )
    table = found_in(tmp_path / "a.mat")
    assert {name: table.units[name] for name in signals} == {"speed": "rpm", "torque": "mN*m"}
    np.testing.assert_array_equal(table.columns["torque"], TORQUE)


def test_structs_of_one_vector_without_units_and_time_stay_recordings(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"s": {"run1": {"data": SPEED}, "run2": {"data": TORQUE}}})
    with pytest.raises(LogError, match=r"several recordings: s.run1, s.run2"):
        found_in(tmp_path / "a.mat")


@pytest.mark.slow
def test_a_cell_matrix_with_a_text_among_its_numbers_is_refused(tmp_path: Path) -> None:
    cells = matrix_of_cells()
    cells[7, 1] = "bad"
    savemat(tmp_path / "a.mat", {"T": cells})
    with pytest.raises(LogError, match="no recording in the variables"):
        found_in(tmp_path / "a.mat")


def test_struct_arrays_are_recordings_one_by_one(tmp_path: Path) -> None:
    runs = cell(MEASURED, {**MEASURED, "speed": 2 * SPEED})
    savemat(tmp_path / "a.mat", {"s": runs})
    with pytest.raises(LogError, match=r"several recordings: s\(1\), s\(2\)"):
        found_in(tmp_path / "a.mat")
    np.testing.assert_array_equal(found_in(tmp_path / "a.mat", "s(2)").columns["speed"], 2 * SPEED)


SIGNALS = {
    "speed": {"Time": TIME, "Data": SPEED},
    "current": {"Time": SLOW, "Data": CURRENT},
    "torque": {"Time": TIME, "Data": TORQUE},
}


@pytest.mark.parametrize(
    ("tree", "names"), [(SIGNALS, "torque + speed + current"), ({"log": SIGNALS}, "log.torque + ")]
)
def test_signals_with_times_of_their_own_are_joined_where_that_is_asked(
    tmp_path: Path, tree: dict[str, Any], names: str
) -> None:
    path = tmp_path / "a.mat"
    savemat(path, tree)
    names = names if names.endswith("current") else "log.torque + log.speed + log.current"
    table = found_in(path, names)
    shared = SLOW[-1] >= TIME
    np.testing.assert_array_equal(table.columns["torque"], TORQUE[shared])
    np.testing.assert_array_equal(table.columns["speed"], SPEED[shared])
    held = CURRENT[np.searchsorted(SLOW, TIME[shared], side="right") - 1]
    np.testing.assert_array_equal(held, table.columns["current"])


def group_of(file: Any, name: str, time: np.ndarray, **columns: tuple[np.ndarray, str]) -> None:
    file.create_dataset(f"{name}/time", data=time).attrs["unit"] = "s"
    for label, (values, unit) in columns.items():
        file.create_dataset(f"{name}/{label}", data=values).attrs["unit"] = unit


@pytest.mark.slow
def test_groups_of_hdf5_that_are_a_log_together_are_asked_about_with_the_answer(
    tmp_path: Path,
) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        group_of(file, "drive", SLOW, value=(CURRENT, "A"))
        group_of(file, "sensors", TIME, speed=(SPEED, "rad/s"), torque=(TORQUE, "N*m"))
        group_of(file, "bath", SLOW, temperature=(20 + SLOW, "°C"))
    assert {*read_table(path, variable="sensors + drive").columns} == {
        "time",
        "speed",
        "torque",
        "drive",
    }
    with h5py.File(path, "w") as file:
        group_of(file, "encoder", TIME, data=(SPEED, "rad/s"))
        group_of(file, "cell", TIME + 1e-4, data=(TORQUE, "N*m"))
    with pytest.raises(ErclutchError, match=r"oin them by time: --variable 'cell \+ encoder'"):
        table_of_log(path, ColumnMap(), None)
    assert {*table_of_log(path, ColumnMap(), None, "cell + encoder").columns} == {
        "time",
        "cell",
        "encoder",
    }

    with h5py.File(path, "w") as file:  # at the same times nothing has to be asked
        group_of(file, "encoder", TIME, data=(SPEED, "rad/s"))
        group_of(file, "cell", TIME, data=(TORQUE, "N*m"))
    table = table_of_log(path, ColumnMap(), None)
    np.testing.assert_array_equal(table.columns["encoder"], SPEED)
    np.testing.assert_array_equal(table.columns["cell"], TORQUE)


@pytest.mark.slow
def test_groups_of_mdf_of_two_rates_are_joined(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    from erclutch.logs.readers import mdf as reader

    path = tmp_path / "a.mf4"
    with asammdf.MDF() as mdf:
        signal = asammdf.Signal
        fast = [
            signal(SPEED, TIME, name="speed", unit="rad/s"),
            signal(TORQUE, TIME, name="torque", unit="Nm"),
        ]
        mdf.append(fast, comment="fast")
        mdf.append([signal(CURRENT, SLOW, name="current", unit="A")], comment="slow")
        mdf.save(path)
    with pytest.raises(LogError, match=r"join them by time: --variable 'fast \+ slow'"):
        reader.find(str(path), None)
    table = reader.find(str(path), "fast + slow")
    shared = SLOW[-1] >= TIME
    np.testing.assert_array_equal(table.columns["torque"], TORQUE[shared])
    held = CURRENT[np.searchsorted(SLOW, TIME[shared], side="right") - 1]
    np.testing.assert_array_equal(held, table.columns["current"])
    assert table.units["current"] == "A"


def test_struct_arrays_inside_of_structs_are_recordings_of_their_own(tmp_path: Path) -> None:
    path = tmp_path / "exo.mat"
    blocks = np.empty(2, dtype=[("block", "O"), ("force", "O"), ("moment", "O")])
    for number in range(2):
        blocks[number] = (f"block{number}", SPEED * (number + 1), TORQUE)
    savemat(path, {"EXO": {"right": blocks}})
    with pytest.raises(LogError, match=r"EXO\.right\(1\), EXO\.right\(2\)"):
        found_in(path)
    np.testing.assert_array_equal(found_in(path, "EXO.right(2)").columns["force"], 2 * SPEED)


def test_vectors_of_the_workspace_go_before_a_struct_of_one_signal_and_can_be_named(
    tmp_path: Path,
) -> None:
    path = tmp_path / "leg.mat"
    of_a_block = {
        "time": TIME,
        "signals": {"values": SPEED[:, None], "dimensions": 1.0, "label": "counter"},
    }
    others = {"table": np.arange(7.0), "mass": 60.0, "R": np.eye(2)}
    savemat(path, {"time": TIME, "speed": SPEED, "torque": TORQUE, "ret": of_a_block, **others})
    table = found_in(path)
    assert set(table.columns) == {"time", "speed", "torque"}
    assert any("--variable takes ret" in note for note in table.notes)
    assert set(found_in(path, "ret").columns) == {"time", "counter"}

    wide = {"time": TIME, "a": SPEED, "b": SPEED, "c": SPEED, "d": SPEED}
    savemat(path, {"time": TIME, "speed": SPEED, "torque": TORQUE, "other": wide})
    with pytest.raises(LogError, match="other, workspace") as caught:
        found_in(path)
    assert "--variable other" in caught.value.remedy
    assert set(found_in(path, "workspace").columns) == {"time", "speed", "torque"}


@pytest.mark.parametrize("beside", [{"log": MEASURED}, dict(MEASURED)])
@pytest.mark.parametrize(
    "last", [np.column_stack([TIME, SPEED]), SPEED, {"time": TIME, "speed": SPEED}]
)
def test_the_last_result_of_matlab_is_left_out_beside_a_recording(
    tmp_path: Path, beside: dict[str, Any], last: Any
) -> None:
    path = tmp_path / "a.mat"
    savemat(path, {"ans": last, **beside})
    table = found_in(path)
    assert set(table.columns) == {*MEASURED}
    assert "variable ans, MATLAB's last result without a name, is left out" in table.notes


def test_the_matrix_of_a_to_file_block_begins_with_its_time(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    savemat(path, {"ans": np.vstack([TIME, SPEED, TORQUE])})
    table = found_in(path)
    assert list(table.columns) == ["time", "ans_2", "ans_3"]
    assert any("Simulink's To File" in note for note in table.notes)
    savemat(path, {"ans": np.vstack([SPEED, TORQUE])})
    assert list(found_in(path).columns) == ["ans_1", "ans_2"]
    savemat(path, {"ans": MEASURED})
    assert set(found_in(path).columns) == {*MEASURED}


def test_an_object_that_only_matlab_reads_is_named_with_its_class(tmp_path: Path) -> None:
    value = np.array([(b"out", b"MCOS", b"Simulink.SimulationOutput", np.zeros(6))],
                     dtype=[("s0", "O"), ("s1", "O"), ("s2", "O"), ("arr", "O")])  # fmt: skip
    assert mat_tree.name_and_kind("None", value) == ("out", "Simulink.SimulationOutput")
    assert mat_tree.name_and_kind("None", np.zeros(3)) == ("None", "")
    assert mat_tree._with_objects({"out": None, "speed": "5"}, {"out": "polyshape"}, None) == {
        "out (a polyshape)": None,
        "speed": "5",
    }
