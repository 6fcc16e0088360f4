"""Trials beside each other in arrays of MATLAB and NumPy are logs of their own, at fields of their own. SYNTHETIC."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from erclutch.errors import LogError
from erclutch.logs import read, read_table, recordings_in
from erclutch.logs.readers.trials import trials_in
from erclutch.signals.array import Array
from tests.support.slow_params import slow_but

pytestmark = pytest.mark.usefixtures("read_here")  # no child process for each file

TIME: Array = 0.002 * np.arange(200, dtype=np.float64)
SPEED = 0.1 * np.cos(17.0 * TIME)
LEVELS = np.array([0.0, 0.5, 1.0])
NAMES = ["time", "velocity", "force", "current"]


def force(level: float) -> Array:
    return (40.0 + 600.0 * level) * np.tanh(SPEED / 0.01)


PAGES = np.stack(
    [np.column_stack([TIME, SPEED, force(i), np.full(TIME.size, i)]) for i in LEVELS], axis=2
)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (2, 1, 0), (1, 0, 2)])
def test_pages_of_an_array_are_trials_whatever_stands_first(
    tmp_path: Path, order: tuple[int, int, int]
) -> None:
    path = tmp_path / "log.npz"
    np.savez(path, data=np.transpose(PAGES, order), names=np.array(NAMES))
    assert recordings_in(path) == ["data(1)", "data(2)", "data(3)"]
    recording = read(path, variable="data(3)")
    np.testing.assert_allclose(recording.signals["effort"], force(1.0))
    np.testing.assert_allclose(recording.signals["field"], 1.0)


def test_pages_of_matlab_have_the_names_and_units_of_cells(tmp_path: Path) -> None:
    cells = {
        "labels": np.array(NAMES, dtype=object),
        "units": np.array(["s", "m/s", "N", "A"], dtype=object),
    }
    savemat(tmp_path / "log.mat", {"data": PAGES, **cells})
    recording = read(tmp_path / "log.mat", variable="data(2)")
    assert recording.units == {"field": "A", "slip": "m/s", "effort": "N"}
    np.testing.assert_allclose(recording.signals["effort"], force(0.5))


def stack(fields: tuple[float, ...]) -> np.ndarray[Any, Any]:
    """Runs by rows by time, current, speed and torque, SYNTHETIC."""
    time = np.arange(400) / 100
    speed = 3 * np.sin(3 * time)
    runs = [
        np.column_stack([time, np.full(400, field), speed, (0.1 + field) * np.tanh(5 * speed)])
        for field in fields
    ]
    return np.stack(runs)


@pytest.mark.slow
@pytest.mark.parametrize("order", [(0, 1, 2), (0, 2, 1), (1, 2, 0)])
@pytest.mark.parametrize("kind", ["npz", "h5", "h5 with attributes"])
@pytest.mark.parametrize("fields", slow_but([(0.0, 0.5)], [(0.0, 0.3, 0.6, 0.9), (0.0, 0.5)]))
def test_runs_by_rows_by_signals_are_told_by_names_and_by_the_time(
    tmp_path: Path, order: tuple[int, int, int], kind: str, fields: tuple[float, ...]
) -> None:
    array = np.transpose(stack(fields), order)
    names = ["time", "current", "speed", "torque"]
    path = tmp_path / f"runs.{kind[:3].strip()}"
    if kind == "npz":
        np.savez(path, data=array, columns=np.array(names))
    else:
        with h5py.File(path, "w") as file:
            file["data"] = array
            of_names = np.array(names, dtype="S")
            if kind == "h5":
                file["names"] = of_names
            else:
                file["data"].attrs["columns"] = of_names
    logs = [read(path, variable=f"data({number + 1})") for number in range(len(fields))]
    assert [set(log.signals["field"]) for log in logs] == [{field} for field in fields]
    np.testing.assert_allclose(logs[1].signals["effort"], stack(fields)[1][:, 3])


@pytest.mark.parametrize("kind", ["npz", "h5"])
def test_an_array_of_three_sides_without_names_is_named_in_the_error(
    tmp_path: Path, kind: str
) -> None:
    path = tmp_path / f"runs.{kind}"
    if kind == "npz":
        np.savez(path, data=stack((0.0, 0.5)))
    else:
        with h5py.File(path, "w") as file:
            file["data"] = stack((0.0, 0.5))
    with pytest.raises(LogError, match="array data is 2 x 400 x 4, and no names beside it"):
        read_table(path)


def test_a_field_for_each_row_of_a_matrix_is_of_its_trial(tmp_path: Path) -> None:
    fields = (0.0, 0.3, 0.6)
    runs = stack(fields)
    np.savez(
        tmp_path / "runs.npz",
        time=runs[0, :, 0],
        current=np.array(fields),
        speed=runs[:, :, 2],
        torque=runs[:, :, 3],
    )
    assert set(read(tmp_path / "runs.npz", variable="trial(2)").signals["field"]) == {0.3}


@pytest.mark.slow
def test_the_field_of_a_run_stands_in_its_group_or_its_object(tmp_path: Path) -> None:
    fields = (0.0, 0.3, 0.6)
    objects: list[dict[str, Any]] = []
    with h5py.File(tmp_path / "runs.h5", "w") as file:
        for number, (field, run) in enumerate(zip(fields, stack(fields), strict=True), start=1):
            signals = dict(zip(("time", "speed", "torque"), run[:, [0, 2, 3]].T, strict=True))
            group = file.create_group(f"run{number}")
            group.attrs["current"] = field
            for name, values in signals.items():
                group[name] = values
            lists = {name: values.tolist() for name, values in signals.items()}
            objects.append({"current_A": field, **lists})
    (tmp_path / "runs.json").write_text(json.dumps({"runs": objects}))
    assert set(read(tmp_path / "runs.h5", variable="run2").signals["field"]) == {0.3}
    assert set(read(tmp_path / "runs.json", variable="runs.3").signals["field"]) == {0.6}


def test_days_of_one_length_in_one_json_are_recordings_of_their_own(tmp_path: Path) -> None:
    days = {}
    for day, run in zip(("2026-05-01", "2026-05-02"), stack((0.0, 0.5)), strict=True):
        names = ("time", "current", "speed", "torque")
        days[day] = {name: run[:, place].tolist() for place, name in enumerate(names)}
    (tmp_path / "days.json").write_text(json.dumps(days))
    log = read(tmp_path / "days.json", variable="2026-05-02")
    assert (log.rows, set(log.signals["field"])) == (400, {0.5})


def test_pages_without_names_are_refused(tmp_path: Path) -> None:
    savemat(tmp_path / "log.mat", {"data": PAGES})
    with pytest.raises(LogError, match="no recording in the variables data"):
        read_table(tmp_path / "log.mat")


@pytest.mark.parametrize("kind", ["mat", "npz"])
def test_columns_beside_a_field_with_a_number_for_each_are_trials(
    tmp_path: Path, kind: str
) -> None:
    columns: dict[str, Any] = {
        "time": TIME,
        "velocity": np.tile(SPEED[:, None], 3),
        "force": PAGES[:, 2, :],
        "current": LEVELS,
    }
    path = tmp_path / f"log.{kind}"
    if kind == "mat":
        savemat(path, columns)
    else:
        np.savez(path, **columns)
    recording = read(path, variable="trial(2)")
    np.testing.assert_allclose(recording.signals["field"], 0.5)
    np.testing.assert_allclose(recording.signals["effort"], force(0.5))


@pytest.mark.parametrize("beside", [{}, {"I": LEVELS}, {"mass": LEVELS}, {"Kp": LEVELS}])
def test_columns_of_joints_are_no_trials(beside: dict[str, Array]) -> None:
    joints = {"t": TIME, "dq": np.tile(SPEED[:, None], 3), "tau": PAGES[:, 2, :]}
    assert trials_in({**joints, **beside}, []) == {}


@pytest.mark.parametrize("lengths", [(300, 300, 300), (300, 250, 280)])
@pytest.mark.parametrize("named", [False, True])
def test_matrices_called_alike_with_a_time_each_are_logs(
    tmp_path: Path, lengths: tuple[int, ...], named: bool
) -> None:
    file: dict[str, Any] = {}
    for current, length in zip((0, 50, 100), lengths, strict=True):
        time = 0.01 * np.arange(length)
        speed = np.cos(5.0 * time)
        file[f"I{current:03d}"] = np.column_stack(
            [time, np.sin(5.0 * time) / 5.0, speed, 3.0 * speed]
        )
    if named:
        file["names"] = np.array(["time", "position", "velocity", "force"], dtype=object)
    path = tmp_path / "runs.mat"
    savemat(path, file)
    assert [*recordings_in(path)] == ["I000", "I050", "I100"]
    told: dict[str, Any] = {} if named else {"time": "c1 [s]", "slip": "c3", "effort": "c4"}
    log = read(path, variable="I050", field="none", **told)
    assert log.rows == lengths[1]
    np.testing.assert_allclose(log.signals["effort"], 3.0 * file["I050"][:, 2])


def test_matrices_without_a_time_or_of_other_names_stay_together(tmp_path: Path) -> None:
    course = np.cos(0.1 * np.arange(300))
    for names, first in ((("x1", "x2"), course), (("disp", "force"), np.arange(300.0))):
        savemat(
            tmp_path / "a.mat", {name: np.column_stack([first, course, course]) for name in names}
        )
        assert len(read_table(tmp_path / "a.mat").columns) == 6
