"""A log with a row in half a minute: its lags are as slow, and its run is read again, reported and exported."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.runs.run_folder import read_run
from tests.support.command import good, refused

PERIOD, LAG = 26.0, 120.0  # s


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A press that pulls a friction to and fro within an hour, behind a load cell with a slow filter (SYNTHETIC)."""
    folder = tmp_path_factory.mktemp("bench")
    rng = np.random.default_rng(0)
    time = PERIOD * np.arange(400.0)
    speed = 1e-4 * np.sin(2.0 * np.pi * time / 2600.0) + 5e-5 * np.sin(2.0 * np.pi * time / 1410.0)
    wanted = 1000.0 * np.tanh(speed / 3e-5) + 5e6 * speed
    force = np.zeros(time.size)
    for row in range(1, time.size):
        share = -np.expm1(-PERIOD / LAG)
        force[row] = force[row - 1] + share * (wanted[row] - force[row - 1])
    rows = np.column_stack([time, speed, force + 3.0 * rng.standard_normal(time.size)])
    head = "time [s],speed [m/s],force [N]"
    np.savetxt(folder / "log.csv", rows, delimiter=",", header=head, comments="")
    good("fit", "log.csv", "--models", "bingham", "--lag", "effort-lag", "--out", "run", cwd=folder)
    return folder


@pytest.mark.slow
def test_the_lag_of_a_slow_log_is_found_and_its_report_is_written(bench: Path) -> None:
    run = read_run(bench / "run")
    assert run.model().numbers["tau_e"] == pytest.approx(LAG, rel=0.05)
    good("report", "run", "--out", "run.html", cwd=bench)
    assert (bench / "run.html").stat().st_size > 0


@pytest.mark.slow
def test_its_export_asks_for_the_period_of_a_loop(bench: Path) -> None:
    said = refused("export", "run", "--to", "c", "--out", "c", cwd=bench)
    assert "its log has a row in 26 s" in said
    assert "--period 10" in said
    good("export", "run", "--to", "c", "--out", "c", "--period", "10", cwd=bench)
