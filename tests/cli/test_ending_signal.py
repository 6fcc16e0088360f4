"""A signal ends a command once, as an exception does; no further one stops it as it clears up."""

from __future__ import annotations

import ctypes
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from erclutch import cli, files
from erclutch.cli import main
from erclutch.cli.ending_signal import EndingSignal
from erclutch.files import scratch_folder, takes_files

_ALL = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.fixture
def usual() -> Iterator[None]:
    """Each signal as a process has it that has just begun, and after the test as it was."""
    before = {number: signal.getsignal(number) for number in _ALL}
    for number in _ALL:
        signal.signal(
            number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
        )
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("first", _ALL)
@pytest.mark.parametrize("second", _ALL)
def test_a_second_signal_does_not_stop_what_clears_up(usual: None, first: int, second: int) -> None:
    """A shell sends SIGHUP and SIGTERM, a hurried user Control-C twice: the second left locks and parts of files."""
    ending = EndingSignal()
    ending.begin()
    with pytest.raises((KeyboardInterrupt, SystemExit)):
        signal.raise_signal(first)
    signal.raise_signal(second)
    assert ending.number == first


@pytest.mark.parametrize("number", _ALL)
def test_a_signal_is_heard_again_where_nothing_can_be_raised(usual: None, number: int) -> None:
    """A compiler calls back while it compiles: there the signal was lost, with a traceback, and the command went on."""
    ending = EndingSignal()
    ending.begin()
    called_back = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(number))
    try:
        called_back()
        with pytest.raises((KeyboardInterrupt, SystemExit)):
            time.sleep(1.0)
    finally:
        ending.end()


def test_who_does_not_end_in_time_hears_the_next_signal(
    usual: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    ending = EndingSignal()
    ending.begin()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    monkeypatch.setattr("erclutch.cli.ending_signal._CLEARS_UP", 0.0)
    with pytest.raises(SystemExit, match=str(128 + signal.SIGTERM)):
        signal.raise_signal(signal.SIGTERM)


@pytest.mark.parametrize("number", _ALL)
def test_after_its_end_a_command_hears_nothing_and_signals_are_the_callers_again(
    usual: None, number: int
) -> None:
    """A program that went on behind a command could be ended by Control-C alone."""
    before = signal.getsignal(number)
    ending = EndingSignal()
    ending.begin()
    ending.end()
    signal.raise_signal(number)
    ending.give_back()
    assert signal.getsignal(number) == before


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("number", _ALL)
@pytest.mark.parametrize("ends", ["return 0", "return 2", "raise SystemExit(143)"])
def test_a_command_that_is_done_can_be_ended_though_a_thread_never_ends(
    tmp_path: Path, number: int, ends: str
) -> None:
    """A plug-in's thread held the process for good, and no signal but SIGKILL was heard."""
    lines = [
        "import os, signal, sys, threading, time",
        "import erclutch.cli",
        "from erclutch.__main__ import main",
        "def command():",
        "    threading.Thread(target=time.sleep, args=(60,)).start()",
        f"    threading.Timer(0.2, os.kill, (os.getpid(), {int(number)})).start()",
        f"    {ends}",
        "signal.signal(signal.SIGINT, signal.default_int_handler)",
        "erclutch.cli.main = command",
        "sys.exit(main())",
    ]
    (tmp_path / "held.py").write_text("\n".join(lines), encoding="utf-8")
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "held.py"],
        cwd=tmp_path,
        env=env,
        capture_output=True,
        check=False,
        timeout=30.0,
    )
    assert (done.returncode, done.stderr) == (int(re.findall(r"\d+", ends)[0]), b"")


def test_what_is_ignored_stays_ignored(usual: None) -> None:
    """By nohup, for one."""
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    EndingSignal().begin()
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
@pytest.mark.parametrize("kind", [ImportError, OSError, MemoryError, ValueError])
def test_a_library_that_makes_an_error_of_a_signal_is_not_told_as_a_fault(
    usual: None,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    number: int,
    code: int,
    kind: type[Exception],
) -> None:
    """Extensions that were imported at that moment said "initialization failed", and a traceback followed."""

    def run(words: object) -> int:
        try:
            signal.raise_signal(number)
        except BaseException:
            raise kind("initialization failed") from None
        return 0

    monkeypatch.setattr(cli, "_run", run)
    try:
        ended: object = main(["fit"])
    except SystemExit as error:
        ended = error.code
    assert ended == code
    assert "initialization" not in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="other systems do not tell of a parent's end"
)
def test_a_reader_whose_parent_died_before_it_began_reads_nothing(tmp_path: Path) -> None:
    """While it imports, its parent may be ended: it read on, with no one to answer."""
    code = (
        "import sys\nfrom erclutch.logs.readers import child_process\n"
        "sys.exit(child_process.serve(lambda path: ([], {'read': str(path)})))"
    )
    words = [sys.executable, "-c", code, "a.mat", str(tmp_path), str(2 << 30), "20"]
    with subprocess.Popen(
        words, env={"PYTHONPATH": ":".join(sys.path), "ERCLUTCH_PARENT": "1"}
    ) as child:
        child.wait(60.0)
    assert child.returncode == -signal.SIGKILL
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("is_told", [True, False])
def test_an_interrupt_while_a_dataclass_is_made_ends_the_process_with_its_code(
    tmp_path: Path, is_told: bool
) -> None:
    lines = [
        "import sys",
        "import erclutch.cli",
        "from erclutch.__main__ import main",
        "def command():",
        "    try:",
        "        exec('raise KeyboardInterrupt')  # as a dataclass is made",
        "    except KeyboardInterrupt:",
        "        return 130" if is_told else "        raise",
        "erclutch.cli.main = command",
        "sys.exit(main())",
    ]
    (tmp_path / "interrupted.py").write_text("\n".join(lines), encoding="utf-8")
    command = [sys.executable, "-m", "interrupted"]
    path = os.pathsep.join([*sys.path, str(tmp_path)])
    env = {**os.environ, "PYTHONPATH": path}
    assert subprocess.run(command, cwd=tmp_path, env=env, check=False).returncode == 130


def test_a_signal_as_a_temporary_folder_is_made_leaves_none(
    usual: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mkdir = os.mkdir

    def made(path: str, mode: int = 0o777) -> None:
        mkdir(path, mode)
        signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("os.mkdir", made)
    ending = EndingSignal()
    ending.begin()
    with pytest.raises(SystemExit), scratch_folder():
        pass
    ending.end()
    assert list(tmp_path.iterdir()) == []


def test_a_signal_beside_the_look_whether_a_folder_takes_files_leaves_nothing(
    usual: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It came between the probe and its end: the probe stayed."""
    touch = Path.touch

    def touched(path: Path, **how: bool) -> None:
        touch(path, **how)
        signal.raise_signal(signal.SIGTERM)

    monkeypatch.delattr(os, "O_TMPFILE", raising=False)  # as where files have names from the start
    monkeypatch.setattr(Path, "touch", touched)
    ending = EndingSignal()
    ending.begin()
    with pytest.raises(SystemExit):
        takes_files(tmp_path)
    ending.end()
    assert list(tmp_path.iterdir()) == []


#: The ring of a session has a lock, by which the next session takes it away.
HELD_BY_A_LOCK = frozenset({"session.py"})


@pytest.mark.slow
def test_every_temporary_folder_is_made_where_no_signal_can_leave_it() -> None:
    """Python makes a folder and notes it in two steps; a signal between them left the folder of a compiler's work."""
    package = Path(cli.__file__).parents[1]
    made = re.compile(r"\b(TemporaryDirectory|mkdtemp|NamedTemporaryFile|mkstemp)\(")
    found = {file.name for file in package.rglob("*.py") if made.search(file.read_text("utf-8"))}
    there = {file.name for file in package.rglob("*.py")}  # a wing may be taken away
    assert found == {*(HELD_BY_A_LOCK & there), Path(files.__file__).name}


def test_a_signal_as_a_temporary_folder_is_taken_away_leaves_none_of_it(
    usual: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It came between two files: the others stayed."""
    rmdir = os.rmdir

    def removed(path: str, *, dir_fd: int | None = None) -> None:
        rmdir(path, dir_fd=dir_fd)
        if Path(path).name == "inner":
            signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("os.rmdir", removed)
    ending = EndingSignal()
    ending.begin()
    with pytest.raises(SystemExit), scratch_folder() as folder:
        (Path(folder) / "inner").mkdir()
    ending.end()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "O_TMPFILE"), reason="files have names from the start here")
def test_the_look_whether_a_folder_takes_files_has_no_name_that_kill_9_could_leave(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One in 20 left a hidden file for good."""
    monkeypatch.setattr(Path, "touch", lambda *_, **__: pytest.fail("a file with a name"))
    try:
        os.close(os.open(tmp_path, os.O_TMPFILE | os.O_WRONLY))
    except OSError:
        pytest.skip("this disk has no files without a name")
    assert takes_files(tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_control_c_behind_the_end_of_a_command_says_nothing(tmp_path: Path) -> None:
    """It came as Python ended: the result was there, and a traceback on the screen."""
    lines = [
        "import atexit, signal, sys",
        "import erclutch.cli",
        "from erclutch.__main__ import main",
        "signal.signal(signal.SIGINT, signal.default_int_handler)",
        "atexit.register(signal.raise_signal, signal.SIGINT)",
        "sys.argv = ['erclutch', '--help']",
        "sys.exit(main())",
    ]
    (tmp_path / "ends.py").write_text("\n".join(lines), encoding="utf-8")
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "ends.py"], cwd=tmp_path, env=env, capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("number", _ALL)
def test_a_signal_while_python_ends_leaves_the_code_of_what_was_done(
    tmp_path: Path, number: int
) -> None:
    """A fleet was complete, and its command had the code of one that was ended."""
    lines = [
        "import os, signal, sys",
        "import erclutch.cli",
        "from erclutch.__main__ import main",
        "class Last:",
        "    def __del__(self, kill=os.kill, us=os.getpid()):",
        f"        kill(us, {int(number)})",
        "sys.of_tests = Last()  # is taken apart when Python has given up its handlers",
        "erclutch.cli.main = lambda: 0",
        "sys.exit(main())",
    ]
    (tmp_path / "ends.py").write_text("\n".join(lines), encoding="utf-8")
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "ends.py"], cwd=tmp_path, env=env, capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")
