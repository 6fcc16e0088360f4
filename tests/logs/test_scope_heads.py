"""Files of oscilloscopes: names of channels in one line, and words for their units in the next."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read_table
from tests.support.command import good

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(80) / 100 - 0.4
CHANNELS = np.column_stack([np.sin(9 * TIME), 2 * np.cos(9 * TIME), np.where(TIME < 0, 0.0, 1.0)])
KEYSIGHT = "x-axis,1,2,3\nsecond,Volt,Volt,Ampere\n"
SIGLENT = (
    "Record Length,Analog:80\nSample Interval,Analog:0.01\nVertical Units,CH1:V,CH2:V,CH3:A\n"
    "Vertical Scale,CH1:1.0,CH2:1.0,CH3:0.5\nHorizontal Units,s\nModel Number,X1\n"
    "Source,CH1,CH2,CH3\nSecond,Volt,Volt,Ampere\n"
)


def written(path: Path, head: str) -> Path:
    rows = np.column_stack([TIME, CHANNELS]).tolist()
    path.write_text(head + "\n".join(",".join(f"{v:+.6E}" for v in row) for row in rows) + "\n")
    return path


@pytest.mark.parametrize(
    "head", [KEYSIGHT, SIGLENT, KEYSIGHT.replace("x-axis,1,2,3", "Source,CH1,CH2,CH3")]
)
def test_channels_keep_their_names_and_units(tmp_path: Path, head: str) -> None:
    """They were called Volt, Volt (2), Volt (3), some with a unit of ``CH1:V``."""
    table = read_table(written(tmp_path / "scope.csv", head))
    assert [*table.columns] == ["Time", "CH1", "CH2", "CH3"]
    assert [*table.units.values()] == ["s", "V", "V", "A"]
    assert table.columns["Time"] == pytest.approx(TIME)
    assert table.columns["CH2"] == pytest.approx(CHANNELS[:, 1], abs=1e-5)


@pytest.mark.slow
def test_labels_name_the_channels(tmp_path: Path) -> None:
    head = "Model,X2\nLabel,slip,torque,coil\nSource,CH1,CH2,CH3\nSecond,Volt,Volt,Ampere\n"
    written(tmp_path / "scope.csv", head)
    last = good("inspect", "scope.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert '--slip "slip" --scale "slip=NUMBER rad/s/V"' in last
    assert '--effort "torque" --scale "effort=NUMBER N*m/V"' in last
