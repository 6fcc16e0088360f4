"""The made-up log is always the same one, and is what its description says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read_table
from erclutch.logs.synthetic import synthetic_log, write_synthetic_log


def test_a_seed_gives_the_same_log_for_ever() -> None:
    """Figures of README and docs rest on it."""
    columns = synthetic_log(2.0, 3)
    assert [(name, unit) for name, (unit, _) in columns.items()] == [
        ("time", "s"), ("field", "V"), ("slip", "rad/s"), ("torque", "N*m"),
    ]  # fmt: skip
    waves = np.cos(np.arange(2000.0))
    found = [(float(values @ waves), float(np.abs(values).max())) for _, values in columns.values()]
    expected = [(2.0683980961026736, 1.999), (-979.2088262620143, 1862.9277094827091),
                (-6.819653591041854, 60.61299557563919), (-0.07316864892776104, 0.7002)]  # fmt: skip
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_what_is_written_is_read_and_says_that_it_is_made_up(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    write_synthetic_log(path, 0.2, 5)
    table = read_table(path)
    assert table.origin == "SYNTHETIC"
    for name, (unit, values) in synthetic_log(0.2, 5).items():
        np.testing.assert_allclose(table.columns[name], values, rtol=1e-5)
        assert table.units[name] == unit


@pytest.mark.parametrize("seconds", [0.05, 1.0])
def test_steps_of_the_field_and_their_lengths(seconds: float) -> None:
    field = synthetic_log(20 * seconds, 7)["field"][1]
    edges = np.flatnonzero(np.diff(field))
    assert edges.size == 0 or np.all(np.diff(edges) >= 10)
    assert np.all((field >= 0.0) & (field <= 2000.0))
