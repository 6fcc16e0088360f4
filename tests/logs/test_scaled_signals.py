"""Columns that were scaled for a network have lost their zero, and the user is asked. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from erclutch.signals.array import Array
from tests.support.command import run

pytestmark = pytest.mark.slow

TIME = np.arange(400) / 100
CURRENT = np.repeat([0.0, 0.5, 1.0, 0.25], 100)
VELOCITY = 0.3 * np.sin(10.7 * TIME)
FORCE = (80 + 420 * CURRENT) * np.tanh(VELOCITY / 0.02) + 900 * VELOCITY


def to_one(values: Array) -> Array:
    return (values - values.min()) / np.ptp(values)


def about_zero(values: Array) -> Array:
    return 2 * to_one(values) - 1


def standardised(values: Array) -> Array:
    return (values - values.mean()) / values.std()


def last_line(folder: Path, names: str, *columns: Array) -> str:
    """What `inspect` says in the end of a log with these columns."""
    table = np.column_stack([TIME, *columns])
    np.savetxt(folder / "log.csv", table, "%.8g", ",", header=names, comments="")
    return inspected(folder)


def inspected(folder: Path, *options: str) -> str:
    return run("inspect", "log.csv", *options, cwd=folder).out.splitlines()[-1]


@pytest.mark.parametrize("scaled", [to_one, about_zero, standardised])
@pytest.mark.parametrize("names", ["time,current,velocity,force", "t [s],I [A],v [m/s],F [N]"])
def test_motion_and_effort_that_were_scaled_alike_are_asked_about(
    tmp_path: Path, scaled: Callable[[Array], Array], names: str
) -> None:
    said = last_line(tmp_path, names, scaled(CURRENT), scaled(VELOCITY), scaled(FORCE))
    assert said.startswith("In doubt: effort is column ")
    assert "where it is zero is lost" in said


def test_columns_that_are_called_scaled_are_asked_about(tmp_path: Path) -> None:
    names = "time,current,velocity_normalized,force_normalized"
    first = last_line(tmp_path, names, CURRENT, VELOCITY / 0.4, FORCE / 800)
    assert first.endswith('inspect log.csv --slip "velocity_normalized"')
    assert "which is called scaled" in inspected(tmp_path, "--slip", "velocity_normalized")


def test_one_column_of_such_numbers_is_chance(tmp_path: Path) -> None:
    names = "time [s],current [A],velocity [m/s],force [N]"
    assert "Understood." in last_line(tmp_path, names, CURRENT, to_one(VELOCITY), FORCE)
    assert "Understood." in last_line(tmp_path, names, CURRENT, VELOCITY, to_one(FORCE))


def test_whoever_names_the_effort_is_believed(tmp_path: Path) -> None:
    columns = map(standardised, (CURRENT, VELOCITY, FORCE))
    assert last_line(tmp_path, "time,current,velocity,force", *columns).endswith('--effort "force"')
    assert inspected(tmp_path, "--effort", "force").startswith("Understood.")
