"""Whatever a plug-in does to end the program, a command that is not done has no exit code 0."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from erclutch.cli.early_end import no_early_end
from erclutch.errors import PluginError
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.registry import Plugin
from tests.support.command import run
from tests.support.installed_plugin import Install, install

__all__ = ["install"]
PLUGIN = Plugin("erclutch.laws", "odd", "odd:LAW", "bench-odd", "1.5")


def in_a_program(*lines: str) -> tuple[int, str]:
    """Exit code and errors of a program with these lines within `no_early_end`."""
    text = ["import os, threading", "from erclutch.cli.early_end import no_early_end"]
    text += ["with no_early_end():", *(f"    {line}" for line in lines)]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(text)],
        env=env,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stderr


def test_a_plug_in_that_ends_the_program_is_told_as_one_that_raises() -> None:
    with (
        no_early_end(),
        pytest.raises(
            PluginError, match=r"'odd' of bench-odd 1\.5 failed: .*os\._exit\(0\) in test_early_end"
        ),
        PLUGIN.working(),
    ):
        os._exit(0)


@pytest.mark.slow
@pytest.mark.parametrize(("status", "code"), [(0, 2), (7, 7)])
def test_a_thread_that_ends_the_program_is_told(status: int, code: int) -> None:
    """No call of a plug-in is under way there."""
    ended, said = in_a_program(
        f"thread = threading.Thread(target=lambda: os._exit({status}))",
        "thread.start()",
        "thread.join()",
    )
    assert ended == code
    assert (
        said
        == f"error: os._exit({status}) in <string>, line 4 ends the command before it is done\n"
    )


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_a_child_that_was_forked_ends_as_it_likes() -> None:
    assert in_a_program(
        "child = os.fork()",
        "if child == 0:",
        "    os._exit(0)",
        "assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0",
    ) == (0, "")


def test_behind_a_command_the_program_ends_as_it_likes() -> None:
    before = os._exit
    with no_early_end():
        assert os._exit is not before
    assert os._exit is before


@pytest.mark.slow
def test_a_fit_with_a_law_that_ends_the_program_says_so(install: Install, tmp_path: Path) -> None:
    """`fit` ended with 0 and kept nothing."""
    install("bench-odd", "[erclutch.laws]\nodd = bench_odd:LAW\n", "import os\nos._exit(0)\n")
    write_synthetic_log(tmp_path / "log.csv", seconds=0.25)
    done = run("fit", "log.csv", "--models", "odd", "--lag", "none", "--out", "o", cwd=tmp_path)
    assert done.code == 2
    assert "the law 'odd' of bench-odd 1.5 cannot be loaded" in done.error


@pytest.mark.slow
def test_what_a_plug_in_prints_as_the_program_ends_is_no_part_of_the_answer(
    install: Install, tmp_path: Path
) -> None:
    """JSON with a line behind it is none."""
    text = "import atexit\natexit.register(print, 'NOISE')\nLAW = None\n"
    install("bench-odd", "[erclutch.laws]\nodd = bench_odd:LAW\n", text)
    done = subprocess.run(
        [sys.executable, "-m", "erclutch", "laws"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    assert "bingham" in done.stdout
    assert ("NOISE" in done.stdout, "NOISE" in done.stderr) == (False, True)
