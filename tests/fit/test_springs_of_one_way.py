"""A slip that never turns has a travel that is a time: what drifts is no spring, unless a position was logged."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from erclutch.fit.choice.ladder import grown
from erclutch.fit.choice.stage_families import feels
from erclutch.logs import read
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array

PERIOD, ROWS = 0.05, 1600  # s
TIME: Array = PERIOD * np.arange(float(ROWS))
BINGHAM = Structure(
    "single", "bingham/constant", law_from_name("bingham/constant", "single"), "none", False, True
)


def log(folder: Path, head: str, motion: Array, effort: Array) -> Dataset:
    """A log of a motion and an effort, read as a user's file is (SYNTHETIC)."""
    file = folder / "log.csv"
    rows = np.column_stack([TIME, motion, effort])
    np.savetxt(file, rows, delimiter=",", header=head, comments="")
    return build_dataset(read(file))


def disc(folder: Path) -> Dataset:
    """A brake that turns one way while its torque falls with the path, as a lining runs in."""
    rng = np.random.default_rng(1)
    speed = 18.0 + 12.0 * np.sin(0.15 * TIME)
    path = np.cumsum(speed) * PERIOD
    torque = 6.0 - 0.002 * path + 0.02 * speed + 0.003 * rng.standard_normal(ROWS)
    return log(folder, "time [s],speed [rad/s],torque [N*m]", speed, torque)


def pull(folder: Path) -> Dataset:
    """A spring that is drawn out one way, with the position logged."""
    rng = np.random.default_rng(2)
    position = 4e-4 * TIME + 1e-3 * (1.0 - np.cos(0.3 * TIME))
    force = 2e4 * position + 5.0 + 0.3 * rng.standard_normal(ROWS)
    return log(folder, "time [s],position [mm],force [N]", 1e3 * position, force)


def swing(folder: Path) -> Dataset:
    """A spring beside a friction that goes to and fro."""
    rng = np.random.default_rng(3)
    speed = 0.05 * np.sin(0.9 * TIME)
    travel = np.cumsum(speed) * PERIOD
    force = 400.0 * travel + 6.0 * np.tanh(speed / 0.002) + 0.1 * rng.standard_normal(ROWS)
    return log(folder, "time [s],speed [m/s],force [N]", speed, force)


@pytest.mark.parametrize(("motion", "tried"), [(disc, False), (pull, True), (swing, True)])
def test_a_spring_is_tried_where_there_is_a_travel(
    motion: Callable[[Path], Dataset], tried: bool, tmp_path: Path
) -> None:
    assert feels(motion(tmp_path), BINGHAM, "stiffness", ()) is tried


@pytest.mark.slow
@pytest.mark.parametrize(("motion", "taken"), [(disc, False), (pull, True), (swing, True)])
def test_the_ladder_takes_a_spring_for_a_spring(
    motion: Callable[[Path], Dataset], taken: bool, tmp_path: Path
) -> None:
    rungs = grown(motion(tmp_path), BINGHAM)
    assert ("stiffness" in rungs[-1].structure.dynamics) is taken
