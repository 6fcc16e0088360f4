"""One place that writes: a file or folder is whole, is ours alone, and never takes another's place."""

from __future__ import annotations

import errno
import inspect
import multiprocessing
import os
import signal
import stat
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from threading import Thread
from types import FrameType
from typing import Any

import pytest

from erclutch import files
from erclutch.cli.command_list import commands
from erclutch.errors import ErclutchError, RunError
from erclutch.files import (
    groups,
    is_plain_file,
    may_fill,
    may_write,
    may_write_file,
    places,
    unwritable,
    whole_file,
    whole_folder,
)
from erclutch.files.groups import together
from erclutch.files.places import put_new, release, release_all, reserve
from erclutch.logs.synthetic import write_synthetic_log
from tests.support.command import refused, run
from tests.support.no_room import read_only
from tests.support.raced_writers import Written, lost_in, written_by
from tests.support.races import SLOW, WORDS, lost_in_pairs, make_material, started

PAIRS = 30
SPAWN = multiprocessing.get_context("fork")
#: What a command is told before its work. The last one: another was between the two steps of a move.
TOLD_BEFORE = ("writing it at this moment", "already", "exists and is not a run")
may_write_run = partial(may_write, marker="run.json")


def write_folder(place: Path, text: str, *, force: bool) -> None:
    may_write_run(place, force)
    with whole_folder(place, unwritable) as folder:
        (folder / "run.json").write_text(text)
        (folder / "more").write_text(text)


def write_file(place: Path, text: str, *, force: bool) -> None:
    may_write_file(place, force)
    with whole_file(place) as file:
        file.write_text(text)


def racer(
    write: Callable[..., None], folder: str, force: bool, start: Any, outcomes: Any, who: int
) -> None:
    """One of two processes that write to the same places, both at each place at once."""
    for number in range(PAIRS):
        start.wait()
        place = Path(folder) / f"place-{number}"
        try:
            write(place, f"by {who}", force=force)
            outcomes.put((number, who, "written"))
        except RunError as error:
            outcomes.put((number, who, f"{error.problem}. {error.remedy}"))


def raced(write: Callable[..., None], folder: Path, *, force: bool) -> dict[int, dict[int, str]]:
    start, outcomes = SPAWN.Barrier(2), SPAWN.Queue()
    racers = [
        SPAWN.Process(target=racer, args=(write, str(folder), force, start, outcomes, who))
        for who in range(2)
    ]
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


@pytest.fixture(params=["locks", "no locks"])
def locks(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> bool:
    if request.param == "no locks":
        monkeypatch.setattr(places, "fcntl", None)
    return request.param == "locks"


@pytest.fixture(
    params=["a rename that refuses", "a rename that replaces", "a disk without second names"]
)
def disk(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_links(*_: object) -> None:
        raise OSError(errno.EPERM, "Operation not permitted")

    if request.param != "a rename that refuses":
        monkeypatch.setattr(places, "_renameat2", lambda: None)
    if request.param == "a disk without second names":
        monkeypatch.setattr("os.link", no_links)


@pytest.mark.slow
@pytest.mark.usefixtures("disk")
@pytest.mark.parametrize("write", [write_folder, write_file])
def test_of_two_results_none_is_lost(
    write: Callable[..., None], locks: bool, tmp_path: Path
) -> None:
    """The loser is told before its work, or what it made is kept beside."""
    for number, said in raced(write, tmp_path, force=False).items():
        place, beside = tmp_path / f"place-{number}", tmp_path / f"place-{number}-2"
        (won,) = [who for who, outcome in said.items() if outcome == "written"]
        assert text_in(place) == f"by {won}"
        if "made it meanwhile" in said[1 - won]:
            assert not locks
            assert str(beside) in said[1 - won]
            assert text_in(beside) == f"by {1 - won}"
        else:
            assert any(words in said[1 - won] for words in TOLD_BEFORE), said
            assert not beside.exists()
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


@pytest.mark.slow
@pytest.mark.usefixtures("disk")
@pytest.mark.parametrize("write", [write_folder, write_file])
def test_by_force_every_place_is_whole(
    write: Callable[..., None], locks: bool, tmp_path: Path
) -> None:
    for number in range(PAIRS):
        write(tmp_path / f"place-{number}", "old", force=False)
    for number, said in raced(write, tmp_path, force=True).items():
        written = [who for who, outcome in said.items() if outcome == "written"]
        assert text_in(tmp_path / f"place-{number}") in [f"by {who}" for who in written], said
        for who in {0, 1} - set(written):
            if "made it meanwhile" in said[who]:
                assert text_in(tmp_path / f"place-{number}-2") == f"by {who}", said
    left = [path.name for path in tmp_path.iterdir() if path.name.count("-") == 1]
    assert sorted(left) == sorted(f"place-{number}" for number in range(PAIRS))


def test_two_threads_are_two_writers(tmp_path: Path) -> None:
    """A program may write from several threads: each place has one of them at a time."""
    said: list[str] = []

    def write(text: str) -> None:
        try:
            write_folder(tmp_path / "run", text, force=False)
            said.append(text)
        except RunError:
            pass

    threads = [Thread(target=write, args=(f"by {who}",)) for who in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert said == [text_in(tmp_path / "run")]
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


@pytest.mark.usefixtures("disk")
@pytest.mark.parametrize("there", ["file", "folder", "empty folder", "link to nothing"])
@pytest.mark.parametrize("finished", ["file", "folder"])
def test_a_finished_one_never_takes_a_place(there: str, finished: str, tmp_path: Path) -> None:
    place, made = tmp_path / "place", tmp_path / "made"
    if there == "file":
        place.write_text("theirs")
    elif there == "link to nothing":
        place.symlink_to(tmp_path / "nowhere")
    else:
        place.mkdir()
        if there == "folder":
            (place / "run.json").write_text("theirs")
    if finished == "file":
        made.write_text("mine")
    else:
        made.mkdir()
    before = place.lstat()
    with pytest.raises(FileExistsError):
        put_new(made, place)
    assert os.path.samestat(place.lstat(), before)
    assert made.exists()


@pytest.mark.usefixtures("disk")
def test_what_came_while_the_work_went_on_is_not_replaced(tmp_path: Path) -> None:
    place = tmp_path / "run v1.5"

    def write_while_another_does() -> None:
        with whole_folder(place, unwritable) as folder:
            (folder / "run.json").write_text("mine")
            place.mkdir()
            (place / "run.json").write_text("theirs")

    with pytest.raises(
        RunError, match=r"made it meanwhile.* Take what was made here from .*run v1\.5-2"
    ):
        write_while_another_does()
    assert (place / "run.json").read_text() == "theirs"
    assert (tmp_path / "run v1.5-2" / "run.json").read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.usefixtures("disk")
def test_force_asks_again_at_the_move(tmp_path: Path) -> None:
    """The run that may be replaced may be something else once the new one is there."""
    place = tmp_path / "run"
    write_folder(place, "old", force=False)
    may_write_run(place, True)

    def write_while_another_does() -> None:
        with whole_folder(place, unwritable) as folder:
            (folder / "run.json").write_text("mine")
            (place / "run.json").unlink()

    with pytest.raises(RunError, match="made it meanwhile"):
        write_while_another_does()
    assert (place / "more").read_text() == "old"
    assert (tmp_path / "run-2" / "run.json").read_text() == "mine"


def test_force_replaces_plain_files_alone(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(RunError, match="no plain file"):
        may_write_file(tmp_path / "pipe", True)
    with pytest.raises(RunError, match="this is a folder"):
        may_write_file(tmp_path, True)


def test_a_failure_leaves_nothing(tmp_path: Path) -> None:
    for write in (whole_file, partial(whole_folder, unwritable=unwritable)):
        with pytest.raises(ValueError, match="in the middle"), write(tmp_path / "place"):
            raise ValueError("in the middle")
    assert list(tmp_path.iterdir()) == []


def test_what_is_written_has_the_rights_that_the_umask_leaves(tmp_path: Path) -> None:
    """Files of a user who keeps them from others were readable for all."""
    before = os.umask(0o027)
    try:
        write_file(tmp_path / "file", "text", force=False)
        write_folder(tmp_path / "folder", "text", force=False)
    finally:
        os.umask(before)
    rights = {path.name: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.rglob("*")}
    assert rights == {"file": 0o640, "folder": 0o750, "run.json": 0o640, "more": 0o640}


# --- reservations -----------------------------------------------------------------------------------------------------


def reserved_elsewhere(place: Path) -> str:
    """What another process is told that reserves the place."""
    code = (
        "import sys, pathlib\nfrom erclutch.files.places import nothing, release_all, reserve\n"
        "reserve(pathlib.Path(sys.argv[1]), nothing)\nrelease_all()\nprint('free')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(place)], capture_output=True, text=True, timeout=60
    )
    return done.stdout.strip() or done.stderr.strip().splitlines()[-1]


@pytest.mark.slow
def test_a_place_is_reserved_until_it_is_written(tmp_path: Path) -> None:
    may_write_run(tmp_path / "run", False)
    assert "another program is writing it" in reserved_elsewhere(tmp_path / "run")
    assert reserved_elsewhere(tmp_path / "other") == "free"
    write_folder(tmp_path / "run", "", force=False)
    assert reserved_elsewhere(tmp_path / "run") == "free"


def test_a_refused_place_is_not_reserved(tmp_path: Path) -> None:
    write_folder(tmp_path / "run", "", force=False)
    (tmp_path / "file").write_text("")
    with pytest.raises(RunError, match="there is a run already"):
        may_write_run(tmp_path / "run", False)
    with pytest.raises(RunError, match="there is a file already"):
        may_write_file(tmp_path / "file", False)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "run"]


def test_what_was_reserved_in_vain_is_given_free(tmp_path: Path) -> None:
    may_write_file(tmp_path / "file", False)
    may_write_file(tmp_path / "no" / "folder" / "file", False)
    assert [path.name for path in tmp_path.iterdir()] == [".file.writing"]
    release_all()
    assert list(tmp_path.iterdir()) == []


def killed_while_writing(place: Path) -> None:
    code = (
        "import sys, time, pathlib\nfrom erclutch.files import unwritable, whole_folder\n"
        "with whole_folder(pathlib.Path(sys.argv[1]), unwritable) as folder:\n"
        "    print('begun', flush=True)\n    time.sleep(60)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, str(place)], stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.send_signal(signal.SIGKILL)


@pytest.mark.slow
def test_what_a_killed_program_left_is_cleared_by_the_next(tmp_path: Path) -> None:
    killed_while_writing(tmp_path / "run")
    assert [path.name.partition("-")[0] for path in sorted(tmp_path.iterdir())] == [
        ".run.partial",
        ".run.writing",
    ]
    write_folder(tmp_path / "run", "", force=False)
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


@pytest.mark.slow
def test_what_another_machine_left_is_not_touched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its program may be at work: not every network disk tells of the locks of other machines."""
    killed_while_writing(tmp_path / "run")
    monkeypatch.setattr(places, "_machine", lambda: b"another")
    write_folder(tmp_path / "run", "", force=False)
    assert sorted(path.name.partition("-")[0] for path in tmp_path.iterdir()) == [
        ".run.partial",
        "run",
    ]


def test_an_old_run_that_was_moved_away_comes_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where two folders cannot be exchanged in one step, a power cut may come between the two."""
    place = tmp_path / "run"
    write_folder(place, "old", force=False)
    reserve(place, is_plain_file)
    lock = (tmp_path / ".run.writing").read_bytes()
    release(place)
    place.rename(tmp_path / ".run.old-1234")
    (tmp_path / ".run.writing").write_bytes(lock)
    with pytest.raises(RunError, match="there is a run already"):
        may_write_run(place, False)
    assert text_in(place) == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_a_move_that_fails_between_its_steps_keeps_the_old_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(places, "_renameat2", lambda: None)
    write_folder(tmp_path / "run", "old", force=False)
    rename, steps = Path.rename, iter((1, 2))

    def second_fails(self: Path, target: Path) -> Path:
        if next(steps, 0) == 2:
            raise OSError(errno.EIO, "Input/output error")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", second_fails)
    with pytest.raises(RunError, match="Input/output error"):
        write_folder(tmp_path / "run", "new", force=True)
    assert text_in(tmp_path / "run") == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_without_locks_work_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_locks(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", no_locks)
    may_write_run(tmp_path / "run", False)
    write_folder(tmp_path / "run", "", force=False)
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_the_error_is_of_the_commands_kind(tmp_path: Path) -> None:
    class OtherError(ErclutchError):
        pass

    (tmp_path / "file").write_text("")
    with pytest.raises(OtherError):
        may_write(tmp_path / "file", False, "run.json", kind=OtherError)


# --- commands ---------------------------------------------------------------------------------------------------------

#: Options of commands that name a place.
PLACES = {"out", "write_mapping", "plots", "picture"}  # live: by LoopOptions


def writing() -> dict[str, set[str]]:
    """Our commands that write, with the options that name a place."""
    options = {
        command.name: PLACES & set(inspect.signature(command.plugin.value).parameters)
        for command in commands()
        if command.plugin.own
    }
    return {name: places for name, places in options.items() if places}


def test_every_command_that_writes_is_raced() -> None:
    assert set(writing()) <= {*WORDS}


#: What each command that writes is told besides a place. Its inputs are not there: who reads them first does not look
#: at the place first.
TOO_EARLY = {
    "align": "none.csv none.csv --on torque",
    "calibrate-twin": "none.csv --device coaxial",
    "compare": "none none",
    "demo": "--seconds 10",
    "excite": "--sequence paper --seconds 1",
    "experiment": "sine --run none --seconds 1",
    "export": "none --to c",
    "figure": "trace none",
    "fit": "none.csv",
    "fit-many": "none",
    "inspect": "none.csv",
    "live": "--run none --headless --seconds 1 --record",
    "predict": "none.csv --run none",
    "recalibrate": "none none.csv",
    "report": "none",
    "reproduce": "table2 --log none.csv",
    "simulate": "training --seconds 2 --rig-file none.toml",
    "table": "none",
    "tune": "none",
}
_ENDINGS = {
    "align": ".csv",
    "predict": ".csv",
    "excite": ".csv",
    "simulate": ".csv",
    "report": ".html",
    "compare": ".html",
}
PLACED = [(name, option) for name, options in writing().items() for option in sorted(options)]
if any(command.name == "live" for command in commands()):
    PLACED.append(("live", "folder"))


@pytest.mark.parametrize(
    "closed", ["a file where the folder is to be", "a folder that nobody may write to"]
)
@pytest.mark.parametrize(("name", "option"), PLACED, ids=["-".join(placed) for placed in PLACED])
def test_a_place_that_takes_nothing_is_told_before_the_work(
    name: str, option: str, closed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`experiment`, `figure` and `tune` worked for minutes, and then found their folder closed."""
    if closed.startswith("a file"):
        (tmp_path / "closed").write_text("")
    else:
        (tmp_path / "closed").mkdir()
        access = os.access  # who runs the tests may be allowed to write everywhere
        monkeypatch.setattr(
            os, "access", lambda path, mode: "closed" not in str(path) and access(path, mode)
        )

    def too_late(*_: object) -> None:
        pytest.fail("it came to the writing")

    monkeypatch.setattr(files, "_partial", too_late)
    ending = {"write_mapping": ".toml", "picture": ".png", "out": _ENDINGS.get(name, "")}.get(
        option, ""
    )
    words = [
        name,
        *TOO_EARLY[name].split(),
        f"--{option.replace('_', '-')}",
        f"closed/made{ending}",
    ]
    if option == "picture":
        words += ["--out", "open.csv"]
    ended = run(*words, cwd=tmp_path)
    assert ended.code == 2
    (error,) = [line for line in ended.error.splitlines() if line.startswith("error: ")]
    assert "closed" in error
    assert "Give " in error or "Make " in error  # the remedy
    left = [
        path.name
        for path in tmp_path.rglob("*")
        if path.name not in ("closed", ".open.csv.writing")
    ]
    assert left == []


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="a folder of Linux")
@pytest.mark.parametrize("name", [name for name, option in PLACED if option == "out"])
def test_a_folder_that_takes_nothing_in_spite_of_its_rights_is_told_before_the_work(
    name: str, tmp_path: Path
) -> None:
    """`fit --out /proc/x` failed after the fit: whoever may write everywhere has the right to write there too."""
    said = refused(
        name, *TOO_EARLY[name].split(), "--out", f"/proc/made{_ENDINGS.get(name, '')}", cwd=tmp_path
    )
    assert said.startswith(f"error: /proc/made{_ENDINGS.get(name, '')}: ")
    assert "Give " in said


@pytest.mark.parametrize("there", [True, False])
def test_the_folder_itself_is_named_that_takes_no_file(there: bool, tmp_path: Path) -> None:
    folder = Path("/proc") if there else tmp_path / "log.csv" / "new"
    (tmp_path / "log.csv").touch()
    with pytest.raises(RunError) as caught:
        may_fill(folder)
    assert caught.value.where == str(folder)


@pytest.fixture(scope="module")
def material(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a log, two logs and two runs."""
    folder = tmp_path_factory.mktemp("material")
    make_material(folder)
    return folder


#: Two commands that make folders and two that make files.
AS_A_USER = ("export", "fit", "report", "table")


@pytest.mark.slow
@pytest.mark.parametrize("name", WORDS)
def test_of_two_commands_at_once_one_is_told(name: str, material: Path) -> None:
    """At one moment, which the start of Python hides; a few once more as a user starts them.

    `studies/attack.py` races a hundred pairs of each, and starts each as a user does.
    """
    if name in AS_A_USER:
        assert started(name, 0, material).lost(name) == ""
    _, lost = lost_in_pairs(name, 1 if name in SLOW else 3, material)
    assert lost == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["export", "fit", "predict-many", "table"])
def test_of_a_hundred_pairs_of_a_commands_writer_none_loses_a_result(
    name: str, material: Path, tmp_path: Path
) -> None:
    """`studies/attack.py` asks the writers of all commands."""
    written = written_by(name, material, tmp_path)
    assert written
    for number, each in enumerate(written):
        assert lost_in(each, 100, tmp_path / f"raced-{number}") == []


@pytest.mark.slow
def test_a_writer_that_takes_anothers_place_is_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "copy").write_text("result")
    written = Written(tmp_path / "copy", "result", places.nothing, unwritable)
    monkeypatch.setattr(files, "_put", lambda partial, target, *_: os.replace(partial, target))
    monkeypatch.setattr(places, "_locked", lambda _: None)
    assert lost_in(written, 5, tmp_path / "raced")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["demo", "export", "tune"])
def test_a_folder_that_takes_nothing_is_one_line(name: str, material: Path) -> None:
    """`studies/attack.py` asks all commands, and each on a disk of 60 kB, too."""
    ended = read_only(name, material)
    assert ended.wrong == ""
    assert ended.code == 2
    assert ended.left == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_signals_leave_nothing_behind(name: str, tmp_path: Path) -> None:
    write_synthetic_log(tmp_path / "log.csv")
    code = (
        "import sys, time\nfrom erclutch import files\nfrom erclutch.cli import main\n"
        "import erclutch.runs.written_run as folders\n"
        "def slow(*given):\n    print('begun', flush=True)\n    time.sleep(60)\n"
        "folders.write_models = slow\nsys.argv = ['erclutch', *sys.argv[1:]]\nsys.exit(main())"
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


def interrupted_at(number: int, work: Callable[[], None]) -> bool:
    """Whether work came to so many lines of the package that writes; there Control-C comes."""
    lines = 0

    def watch(frame: FrameType, event: str, arg: object) -> Any:
        nonlocal lines
        if frame.f_code.co_filename not in (files.__file__, groups.__file__, places.__file__):
            return None
        lines += event == "line"
        if lines == number and event == "line":
            signal.raise_signal(signal.SIGINT)
        return watch

    before = sys.gettrace()
    sys.settrace(watch)
    try:
        work()
    except KeyboardInterrupt:
        pass
    finally:
        sys.settrace(before)
    return lines >= number


@pytest.mark.slow
@pytest.mark.parametrize("over_an_old_one", [False, True])
@pytest.mark.parametrize("kind", ["file", "folder", "files together"])
def test_wherever_control_c_comes_nothing_half_made_stays(
    kind: str, over_an_old_one: bool, tmp_path: Path
) -> None:
    """One in 39 left the lock of its name beside what `simulate` made: it came before that was known."""

    def write() -> None:
        reserve(target, Path.exists)
        if kind == "file":
            with whole_file(target) as partial_file:
                partial_file.write_text("whole")
        elif kind == "files together":
            with together(), whole_file(target) as first, whole_file(target.with_name("b")) as last:
                first.write_text("whole")
                last.write_text("whole")
        else:
            with whole_folder(target, unwritable) as folder:
                (folder / "whole").touch()

    number, came = 0, True
    while came:
        number += 1
        target = tmp_path / str(number) / "out"
        target.parent.mkdir()
        if over_an_old_one:
            for old in (target, target.with_name("b")) if kind == "files together" else (target,):
                (old.mkdir if kind == "folder" else old.touch)()
        came = interrupted_at(number, write)
        release_all()
        left = {path.name for path in target.parent.iterdir()}
        both = {"out", "b"} if kind == "files together" else {"out"}
        assert left in ((both,) if over_an_old_one else (set(), both)), number
    assert number > 60
