from __future__ import annotations

import struct
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import ErclutchError, LogError, MappingError
from erclutch.logs import ColumnMap, Table, read, read_all, read_table, recordings_in
from erclutch.logs.dataset import build_dataset
from erclutch.logs.readers import child_process, mat_layout, mat_tree
from tests.support.command import refused
from tests.support.examples import examples
from tests.support.slow_params import slow_behind, slow_but

COUNT = 120
TIME = np.arange(COUNT) * 1e-3
SLIP = np.sin(TIME * 50)
FORCE = np.cos(TIME * 50)


def structs(items: list[dict[str, Any]]) -> np.ndarray:
    """A 1 x n struct array for savemat."""
    array = np.zeros((1, len(items)), dtype=[(name, object) for name in items[0]])
    for index, item in enumerate(items):
        for name, value in item.items():
            array[0, index][name] = value
    return array


def dspace(time: bool = True) -> dict[str, Any]:
    """A ControlDesk recording as public scripts describe it."""
    signals = [
        {
            "Name": '"Model Root"/"Field"/"Out1"',
            "Unit": "V",
            "Data": np.full(COUNT, 2.0),
            "XIndex": 1,
        },
        {
            "Name": '"Model Root"/"Slip speed"/"In1"',
            "Unit": "rad/s",
            "Data": SLIP.astype(np.float32),
            "XIndex": 1,
        },
        {"Name": '"Model Root"/"Force"/"In1"', "Unit": "N", "Data": FORCE, "XIndex": 1},
        {"Name": '"Model Root"/"Slow"/"In1"', "Unit": "", "Data": FORCE[:10], "XIndex": 2},
    ]
    axes = [
        {"Name": "Time", "Data": TIME if time else np.zeros((0, 0)), "Unit": "s"},
        {"Name": "Slow", "Data": TIME[:10], "Unit": "s"},
    ]
    return {
        "X": structs(axes),
        "Y": structs(signals),
        "Description": "run 1",
        "RTProgram": "rig.sdf",
        "Capture": {"SamplingPeriod": 5e-4, "Downsampling": 2},
    }


class V73:
    """Writes v7.3 files the way MATLAB does: user block, class attributes, references, chars as uint16."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.file = h5py.File(path, "w", userblock_size=512)
        self.count = 0

    def put(self, group: Any, name: str, value: Any) -> None:
        if isinstance(value, dict):
            child_group = group.create_group(name)
            child_group.attrs["MATLAB_class"] = np.bytes_("struct")
            for key, item in value.items():
                self.put(child_group, key, item)
        elif isinstance(value, str):
            codes = np.array([[ord(letter)] for letter in value] or [[0]], dtype=np.uint16)
            item = group.create_dataset(name, data=codes)
            item.attrs["MATLAB_class"] = np.bytes_("char")
            item.attrs["MATLAB_int_decode"] = np.int32(2)
        elif isinstance(value, np.ndarray) and value.dtype.names:
            child_group = group.create_group(name)
            child_group.attrs["MATLAB_class"] = np.bytes_("struct")
            for key in value.dtype.names:
                references = [[self.refer(one[key])] for one in value.ravel()]
                child_group.create_dataset(
                    key, data=np.array(references, dtype=object), dtype=h5py.ref_dtype
                )
        else:
            array = np.asarray(value)
            if array.size == 0:
                item = group.create_dataset(name, data=np.zeros(2, dtype=np.uint64))
                item.attrs["MATLAB_empty"] = np.uint8(1)
            else:
                item = group.create_dataset(name, data=np.atleast_2d(array).T)
            item.attrs["MATLAB_class"] = np.bytes_(
                {"f": "double", "i": "int64"}.get(array.dtype.kind, "double")
            )

    def refer(self, value: Any) -> Any:
        refs = self.file.require_group("#refs#")
        self.count += 1
        self.put(refs, f"r{self.count}", value)
        return refs[f"r{self.count}"].ref

    def close(self) -> None:
        self.file.close()
        block = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
        with self.path.open("r+b") as file:
            file.write(block.ljust(512, b"\0"))


def save5(path: Path, variables: dict[str, Any]) -> Path:
    scipy.io.savemat(path, variables, do_compression=True)
    return path


def save73(path: Path, variables: dict[str, Any]) -> Path:
    file = V73(path)
    for name, value in variables.items():
        file.put(file.file, name, value)
    file.close()
    return path


both = pytest.mark.parametrize("save", [save5, save73], ids=["v5", "v7.3"])
Save = Callable[[Path, dict[str, Any]], Path]


@pytest.mark.usefixtures("read_here")
@both
def test_vectors_of_the_workspace(tmp_path: Path, save: Save) -> None:
    path = save(
        tmp_path / "a.mat",
        {
            "t": TIME,
            "V": SLIP,
            "M": np.c_[SLIP, FORCE],
            "fs": 1000.0,
            "who": "Meier",
            "odd": TIME[:7],
        },
    )
    table = read_table(path)
    assert set(table.columns) == {"t", "V", "M_1", "M_2"}  # HDF5 sorts its members
    assert np.array_equal(table.columns["M_2"], FORCE)
    assert table.constants == {"fs": 1000.0}
    assert "variable odd has 7 samples, not 120: left out" in table.notes


@both
@pytest.mark.usefixtures("read_here")
def test_a_struct_of_vectors(tmp_path: Path, save: Save) -> None:
    path = save(
        tmp_path / "a.mat", {"run": {"time": TIME, "speed": SLIP, "force": FORCE, "rate": 1000.0}}
    )
    table = read_table(path)
    assert set(table.columns) == {"time", "speed", "force"}
    assert np.array_equal(table.columns["speed"], SLIP)
    assert "recording read from variable run" in table.notes


@both
@pytest.mark.usefixtures("read_here")
def test_a_matrix_on_its_side(tmp_path: Path, save: Save) -> None:
    path = save(tmp_path / "a.mat", {"log": np.vstack([TIME, SLIP, FORCE])})
    table = read_table(path)
    assert list(table.columns) == ["log_1", "log_2", "log_3"]
    assert "matrix log is 3 x 120: its rows are taken as columns" in table.notes


@both
@pytest.mark.usefixtures("read_here")
def test_a_timeseries_like_struct_and_a_structure_with_time(tmp_path: Path, save: Save) -> None:
    table = read_table(save(tmp_path / "a.mat", {"speed": {"Time": TIME, "Data": SLIP}}))
    assert list(table.columns) == ["time", "speed"]
    scope = {"time": TIME, "signals": {"values": SLIP, "label": "speed"}}
    table = read_table(save(tmp_path / "b.mat", {"scope": scope}))
    assert list(table.columns) == ["time", "speed"]


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("factor", [1, 2])
def test_a_path_that_a_controldesk_recording_has_twice_is_lost_only_where_its_numbers_are_the_same(
    tmp_path: Path, factor: int
) -> None:
    path = tmp_path / "rec.mat"
    named = [("Speed", SLIP), ("Speed", factor * SLIP), ("Torque", FORCE)]
    signals = [{"Name": f'"Model Root"/"{name}"', "Data": values} for name, values in named]
    scipy.io.savemat(path, {"rec": {"X": {"Data": TIME}, "Y": structs(signals)}})
    columns = read_table(path).columns
    if factor == 1:
        assert [*columns] == ["time", "Speed", "Torque"]
        return
    first, second = (values for name, values in columns.items() if "Speed" in name)
    np.testing.assert_array_equal(second, 2 * first)


@pytest.mark.slow
@both
@pytest.mark.usefixtures("read_here")
def test_a_controldesk_recording(tmp_path: Path, save: Save) -> None:
    path = save(tmp_path / "rec.mat", {"rec001": dspace()})
    table = read_table(path)
    assert table.labels == ("time [s]", "Field [V]", "Slip speed [rad/s]", "Force [N]")
    assert table.metadata == {"Description": "run 1", "RTProgram": "rig.sdf"}
    assert "1 signals on other time axes than X(1) left out" in table.notes
    recording = read(path)
    assert recording.units == {"field": "V", "slip": "rad/s", "effort": "N"}
    assert recording.period == pytest.approx(1e-3, rel=1e-12)
    assert np.array_equal(recording.signals["effort"], FORCE)


@both
@pytest.mark.usefixtures("read_here")
def test_a_controldesk_recording_without_time_uses_its_period(tmp_path: Path, save: Save) -> None:
    recording = read(save(tmp_path / "rec.mat", {"rec001": dspace(time=False)}))
    assert recording.period == 1e-3
    assert recording.rows == COUNT


@pytest.mark.slow
@both
@pytest.mark.usefixtures("read_here")
def test_several_recordings_need_a_choice(tmp_path: Path, save: Save) -> None:
    run = {"time": TIME, "speed": SLIP}
    path = save(tmp_path / "a.mat", {"run1": run, "run2": {**run, "speed": FORCE}})
    with pytest.raises(
        LogError, match=r"several recordings: run1, run2. Choose one, such as --variable run1"
    ):
        read_table(path)
    assert np.array_equal(read_table(path, variable="run2").columns["speed"], FORCE)
    with pytest.raises(LogError, match=r"no variable 'run3' \(there are: run1, run2\)"):
        read_table(path, variable="run3")
    mapping = ColumnMap.from_labels({"slip": "speed [rad/s]", "effort": "force [N]"})
    run["force"] = FORCE
    save(path, {"run1": run, "run2": {**run, "speed": 2 * SLIP}})
    assert recordings_in(path) == ["run1", "run2"]
    first, second = read_all(path, mapping)
    assert (first.name, second.name) == ("a.mat: run1", "a.mat: run2")
    assert np.array_equal(second.signals["slip"], 2 * first.signals["slip"])
    assert build_dataset([first, second]).rows == 2 * first.rows  # two logs, not one log twice


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_several_efforts_over_one_position_are_logs(tmp_path: Path) -> None:
    run = {"time": TIME, "speed": SLIP, "F_0A": FORCE, "F_0x5A": 2 * FORCE}
    path = save5(tmp_path / "a.mat", {"run1": run, "run2": run})
    how = {"name_pattern": "F_{field}A", "variable": "all"}
    labels = {"slip": "speed [rad/s]", "effort": "-F_* [N]"}
    logs = read_all(path, ColumnMap.from_labels(labels, **how))
    assert [log.name for log in logs] == [
        f"a.mat: {run} -{effort}" for run in ("run1", "run2") for effort in ("F_0A", "F_0x5A")
    ]
    assert [log.constants["field"] for log in logs] == [0, 0.5, 0, 0.5]
    np.testing.assert_array_equal(logs[3].signals["effort"], -2 * FORCE)


def test_each_effort_that_may_be_meant_gets_its_own_number(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = [f"{k / 100},{k % 7},{k},{2 * k}" for k in range(50)]
    path.write_text("\n".join(["t [s],slip [rad/s],F1 [N],F2 [N]", *rows]), encoding="utf-8")
    logs = read_all(path, ColumnMap.from_dict({"constants": {"field": "0.25, 1 A"}}))
    assert [(log.name, log.constants["field"], log.units["field"]) for log in logs] == [
        ("a.csv: F1", 0.25, "A"),
        ("a.csv: F2", 1.0, "A"),
    ]
    assert len({log.digest for log in logs}) == 2
    with pytest.raises(MappingError, match="add --variable all"):
        read(path, {"effort": "F* [N]", "field": "none"})


def cell(items: list[Any]) -> np.ndarray:
    """A 1 x n cell for savemat."""
    made = np.empty((1, len(items)), dtype=object)
    for place, item in enumerate(items):
        made[0, place] = item
    return made


@pytest.mark.usefixtures("read_here")
def test_a_cell_of_vectors_is_columns(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"t": TIME, "sig": cell([SLIP, FORCE])})
    assert list(read_table(path).columns) == ["t", "sig_1", "sig_2"]
    scipy.io.savemat(
        path, {"run": {"t": TIME, "sig": cell([SLIP.reshape(-1, 1), FORCE.reshape(-1, 1)])}}
    )
    table = read_table(path)
    assert list(table.columns) == ["t", "sig_1", "sig_2"]
    np.testing.assert_array_equal(table.columns["sig_2"], FORCE)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("inside", [False, True])
def test_a_cell_of_names_names_the_columns_of_a_matrix(tmp_path: Path, inside: bool) -> None:
    path = tmp_path / "a.mat"
    nodes = {
        "names": cell(["t [s]", "slip [rad/s]", "F [N]"]),
        "data": np.column_stack([TIME, SLIP, FORCE]),
    }
    scipy.io.savemat(path, {"run": nodes} if inside else nodes)
    table = read_table(path)
    assert table.labels == ("t [s]", "slip [rad/s]", "F [N]")
    np.testing.assert_array_equal(table.columns["F"], FORCE)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("named", [True, False])
def test_an_array_of_structs_that_are_signals_is_one_log(tmp_path: Path, named: bool) -> None:
    path = tmp_path / "a.mat"
    names = [("t", "s", TIME), ("slip", "rad/s", SLIP), ("F", "", FORCE)]
    signals = [{"data": v, "unit": u, **({"name": n} if named else {})} for n, u, v in names]
    for stored in (structs(signals), cell(signals)):
        scipy.io.savemat(path, {"sig": stored})
        table = read_table(path)
        labels = (
            ("t [s]", "slip [rad/s]", "F") if named else ("sig_1 [s]", "sig_2 [rad/s]", "sig_3")
        )
        assert table.labels == labels
        np.testing.assert_array_equal(table.columns[table.numbered(2) or ""], SLIP)


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("of_a_scope", [False, True])
def test_of_two_signals_with_one_name_none_is_lost(tmp_path: Path, of_a_scope: bool) -> None:
    path = tmp_path / "a.mat"
    named = [("speed", SLIP), ("speed", 2 * SLIP), ("torque", FORCE)]
    if of_a_scope:
        signals = [{"values": values, "label": name} for name, values in named]
        variables = {"ScopeData": {"time": TIME, "signals": structs(signals)}}
    else:
        items = [{"data": values, "name": name} for name, values in [("time", TIME), *named]]
        variables = {"sig": structs(items)}
    scipy.io.savemat(path, variables)
    table = read_table(path)
    assert [*table.columns] == ["time", "speed (1)", "speed (2)", "torque"]
    np.testing.assert_array_equal(table.columns["speed (1)"], SLIP)
    with pytest.raises(MappingError, match=r"slip may be any of the columns speed \(1\), speed"):
        read(path)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("form", ["matrices", "cells", "signals"])
def test_runs_below_one_line_of_names_are_recordings(tmp_path: Path, form: str) -> None:
    path = tmp_path / "a.mat"
    names = ["t", "slip", "F"]
    variables: dict[str, Any] = {"names": cell(names)} if form != "signals" else {}
    for factor in (1, 2):
        columns = [TIME, factor * SLIP, FORCE]
        signals = [{"name": n, "data": v} for n, v in zip(names, columns, strict=True)]
        stored = {
            "matrices": np.column_stack(columns),
            "cells": cell([column[:, None] for column in columns]),
            "signals": structs(signals),
        }
        variables[f"run{factor}"] = stored[form]
    scipy.io.savemat(path, variables)
    assert recordings_in(path) == ["run1", "run2"]
    np.testing.assert_array_equal(read_table(path, variable="run1").columns["slip"], SLIP)
    with pytest.raises(LogError, match="several recordings: run1, run2"):
        read_table(path)


@pytest.mark.usefixtures("read_here")
def test_matrices_of_a_struct_below_one_line_of_names_keep_their_names(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    left = np.column_stack([SLIP, FORCE])
    sides = {"names": cell(["slip", "F"]), "left": left, "right": 2 * left, "t": TIME}
    scipy.io.savemat(path, {"log": sides})
    table = read_table(path)
    assert {*table.columns} == {"t", "left.slip", "left.F", "right.slip", "right.F"}
    np.testing.assert_array_equal(table.columns["right.slip"], 2 * SLIP)


@pytest.mark.usefixtures("read_here")
def test_a_vector_does_not_take_the_place_of_a_column_of_its_name(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    matrix = np.column_stack([TIME, SLIP, FORCE])
    variables = {"names": cell(["t", "slip", "F"]), "data": matrix, "slip": 3 * SLIP}
    scipy.io.savemat(path, variables)
    with pytest.raises(LogError, match=r"several recordings: data, workspace \(the vectors slip\)"):
        read_table(path)
    np.testing.assert_array_equal(read_table(path, variable="data").columns["slip"], SLIP)


@pytest.mark.usefixtures("read_here")
@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 3])
def test_an_array_or_a_cell_of_structs_is_recordings(tmp_path: Path, count: int) -> None:
    path = tmp_path / "a.mat"
    runs = [{"t": TIME, "slip": k * SLIP, "F": FORCE} for k in range(1, count + 1)]
    for stored in (structs(runs), cell(runs)):
        scipy.io.savemat(path, {"runs": stored})
        if count == 1:
            assert read_table(path).rows == COUNT
            continue
        assert recordings_in(path) == ["runs(1)", "runs(2)", "runs(3)"]
        np.testing.assert_array_equal(
            read_table(path, variable="runs(2)").columns["slip"], 2 * SLIP
        )
        with pytest.raises(LogError, match=r"several recordings: runs\(1\), runs\(2\), runs\(3\)"):
            read_table(path)


@pytest.mark.usefixtures("read_here")
@both
def test_nothing_to_read(tmp_path: Path, save: Save) -> None:
    with pytest.raises(LogError, match="no recording in the variables who"):
        read_table(save(tmp_path / "a.mat", {"who": "Meier"}))


@pytest.mark.slow
@both
@pytest.mark.parametrize("share", slow_but([0.9], [0.3, 0.9]))
def test_a_truncated_file(tmp_path: Path, save: Save, share: float) -> None:
    path = save(tmp_path / "a.mat", {"t": TIME, "V": SLIP, "F": FORCE})
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(LogError, match=r"a\.mat: "):
        read_table(path)


@pytest.mark.usefixtures("read_here")
def test_links_to_other_files_are_not_followed(tmp_path: Path) -> None:
    secret = save73(tmp_path / "secret.mat", {"t": TIME})
    path = tmp_path / "a.mat"
    save73(path, {"V": SLIP})
    with h5py.File(path, "r+") as file:
        file["out"] = h5py.ExternalLink(str(secret), "t")
        file["ring"] = h5py.SoftLink("/")
    assert list(read_table(path).columns) == ["V"]


CHILD = """
import sys, time
from erclutch.logs.readers import child_process
from erclutch.errors import LogError, MappingError
def read(path, how):
    if how == "crash":
        import os, signal
        os.kill(os.getpid(), signal.SIGSEGV)
    if how == "spin":
        import os, signal
        os.kill(os.getpid(), signal.SIGXCPU)
    if how == "hang":
        time.sleep(60)
    if how == "greed":
        bytearray(1 << 40)
    if how == "exit":
        sys.exit(3)
    raise ValueError("odd")
sys.exit(child_process.serve(read))
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("how", "problem"),
    slow_behind(
        1,
        [
            ("crash", "the reader broke on this file"),
            ("spin", "takes longer than the 20 s that its size allows|took longer than"),
            ("hang", "took longer than"),
            ("greed", "needs more than 2048 MiB"),
            ("exit", r"the reader broke on this file \(code 3\)"),
            ("raise", r"cannot be read \(ValueError: odd\)"),
        ],
    ),
)
@pytest.mark.skipif(sys.platform == "win32", reason="signals and limits of POSIX")
def test_a_child_that_fails_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: str, problem: str
) -> None:
    (tmp_path / "bad_reader.py").write_text(CHILD, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(LogError, match=problem):
        child_process.run(
            "bad_reader",
            tmp_path / "x.mat",
            how,
            memory=2 << 30,
            seconds=0.1 if how == "hang" else 20,
        )
    assert not list(tmp_path.glob("erclutch-*"))  # the temporary folder is gone


# Damaged files: the reader in this process, many times (the child is the same code behind a wall, tried above).


@pytest.fixture(scope="module")
def whole5(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("mat") / "a.mat"
    scipy.io.savemat(path, {"rec": dspace(), "t": TIME[:20]})
    return path.read_bytes()


FIELDS = ["X", "Y", "Name", "Data", "time", "signals", "XIndex", "Capture"]
LEAVES = (
    st.none()
    | st.text(max_size=3)
    | st.sampled_from([np.arange(5.0), np.zeros((2, 3, 4)), np.zeros((3, 5))])
)


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(
    st.recursive(
        LEAVES,
        lambda node: (
            st.lists(node, max_size=3) | st.dictionaries(st.sampled_from(FIELDS), node, max_size=4)
        ),
        max_leaves=12,
    )
)
def test_any_tree_is_a_recording_or_an_error_of_ours(node: Any) -> None:
    with suppress(ErclutchError):
        assert mat_layout.choose({"a": node, "b": np.arange(5.0)}, None).columns


@pytest.mark.slow
@pytest.mark.parametrize("seed", slow_but(range(1), range(6)))
def test_a_mutated_file_gives_a_table_or_an_error_of_ours(
    tmp_path: Path, whole5: bytes, seed: int
) -> None:
    random = np.random.default_rng(seed)
    data = bytearray(whole5)
    for place in random.integers(128, len(data), 20):
        data[place] = random.integers(256)
    path = tmp_path / "a.mat"
    path.write_bytes(bytes(data))
    with suppress(ErclutchError):
        assert isinstance(read_table(path), Table)


@pytest.mark.slow
def test_the_tree_of_a_file(tmp_path: Path) -> None:
    for tree in (
        mat_tree.load_v5(str(save5(tmp_path / "a.mat", {"rec": dspace()}))),
        mat_tree.load_v73(str(save73(tmp_path / "b.mat", {"rec": dspace()}))),
    ):
        record = tree["rec"]
        assert isinstance(record, dict)
        assert record["Y"][0]["Name"] == '"Model Root"/"Field"/"Out1"'


@pytest.mark.slow
def test_a_module_beside_the_log_is_not_imported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "numpy.py").write_text("raise SystemExit('this ran')")
    scipy.io.savemat(
        tmp_path / "log.mat", {"time": TIME, "field": FORCE, "slip": SLIP, "force": FORCE}
    )
    monkeypatch.chdir(tmp_path)
    assert read_table("log.mat").rows == COUNT


def _element(kind: int, data: bytes) -> bytes:
    """One element of a v5 file: a tag, and data filled up to 8 bytes."""
    return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)


def _object() -> bytes:
    """A variable that is a datetime, as MATLAB writes it: an object has no shape in its head."""
    head = _element(6, struct.pack("<II", 17, 0))
    names = b"".join(_element(1, text) for text in (b"when", b"MCOS", b"datetime"))
    shape = _element(5, struct.pack("<ii", 1, 1))
    number = (
        _element(6, struct.pack("<II", 13, 0))
        + shape
        + _element(1, b"")
        + _element(6, struct.pack("<I", 7))
    )
    return _element(14, head + names + _element(14, number))


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("first", [True, False])
def test_a_datetime_among_the_variables_hides_none_of_them(tmp_path: Path, first: bool) -> None:
    path = tmp_path / "log.mat"
    scipy.io.savemat(path, {"t": TIME, "velocity": SLIP, "force": FORCE})
    written = path.read_bytes()
    path.write_bytes(written[:128] + _object() + written[128:] if first else written + _object())
    table = read_table(path)
    np.testing.assert_array_equal(table.columns["velocity"], SLIP)
    assert [*table.columns] == ["t", "velocity", "force"]


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("name", ["data", "f", "measured_signals_of_the_rig"])
@pytest.mark.parametrize("values", [np.float64, np.float32, np.int16])
def test_a_matrix_of_v4_is_read_as_one_of_v5(tmp_path: Path, name: str, values: type) -> None:
    rows = np.round(np.stack([TIME, SLIP, FORCE]) * 1000).astype(
        values
    )  # a row a signal, as Simulink writes them
    for version in ("4", "5"):
        scipy.io.savemat(tmp_path / f"v{version}.mat", {name: rows}, format=version)
    old, new = (read_table(tmp_path / f"v{version}.mat") for version in "45")
    assert list(old.columns) == [f"{name}_1", f"{name}_2", f"{name}_3"]
    for label, column in new.columns.items():
        np.testing.assert_array_equal(old.columns[label], column)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize(
    "head", [bytes(20) + b"data\0", struct.pack("<5i", 60, 2, 2, 0, 2) + b"a\0"]
)
def test_bytes_that_begin_like_no_matrix_are_no_v4(tmp_path: Path, head: bytes) -> None:
    (tmp_path / "a.mat").write_bytes(head + bytes(600))
    with pytest.raises(LogError, match="neither a MATLAB v4 or v5 nor"):
        read_table(tmp_path / "a.mat")


@pytest.mark.slow
def test_a_variable_without_a_recording_is_refused_without_a_command(tmp_path: Path) -> None:
    """The message lists the others in brackets; the first word of the list was printed as an option."""
    run = {"time": TIME, "velocity": SLIP, "force": FORCE}
    scipy.io.savemat(tmp_path / "log.mat", {"run": run, "gain": 3.0})
    assert "holds no recording" in refused("inspect", "log.mat", "--variable", "gain", cwd=tmp_path)
