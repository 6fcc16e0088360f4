"""A line of levels may stand over names that are the same at each level, behind a time or a speed that all share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, read, read_all
from tests.support.command import run

TIME = np.arange(120) * 0.01
SPEED = 0.1 * np.sin(9.0 * TIME)
FORCES = {level: (20.0 + 300.0 * level) * np.tanh(SPEED / 0.01) for level in (0.0, 1.0)}
PAIRS = np.column_stack([TIME, SPEED, FORCES[0.0], SPEED, FORCES[1.0]])
ALONE = PAIRS[:, (0, 1, 2, 4)]


def sheet(tmp_path: Path, header: str, rows: np.ndarray = PAIRS) -> Path:
    path = tmp_path / "log.csv"
    lines = (",".join(f"{value:.6f}" for value in row) for row in rows)
    path.write_text("\n".join([header, *lines]) + "\n")
    return path


@pytest.mark.parametrize(
    "header",
    [
        ",0 A,0 A,1 A,1 A\nTime (s),velocity (m/s),force (N),velocity (m/s),force (N)",
        ",0 A,,1 A,\nTime (s),velocity (m/s),force (N),velocity,force",
        "Current (A),0,,1,\nTime (s),velocity (m/s),force (N),velocity,force",
        "I =,0 A,0 A,1 A,1 A\nTime (s),velocity (m/s),force (N),velocity (m/s),force (N)",
        # As pandas writes names of two levels.
        ",0 A,0 A,1 A,1 A\n,velocity (m/s),force (N),velocity (m/s),force (N)\nt,,,,",
        "level,0 A,0 A,1 A,1 A\nsignal,velocity (m/s),force (N),velocity (m/s),force (N)\nt,,,,",
    ],
)
def test_rows_at_each_level_stand_one_after_another(tmp_path: Path, header: str) -> None:
    recording = read(sheet(tmp_path, header))
    assert [stop - start for start, stop in recording.segments] == [120, 120]
    for (start, stop), (level, force) in zip(recording.segments, FORCES.items(), strict=True):
        assert recording.signals["field"][start:stop] == pytest.approx(np.full(120, level))
        assert recording.signals["slip"][start:stop] == pytest.approx(SPEED, abs=1e-6)
        assert recording.signals["effort"][start:stop] == pytest.approx(force, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("over", [",,0 A,1 A", "Current [A],,0,1"])
def test_efforts_that_share_a_motion_are_a_log_each(tmp_path: Path, over: str) -> None:
    header = f"{over}\nt (s),velocity (m/s),force (N),force (N)"
    path = sheet(tmp_path, header, ALONE)
    assert "--variable all" in run("inspect", path.name, cwd=tmp_path).out.splitlines()[-1]
    logs = read_all(path, ColumnMap())
    assert [float(log.signals["field"][0]) for log in logs] == [0.0, 1.0]


@pytest.mark.slow
def test_names_of_a_current_without_a_unit_are_levels(tmp_path: Path) -> None:
    header = "Current,0,0,1,1\n,velocity,force,velocity,force"
    last = run("inspect", sheet(tmp_path, header).name, cwd=tmp_path).out.splitlines()[-1]
    assert '--field "level"' in last
    assert "none" not in last.partition("--field")[2]


@pytest.mark.slow
@pytest.mark.parametrize("over", [",Run 1,Run 1,Run 2,Run 2", "Test,1,,2,", ",Front,,Rear,"])
def test_headings_that_are_no_field_are_asked_about(tmp_path: Path, over: str) -> None:
    header = f"{over}\nTime (s),velocity (m/s),force (N),velocity (m/s),force (N)"
    said = run("inspect", sheet(tmp_path, header).name, cwd=tmp_path)
    assert said.code == 1
    assert "force, " in said.out or "force [N], " in said.out


@pytest.mark.slow
def test_a_unit_below_the_first_name_is_no_name(tmp_path: Path) -> None:
    header = "x,velocity,force,F2,F3\nmm,,,,"
    said = run("inspect", sheet(tmp_path, header).name, cwd=tmp_path).out
    assert " x " in said
