"""One place that writes: a file or folder is whole, is ours alone, and never takes another's place."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from erclutch import files
from erclutch.errors import ErclutchError, RunError
from erclutch.files import claim, may_write, may_write_file, unwritable, whole_file, whole_folder
from erclutch.logs.synthetic import write_synthetic_log

PAIRS = 100
SPAWN = multiprocessing.get_context("fork")
may_write_run = partial(may_write, marker="run.json")


def write_folder(place: Path, text: str, *, force: bool) -> None:
    with whole_folder(place, unwritable, replace=force) as folder:
        (folder / "run.json").write_text(text)
        (folder / "more").write_text(text)


def write_file(place: Path, text: str, *, force: bool) -> None:
    with whole_file(place, replace=force) as file:
        file.write_text(text)


def racer(write: Callable[..., None], folder: str, force: bool, start: Any, outcomes: Any, who: int) -> None:
    """One of two processes that write to the same places, both at each place at once."""
    for number in range(PAIRS):
        start.wait()
        place = Path(folder) / f"place-{number}"
        try:
            write(place, f"by {who}", force=force)
            outcomes.put((number, who, "written"))
        except RunError as error:
            outcomes.put((number, who, error.remedy or error.problem))


def raced(write: Callable[..., None], folder: Path, *, force: bool) -> dict[int, dict[int, str]]:
    start, outcomes = SPAWN.Barrier(2), SPAWN.Queue()
    racers = [SPAWN.Process(target=racer, args=(write, str(folder), force, start, outcomes, who)) for who in range(2)]
    for process in racers:
        process.start()
    said: dict[int, dict[int, str]] = {number: {} for number in range(PAIRS)}
    for _ in range(2 * PAIRS):
        number, who, outcome = outcomes.get(timeout=60)
        said[number][who] = outcome
    for process in racers:
        process.join()
    return said


def text_in(place: Path) -> str:
    if place.is_file():
        return place.read_text()
    texts = {path.read_text() for path in place.iterdir()}
    assert len(texts) == 1, "a folder of two writers"
    return texts.pop()


@pytest.fixture(params=["as Linux does", "as any system does"])
def system(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param != "as Linux does":
        monkeypatch.setattr(files, "_renameat2", lambda *_: False)


@pytest.mark.usefixtures("system")
@pytest.mark.parametrize("write", [write_folder, write_file])
def test_of_two_finished_results_none_is_lost(write: Callable[..., None], tmp_path: Path) -> None:
    for number, said in raced(write, tmp_path, force=False).items():
        place, beside = tmp_path / f"place-{number}", tmp_path / f"place-{number}-2"
        (won,) = [who for who, outcome in said.items() if outcome == "written"]
        assert text_in(place) == f"by {won}"
        assert said[1 - won] == f"What this command made is kept as place-{number}-2"
        assert text_in(beside) == f"by {1 - won}"
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


@pytest.mark.usefixtures("system")
@pytest.mark.parametrize("write", [write_folder, write_file])
def test_by_force_the_last_one_stays_whole(write: Callable[..., None], tmp_path: Path) -> None:
    for number in range(PAIRS):
        write(tmp_path / f"place-{number}", "old", force=False)
    for number, said in raced(write, tmp_path, force=True).items():
        assert set(said.values()) == {"written"}
        assert text_in(tmp_path / f"place-{number}") in ("by 0", "by 1")
    assert len(list(tmp_path.iterdir())) == PAIRS


def test_what_came_while_the_work_went_on_is_not_replaced(tmp_path: Path) -> None:
    place = tmp_path / "run"

    def write_while_another_does() -> None:
        with whole_folder(place, unwritable) as folder:
            (folder / "run.json").write_text("mine")
            place.mkdir()
            (place / "run.json").write_text("theirs")

    with pytest.raises(RunError, match=r"run: another command has made this meanwhile\. What .* kept as run-2"):
        write_while_another_does()
    assert (place / "run.json").read_text() == "theirs"
    assert (tmp_path / "run-2" / "run.json").read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 2


def test_a_failure_leaves_nothing(tmp_path: Path) -> None:
    for write in (whole_file, partial(whole_folder, unwritable=unwritable)):
        with pytest.raises(ValueError, match="in the middle"), write(tmp_path / "place"):
            raise ValueError("in the middle")
    assert list(tmp_path.iterdir()) == []


# --- claims -----------------------------------------------------------------------------------------------------------


def claimed_elsewhere(place: Path) -> str:
    """What another process is told that claims the place."""
    code = "import sys, pathlib\nfrom erclutch.files import claim\nclaim(pathlib.Path(sys.argv[1]))\nprint('free')"
    done = subprocess.run([sys.executable, "-c", code, str(place)], capture_output=True, text=True, timeout=60)
    return done.stdout.strip() or done.stderr.strip().splitlines()[-1]


def test_a_place_is_claimed_until_it_is_written(tmp_path: Path) -> None:
    may_write_run(tmp_path / "run", False)
    assert "another command is writing to this place" in claimed_elsewhere(tmp_path / "run")
    assert claimed_elsewhere(tmp_path / "other") == "free"
    write_folder(tmp_path / "run", "", force=False)
    assert claimed_elsewhere(tmp_path / "run") == "free"


def test_a_refused_place_is_not_claimed(tmp_path: Path) -> None:
    write_folder(tmp_path / "run", "", force=False)
    (tmp_path / "file").write_text("")
    with pytest.raises(RunError, match="there is a run already"):
        may_write_run(tmp_path / "run", False)
    with pytest.raises(RunError, match="there is a file already"):
        may_write_file(tmp_path / "file", False)
    assert claimed_elsewhere(tmp_path / "run") == "free"
    assert claimed_elsewhere(tmp_path / "file") == "free"


def test_a_killed_process_claims_nothing_and_the_next_one_sweeps(tmp_path: Path) -> None:
    code = (
        "import sys, time, pathlib\nfrom erclutch.files import claim, unwritable, whole_folder\n"
        "place = pathlib.Path(sys.argv[1])\nclaim(place)\n"
        "with whole_folder(place, unwritable) as folder:\n    print('begun', flush=True)\n    time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code, str(tmp_path / "run")], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.send_signal(signal.SIGKILL)
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(".run.partial-")
    claim(tmp_path / "run")
    write_folder(tmp_path / "run", "", force=False)
    assert left.exists()  # it may be of another machine, at work
    os.utime(left, (time.time() - 7200,) * 2)
    claim(tmp_path / "run")
    write_folder(tmp_path / "run", "", force=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run"]


def test_without_locks_work_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_locks(*_: object) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr("fcntl.flock", no_locks)
    may_write_run(tmp_path / "run", False)
    write_folder(tmp_path / "run", "", force=False)
    assert (tmp_path / "run").is_dir()


def test_the_error_is_of_the_commands_kind(tmp_path: Path) -> None:
    class OtherError(ErclutchError):
        pass

    (tmp_path / "file").write_text("")
    with pytest.raises(OtherError):
        may_write(tmp_path / "file", False, "run.json", kind=OtherError)


# --- commands ---------------------------------------------------------------------------------------------------------

COMMAND = (sys.executable, "-m", "erclutch")


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ("fit", "log.csv", "--models", "bingham", "--lag", "none", "--out"),
        ("export", "run", "--to", "c", "--out"),
        ("predict", "log.csv", "--model", "run", "--out"),
    ],
)
def test_of_two_commands_at_once_one_is_told(words: tuple[str, ...], tmp_path: Path) -> None:
    write_synthetic_log(tmp_path / "log.csv")
    first = ("fit", "log.csv", "--models", "bingham", "--lag", "none", "--out", "run")
    subprocess.run([*COMMAND, *first], cwd=tmp_path, check=True, capture_output=True)
    ending = ".csv" if words[0] == "predict" else ""
    for pair in range(3):
        both = [
            subprocess.Popen(
                [*COMMAND, *words, f"o{pair}{ending}"],
                cwd=tmp_path,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
            for _ in range(2)
        ]
        said = [process.communicate(timeout=120)[1] for process in both]
        codes = sorted(process.returncode for process in both)
        assert codes == [0, 2], said
        assert any("another command is writing" in text or "already" in text or "kept as" in text for text in said)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_signals_leave_nothing_behind(name: str, tmp_path: Path) -> None:
    write_synthetic_log(tmp_path / "log.csv")
    code = (
        "import sys, time\nfrom erclutch import files\nfrom erclutch.cli import main\n"
        "import erclutch.runs.run_folder as folders\n"
        "def slow(*given):\n    print('begun', flush=True)\n    time.sleep(60)\n"
        "folders._fill = slow\nsys.argv = ['erclutch', *sys.argv[1:]]\nsys.exit(main())"
    )
    words = ("fit", "log.csv", "--models", "bingham", "--lag", "none", "--json", "--out", "run")
    with subprocess.Popen(
        [sys.executable, "-c", code, *words], cwd=tmp_path, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.strip() == "begun":
                break
        process.send_signal(getattr(signal, name))
        process.communicate(timeout=60)
    assert process.returncode == 128 + getattr(signal, name)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.csv"]
