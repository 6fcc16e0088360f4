"""What readers of binary files find stays as it is kept beside this file; the children's work runs in this process.

`tests/conftest.py` says how to pin anew after a change that is meant.
"""

from __future__ import annotations

import datetime
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from erclutch.errors import ErclutchError
from erclutch.logs.table import Table
from tests.support.pinning import Pinned

ROWS = np.arange(20.0)
A, B = np.sin(ROWS), np.cos(ROWS)


def told(of: Callable[[], Any]) -> Any:
    """What comes of it, tables as what they hold, or the words of the error."""
    try:
        found = of()
    except ErclutchError as error:
        return f"{type(error).__name__}: {error}"
    if not isinstance(found, Table):
        return found
    names = ("units", "sample_period", "clock_name", "constants", "metadata", "notes")
    sums = {
        k: [v.size, float(np.nansum(v * np.cos(np.arange(v.size)))), int(np.isnan(v).sum())]
        for k, v in found.columns.items()
    }
    clock = None if found.clock is None else found.clock.tolist()[:5]
    return {"columns": sums, "clock": clock, **{name: getattr(found, name) for name in names}}


@pytest.mark.slow
def test_tdms(tmp_path: Path, pinned: Pinned) -> None:
    nptdms: Any = pytest.importorskip("nptdms")
    from erclutch.logs.readers import tdms

    start = np.datetime64("2026-01-31T12:00:00")
    clocked = {"wf_increment": 0.01, "wf_start_offset": 0.5}
    units = {"unit_string": "N", "NI_UnitDescription": "kN"}
    runs: dict[str, list[Any]] = {
        "one clock": [("g", "a", A, {**clocked, **units}), ("g", "b", B, clocked)],
        "another clock": [
            ("g", "a", A, clocked),
            ("g", "b", B, clocked),
            ("g", "c", A[:7], {"wf_increment": 0.1}),
        ],
        "no clock": [("g", "a", A, {"NI_UnitDescription": "V"}), ("g", "b", B, {})],
        "stamps": [
            ("g", "at", start + (1000 * ROWS).astype("timedelta64[ms]"), {}),
            ("g", "b", B, {}),
        ],
        "two groups": [("g", "a", A, clocked), ("h", "a", B, {})],
        "no numbers": [("g", "a", ["x", "y"], {})],
    }
    found: dict[str, Any] = {}
    path = tmp_path / "a.tdms"
    for name, channels in runs.items():
        with nptdms.TdmsWriter(path) as file:
            file.write_segment([nptdms.ChannelObject(*channel) for channel in channels])
        found[name] = [told(lambda v=v: tdms.find(str(path), v)) for v in (None, "h", "x")]
    with nptdms.TdmsWriter(path) as file:
        for second in (0, 5):
            more = {"wf_increment": 0.01, "wf_start_time": start + np.timedelta64(second, "s")}
            file.write_segment([nptdms.ChannelObject("g", "a", A, more)])
    found["begun anew"] = told(lambda: tdms.find(str(path), None))
    path.write_bytes(path.read_bytes()[:-60])
    found["cut off"] = told(lambda: tdms.find(str(path), None))
    pinned(found)


@pytest.mark.slow
def test_hdf5(tmp_path: Path, pinned: Pinned) -> None:
    h5py: Any = pytest.importorskip("h5py")
    from erclutch.logs.readers import hdf5

    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.attrs["rig"], file.attrs["numbers"] = "three", np.arange(3)
        file["run/a"], file["run/b"], file["run/gain"] = A, B[:, None], 2.5
        file["run/a"].attrs["unit"] = "N"
        file["run"].attrs["sample_rate"] = "100 Hz"
        file["other/table"] = np.array(
            list(zip(A, B, strict=True)), dtype=[("x", "f8"), ("y", "f8")]
        )
        file["other/table"].attrs["note"] = b"bytes"
        file["cube"], file["text"] = np.ones((2, 2, 2)), "words"
        file["out"] = h5py.ExternalLink("secret.h5", "/")
    found = [
        told(lambda v=v: hdf5.find(str(path), v)) for v in (None, "run", "other/table", "/", "x")
    ]
    with h5py.File(path, "w") as file:
        file["a"], file["b"] = A, A[:5]
    pinned([*found, told(lambda: hdf5.find(str(path), None))])


@pytest.mark.slow
def test_spreadsheets(tmp_path: Path, pinned: Pinned) -> None:
    openpyxl: Any = pytest.importorskip("openpyxl")
    pytest.importorskip("python_calamine")
    from erclutch.logs.readers import spreadsheet

    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Run 1"
    sheet.append(["Bench", "# 3"])
    sheet.append([])
    sheet.append(["when", "F [N]", "U [V]", "remark", "on"])
    begin = datetime.datetime(2026, 1, 31, 12)
    for k in range(20):
        when = begin + datetime.timedelta(milliseconds=10 * k)
        sheet.append([when, k / 4 if k != 7 else None, k, None, k % 2 == 0])
    notes, third = book.create_sheet("Notes"), book.create_sheet("Run 2")
    notes.append(["nothing but text"])
    for k in range(12):
        third.append([0.1 * k, k * k])
    path = tmp_path / "a.xlsx"
    book.save(path)
    found = [
        told(lambda v=v: spreadsheet.find(str(path), v))
        for v in (None, "Run 1", "Run 2", "Notes", "x")
    ]
    third.cell(5, 2, "stalled")
    book.save(path)
    found.append(told(lambda: spreadsheet.find(str(path), "Run 2")))
    del book["Run 1"], book["Run 2"]
    book.save(path)
    pinned([*found, told(lambda: spreadsheet.find(str(path), None))])


@pytest.mark.slow
def test_mat(tmp_path: Path, pinned: Pinned) -> None:
    from scipy.io import savemat

    from erclutch.logs.readers import mat

    struct = {
        "t": ROWS / 100,
        "F": A,
        "gain": 2.5,
        "unit": "N",
        "cells": np.array([1, "x"], object),
    }
    kinds: dict[str, dict[str, Any]] = {
        "vectors": {"t": ROWS, "a": A[:, None], "b": B[None, :], "gain": 3.0, "name": "words"},
        "struct": {"run": struct},
        "two structs": {"run1": struct, "run2": struct},
        "nested": {"log": {"deep": struct, "more": {"x": A}}},
        "signals": {
            "scope": {
                "time": ROWS / 10,
                "signals": {"values": np.column_stack([A, B]), "label": "torque"},
            }
        },
        "matrix": {"m": np.column_stack([ROWS, A, B])},
        "array of structs": {
            "s": np.array([(A, "N"), (B, "V")], dtype=[("data", object), ("unit", object)])
        },
        "nothing": {"x": 1.0, "y": "words"},
        "lengths": {"a": A, "b": B[:7]},
        "logical": {"a": A > 0, "b": np.arange(20, dtype=np.int16), "c": A + 1j},
    }
    found: dict[str, Any] = {}
    path = tmp_path / "a.mat"
    for name, given in kinds.items():
        savemat(path, given)
        found[name] = [told(lambda v=v: mat.find(str(path), v)) for v in (None, "run2", "x", "m")]
    pinned(found)


def test_mdf(monkeypatch: pytest.MonkeyPatch, pinned: Pinned) -> None:
    """The library takes a second to import, so what it gives is made here; slow tests read real files."""
    from erclutch.logs.readers import mdf

    def channel(name: str, values: Any, unit: str = "", bits: Any = None) -> Any:
        signal = SimpleNamespace(samples=np.asarray(values), unit=unit, invalidation_bits=bits)
        return SimpleNamespace(name=name, unit=unit, signal=signal)

    def group(said: str, channels: list[Any], master: int | None, comment: str = "") -> Any:
        own = SimpleNamespace(acq_name=said, comment=comment, cycles_nr=20)
        return SimpleNamespace(channel_group=own, channels=channels, master=master)

    def opened(groups: list[Any]) -> Any:
        class MDF:
            masters_db = {k: g.master for k, g in enumerate(groups) if g.master is not None}  # noqa: RUF012

            def __init__(self, path: str) -> None:
                self.groups = groups

            def __enter__(self) -> Any:
                return self

            def __exit__(self, *_: object) -> None: ...

            def get_master(self, index: int) -> Any:
                master = self.groups[index].master
                return [] if master is None else self.groups[index].channels[master].signal.samples

            def get(self, group: int, index: int, ignore_invalidation_bits: bool) -> Any:
                assert ignore_invalidation_bits
                return self.groups[group].channels[index].signal

        return MDF

    time = channel("t", ROWS / 100, "s")
    kinds = {
        "one": [group("fast", [time, channel("F", A, "N"), channel("words", ["x"] * 20)], 0)],
        "invalid": [
            group(
                "",
                [
                    channel("", ROWS),
                    channel("F", A, bits=ROWS % 5 == 0),
                    channel("G", B, bits=ROWS < 0),
                ],
                0,
            )
        ],
        "same time": [
            group("a", [time, channel("F", A)], 0),
            group("b", [time, channel("F", B)], 0),
        ],
        "two": [
            group("a", [time, channel("F", A)], 0),
            group("a", [channel("t", ROWS), channel("F", B)], 0),
        ],
        "by comment": [
            group("", [time, channel("F", A)], 0, "slow"),
            group("x" * 60, [channel("t", ROWS), time], 0, "y"),
        ],
        "no master": [group("", [channel("F", A)], None)],
        "cut off": [group("", [time, channel("F", A[:-1])], 0)],
        "one row": [group("", [channel("t", [0.0]), channel("F", [1.0])], 0)],
        "matrix": [group("", [time, channel("M", np.ones((20, 2)))], 0)],
        "none": [],
    }
    found: dict[str, Any] = {}
    for name, groups in kinds.items():
        library: Any = ModuleType("asammdf")
        library.MDF = opened(groups)
        monkeypatch.setitem(sys.modules, "asammdf", library)
        found[name] = [told(lambda v=v: mdf.find("a.mf4", v)) for v in (None, "a", "group 2")]
    pinned(found)


@pytest.mark.slow
def test_mat_73(tmp_path: Path, pinned: Pinned, monkeypatch: pytest.MonkeyPatch) -> None:
    h5py: Any = pytest.importorskip("h5py")
    from erclutch.logs.readers import mat, mat_tree

    path = tmp_path / "a.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        refs = file.create_group("#refs#")
        refs["a"], refs["b"] = A, B
        file["run/F"], file["run/t"], file["run/gain"] = (
            A[None, :],
            ROWS[None, :] / 100,
            np.array([[2.5]]),
        )
        name = file.create_dataset("run/name", data=np.array([[ord(c)] for c in "rig "], np.uint16))
        name.attrs["MATLAB_class"] = np.bytes_("char")
        empty = file.create_dataset("run/none", data=np.zeros(2))
        empty.attrs["MATLAB_empty"] = 1
        cells = file.create_dataset("cells", (2, 1), dtype=h5py.ref_dtype)
        cells.attrs["MATLAB_class"] = np.bytes_("cell")
        cells[0, 0], cells[1, 0] = refs["a"].ref, refs["b"].ref
        structs = file.create_group("many")
        for field in ("data", "other"):
            own = structs.create_dataset(field, (2, 1), dtype=h5py.ref_dtype)
            own[0, 0], own[1, 0] = refs["a"].ref, refs["b"].ref
        file["deep/deeper/deepest/x"] = A
        file["out"], file["soft"] = h5py.ExternalLink("secret.h5", "/"), h5py.SoftLink("/run")
    with path.open("r+b") as block:
        block.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + b"\0" * 8 + b"\0\2IM")

    def shape(node: Any) -> Any:
        if isinstance(node, dict):
            return {key: shape(value) for key, value in node.items()}
        return (
            [shape(each) for each in node]
            if isinstance(node, list)
            else getattr(node, "shape", node)
        )

    found: list[Any] = [
        told(lambda v=v: mat.find(str(path), v))
        for v in (None, "run", "cells", "many", "deep", "x")
    ]
    for limits in ({"_DEEPEST": 0}, {"_DEEPEST": 1}, {"_DEEPEST": 2}, {"_MOST": 1}, {"_MOST": 2}):
        with monkeypatch.context() as patch:
            for name_of, value in limits.items():
                patch.setattr(mat_tree, name_of, value)
            found.append(shape(mat_tree.load_v73(str(path))))
    pinned(found)


@pytest.mark.usefixtures("read_here")
def test_sizes_that_are_just_allowed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import pyarrow as pa
    from pyarrow import parquet as written

    from erclutch import logs
    from erclutch.errors import LogError
    from erclutch.logs import log_reader
    from erclutch.logs.readers import budget, rosbag

    path = tmp_path / "a.csv"
    path.write_text("t,F\n" + "".join(f"{k},{k}\n" for k in range(20)))
    other = tmp_path / "a.parquet"
    written.write_table(pa.table({"t": ROWS, "F": A}), other)
    meta = written.ParquetFile(other).metadata
    needed = max(meta.row_group(0).total_byte_size // 8, meta.num_rows * meta.num_columns)
    monkeypatch.setattr(budget, "CELLS_PER_BYTE", 0)
    for module, limit, file, size in (
        (log_reader, "_LARGEST", path, path.stat().st_size),
        (budget, "CELLS", other, needed),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(module, limit, size)
            assert len(logs.read_table(file).columns) == 2
            patch.setattr(module, limit, size - 1)
            with pytest.raises(LogError, match=r"GiB|more than"):
                logs.read_table(file)
    row: dict[str, float] = {}
    rosbag._flatten("x", np.zeros(rosbag.LONGEST_LIST), row)
    assert len(row) == rosbag.LONGEST_LIST
    with pytest.raises(LogError, match="numbers"):
        rosbag._flatten("x", np.zeros(rosbag.LONGEST_LIST + 1), row)
