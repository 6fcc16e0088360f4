"""Files that belong together are all there or none is: on a full disk, after a signal, or after an error."""

from __future__ import annotations

import errno
import json
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch import files
from erclutch.errors import RunError
from erclutch.files import may_write_file, whole_file
from erclutch.files.groups import together
from erclutch.report.plots.matplotlib_painter import save_plot
from erclutch.report.plots.plot_description import Axis, Line, Panel, Plot, PlotTable
from tests.support.command import run
from tests.support.races import make_material, words_of


def write(target: Path, text: str = "new") -> None:
    with whole_file(target) as partial:
        partial.write_text(text)


def full() -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def write_two(
    folder: Path,
    between: Callable[[], object] = lambda: None,
    within: Callable[[], object] = lambda: None,
) -> None:
    """Write a and b together; something happens when a is whole, and something while b is written."""
    with together():
        write(folder / "a")
        between()
        with whole_file(folder / "b") as partial:
            within()
            partial.write_text("new")


def names_in(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_no_name_is_there_before_all_files_are_whole(tmp_path: Path) -> None:
    with together():
        write(tmp_path / "a")
        with together():
            write(tmp_path / "b")
        assert not (tmp_path / "a").exists()
        assert not (tmp_path / "b").exists()
    assert names_in(tmp_path) == {"a", "b"}


def test_an_error_leaves_the_old_files_as_they_were(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old")
    with pytest.raises(RunError, match=r"b: cannot be written: No space left"):
        write_two(tmp_path, lambda: None, full)
    assert (tmp_path / "a").read_text() == "old"
    assert names_in(tmp_path) == {"a"}


def test_an_error_behind_finished_files_is_told_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        write_two(tmp_path, (tmp_path / "none").read_text)
    assert names_in(tmp_path) == set()


def test_a_name_that_was_taken_meanwhile_is_told_and_the_others_are_there(tmp_path: Path) -> None:
    may_write_file(tmp_path / "a", force=False)
    with pytest.raises(RunError, match="another program made it meanwhile"):
        write_two(tmp_path, lambda: (tmp_path / "a").write_text("another's"))
    assert names_in(tmp_path) == {"a", "a-2", "b"}
    assert (tmp_path / "a").read_text() == "another's"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_between_two_moves_is_heard_after_the_last(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put = files._put

    def put_and_ended(*given: Any) -> None:
        put(*given)
        signal.raise_signal(number)

    def ended(number: int, frame: object) -> None:
        raise SystemExit(128 + number)

    usual = signal.signal(number, ended)
    monkeypatch.setattr(files, "_put", put_and_ended)
    try:
        with pytest.raises(SystemExit):
            write_two(tmp_path)
    finally:
        signal.signal(number, usual)
    assert names_in(tmp_path) == {"a", "b"}


def at_file(monkeypatch: pytest.MonkeyPatch, number: int, happens: Callable[[], None]) -> list[int]:
    """Let something happen when so many files are begun; the list counts them."""
    begun = [0]
    partial = files._partial

    def counted(*given: Any) -> Path:
        begun[0] += 1
        if begun[0] == number:
            happens()
        return partial(*given)

    monkeypatch.setattr(files, "_partial", counted)
    return begun


def ended() -> None:
    signal.raise_signal(signal.SIGTERM)


@pytest.mark.slow
@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_plot_has_all_its_files_or_none(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    axis = Axis("x", low=0.0, high=1.0)
    ends = np.array([0.0, 1.0])
    panel = Panel(axis, axis, (Line(ends, ends, "measured"),))
    plot = Plot((panel,), PlotTable(("x",), ((1.0,),)), 1.0)
    at_file(monkeypatch, number, full)
    with pytest.raises(RunError, match="No space left"):
        save_plot(plot, tmp_path / "a.svg", tmp_path / "b.svg")
    assert names_in(tmp_path) == set()


# --- commands ---------------------------------------------------------------------------------------------------------

#: Commands that write several files beside each other, and how many.
SEVERAL = {
    "figure": (words_of("figure", 0), 2),
    "figure-all": (("figure", "all", "run", "--as", "svg", "--out", "all"), 10),
    "tune": (words_of("tune", 0), 3),
    "align": (words_of("align", 0), 3),
    "reproduce": (words_of("reproduce", 0), 3),
    "inspect": (("inspect", "log.csv", "--plots", "seen", "--write-mapping", "seen.toml"), 5),
}


@pytest.fixture(scope="module")
def material(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("material")
    make_material(folder)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("happens", [full, ended])
@pytest.mark.parametrize("name", SEVERAL)
def test_a_command_leaves_all_its_files_or_none(
    name: str, happens: Callable[[], None], material: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words, least = SEVERAL[name]
    before = names_in(material)
    number, came = 1, True
    while came:
        number *= 2  # each once would take minutes
        with monkeypatch.context() as patch:
            begun = at_file(patch, number, happens)
            try:
                code: object = run(*words, cwd=material).code
            except SystemExit as error:
                code = error.code
        came = begun[0] >= number
        made = names_in(material) - before
        if came:
            assert code in (2, 143), number
            assert made == set(), number
    assert code == 0
    assert len(made) >= least
    for each in made:
        (material / each).unlink()


FLEET = ("fit-many", "logs", "--models", "bingham", "--lag", "none", "--out")
OF_ALL = {"fits.parquet", "parameters.parquet", "report.html"}


@pytest.mark.slow
def test_a_fleet_has_all_its_tables_and_their_report_or_none(
    material: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    number, came = 0, True
    while came:
        number += 1
        with monkeypatch.context() as patch:
            begun = at_file(patch, number, full)
            code = run(*FLEET, f"fleet-{number}", cwd=material).code
        came = begun[0] >= number
        assert (code == 0) is not came
        made = (
            names_in(material / f"fleet-{number}")
            if (material / f"fleet-{number}").exists()
            else set()
        )
        assert made & OF_ALL == (set() if came else OF_ALL), number
        assert not any(".partial" in name or ".writing" in name for name in made)
    assert number > 5


@pytest.mark.slow
def test_a_fleet_that_begins_anew_keeps_nothing_of_the_old_settings(
    material: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was interrupted after the first log: the tables and the report of the old settings stood beside it."""
    assert run(*FLEET, "anew", cwd=material).code == 0
    assert names_in(material / "anew") >= OF_ALL
    at_file(monkeypatch, 3, ended)
    with pytest.raises(SystemExit):
        run(*FLEET, "anew", "--seed", "1", "--force", cwd=material)
    left = names_in(material / "anew")
    assert not left & OF_ALL
    marker = json.loads((material / "anew" / "fleet.json").read_text())
    assert marker["settings"]["seed"] == 1
    assert "digest" not in marker


def test_a_torn_line_is_cut_off_though_the_disk_is_full(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file was written anew without the torn line: on a full disk all points were lost."""
    points = pytest.importorskip("erclutch.wings.paper.sweep_points").Points
    path = tmp_path / "points.jsonl"
    points(path, {}).get("ä", lambda: 1)
    with path.open("a") as file:
        file.write('{"settings": "torn')

    def full_disk(file: Path, *given: object, **options: object) -> int:
        file.open("w").close()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_text", full_disk)
    assert points(path, {}).get("ä", lambda: 2) == 1
    assert path.read_text().count("\n") == 1
    assert path.read_text().endswith("\n")
