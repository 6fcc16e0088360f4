"""Sentences about a log without units leave no gap where the unit would stand."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.support.command import good


@pytest.mark.slow
def test_no_gap_before_a_comma_or_a_stop(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    time = 0.005 * np.arange(3000) + 1.7e9  # a clock that counts from 1970
    slip = np.sin(1.7 * time) + 0.5 * np.sin(4.1 * time)
    force = 5.0 * np.tanh(3.0 * slip) + 2.0 * slip + 0.1 * rng.standard_normal(time.size)
    log = tmp_path / "log.csv"
    columns = np.column_stack([time, slip, force])
    np.savetxt(log, columns, delimiter=",", header="time,velocity,force", comments="", fmt="%.6f")
    out = good(
        "fit",
        log,
        "--field",
        "none",
        "--models",
        "bingham,fnn-4",
        "--lag",
        "none",
        "--out",
        tmp_path / "run",
    )
    sentences = [line for line in out.splitlines() if not line.startswith(" ")]
    assert "mean width" in out
    assert not [line for line in sentences if re.search(r"\d [.,;]|\?", line)]
    assert re.search(
        r"in the second from \d+\.\d s after the log's start on", " ".join(out.split())
    )
