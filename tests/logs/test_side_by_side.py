"""Tables of the same columns side by side, a heading over each, are recordings: runs at fields, or channels."""

from __future__ import annotations

import contextlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import LogError
from erclutch.logs import read, read_table, recordings_in
from tests.support.command import run

TIME = np.arange(120) * 0.01
SPEED = 0.1 * np.sin(9.0 * TIME)
LEVELS = (0.0, 0.5)


def runs(
    path: Path, headings: tuple[str, str] = ("0 A", "0.5 A"), rows_of_second: int = 120
) -> Path:
    """A run of a damper at each of two currents, with a time of its own."""
    lines = [f"{headings[0]},,,{headings[1]},,"]
    lines.append(",".join(["Time [s],Velocity [m/s],Force [N]"] * 2))
    for k, (time, speed) in enumerate(zip(TIME, SPEED, strict=True)):
        cells: list[str] = []
        for level in LEVELS:
            ended = level > 0.0 and k >= rows_of_second
            force = (20.0 + 300.0 * level) * np.tanh(speed / 0.01)
            cells.append(",," if ended else f"{time:.2f},{speed:.6f},{force:.6f}")
        lines.append(",".join(cells))
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.slow
def test_each_table_is_a_recording_at_the_field_of_its_heading(tmp_path: Path) -> None:
    path = runs(tmp_path / "runs.csv")
    assert recordings_in(path) == ["0 A", "0.5 A"]
    for level, heading in zip(LEVELS, ("0 A", "0.5 A"), strict=True):
        recording = read(path, variable=heading)
        assert recording.signals["field"] == pytest.approx(np.full(120, level))
        assert recording.signals["effort"] == pytest.approx(
            (20.0 + 300.0 * level) * np.tanh(SPEED / 0.01), abs=1e-3
        )


@pytest.mark.slow
def test_runs_of_one_motion_at_several_fields_are_all_taken(tmp_path: Path) -> None:
    path = runs(tmp_path / "runs.csv")
    seen = run("inspect", path)
    assert seen.code == 0
    assert "Understood" in seen.out
    assert "Understood" in run("inspect", path, "--variable", "all").out


def test_a_shorter_table_ends_where_its_rows_end(tmp_path: Path) -> None:
    path = runs(tmp_path / "runs.csv", rows_of_second=80)
    assert read_table(path, variable="0 A").rows == 120
    assert read_table(path, variable="0.5 A").rows == 80


def test_a_table_with_an_empty_column_leaves_the_others_as_they_are(tmp_path: Path) -> None:
    path = runs(tmp_path / "runs.csv")
    lines = path.read_text().splitlines()
    without = [",".join([*line.split(",")[:2], "", *line.split(",")[3:]]) for line in lines[2:]]
    path.write_text("\n".join([*lines[:2], *without]))
    assert "Force" not in read_table(path, variable="0 A").columns
    assert read(path, variable="0.5 A").signals["effort"] == pytest.approx(
        170.0 * np.tanh(SPEED / 0.01), abs=1e-3
    )


def test_a_heading_of_words_states_no_field(tmp_path: Path) -> None:
    path = runs(tmp_path / "runs.csv", ("soft", "hard at 3 o'clock"))
    assert "field" not in read_table(path, variable="soft").columns


@pytest.mark.slow
def test_channels_with_times_of_their_own_are_joined(tmp_path: Path) -> None:
    lines = [
        "Force,,Position,,Current,",
        "Time [s],Value [N],Time [s],Value [mm],Time [s],Value [A]",
    ]
    for k, time in enumerate(TIME):
        slower = f"{2 * time:.2f},{np.cos(2 * time):.6f}" if k < 60 else ","
        lines.append(
            f"{time:.2f},{40 * np.sin(9 * time):.6f},{slower},{time:.2f},{0.5 * (k // 60):g}"
        )
    path = tmp_path / "channels.csv"
    path.write_text("\n".join(lines) + "\n")
    asked = run("inspect", path).out.strip().splitlines()[-1]
    assert asked.endswith("--variable 'Force + Position + Current'")
    recording = read(path, variable="Force + Position + Current")
    inside = recording.signals["effort"].size
    assert recording.signals["effort"] == pytest.approx(40 * np.sin(9 * TIME[:inside]), abs=1e-5)
    assert recording.signals["position"] == pytest.approx(1e-3 * np.cos(TIME[:inside]), abs=1e-6)
    assert set(np.unique(recording.signals["field"])) == {0.0, 0.5}


def test_a_heading_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no table '1 A' of numbers"):
        read_table(runs(tmp_path / "runs.csv"), variable="1 A")


def test_a_shared_time_keeps_the_columns_together(tmp_path: Path) -> None:
    rows = [f"{time:.2f},{k},{2 * k},{3 * k},{4 * k}" for k, time in enumerate(TIME)]
    (tmp_path / "a.csv").write_text("\n".join([",left,,right,", "t [s],x,y,x,y", *rows]))
    assert read_table(tmp_path / "a.csv").rows == TIME.size
    assert recordings_in(tmp_path / "a.csv") == []


def test_names_with_a_colon_beside_a_shared_time_are_names(tmp_path: Path) -> None:
    rows = [f"{time:.2f},{k},{2 * k},{3 * k},{4 * k}" for k, time in enumerate(TIME)]
    names = "t [s],axis 1: speed,axis 1: torque,axis 2: speed,axis 2: torque"
    (tmp_path / "a.csv").write_text("\n".join([names, *rows]))
    assert [*read_table(tmp_path / "a.csv").columns] == names.replace(" [s]", "").split(",")


@pytest.mark.slow
@given(text=st.text(alphabet="ab, \n;:1.A", max_size=120))
def test_any_text_is_read_or_refused(text: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("any") / "a.csv"
    path.write_text(text)
    with contextlib.suppress(LogError):
        read_table(path)


def test_an_option_that_is_to_be_left_out_is_no_command(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t [s],x\n" + "".join(f"{time:.2f},{k}\n" for k, time in enumerate(TIME)))
    asked = run("inspect", path, "--variable", "left")
    assert asked.code == 2
    assert "Leave it out" in asked.error
    assert "What settles it" not in asked.out


def _specimens(path: Path, names: tuple[str, str, str]) -> Path:
    """Three tests of two materials side by side; the units stand with the names of the first alone."""
    lines = [
        ",,,,,,second,,",
        "S.1,,,S.2,,,S.1,,",
        "t (s),x (mm),F (kN)," + ",".join([*names, *names]),
    ]
    for time in TIME:
        cells = [f"{time:.2f},{k * time:.4f},{k * np.tanh(time):.5f}" for k in (1, 2, 3)]
        lines.append(",".join(cells))
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.slow
def test_units_that_stand_with_the_first_test_hold_for_those_beside_it(tmp_path: Path) -> None:
    path = _specimens(tmp_path / "tests.csv", ("t", "x", "F"))
    assert recordings_in(path) == ["S.1", "S.2", "S.1 (2)"]
    for k, name in enumerate(("S.1", "S.2", "S.1 (2)"), start=1):
        recording = read(path, variable=name)
        assert recording.signals["effort"] == pytest.approx(1e3 * k * np.tanh(TIME), abs=0.1)
        assert recording.signals["position"] == pytest.approx(1e-3 * k * TIME, abs=1e-6)


@pytest.mark.slow
def test_units_of_another_test_are_its_own(tmp_path: Path) -> None:
    path = _specimens(tmp_path / "tests.csv", ("t (s)", "x (m)", "F (N)"))
    recording = read(path, variable="S.2")
    assert recording.signals["effort"] == pytest.approx(2.0 * np.tanh(TIME), abs=1e-4)
    assert recording.signals["position"] == pytest.approx(2.0 * TIME, abs=1e-3)
