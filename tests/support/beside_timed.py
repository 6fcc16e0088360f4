"""All tests at once: those that keep time at 1 kHz have the processors first, the others take what time they leave.

A timed test waits more than it computes, so alone it leaves a processor idle. The others run in the scheduler's idle
class: each of them gives way the moment a timed test wakes. Where one of the timed still fails, it runs again, alone.

    python -m tests.support.beside_timed MARKS [flags of pytest]

MARKS chooses among the tests as pytest's ``-m`` does, such as "slow"; "" takes all.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence

_PYTEST = (sys.executable, "-m", "pytest")
#: A worker more than processors was tried: it makes what a session shares once more, and takes what it saves in waits.
_IN_PARALLEL = ("-n", "auto", "--dist", "loadgroup")
#: What pytest returns where all has passed, where a test has failed, and where there is no test of these marks.
_PASSED, _FAILED, _NO_TEST = 0, 1, 5


def give_way() -> None:
    """Let every other process go first; what this process starts does so, too."""
    if hasattr(os, "SCHED_IDLE"):
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    else:
        os.nice(19)


def run(marks: str, flags: Sequence[str]) -> bool:
    """Whether all tests of these marks pass. What the timed ones say comes in one piece, behind the others."""
    chosen = f" and ({marks})" if marks else ""
    with (
        tempfile.TemporaryDirectory() as folder,
        tempfile.TemporaryFile("w+", encoding="utf-8") as said,
    ):
        alone = [*_PYTEST, "-m", f"timed{chosen}", "-o", f"cache_dir={folder}", *flags]
        together = [*_PYTEST, *_IN_PARALLEL, "-m", f"not timed{chosen}", *flags]
        with subprocess.Popen(together, preexec_fn=give_way) as others:
            timed = subprocess.run(alone, stdout=said, stderr=subprocess.STDOUT, check=False)
        said.seek(0)
        print("\nTests that keep time:", said.read(), sep="\n", flush=True)
        if timed.returncode == _FAILED:
            print("Those that failed, once more and alone:", flush=True)
            timed = subprocess.run([*alone, "--last-failed"], check=False)
    return {timed.returncode, others.returncode} <= {_PASSED, _NO_TEST}


if __name__ == "__main__":
    sys.exit(not run(sys.argv[1], sys.argv[2:]))
