"""Signals that Simulink streamed to a v7.3 file are read from its records. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs.readers.mat_layout import choose
from erclutch.logs.readers.mat_streams import signal_of_a_stream
from erclutch.logs.readers.mat_tree import load_v73
from erclutch.signals.array import Array
from tests.logs.test_mat_objects import COUNT, CURRENT, SPEED, TIME, TORQUE, check, log_in
from tests.support.mat_objects import MatObject, save_v73

pytestmark = pytest.mark.slow

GRID = np.array([0.0, 0.01, float(COUNT)])
NONE = np.zeros((0, 0))


def element(
    name: str,
    record: int,
    unit: str = "",
    kind: str = "double",
    sides: tuple[float, ...] = (1.0,),
    time: Array = GRID,
    record_of_time: Array = NONE,
    unit_of_time: str = "seconds",
) -> dict[str, Any]:
    return {
        "Name": name,
        "BlockPath": MatObject("Simulink.SimulationData.BlockPath", {"path": [f"bench/{name}"]}),
        "Values": {
            "ElementType": "timeseries",
            "CompressedTime": time,
            "TimeR2": record_of_time,
            "DataR2": np.array([float(record)]),
            "DataUnits": {"Class": "char", "Value": unit},
            "TimeUnits": {"Class": "char", "Value": unit_of_time},
            "SignalAttributes": {"ClassName": kind, "Dimension": np.array(sides)},
        },
    }


def streamed(path: Path, elements: list[dict[str, Any]], records: list[Array]) -> Path:
    storage = MatObject(
        "Simulink.SimulationData.Storage.MatFileDatasetStorage", {"Elements": elements}
    )
    data = MatObject("Simulink.SimulationData.Dataset", {"Name": "log", "Storage": storage})
    save_v73(path, {"data": data})
    with h5py.File(path, "r+") as file:
        for number, numbers in enumerate(records):
            raw = np.frombuffer(numbers.tobytes(), np.uint8)
            file[f"#sigstream#/{number}/#data#"] = raw
            file[f"#sigstream#/{number}/#length#"] = np.array([numbers.shape[0]], np.uint64)
    return path


BENCH = [element("current", 2, "A"), element("speed", 0, "rad/s"), element("torque", 1, "N*m")]
RECORDS = [SPEED, TORQUE, CURRENT]


def test_signals_that_were_streamed_to_a_file_are_a_log(tmp_path: Path) -> None:
    check(streamed(tmp_path / "log.mat", BENCH, RECORDS))


def test_a_signal_of_four_bytes_and_a_time_of_its_own_are_read(tmp_path: Path) -> None:
    times = np.array([3.0])
    elements = [
        element("current", 2, "A", kind="single", record_of_time=times, time=NONE),
        element("speed", 0, "rad/s", record_of_time=times, time=NONE),
        element("torque", 1, "N*m", record_of_time=times, time=NONE),
    ]
    records = [SPEED, TORQUE, CURRENT.astype("<f4"), TIME + 5.0]
    check(streamed(tmp_path / "log.mat", elements, records), start=5.0)


def test_the_columns_of_a_vector_are_columns(tmp_path: Path) -> None:
    elements = [element("forces", 0, sides=(3.0,), time=np.array([0.0, 10.0, 400.0]))]
    elements[0]["Values"]["TimeUnits"]["Value"] = "milliseconds"
    together = np.column_stack([SPEED, TORQUE, CURRENT])
    log = log_in(streamed(tmp_path / "log.mat", elements, [together]))
    assert [*log.columns] == ["time_s", "forces_1", "forces_2", "forces_3"]
    assert np.array_equal(log.columns["forces_2"], TORQUE)
    assert np.allclose(log.columns["time_s"], TIME)


@pytest.mark.parametrize(
    "broken",
    [
        element("speed", 7),  # no such record
        element("speed", -1),
        element("speed", 0, kind="sfix16_En8"),
        element("speed", 0, kind="single"),  # twice as many numbers as times
        element("speed", 0, sides=(7.0,)),
        element("speed", 0, time=np.array([0.0, 0.01, 399.0])),
        element("speed", 0, time=np.array([0.0, 0.0, 400.0])),
        element("speed", 0, time=NONE),
    ],
)
def test_samples_that_are_not_where_they_are_said_to_be_are_no_columns(
    tmp_path: Path, broken: dict[str, Any]
) -> None:
    path = streamed(tmp_path / "log.mat", [broken, BENCH[2]], RECORDS)
    assert [*log_in(path).columns] == [
        "time_s",
        "torque",
    ]  # and what Simulink keeps is none of them


def test_a_file_of_one_signal_that_cannot_be_read_holds_no_log(tmp_path: Path) -> None:
    path = streamed(tmp_path / "log.mat", [element("speed", 7)], RECORDS)
    with pytest.raises(LogError, match="no recording"):
        choose(load_v73(str(path)), None)


def test_a_record_in_another_file_is_not_followed(tmp_path: Path) -> None:
    path = streamed(tmp_path / "log.mat", BENCH, RECORDS)
    other = streamed(tmp_path / "other.mat", BENCH, RECORDS)
    with h5py.File(path, "r+") as file:
        streams: Any = file["#sigstream#"]
        del streams["0"]
        streams["0"] = h5py.ExternalLink(str(other), "/#sigstream#/0")
    assert "speed" not in log_in(path).columns


def test_without_records_there_is_no_signal() -> None:
    with pytest.raises(ValueError, match="no record"):
        signal_of_a_stream(BENCH[0]["Values"], lambda number: None)
