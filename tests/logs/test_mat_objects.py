"""Tables, timeseries and what Simulink logs, saved as objects in a MATLAB file, are read as they stand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, Table, apply, plan_of, recordings_in
from erclutch.logs.readers import mat_layout, mat_tree
from erclutch.logs.readers.budget import Budget
from erclutch.logs.readers.mat import version
from erclutch.logs.readers.mat_objects import Objects
from tests.support.examples import examples
from tests.support.mat_objects import MatObject, Subsystem, save_v5, save_v73

COUNT = 400
TIME = 0.01 * np.arange(COUNT)
CURRENT = np.repeat([0.0, 0.5, 1.0, 1.5], COUNT // 4)
SPEED = 40.0 * np.sin(9.0 * TIME)  # [rad/s]
TORQUE = (0.1 + 2.0 * CURRENT) * np.tanh(SPEED) + 0.01 * SPEED  # [N m]

Save = Callable[[Path, dict[str, Any]], Path]
versions = pytest.mark.parametrize("save", [save_v5, save_v73])


def duration(seconds: np.ndarray) -> MatObject:
    return MatObject("duration", {"millis": 1000.0 * seconds, "fmt": "s"})


def table(columns: dict[str, Any], units: list[str]) -> MatObject:
    properties = {
        "data": [*columns.values()],
        "ndims": np.array([2.0]),
        "nrows": np.array([float(COUNT)]),
        "rownames": np.zeros((0, 0)),
        "nvars": np.array([float(len(columns))]),
        "varnames": [*columns],
        "props": {"versionSavedFrom": np.array([2.2]), "VariableUnits": units},
    }
    return MatObject("table", properties)


def timetable(columns: dict[str, Any], row_times: Any) -> MatObject:
    held = {
        "data": [*columns.values()],
        "varNames": [*columns],
        "varUnits": ["A", "rad/s", "N*m"],
        "numRows": np.array([float(COUNT)]),
        "rowTimes": row_times,
        "versionSavedFrom": np.array([4.0]),
    }
    return MatObject("timetable", {"any": held}, made=True)


def timeseries(
    name: str, values: np.ndarray, unit: str, time: np.ndarray | None, time_unit: str = "seconds"
) -> MatObject:
    info: dict[str, Any] = {"Units": time_unit, "Length": np.array([float(values.size)])}
    if time is None:
        info |= {
            "Time_": np.zeros((0, 0)),
            "Increment_": np.array([0.01]),
            "Start_": np.array([0.0]),
        }
    else:
        info |= {"Time_": time, "Increment_": np.zeros((0, 0)), "Start_": np.zeros((0, 0))}
    properties = {
        "Name": name,
        "DataInfo": MatObject("tsdata.datametadata", {"Units": unit}),
        "TimeInfo": MatObject("tsdata.timemetadata", info),
        "Data_": values,
        "IsTimeFirst_": np.array([1.0]),
    }
    return MatObject("timeseries", properties)


def dataset(*signals: tuple[str, MatObject]) -> MatObject:
    elements: list[Any] = []
    for name, values in signals:
        path = MatObject("Simulink.SimulationData.BlockPath", {"path": [f"bench/{name or 'Out'}"]})
        elements.append(
            MatObject(
                "Simulink.SimulationData.Signal",
                {"Name": name, "BlockPath": path, "Values": values},
            )
        )
    storage = MatObject(
        "Simulink.SimulationData.Storage.RamDatasetStorage",
        {"any": {"Elements": elements}},
        made=True,
    )
    return MatObject(
        "Simulink.SimulationData.Dataset", {"any": {"Name": "log", "Storage": storage}}, made=True
    )


def log_in(path: Path, variable: str | None = None) -> Table:
    """A log of the file, read in this process."""
    is_v5 = version(path.read_bytes()[:520]) == "5"
    tree = mat_tree.load_v5(str(path)) if is_v5 else mat_tree.load_v73(str(path))
    return mat_layout.choose(tree, variable).table()


def check(path: Path, variable: str | None = None, start: float = 0.0) -> None:
    """The file is understood at once, and its numbers are those of the bench."""
    log = log_in(path, variable)
    plan = plan_of(log, ColumnMap())
    assert not plan.questions, [question.short for question in plan.questions]
    assert not plan.doubts
    recording = apply(plan, log)
    assert recording.rows == COUNT
    assert np.allclose(recording.signals["field"], CURRENT)
    assert np.allclose(recording.signals["slip"], SPEED)
    assert np.allclose(recording.signals["effort"], TORQUE)
    assert np.allclose(recording.time, start + TIME)
    assert (recording.units["slip"], recording.units["effort"]) == ("rad/s", "N*m")


@versions
def test_a_table_is_read_with_the_units_of_its_variables(tmp_path: Path, save: Save) -> None:
    columns = {"Time": TIME, "Current": CURRENT, "Speed": SPEED, "Torque": TORQUE}
    log = table(columns, ["s", "A", "rad/s", "N*m"])
    check(save(tmp_path / "a.mat", {"log": log, "gain": np.array([2.0])}))


@versions
def test_durations_in_a_table_are_seconds(tmp_path: Path, save: Save) -> None:
    columns = {"Time": duration(TIME), "Current": CURRENT, "Speed": SPEED, "Torque": TORQUE}
    check(save(tmp_path / "a.mat", {"log": table(columns, ["", "A", "rad/s", "N*m"])}))


@pytest.mark.slow
@versions
def test_a_column_of_texts_in_a_table_is_left_out_with_a_word(tmp_path: Path, save: Save) -> None:
    columns = {
        "Time": TIME,
        "Current": CURRENT,
        "Speed": SPEED,
        "Torque": TORQUE,
        "Remark": ["ok"] * COUNT,
    }
    path = save(tmp_path / "a.mat", {"log": table(columns, ["s", "A", "rad/s", "N*m", ""])})
    check(path)
    assert any("Remark holds no vector of numbers: left out" in note for note in log_in(path).notes)


@versions
def test_a_timetable_is_read_by_its_row_times(tmp_path: Path, save: Save) -> None:
    columns = {"Current": CURRENT, "Speed": SPEED, "Torque": TORQUE}
    check(save(tmp_path / "a.mat", {"log": timetable(columns, duration(5.0 + TIME))}), start=5.0)


@pytest.mark.slow
@versions
def test_a_timetable_with_a_rate_or_a_step_has_even_times(tmp_path: Path, save: Save) -> None:
    columns = {"Current": CURRENT, "Speed": SPEED, "Torque": TORQUE}
    none = np.zeros((0, 0))
    start = duration(np.zeros(1))
    by_rate = {
        "origin": start,
        "specifiedAsRate": np.ones(1),
        "stepSize": none,
        "sampleRate": np.array([100.0]),
    }
    check(save(tmp_path / "a.mat", {"log": timetable(columns, by_rate)}))
    step = duration(np.array([0.01]))
    by_step = {
        "origin": start,
        "specifiedAsRate": np.zeros(1),
        "stepSize": step,
        "sampleRate": none,
    }
    check(save(tmp_path / "b.mat", {"log": timetable(columns, by_step)}))


@pytest.mark.slow
@versions
@pytest.mark.parametrize("stored", [True, False])
def test_timeseries_beside_each_other_are_one_recording(
    tmp_path: Path, save: Save, stored: bool
) -> None:
    time = TIME if stored else None
    signals = {
        "i": timeseries("Current", CURRENT, "A", time),
        "w": timeseries("Speed", SPEED, "rad/s", time),
        "m": timeseries("Torque", TORQUE, "N*m", time),
    }
    check(save(tmp_path / "a.mat", signals))
    check(save(tmp_path / "b.mat", {"run": signals}))


@pytest.mark.slow
@versions
def test_times_in_another_unit_are_turned_into_seconds(tmp_path: Path, save: Save) -> None:
    signals = [
        ("Current", timeseries("", CURRENT, "A", 1000.0 * TIME, "milliseconds")),
        ("Speed", timeseries("", SPEED, "rad/s", 1000.0 * TIME, "milliseconds")),
        ("Torque", timeseries("", TORQUE, "N*m", 1000.0 * TIME, "milliseconds")),
    ]
    check(save(tmp_path / "a.mat", {"log": dataset(*signals)}))


@pytest.mark.slow
@versions
def test_logged_signals_of_simulink_are_called_as_the_user_called_them(
    tmp_path: Path, save: Save
) -> None:
    along_the_last_side = TORQUE.reshape(1, 1, COUNT)
    logsout = dataset(
        ("Current", timeseries("", CURRENT, "A", None)),
        ("Speed", timeseries("<w>", SPEED, "rad/s", None)),
        ("", timeseries("Torque", along_the_last_side, "N*m", None)),
    )
    check(save(tmp_path / "a.mat", {"data": logsout}))
    out = MatObject("Simulink.SimulationOutput", {"Data": {"tout": TIME, "logsout": logsout}})
    check(save(tmp_path / "b.mat", {"out": out}))


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@versions
def test_signals_of_two_rates_are_recordings_that_can_be_joined(tmp_path: Path, save: Save) -> None:
    slow = TIME[::4]
    log = dataset(
        ("Current", timeseries("", CURRENT, "A", None)),
        ("Speed", timeseries("", SPEED, "rad/s", None)),
        ("Torque", timeseries("", TORQUE[::4], "N*m", slow)),
    )
    path = save(tmp_path / "a.mat", {"log": log})
    assert recordings_in(path) == ["log.Current", "log.Speed", "log.Torque"]
    joined = log_in(path, "log.Current + log.Speed + log.Torque")
    assert np.allclose(joined.columns["Torque"][::4], TORQUE[::4])


@versions
def test_objects_of_other_classes_are_named_where_nothing_else_is_there(
    tmp_path: Path, save: Save
) -> None:
    path = save(
        tmp_path / "a.mat", {"foot": MatObject("polyshape", {"Vertices": np.zeros((4, 2))})}
    )
    with pytest.raises(
        LogError, match=r"foot \(a polyshape\).*objects of these classes cannot be read"
    ):
        log_in(path)


@versions
def test_an_object_beside_vectors_does_not_keep_them_from_being_read(
    tmp_path: Path, save: Save
) -> None:
    vectors = {"time": TIME, "current_A": CURRENT, "speed_rad_s": SPEED, "torque_Nm": TORQUE}
    check(
        save(
            tmp_path / "a.mat",
            {"foot": MatObject("polyshape", {"Vertices": np.zeros((4, 2))}), **vectors},
        )
    )


@pytest.mark.usefixtures("read_here")
def test_two_objects_of_v5_have_names_of_their_own(tmp_path: Path) -> None:
    one = table(
        {"Time": TIME, "Current": CURRENT, "Speed": SPEED, "Torque": TORQUE},
        ["s", "A", "rad/s", "N*m"],
    )
    two = table(
        {"Time": TIME, "Current": CURRENT, "Speed": -SPEED, "Torque": -TORQUE},
        ["s", "A", "rad/s", "N*m"],
    )
    path = save_v5(tmp_path / "a.mat", {"up": one, "down": two}, packed=False)
    assert recordings_in(path) == ["up", "down"]
    check(path, variable="up")


def test_an_object_that_holds_itself_is_none() -> None:
    subsystem = Subsystem()
    reference = subsystem.reference(MatObject("Simulink.SimulationOutput", {"Data": np.zeros(2)}))
    subsystem.values[0] = reference
    assert Objects(subsystem.cells(), Budget(1000)).resolved(reference) is None


@pytest.mark.slow
@settings(max_examples=examples(300), deadline=None)
@given(st.data())
def test_a_damaged_subsystem_gives_no_object_and_no_traceback(data: st.DataObject) -> None:
    subsystem = Subsystem()
    log = table({"Time": TIME, "Torque": TORQUE}, ["s", "N*m"])
    reference = subsystem.reference(log)
    cells = subsystem.cells()
    head = cells[0].copy()
    for place in data.draw(st.lists(st.integers(0, head.size - 1), min_size=1, max_size=6)):
        head[place, 0] = data.draw(st.integers(0, 255))
    try:
        objects = Objects([head, *cells[1:]], Budget(1000))
    except (ValueError, IndexError):
        return
    found = objects.resolved(reference)
    assert found is None or isinstance(found, dict | list | str | np.ndarray)
