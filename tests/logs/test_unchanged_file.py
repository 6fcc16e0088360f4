"""A log that changes while it is read in blocks is told: half of the old log and half of the new came back as one."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import read_batches

NAMES = {"field": "E", "slip": "w", "effort": "T"}


def written(path: Path, first: float) -> Path:
    """A SYNTHETIC log of 60,000 rows; all its numbers have as many digits as those of another first number."""
    rows = np.arange(60_000)
    columns = (1e-3 * rows, rows % 7 / 7, np.sin(0.01 * rows), first + 0.1 * np.cos(0.01 * rows))
    np.savetxt(
        path,
        np.column_stack(columns),
        "%.6f",
        ",",
        header="t [s],E [V],w [rad/s],T [N m]",
        comments="",
    )
    return path


def over(path: Path) -> None:
    other = written(path.with_name("other.csv"), 2.0).read_bytes()
    with path.open("r+b") as file:
        file.write(other)


def grown(path: Path) -> None:
    with path.open("ab") as file:
        file.write(b"60.000000,0.0,0.0,1.0\n")


@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [
        over,
        grown,
        lambda path: os.truncate(path, path.stat().st_size // 2),
        lambda path: path.unlink(),
    ],
    ids=["written over", "grown", "cut", "gone"],
)
def test_a_log_that_changes_between_its_blocks_is_told(
    change: Callable[[Path], None], tmp_path: Path
) -> None:
    path = written(tmp_path / "log.csv", 1.0)
    batches = read_batches(path, NAMES, rows=10_000)
    assert next(batches).start == 0
    change(path)
    with pytest.raises(LogError, match=r"log\.csv: the file was written while it was read"):
        list(batches)


@pytest.mark.slow
def test_a_log_that_stays_is_read_to_its_end(tmp_path: Path) -> None:
    batches = list(read_batches(written(tmp_path / "log.csv", 1.0), NAMES, rows=10_000))
    assert (batches[0].start, batches[-1].stop) == (0, 60_000)
    assert len(batches) > 4
