"""An effort that was told, computed or modelled is never fitted as measured, and ``act`` is asked about."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.support.command import good, refused
from tests.support.slow_params import slow_behind

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(600) / 200
FIELD = np.repeat([0.0, 0.5, 1.0, 0.25, 0.75, 0.0], 100)
SPEED = 5 * np.sin(6 * TIME)
TORQUE = (0.3 + 1.7 * FIELD) * np.tanh(4 * SPEED) + 0.02 * SPEED


def log_with(folder: Path, **columns: np.ndarray) -> Path:
    """A log of a brake, SYNTHETIC, with the columns besides time and current."""
    every = {"time": TIME, "current": FIELD, **columns}
    rows = np.column_stack(list(every.values()))
    np.savetxt(
        folder / "log.csv", rows, delimiter=",", fmt="%.6g", header=",".join(every), comments=""
    )
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    slow_behind(
        3,
        [
            "Sollmoment",
            "requested_torque_Nm",
            "torque_ff",
            "boucwen_force",
            "F_pred",
            "tau_hat",
            "model_torque",
            "couple_consigne",
        ],
    ),
)
def test_an_effort_that_nobody_measured_is_neither_taken_nor_offered(
    tmp_path: Path, name: str
) -> None:
    log_with(tmp_path, speed=SPEED, **{name: TORQUE})
    said = good("inspect", "log.csv", cwd=tmp_path, code=1)
    assert f"column {name} was not measured" in said.replace("\n", " ")
    assert said.splitlines()[-1].endswith('--effort "COLUMN [N]"')
    assert "was not measured" in refused("fit", "log.csv", cwd=tmp_path)
    good("inspect", "log.csv", "--effort", name, cwd=tmp_path)  # who says so is believed


@pytest.mark.slow
def test_measured_and_told_values_of_german_drives_are_told_apart(tmp_path: Path) -> None:
    log_with(
        tmp_path,
        Solldrehzahl=1.1 * SPEED,
        Istdrehzahl=SPEED,
        Drehmomentsollwert=1.2 * TORQUE,
        Istmoment=TORQUE,
    )
    said = good("inspect", "log.csv", cwd=tmp_path)
    assert "slip <- column Istdrehzahl" in said
    assert "effort <- column Istmoment" in said


@pytest.mark.slow
def test_act_beside_another_effort_is_asked_about_and_beside_a_told_one_is_not(
    tmp_path: Path,
) -> None:
    log_with(tmp_path, speed=SPEED, act_force=TORQUE, load_force=0.4 * TORQUE)
    said = good("inspect", "log.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert "act may mean actual or actuator, beside load_force" in said
    assert said.endswith('erclutch inspect log.csv --effort "act_force"')
    good("inspect", "log.csv", "--effort", "act_force", cwd=tmp_path)
    log_with(tmp_path, speed=SPEED, force_act=TORQUE, force_cmd=1.3 * TORQUE, force=0.9 * TORQUE)
    assert "effort <- column force_act" in good("inspect", "log.csv", cwd=tmp_path)
