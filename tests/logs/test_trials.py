"""Trials beside each other in arrays of MATLAB and NumPy are logs of their own, at fields of their own. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

from erclutch.errors import LogError
from erclutch.logs import read, read_table, recordings_in
from erclutch.logs.readers.trials import trials_in
from erclutch.signals.array import Array

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
