"""An effort in each of two senses beside a speed is one curve of both signs; other pairs of columns stay. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read, read_table
from erclutch.signals.array import Array

SPEED: Array = np.linspace(25.0, 1000.0, 16)
BUMP = 200.0 + 0.5 * SPEED
REBOUND = 300.0 + 0.9 * SPEED


def written(folder: Path, names: str, *columns: Array) -> Path:
    path = folder / "sheet.csv"
    lines = [",".join(f"{cell:.9g}" for cell in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([names, *lines]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("bump", "rebound"),
    [
        ("Compression (N)", "Rebound (N)"),
        ("Bump Force (N)", "Rebound Force (N)"),
        ("Druckstufe [N]", "Zugstufe [N]"),
        ("Druck [N]", "Zug [N]"),
        ("C [N]", "R [N]"),
    ],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_compression_and_rebound_are_two_senses_of_one_motion(
    tmp_path: Path, bump: str, rebound: str, sign: float
) -> None:
    path = written(tmp_path, f"Velocity (mm/s),{bump},{rebound}", SPEED, BUMP, sign * REBOUND)
    log = read(path)
    np.testing.assert_allclose(log.signals["slip"] * 1e3, np.concatenate([SPEED, -SPEED]))
    np.testing.assert_allclose(log.signals["effort"], np.concatenate([REBOUND, -BUMP]))
    assert any("two senses of one motion" in note for note in log.notes)
    assert any("its rows are points" in note for note in log.notes)


def test_so_are_torques_of_a_brake_either_way_at_each_current(tmp_path: Path) -> None:
    names = (
        "Speed (rpm),Torque CW 0A (Nm),Torque CCW 0A (Nm),Torque CW 1.5A (Nm),Torque CCW 1.5A (Nm)"
    )
    path = written(tmp_path, names, SPEED, BUMP, REBOUND, 3 * BUMP, 3 * REBOUND)
    log = read(path)
    assert log.rows == 4 * SPEED.size
    np.testing.assert_array_equal(
        np.unique(log.signals["field"], return_counts=True), ([0.0, 1.5], [32, 32])
    )
    assert np.all(log.signals["slip"] * log.signals["effort"] > 0.0)


def test_a_sense_that_ends_earlier_has_fewer_rows(tmp_path: Path) -> None:
    short = BUMP.copy()
    short[10:] = np.nan
    path = written(tmp_path, "v [mm/s],Compression [N],Rebound [N]", SPEED, short, REBOUND)
    assert read(path).rows == SPEED.size + 10


@pytest.mark.parametrize(
    "names",
    [
        "Time [s],Compression [N],Rebound [N]",  # at one time a device moves one way
        "Velocity [mm/s],Compression [N],Rebound [kN]",
        "Velocity [mm/s],Compression ratio,Rebound ratio",
        "Velocity [mm/s],Left force [N],Right force [N]",  # of two dampers
        "Velocity [mm/s],Compression [N],Friction [N]",
    ],
)
def test_other_pairs_stay_as_they_are(tmp_path: Path, names: str) -> None:
    table = read_table(written(tmp_path, names, SPEED, BUMP, REBOUND))
    assert table.rows == SPEED.size


def test_an_effort_that_crosses_zero_is_no_size(tmp_path: Path) -> None:
    path = written(tmp_path, "v [mm/s],Compression [N],Rebound [N]", SPEED, BUMP - 300.0, REBOUND)
    assert read_table(path).rows == SPEED.size


@pytest.mark.parametrize(
    ("words", "sign"),
    [(("Rebound", "Compression"), 1.0), (("C", "R"), -1.0), (("Zugstufe", "Druckstufe"), 1.0)],
)
@pytest.mark.parametrize("has_time", [True, False])
def test_sizes_beside_words_of_senses_get_their_signs(
    tmp_path: Path, words: tuple[str, str], sign: float, has_time: bool
) -> None:
    # Both senses were one, at the same speeds, in silence.
    speed = np.tile(np.linspace(0.02, 0.5, 20), 2)
    force = np.concatenate([1800.0 * speed[:20], 1000.0 * speed[20:]])
    senses = np.repeat([1.0, -1.0], 20) * sign
    rows = [
        f"{place / 100:g},{words[place // 20]},{v:.6g},{f:.6g}"
        for place, (v, f) in enumerate(zip(speed, force, strict=True))
    ]
    head = "Time (s),Direction,Velocity (m/s),Force (N)"
    if not has_time:
        head, rows = head.partition(",")[2], [row.partition(",")[2] for row in rows]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    table = read_table(path)
    np.testing.assert_allclose(table.columns["Velocity"], senses * speed, rtol=1e-5)
    np.testing.assert_allclose(table.columns["Force"], senses * force, rtol=1e-5)
    assert any("are sizes" in note for note in table.notes)
