"""An effort that was logged as its size is asked about; a weight, a preload and a spring have one sign and are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import erclutch
from erclutch.errors import LogError, MappingError
from erclutch.signals.array import Array

pytestmark = pytest.mark.slow

TIME = np.arange(0.0, 20.0, 0.005)
CURRENT = np.where(TIME < 10.0, 0.2, 1.0)
SPEED = 0.2 * np.sin(2 * np.pi * 0.4 * TIME)
TRAVEL = 0.08 * (1.0 - np.cos(2 * np.pi * 0.4 * TIME))
NOISE = np.random.default_rng(3).normal(size=TIME.size)
FRICTION = (20.0 + 300.0 * CURRENT) * np.tanh(SPEED / 0.01) + 3.0 * NOISE
LATE = (20.0 + 300.0 * CURRENT) * np.tanh((SPEED + 0.5 * (TRAVEL - 0.08)) / 0.03) + 3.0 * NOISE


@pytest.fixture
def log(tmp_path: Path) -> Callable[[Array], Path]:
    """Writes a log of the motion with an effort, shape (n,)."""

    def write(effort: Array) -> Path:
        path = tmp_path / "damper.csv"
        rows = np.column_stack([TIME, CURRENT, SPEED, effort])
        head = "t [s],I [A],v [m/s],force [N]"
        np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.5g")
        return path

    return write


@pytest.mark.parametrize(
    "effort",
    [np.abs(FRICTION), -np.abs(FRICTION), np.abs(LATE)],
    ids=["size", "size turned", "size behind a memory"],
)
def test_a_size_of_an_effort_is_asked_about(log: Callable[[Array], Path], effort: Array) -> None:
    path = log(effort)
    with pytest.raises((LogError, MappingError), match="has no sign and falls to 0"):
        erclutch.read(path)
    confirmed = erclutch.read(path, effort="force [N]")
    assert np.abs(confirmed.signals["effort"]).max() > 100.0


@pytest.mark.parametrize(
    "effort",
    [FRICTION, FRICTION + 900.0, 2000.0 * TRAVEL + 12.0 + 0.02 * FRICTION],
    ids=["signed", "gas under pressure", "spring"],
)
def test_an_effort_of_one_sign_for_a_reason_is_read(
    log: Callable[[Array], Path], effort: Array
) -> None:
    assert erclutch.read(log(effort)).rows == TIME.size


def test_a_motor_of_one_sense_with_noise_about_rest_is_read(tmp_path: Path) -> None:
    path = tmp_path / "motor.csv"
    speed = np.where(TIME > 2.0, 5.0, 0.0) + 0.01 * NOISE
    rows = np.column_stack([TIME, CURRENT, speed, 1.0 + CURRENT * speed])
    head = "t [s],I [A],speed [rad/s],torque [N*m]"
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.5g")
    assert erclutch.read(path).rows == TIME.size


def test_a_size_beside_a_position_is_asked_about(tmp_path: Path) -> None:
    path = tmp_path / "damper.csv"
    for effort in (np.abs(FRICTION), FRICTION):
        rows = np.column_stack([TIME, CURRENT, TRAVEL, effort])
        head = "t [s],I [A],x [m],force [N]"
        np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.9g")
        if effort.min() < 0.0:
            assert erclutch.read(path).rows == TIME.size
            continue
        with pytest.raises(MappingError, match="falls to 0 wherever x turns"):
            erclutch.read(path)


SQUARE = np.where(np.sin(2 * np.pi * 1.5 * TIME) > 0.0, 0.2, -0.15)
RESTS = np.where((TIME * 3).astype(int) % 3 == 0, 0.0, SQUARE)


@pytest.mark.parametrize("speed", [SQUARE, RESTS], ids=["square", "square with rests"])
@pytest.mark.parametrize(
    ("sign", "preload", "is_asked"),
    [(1.0, 0.0, True), (-1.0, 0.0, True), (0.0, 0.0, False), (0.0, 700.0, False)],
    ids=["size", "size turned", "signed", "beside a weight"],
)
def test_a_size_beside_a_motion_that_turns_at_once_is_asked_about(
    tmp_path: Path, speed: Array, sign: float, preload: float, is_asked: bool
) -> None:
    friction = (20.0 + 300.0 * CURRENT) * np.tanh(speed / 0.01) + 3.0 * NOISE
    effort = sign * np.abs(friction) if sign else friction + preload
    path = tmp_path / "damper.csv"
    rows = np.column_stack([TIME, CURRENT, speed, effort])
    head = "t [s],I [A],v [m/s],force [N]"
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.5g")
    if is_asked:
        with pytest.raises((LogError, MappingError), match="has no sign and"):
            erclutch.read(path)
        assert erclutch.read(path, effort="force [N]").rows == TIME.size
    else:
        assert erclutch.read(path).rows == TIME.size
