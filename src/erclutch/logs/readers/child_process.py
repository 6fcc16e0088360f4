"""Native code reads a file in a child process, so that a damaged file can kill or hang only the child.

The child is this package's own module, started with ``python -m``. It writes ``columns.npz`` (no pickles) and
``table.json`` into a temporary folder that the parent always removes.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from math import ceil
from pathlib import Path
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.readers.budget import MORE, budget_of
from erclutch.signals.array import Array

WALL = 5.0  # times that by the clock: a busy machine is slow, and nothing was seen to wait without using the processor
_PDEATHSIG = 1  # of prctl: which signal comes when the parent dies
_ARRAYS, _TEXTS = "columns.npz", "table.json"
_NO_MEMORY = (b"memory allocation of", b"MemoryError", b"bad_alloc")  # last words of Rust, Python and C++
_DAMAGED = "The file may be damaged: copy it again or export it as CSV"


#: What a child reads: float64 vectors, and everything else as JSON.
Answer = tuple[list[Array], dict[str, Any]]


def run(module: str, path: Path, *arguments: str, memory: int | None = None, seconds: float | None = None) -> Answer:
    """Run ``python -m module path folder *arguments`` and fetch the answer of its `serve`.

    Its limits are bytes of address space and of each file that it writes, where the platform has them, and seconds of
    processor time; None: what the `Budget` of the file or folder allows. What it answers is held to that budget too.

    Raises:
        LogError: the child reports one, crashes, hangs, or runs out of memory.
    """
    budget = budget_of(path)
    memory, seconds = memory or budget.memory, seconds or budget.seconds
    root = str(Path(__file__).resolve().parents[3])
    paths = os.pathsep.join([root, *(entry for entry in sys.path if entry)])
    with tempfile.TemporaryDirectory(prefix="erclutch-") as folder:
        settings = {"PYTHONPATH": paths, "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1", "TMPDIR": folder}
        environment = {**os.environ, **settings}
        limits = str(memory), str(ceil(seconds))
        command = [sys.executable, "-P", "-W", "ignore", "-m", module, str(path), folder, *limits, *arguments]
        try:
            done = subprocess.run(
                command, env=environment, stdin=subprocess.DEVNULL, capture_output=True, timeout=WALL * seconds
            )
        except subprocess.TimeoutExpired:
            done = None
        if done is None or done.returncode == -getattr(signal, "SIGXCPU", -1):
            problem = f"reading the file takes longer than the {seconds:.3g} s that its size allows"
            raise LogError(problem, remedy=_DAMAGED)
        return _answer(Path(folder), done.returncode, done.stderr, memory)


def _answer(folder: Path, code: int, stderr: bytes, memory: int) -> Answer:
    try:
        texts = cast("dict[str, Any]", json.loads((folder / _TEXTS).read_text(encoding="utf-8")))
        if code == 0 and "problem" in texts:
            raise LogError(str(texts["problem"]), remedy=str(texts["remedy"]))
        with np.load(folder / _ARRAYS, allow_pickle=False) as file:
            arrays = [np.asarray(file[f"a{index}"], dtype=np.float64) for index in range(int(texts["count"]))]
    except (OSError, ValueError, KeyError):
        if any(words in stderr for words in _NO_MEMORY):
            raise _too_little(memory) from None
        last = stderr.decode("utf-8", "replace").strip().splitlines()
        how = f"signal {-code}" if code < 0 else f"code {code}" + (f": {last[-1][:120]}" if last else "")
        raise LogError(f"the reader broke on this file ({how})", remedy=_DAMAGED) from None
    if code != 0:
        raise LogError(f"the reader broke on this file (code {code})", remedy=_DAMAGED)
    return arrays, texts


def _too_little(memory: int) -> LogError:
    return LogError(f"reading the file needs more than {memory >> 20} MiB", remedy=MORE)


def serve(read: Callable[..., Answer]) -> int:
    """The child's side: limit itself, call ``read(path, *arguments) -> (arrays, texts)`` and write the answer.

    Every error becomes a report; running out of memory too. Returns the exit code.
    """
    path, folder, memory, seconds, *arguments = sys.argv[1:]
    _end_with_parent()
    _limit(int(memory), int(seconds))
    try:
        arrays, texts = read(path, *arguments)
        budget = budget_of(Path(path))
        budget.take_names(len(arrays))
        budget.take_cells(sum(np.size(values) for values in arrays))
        columns: dict[str, Any] = {f"a{index}": np.asarray(values, np.float64) for index, values in enumerate(arrays)}
        np.savez(Path(folder) / _ARRAYS, **columns)
        report: dict[str, Any] = {**texts, "count": len(arrays)}
    except LogError as error:
        report = {"problem": error.problem, "remedy": error.remedy}
    except MemoryError:
        error = _too_little(int(memory))
        report = {"problem": error.problem, "remedy": error.remedy}
    except Exception as error:  # libraries raise anything on damaged files
        cause = f"{type(error).__name__}: {str(error).strip()[:120]}"
        problem = f"the file is damaged or of a kind that cannot be read ({cause})"
        report = {"problem": problem, "remedy": "Copy the file again, or export it as CSV"}
    (Path(folder) / _TEXTS).write_text(json.dumps(report), encoding="utf-8")
    return 0


def _end_with_parent() -> None:
    """Let the system kill this process when its parent dies, however it dies, where the system can."""
    if not sys.platform.startswith("linux"):
        return  # the limit of processor time remains
    import ctypes

    parent = os.getppid()
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).prctl(_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it died just before
            os.kill(os.getpid(), signal.SIGKILL)


def _limit(memory: int, seconds: int) -> None:
    """Limit address space, files, processor time and core dumps, where the platform can."""
    try:
        import resource
    except ImportError:
        return  # Windows: the wall-clock limit of the parent remains
    for limit, value in (("RLIMIT_AS", memory), ("RLIMIT_FSIZE", memory), ("RLIMIT_CPU", seconds), ("RLIMIT_CORE", 0)):
        try:
            hard = resource.getrlimit(getattr(resource, limit))[1]
            bound = value if hard == resource.RLIM_INFINITY else min(value, hard)
            resource.setrlimit(getattr(resource, limit), (bound, hard))
        except (AttributeError, ValueError, OSError):
            continue
