"""Times are those of the log: behind rows without a neighbour, and behind one odd step. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read
from tests.support.command import good


def written(path: Path, time: np.ndarray) -> Path:
    rows = np.arange(time.size)
    speed = 10.0 * np.sin(0.05 * rows)
    torque = np.tanh(speed) + 0.1
    lines = [f"{t:.6f},{w:.4f},1,{m:.4f}" for t, w, m in zip(time, speed, torque, strict=True)]
    text = "time [s],speed [rad/s],current [A],torque [N*m]\n" + "\n".join(lines) + "\n"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.slow
def test_segments_behind_lone_rows_have_their_own_times(tmp_path: Path) -> None:
    """The times of rows as many earlier as rows were left out stood there."""
    part = np.arange(500) / 100.0
    written(tmp_path / "lone.csv", np.concatenate(([0.0, 3.0], 10.0 + part, 16.0 + part)))
    out = good("inspect", "lone.csv", cwd=tmp_path)
    segments = out.split("Segments between gaps")[1].splitlines()
    rows = [line.split() for line in segments if line.split()[:2] in (["1", "500"], ["2", "500"])]
    assert [row[2:4] for row in rows] == [["10", "14.99"], ["16", "20.99"]]


@pytest.mark.parametrize("rows", [21, 101, 1001])
def test_one_odd_step_moves_no_other_stamp(tmp_path: Path, rows: int) -> None:
    """All stamps were put on a grid that stood half a step beside them, as if a busy logger had been late."""
    rng = np.random.default_rng(1)
    time = np.concatenate(([0.2369], 0.2388 + 3.5 * np.arange(rows - 1)))
    time[1:] += rng.normal(scale=5e-4, size=rows - 1)
    log = read(written(tmp_path / "odd.csv", time))
    np.testing.assert_allclose(log.time, time, atol=0.01)


def test_a_busy_logger_is_put_on_its_grid_as_before(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    grid = np.arange(2000) / 100.0
    log = read(written(tmp_path / "busy.csv", grid + rng.normal(scale=1e-3, size=grid.size)))
    assert log.uniform
    np.testing.assert_allclose(np.diff(log.time), log.period, rtol=1e-6)
