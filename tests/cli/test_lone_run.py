"""A run that a command needs and nobody named is the only one near; of several none is taken."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.command import refused, run


def _folder(place: Path, name: str, mark: str = "run.json") -> None:
    """A folder that looks like a run, or like an export, and holds nothing."""
    (place / name).mkdir(parents=True)
    (place / name / mark).write_text("{}", encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ("score", "log.csv"),
        ("predict", "log.csv", "--out", "said.csv"),
        ("recalibrate", "log.csv"),
        ("report",),
        ("report", "--title", "Damper"),
        ("table", "--what", "parameters"),
        ("export", "--to", "python"),
        ("figure", "trace"),
    ],
)
def test_the_only_run_of_the_folder_is_taken_and_said(
    words: tuple[str, ...], tmp_path: Path
) -> None:
    _folder(tmp_path, "first run")
    (tmp_path / "log.csv").write_text("t,u\n0,1\n", encoding="utf-8")
    done = run(*words, cwd=tmp_path)
    note, *rest = done.error.splitlines()
    assert note == "run: first run, the only run here"
    assert "is missing" not in " ".join(rest)
    assert "first run" in " ".join(rest)  # which is none, as its run.json says nothing


def test_the_only_export_is_verified(tmp_path: Path) -> None:
    _folder(tmp_path, "first_c", "export.json")
    done = run("verify", cwd=tmp_path)
    assert done.error.splitlines()[0] == "export: first_c, the only export here"


def test_the_only_run_beside_the_log_is_taken_where_the_folder_has_none(tmp_path: Path) -> None:
    bench = tmp_path / "bench"
    _folder(bench, "old")
    (bench / "log.csv").write_text("t,u\n0,1\n", encoding="utf-8")
    done = run("score", "bench/log.csv", cwd=tmp_path)
    assert done.error.splitlines()[0] == f"run: {Path('bench/old')}, the only run here"


def test_a_folder_that_is_a_run_itself_is_taken(tmp_path: Path) -> None:
    _folder(tmp_path, "one")
    done = run("report", cwd=tmp_path / "one")
    assert done.error.splitlines()[0] == "run: ., the only run here"


@pytest.mark.parametrize("words", [("score", "log.csv"), ("report",), ("recalibrate", "log.csv")])
def test_of_several_runs_none_is_taken_and_the_error_names_them(
    words: tuple[str, ...], tmp_path: Path
) -> None:
    _folder(tmp_path, "a")
    _folder(tmp_path, "b c")
    (tmp_path / "log.csv").write_text("t,u\n0,1\n", encoding="utf-8")
    assert "There are 2 runs: a, 'b c'." in refused(*words, cwd=tmp_path)


def test_a_run_that_stands_in_the_wrong_place_is_not_taken_twice(tmp_path: Path) -> None:
    _folder(tmp_path, "a")
    said = refused("score", "a", "log.csv", cwd=tmp_path)
    assert "a is a run: give it as --run a." in said


@pytest.mark.parametrize(
    "words",
    [
        ("--run", "a", "log.csv"),
        ("--run", "a", "b c", "log.csv", "--json"),
        ("--json", "--run", "log.csv", "a"),
    ],
)
def test_a_log_behind_the_run_is_a_log(words: tuple[str, ...], tmp_path: Path) -> None:
    _folder(tmp_path, "a")
    _folder(tmp_path, "b c")
    (tmp_path / "log.csv").write_text("t,u\n0,1\n", encoding="utf-8")
    said = refused("score", *words, cwd=tmp_path)
    assert "LOG is missing" not in said
    assert "run.json" in said  # which says nothing


def test_a_name_behind_the_run_that_is_no_file_is_no_log(tmp_path: Path) -> None:
    _folder(tmp_path, "a")
    assert "LOG is missing" in refused("score", "--run", "a", "lgo.csv", cwd=tmp_path)
