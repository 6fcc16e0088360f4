"""`erclutch inspect --json --courses` gives signals over time, for a page to draw."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import erclutch
from erclutch.logs.synthetic import write_synthetic_log
from tests.support.command import good, refused


@pytest.mark.slow
def test_a_course_holds_every_value_of_its_stretch(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    write_synthetic_log(log, 2)
    course = json.loads(good("inspect", log, "--json", "--courses", "40"))["over_time"]
    read = erclutch.read(log)
    assert len(course["time"]) == 40
    assert (course["time"][0], course["until"]) == (read.time[0], read.time[-1])
    for name, values in read.signals.items():
        ends = course["signals"][name]
        assert np.isclose(min(ends["low"]), values.min(), rtol=1e-4)
        assert np.isclose(max(ends["high"]), values.max(), rtol=1e-4)
        assert np.all(np.array(ends["low"]) <= np.array(ends["high"]))
    assert "over_time" not in json.loads(good("inspect", log, "--json"))
    assert "courses" in refused("inspect", log, "--json", "--courses", "-1", cwd=tmp_path)
