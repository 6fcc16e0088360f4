"""What Simulink leaves in a workspace is understood: ``tout`` is the time, ``yout`` is asked about by its numbers."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

from tests.support.command import good

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(400) / 100
SPEED = 10 * np.sin(4 * TIME)
LEVELS = np.where(TIME < 2, 0.0, 1.5)
TORQUE = (0.2 + LEVELS) * np.tanh(SPEED / 0.3)
BESIDE = np.column_stack([SPEED, TORQUE, LEVELS])


@pytest.mark.slow
@pytest.mark.parametrize(
    "variables",
    [
        {"tout": TIME[:, None], "yout": BESIDE},
        {"simout": {"time": TIME[:, None], "signals": {"values": BESIDE, "label": ""}}},
        {"out": {"tout": TIME[:, None], "yout": BESIDE}},
    ],
    ids=["tout and yout", "a struct with time", "one output"],
)
def test_columns_of_an_output_without_names_are_asked_about_in_one_command(
    tmp_path: Path, variables: dict[str, Any]
) -> None:
    savemat(tmp_path / "log.mat", variables)
    last = good("inspect", "log.mat", cwd=tmp_path, code=1).splitlines()[-1]
    words = shlex.split(last.removeprefix("What settles it: erclutch "))
    columns = [word.rpartition("_")[2] for word in words[3::2]]
    assert [*zip(words[2::2], columns, strict=True)] == [
        ("--field", "3"),
        ("--slip", "1"),
        ("--effort", "2"),
    ]
    said = good(*words, cwd=tmp_path)
    assert "Understood." in said
    assert "at 100 Hz" in said


@pytest.mark.slow
def test_a_signal_of_a_simulink_output_keeps_its_label(tmp_path: Path) -> None:
    signals = np.array(
        [(SPEED[:, None], "omega"), (TORQUE[:, None], "T_brake"), (LEVELS[:, None], "I_coil")],
        dtype=[("values", "O"), ("label", "O")],
    )
    savemat(tmp_path / "log.mat", {"ScopeData": {"time": TIME[:, None], "signals": signals}})
    said = good("inspect", "log.mat", cwd=tmp_path)
    assert "slip <- column omega" in said
    assert "effort <- column T_brake" in said
