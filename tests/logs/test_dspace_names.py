"""Recordings of dSPACE whose paths hold units, or whose signals have numbers alone, keep their names and their time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from erclutch.logs import read_table

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(50) / 100
SIGNALS = (np.sin(TIME), np.cos(TIME), np.tanh(TIME))


def recorded(path: Path, names: tuple[str, ...] | None) -> list[str]:
    fields = [("Name", "O"), ("Data", "O")] if names else [("Data", "O")]
    rows = [values[None, :] for values in SIGNALS]
    signals = [*zip(names, rows, strict=True)] if names else [(row,) for row in rows]
    savemat(path, {"rec": {"X": {"Data": TIME[None, :]}, "Y": np.array(signals, dtype=fields)}})
    table = read_table(path)
    assert table.columns["time"] == pytest.approx(TIME)
    return [name for name in table.columns if name != "time"]


@pytest.mark.parametrize("quote", ["'", '"', ""])
def test_a_slash_of_a_unit_parts_no_path(tmp_path: Path, quote: str) -> None:
    """The slip was called ``s]'``."""
    names = ("Model Root/slip [rad/s]", "Model Root/coil_current", "Model Root/torque")
    if quote == '"':
        names = ('"Model Root"/"slip [rad/s]"', '"Model Root"/"coil_current"', '"torque"')
    found = recorded(
        tmp_path / "rec.mat",
        tuple(f"{quote}{name}{quote}" for name in names) if quote != '"' else names,
    )
    assert found == ["slip", "coil_current", "torque"]


def test_signals_without_names_keep_their_time(tmp_path: Path) -> None:
    assert recorded(tmp_path / "rec.mat", None) == ["Y_1", "Y_2", "Y_3"]
