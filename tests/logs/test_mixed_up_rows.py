"""Rows that were mixed up for a network are sorted by their time, and rows twice are taken once. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from erclutch.errors import MappingError
from erclutch.logs import read
from erclutch.logs.clock.mixed_rows import are_mixed_up
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording

ROWS = 400
TIME = np.arange(ROWS) / 100
CURRENT = np.repeat([0.0, 0.5, 1.0, 0.25], 100)
VELOCITY = 0.3 * np.sin(10.7 * TIME)
FORCE = (80 + 420 * CURRENT) * np.tanh(VELOCITY / 0.02) + 900 * VELOCITY


def read_rows(folder: Path, rows: NDArray[np.intp], time: Array = TIME) -> Recording:
    table = np.column_stack([time, CURRENT, VELOCITY, FORCE])[rows]
    path = folder / "log.csv"
    np.savetxt(path, table, "%.8g", ",", header="time,current,velocity,force", comments="")
    return read(path)


def mixed(rows: int = ROWS) -> NDArray[np.intp]:
    return np.random.default_rng(3).permutation(ROWS)[:rows]


@pytest.mark.slow
def test_rows_that_were_mixed_up_are_sorted_and_that_is_said(tmp_path: Path) -> None:
    log = read_rows(tmp_path, mixed())
    assert log.segments == ((0, ROWS),)
    assert log.signals["effort"] == pytest.approx(FORCE, rel=1e-6)
    assert any("sorted by column time" in note for note in log.notes)


def test_a_random_part_of_the_rows_is_sorted_too(tmp_path: Path) -> None:
    # The other rows are those that the network was tested by.
    kept = mixed(320)
    log = read_rows(tmp_path, kept)
    assert log.rows == 320
    assert log.time - log.time[0] == pytest.approx(TIME[np.sort(kept)], abs=1e-9)
    assert log.signals["slip"] == pytest.approx(VELOCITY[np.sort(kept)], abs=1e-7)


def test_the_times_of_points_are_no_steady_clock(tmp_path: Path) -> None:
    time = np.cumsum(np.random.default_rng(5).uniform(0.005, 0.02, ROWS))
    with pytest.raises(MappingError, match="runs backwards"):
        read_rows(tmp_path, mixed(), time)


def test_a_steady_clock_in_order_or_that_begins_anew_is_not_mixed_up() -> None:
    assert not are_mixed_up(TIME)
    assert not are_mixed_up(TIME[::-1])
    assert not are_mixed_up(np.tile(TIME[:100], 4))
    assert are_mixed_up(TIME[mixed()])


def test_rows_that_are_all_there_twice_are_taken_once(tmp_path: Path) -> None:
    # They were put on a grid of half the step, as if the clock were coarse.
    log = read_rows(tmp_path, np.repeat(np.arange(ROWS), 2))
    assert log.rows == ROWS
    assert log.period == pytest.approx(0.01)
    assert any("400 rows that repeat the row before were dropped" in note for note in log.notes)
