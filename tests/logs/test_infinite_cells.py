"""A log may hold infinities in any column, and numbers whose squares no float holds: it is planned without a warning.

Warnings are errors in these tests, so a warning of NumPy ends them.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import ErclutchError
from erclutch.logs import ColumnMap, apply, plan_of, table_of_log

NAMES = ("time [s]", "current [A]", "position [mm]", "velocity [mm/s]", "force [N]", "ch1")
PLACES = {
    "a cell": lambda rng, rows: rng.integers(rows, size=1),
    "many cells": lambda rng, rows: rng.integers(rows, size=max(1, rows // 5)),
    "all cells": lambda rng, rows: np.arange(rows),
}


def write(path: Path, names: tuple[str, ...], spoilt: str, number: float, place: str) -> None:
    """A log of a swing, of which a column has a number in some cells."""
    rng = np.random.default_rng(5)
    rows = 60
    time = np.arange(rows) / 1000.0
    columns = {
        "time [s]": time,
        "current [A]": np.repeat([0.0, 1.0, 2.0], 20),
        "position [mm]": np.sin(50.0 * time),
        "velocity [mm/s]": 50.0 * np.cos(50.0 * time),
        "force [N]": 30.0 * np.sign(np.cos(50.0 * time)) + rng.normal(size=rows),
        "ch1": rng.normal(size=rows),
        "q1": np.sin(50.0 * time),
        "dq1": 50.0 * np.cos(50.0 * time),
        "tau1": rng.normal(size=rows),
        "i1": rng.normal(size=rows),
    }
    values = columns[spoilt].copy()
    values[PLACES[place](rng, rows)] = number
    columns[spoilt] = values
    table = np.column_stack([columns[name] for name in names])
    np.savetxt(path, table, fmt="%.9g", delimiter=",", header=",".join(names), comments="")


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("number", [np.inf, -np.inf, 1e308])
@pytest.mark.parametrize("spoilt", NAMES)
def test_a_log_with_infinities_is_planned(
    spoilt: str, number: float, place: str, tmp_path: Path
) -> None:
    path = tmp_path / "log.csv"
    write(path, NAMES, spoilt, number, place)
    with suppress(ErclutchError):
        table = table_of_log(path, ColumnMap(), None)
        plan = plan_of(table, ColumnMap())
        if not plan.questions:
            apply(plan, table)


@pytest.mark.parametrize("number", [np.inf, 1e308])
@pytest.mark.parametrize("spoilt", ["q1", "dq1", "tau1", "i1"])
def test_a_log_without_a_clock_and_with_infinities_is_asked_about(
    spoilt: str, number: float, tmp_path: Path
) -> None:
    # Positions and speeds tell the rate of a log without a clock: theirs may be infinite.
    path = tmp_path / "log.csv"
    write(path, ("q1", "dq1", "tau1", "i1"), spoilt, number, "a cell")
    plan = plan_of(table_of_log(path, ColumnMap(), None), ColumnMap())
    assert plan.questions


def test_a_joint_of_one_row_is_asked_about(tmp_path: Path) -> None:
    # The current of a drive follows the rate of its position: one row has none, and ended in a traceback.
    path = tmp_path / "log.csv"
    path.write_text(
        "temp [C],i_q,current [A],Target Position,theta [rad]\n0,1,3,-2.5,1\n", encoding="utf-8"
    )
    assert plan_of(table_of_log(path, ColumnMap(), None), ColumnMap()).questions
