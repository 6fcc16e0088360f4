"""A flow curve's file may hold infinities, and numbers whose squares no float holds: no warning of NumPy is printed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.cli import main

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("number", [np.inf, 1e308])
@pytest.mark.parametrize("spoilt", ["Shear rate [1/s]", "Shear stress [Pa]", "ch1"])
def test_inspect_and_flowcurve_say_nothing_of_numpy(
    spoilt: str, number: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rates = np.geomspace(0.1, 100.0, 60)
    noise = np.random.default_rng(5).normal(size=60)
    columns = {"Shear rate [1/s]": rates, "Shear stress [Pa]": 10.0 + rates, "ch1": noise}
    columns[spoilt][::5] = number
    path = tmp_path / "log.csv"
    table = np.column_stack([*columns.values()])
    np.savetxt(path, table, fmt="%.9g", delimiter=",", header=",".join(columns), comments="")
    for command in ("inspect", "flowcurve"):
        assert main([command, str(path)]) in (0, 1, 2)
    said = "".join(capsys.readouterr())
    assert "Warning" not in said
    assert "Traceback" not in said
