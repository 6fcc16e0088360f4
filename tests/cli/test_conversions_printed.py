"""What is done to a log on the way to its rows is printed by ``inspect`` and by ``fit`` alike."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.support.command import good

pytestmark = pytest.mark.usefixtures("read_here")
MADE = (
    "drawn out without jumps",
    "slip <- position by the savgol derivative",
)


def log_of_an_encoder(folder: Path) -> Path:
    time = np.arange(2000) / 100  # s
    speed = 4.0 + 3.0 * np.sin(2 * time)  # rad/s
    angle = np.cumsum(speed) / 100 % (2 * np.pi)
    current = np.where(time % 8 < 4, 0.0, 1.0)
    torque = (0.2 + 1.5 * current) * np.tanh(speed)
    path = folder / "log.csv"
    rows = np.column_stack([time, angle, current, torque])
    head = "t [s],angle [rad],current [A],torque [Nm]"
    np.savetxt(path, rows, header=head, comments="", delimiter=",", fmt="%.6f")
    return path


@pytest.mark.slow
def test_inspect_says_that_an_angle_is_drawn_out_and_differentiated(tmp_path: Path) -> None:
    log_of_an_encoder(tmp_path)
    said = good("inspect", "log.csv", "--position", "angle [rad]", cwd=tmp_path)
    for note in MADE:
        assert said.count(note) == 1


@pytest.mark.slow
def test_fit_says_that_an_angle_is_drawn_out_and_differentiated(tmp_path: Path) -> None:
    log_of_an_encoder(tmp_path)
    words = ("--position", "angle [rad]", "--models", "bingham", "--lag", "none")
    said = good("fit", "log.csv", *words, cwd=tmp_path)
    for note in MADE:
        assert said.count(note) == 1
