"""Counts of an encoder, and counts a second, are asked about with the scale that makes turns of them. SYNTHETIC."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read
from erclutch.logs.columns.name_ends import split_end
from tests.support.command import good

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(600) / 100
SPEED = 2 + 9 * np.sin(3 * TIME)  # rad/s
ANGLE = np.cumsum(SPEED) / 100
TORQUE = 1.2 * np.tanh(2 * SPEED)
COUNTS = 4096 / (2 * np.pi)  # a radian


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("Velocity [counts/s]", COUNTS * SPEED),
        ("speed (cts/s)", COUNTS * SPEED),
        ("Speed [ticks/sec]", COUNTS * SPEED),
        ("Pulses", np.round(COUNTS * ANGLE)),
        ("ticks", np.round(COUNTS * ANGLE)),
    ],
)
def test_the_scale_of_counts_is_asked_for(
    tmp_path: Path, name: str, numbers: np.ndarray[tuple[int], np.dtype[np.float64]]
) -> None:
    # A unit in other words was asked for, or a column of another name: neither can be given.
    rows = zip(TIME, numbers, TORQUE, strict=True)
    text = "\n".join(f"{t:.2f},{w:.6g},{m:.4f}" for t, w, m in rows)
    (tmp_path / "log.csv").write_text(f"t [s],{name},Torque (Nm)\n{text}\n")
    printed = " ".join(good("inspect", "log.csv", cwd=tmp_path, code=1).split())
    *_, answer = printed.rpartition("erclutch inspect log.csv ")
    words = shlex.split(answer.replace("NUMBER", repr(1 / COUNTS)))
    good("inspect", "log.csv", *words, "--write-mapping", "log.csv.toml", cwd=tmp_path)
    log = read(tmp_path / "log.csv")
    motion = "slip" if "slip" in log.signals else "position"
    truth = SPEED if motion == "slip" else ANGLE
    np.testing.assert_allclose(log.signals[motion], truth, atol=0.01)


@pytest.mark.slow
def test_rows_that_are_counted_are_no_position(tmp_path: Path) -> None:
    text = "\n".join(
        f"{t:.2f},{k},{m:.4f}" for k, (t, m) in enumerate(zip(TIME, TORQUE, strict=True))
    )
    (tmp_path / "log.csv").write_text(f"t [s],counts,Torque (Nm)\n{text}\n")
    printed = good("inspect", "log.csv", cwd=tmp_path, code=1)
    assert '--position "counts"' not in printed


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("theta_rev", ("theta", "turn")),
        ("angle_revs", ("angle", "turn")),
        ("torque_rev", ("torque_rev", None)),
        ("load_klbf", ("load", "kip")),
    ],
)
def test_turns_and_kips_end_a_name(name: str, said: tuple[str, str | None]) -> None:
    assert split_end(name) == said
