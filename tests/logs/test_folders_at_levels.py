"""A folder for each field, with files of the same names: read as one device, each log under a name of its own."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import any_size
from erclutch.logs.any_size import read_rows
from erclutch.logs.names_of_logs import names_apart
from erclutch.logs.reading import Reading
from tests.support.command import good, refused

TIME = np.arange(400) / 100
FORCES = {"0A": 0.1, "0.5A": 0.6, "1A": 1.1}


def _brake(path: Path, force: float, header: str = "t [s],w [rad/s],torque [N*m]\n") -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    slip = 3.0 * np.sin(3.0 * TIME)
    torque = force * np.tanh(5.0 * slip) + 0.01 * slip
    rows = "".join(f"{t:g},{w:.6g},{m:.6g}\n" for t, w, m in zip(TIME, slip, torque, strict=True))
    path.write_text(header + rows, encoding="utf-8")


@pytest.fixture
def bench(tmp_path: Path) -> Path:
    """Two runs in a folder for each current."""
    for level, force in FORCES.items():
        _brake(tmp_path / "bench" / level / "run1.csv", force)
        _brake(tmp_path / "bench" / level / "run2.csv", 1.01 * force)
    return tmp_path / "bench"


def test_names_have_as_many_folders_as_tell_them_apart() -> None:
    paths = [Path(way) for way in ("/b/1Hz/0A/x.csv", "/b/2Hz/0A/x.csv", "/b/1A/x.csv", "/b/y.csv")]
    assert names_apart(paths) == ["1Hz/0A/x.csv", "2Hz/0A/x.csv", "1A/x.csv", "y.csv"]
    assert names_apart([Path("/b/x.csv")]) == ["x.csv"]
    assert names_apart([]) == []
    # The same file given twice is refused elsewhere: no folder tells it from itself.
    assert names_apart([Path("/b/x.csv"), Path("/b/x.csv")]) == ["x.csv", "x.csv"]


@pytest.mark.slow
def test_a_folder_of_levels_is_settled_by_one_command(bench: Path) -> None:
    said = good("inspect", "bench", cwd=bench.parent, code=1)
    assert "The same is asked of 5 more logs, the last 1A/run2.csv" in said
    _, _, command = said.splitlines()[-1].partition("erclutch ")
    table = good(*shlex.split(command), cwd=bench.parent)
    for level in FORCES:
        row = next(line.split() for line in table.splitlines() if f" {level}/run2 " in line)
        assert row[2] == level.removesuffix("A")
    assert "Understood. Fit them" in table


@pytest.mark.slow
def test_logs_of_one_name_are_held_out_by_their_folders(bench: Path) -> None:
    words = ["--name-pattern", "{field}A/run{n1}", "--models", "bingham", "--lag", "none"]
    said = good("fit", "bench", *words, "--test", "0.5A/*", "--out", "o", cwd=bench.parent)
    assert "held out: 0.5A/run1.csv, 0.5A/run2.csv" in said


@pytest.mark.slow
def test_logs_read_in_blocks_have_their_own_names_too(
    bench: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(any_size, "_WITHOUT_ROWS", 0)
    paths = [bench / level / "run1.csv" for level in FORCES]
    how = Reading.from_options({"name_pattern": "{field}A/run{n1}"})
    names = ("0A/run1.csv", "0.5A/run1.csv", "1A/run1.csv")
    assert read_rows(paths, how).data.sources == names
    in_blocks = read_rows(paths, how, memory=1.2e6)
    assert in_blocks.left_out > 0
    assert in_blocks.data.sources == tuple(names[number] for number in in_blocks.numbers)
    assert tuple(log.name for log in in_blocks.in_blocks) == names


def test_folders_whose_names_tell_no_field_are_asked_about(tmp_path: Path) -> None:
    for folder in ("raw", "smoothed"):
        _brake(tmp_path / folder / "log.csv", 0.5)
    said = refused("inspect", tmp_path, cwd=tmp_path)
    assert "Give one of its folders: raw, smoothed" in said


@pytest.mark.slow
def test_a_bare_number_in_names_is_asked_about_behind_columns_without_names(
    tmp_path: Path,
) -> None:
    for level, force in (("0.0", 0.1), ("0.5", 0.6), ("1.0", 1.1)):
        _brake(tmp_path / "logs" / f"brake_{level}.csv", force, header="")
    command = good("inspect", "logs", cwd=tmp_path, code=1).splitlines()[-1]
    assert "--field none" not in command
    said = good(*shlex.split(command.partition("erclutch ")[2]), cwd=tmp_path, code=1)
    assert "times the effort of brake_0.0.csv" in said
    assert '--name-pattern "brake_{field}"' in said.splitlines()[-1]
