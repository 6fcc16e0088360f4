"""`make test-slow`: tests that keep time run beside others that give way. What fails alone fails."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.beside_timed import give_way

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
TESTS = """
import os
from pathlib import Path
import pytest

SEEN = Path(__file__).with_name("seen")

@pytest.mark.timed
def test_is_held_up_once():
    first = not SEEN.exists()
    SEEN.touch()
    assert not first

@pytest.mark.timed
def test_keeps_time():
    assert {timed}

def test_other():
    assert os.sched_getscheduler(0) == os.SCHED_IDLE
    assert {other}
"""


@pytest.mark.skipif(not hasattr(os, "SCHED_IDLE"), reason="needs the scheduler of Linux")
def test_a_process_gives_way() -> None:
    code = "import os; print(os.sched_getscheduler(0) == os.SCHED_IDLE)"
    done = subprocess.run(
        [sys.executable, "-S", "-c", code], preexec_fn=give_way, stdout=subprocess.PIPE, check=True
    )
    assert done.stdout == b"True\n"


@pytest.mark.skipif(not hasattr(os, "SCHED_IDLE"), reason="needs the scheduler of Linux")
@pytest.mark.parametrize(("timed", "other"), [(True, True), (False, True), (True, False)])
def test_what_fails_alone_or_among_the_others_fails(
    timed: bool, other: bool, tmp_path: Path
) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = timed: keeps time\n")
    (tmp_path / "test_made.py").write_text(TESTS.format(timed=timed, other=other))
    # Workers of the tests that run now are named in the environment.
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    environment["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = (
        "1"  # four pytests are started, and need none but xdist
    )
    words = (
        "-m",
        "tests.support.beside_timed",
        "",
        "-q",
        "-p",
        "xdist",
        f"--rootdir={tmp_path}",
        str(tmp_path),
    )
    done = subprocess.run(
        [sys.executable, *words],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == (0 if timed and other else 1), done.stdout + done.stderr
    assert "1 failed, 1 passed" in done.stdout if timed else "2 failed" in done.stdout
    alone = done.stdout.partition("once more and alone:")[2]
    assert "1 passed" in alone
