"""Native code reads a file in a child process, so that a damaged file can kill or hang only the child.

The child is this package's own module, started with ``python -m``. It writes ``columns.f64``, the bytes of all vectors,
and ``table.json`` into a temporary folder that the parent always removes. A long file comes in pieces (`stream`).
"""

from __future__ import annotations

import itertools
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from math import ceil
from pathlib import Path
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError, SeveralRecordingsError
from erclutch.files import scratch_folder
from erclutch.logs.readers.budget import MORE, RAISED, Budget, budget_of
from erclutch.signals.array import Array

WALL = 20.0  # times that by the clock: a busy machine is slow, and nothing was seen to wait without using the processor
_PDEATHSIG = 1  # of prctl: which signal comes when the parent dies
_PARENT = "ERCLUTCH_PARENT"  # variable of the environment: the number of the process that started the child
_ARRAYS, _TEXTS = "columns.f64", "table.json"
#: Last words of Rust, Python and C++.
_NO_MEMORY = (b"memory allocation of", b"MemoryError", b"bad_alloc")
_DAMAGED = "The file may be damaged: copy it again or export it as CSV"
_READY = b"."  # a piece is there; a piece was fetched
_SINGLE = {
    "OPENBLAS_NUM_THREADS": "1",
    "PYTHONDONTWRITEBYTECODE": "1",
    "ARROW_DEFAULT_MEMORY_POOL": "system",  # Arrow's own reserves a GiB of address space at once
}


#: What a child reads: float64 vectors, and everything else as JSON.
Answer = tuple[list[Array], dict[str, Any]]


def run(
    module: str,
    path: Path,
    *arguments: str,
    memory: int | None = None,
    seconds: float | None = None,
) -> Answer:
    """Run ``python -m module path folder *arguments`` and fetch the answer of its `serve`.

    Its limits are bytes of address space and of each file that it writes, where the platform has them, and seconds of
    processor time; None: what the `Budget` of the file or folder allows. What it answers is held to that budget too.

    Raises:
        LogError: the child reports one, crashes, hangs, or runs out of memory.
    """
    memory, seconds = _limits(path, memory, seconds)
    with scratch_folder() as folder:
        command, environment = _started(module, path, folder, memory, seconds, arguments)
        try:
            done = subprocess.run(
                command,
                env=environment,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=WALL * seconds,
            )
        except subprocess.TimeoutExpired:
            raise _too_late(WALL * seconds) from None
        if done.returncode == _OUT_OF_TIME:
            raise _too_long(seconds)
        return _answer(Path(folder), done.returncode, done.stderr, memory)


def stream(
    module: str,
    path: Path,
    *arguments: str,
    memory: int | None = None,
    seconds: float | None = None,
) -> Iterator[Answer]:
    """As `run`, of a module that answers in pieces (`serve_pieces`): the child is one piece ahead, and two are on disk.

    Raises:
        LogError: see `run`; the pieces before have come.
    """
    memory, seconds = _limits(path, memory, seconds)
    with (
        scratch_folder() as folder,
        (Path(folder) / "said").open("w+b") as said,
    ):
        command, environment = _started(module, path, folder, memory, seconds, arguments)
        pipe = subprocess.PIPE
        with subprocess.Popen(
            command,
            env=environment,
            stdin=pipe,
            stdout=pipe,
            stderr=said,
        ) as child:
            assert child.stdin is not None
            assert child.stdout is not None
            late = threading.Event()
            try:
                for number in itertools.count():
                    with _killed_after(WALL * seconds, child, late):
                        ready = child.stdout.read(1)
                    if ready != _READY:
                        break
                    place = Path(folder) / str(number)
                    piece = _answer(place, 0, b"", memory)
                    (place / _ARRAYS).unlink()
                    yield piece
                    with suppress(BrokenPipeError):  # it has ended
                        child.stdin.write(_READY)
                        child.stdin.flush()
                code = child.wait()
            finally:
                child.kill()
                with suppress(BrokenPipeError):
                    child.stdin.close()
        if late.is_set():
            raise _too_late(WALL * seconds)
        if code == _OUT_OF_TIME:
            raise _too_long(seconds)
        said.seek(0)
        _answer(Path(folder), code, said.read(), memory)


_OUT_OF_TIME = -getattr(signal, "SIGXCPU", 0) or None  # what a child's end says


@contextmanager
def _killed_after(
    seconds: float,
    child: subprocess.Popen[bytes],
    late: threading.Event,
) -> Generator[None]:
    """A child that takes longer is killed, and the event is set."""

    def kill() -> None:
        late.set()
        child.kill()

    timer = threading.Timer(seconds, kill)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _limits(
    path: Path,
    memory: int | None,
    seconds: float | None,
) -> tuple[int, float]:
    budget = budget_of(path)
    return memory or budget.memory, seconds or budget.seconds


def _started(
    module: str,
    path: Path,
    folder: str,
    memory: int,
    seconds: float,
    arguments: tuple[str, ...],
) -> tuple[list[str], dict[str, str]]:
    """Words and environment of a child."""
    root = str(Path(__file__).resolve().parents[3])
    paths = os.pathsep.join([root, *(entry for entry in sys.path if entry)])
    limits = str(memory), str(ceil(seconds))
    python = [sys.executable, "-P", "-W", "ignore", "-m", module]
    environment = {
        **os.environ,
        **_SINGLE,
        "PYTHONPATH": paths,
        "TMPDIR": folder,
        _PARENT: str(os.getpid()),
    }
    return [*python, str(path), folder, *limits, *arguments], environment


def _too_long(seconds: float) -> LogError:
    return LogError(
        f"reading the file takes longer than the {seconds:.3g} s that its size allows", remedy=MORE
    )


def _too_late(seconds: float) -> LogError:
    """By the clock on the wall, which runs on while a busy machine does something else."""
    remedy = f"Try again when the machine is less busy, or allow more by the environment: {RAISED}=8192 (MiB)"
    return LogError(f"reading the file took longer than {seconds:.3g} s", remedy=remedy)


def _answer(folder: Path, code: int, stderr: bytes, memory: int) -> Answer:
    try:
        texts = cast("dict[str, Any]", json.loads((folder / _TEXTS).read_text(encoding="utf-8")))
        if code == 0 and "problem" in texts:
            kind = SeveralRecordingsError if texts["holds_several"] else LogError
            raise kind(texts["problem"], remedy=texts["remedy"], option=texts["option"])
        with (folder / _ARRAYS).open("rb") as file:
            arrays: list[Array] = []
            for size in texts["sizes"]:
                values = np.fromfile(file, np.float64, int(size))
                if values.size < int(size):
                    raise ValueError("the answer is cut off")
                arrays.append(values)
    except (OSError, ValueError, KeyError):
        if any(words in stderr for words in _NO_MEMORY):
            raise _too_little(memory) from None
        how = f"signal {-code}" if code < 0 else f"code {code}"
        lines = stderr.decode("utf-8", "replace").strip().splitlines()
        if code >= 0 and lines:
            how += f": {lines[-1][:120]}"
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
    path, folder, memory, *arguments = _begun()
    with _told(folder, memory):
        _refuse_pipe(path)
        arrays, texts = read(path, *arguments)
        _keep(folder, arrays, texts, budget_of(Path(path)))
    return 0


def serve_pieces(read: Callable[..., Iterator[Answer]]) -> int:
    """As `serve`, for `stream`: ``read`` yields answers."""
    path, folder, memory, *arguments = _begun()
    with _told(folder, memory):
        _refuse_pipe(path)
        for number, (arrays, texts) in enumerate(read(path, *arguments)):
            place = folder / str(number)
            place.mkdir()
            _keep(place, arrays, texts, budget_of(Path(path)))
            sys.stdout.buffer.write(_READY)
            sys.stdout.buffer.flush()
            if number and not sys.stdin.buffer.read(1):
                return 0  # nobody wants more
        _keep(folder, [], {}, budget_of(Path(path)))
    return 0


def _begun() -> tuple[Any, ...]:
    """Path, folder, bytes of memory and further words of a child that has limited itself."""
    path, folder, memory, seconds, *arguments = sys.argv[1:]
    end_with_parent()
    limit_process(int(memory), int(seconds))
    return path, Path(folder), int(memory), *arguments


def _refuse_pipe(path: str) -> None:
    """Refuse what became a pipe or a device after the look at it: to open a pipe that nobody fills has no end.

    Raises:
        LogError: it is one.
    """
    place = Path(path)
    for file in (place, *place.iterdir()) if place.is_dir() else (place,):
        if file.exists() and not (file.is_file() or file.is_dir()):
            raise LogError("the file was replaced while it was read", remedy="Give a plain file")


@contextmanager
def _told(folder: Path, memory: int) -> Generator[None]:
    """Every error becomes a report in the folder."""
    try:
        yield
        return
    except LogError as raised:
        error = raised
    except MemoryError:
        error = _too_little(memory)
    except Exception as raised:  # libraries raise anything on damaged files
        cause = f"{type(raised).__name__}: {str(raised).strip()[:120]}"
        problem = f"the file is damaged or of a kind that cannot be read ({cause})"
        error = LogError(problem, remedy="Copy the file again, or export it as CSV")
    report = {
        "problem": error.problem,
        "remedy": error.remedy,
        "option": error.option,
        "holds_several": isinstance(error, SeveralRecordingsError),
    }
    (folder / _TEXTS).write_text(json.dumps(report), encoding="utf-8")


def _keep(
    folder: Path,
    arrays: list[Array],
    texts: dict[str, Any],
    budget: Budget,
) -> None:
    """Write an answer.

    Raises:
        LogError: it is beyond the budget of the file, or there is no room for it.
    """
    vectors = [np.ascontiguousarray(values, np.float64) for values in arrays]
    budget.take_names(len(vectors))
    budget.take_cells(sum(values.size for values in vectors))
    try:
        with (folder / _ARRAYS).open("wb") as file:
            for values in vectors:
                values.tofile(file)
    except OSError as error:
        problem = f"the numbers of the file cannot be kept among the temporary files ({error.strerror or error})"
        remedy = "Make room there, or name another folder by the environment: TMPDIR"
        raise LogError(problem, remedy=remedy) from error
    report = {**texts, "sizes": [values.size for values in vectors]}
    (folder / _TEXTS).write_text(json.dumps(report), encoding="utf-8")


def end_with_parent() -> None:
    """Let the system kill this process when its parent dies, however it dies, where the system can."""
    if not sys.platform.startswith("linux"):
        return  # the limit of processor time remains
    import ctypes

    parent = int(os.environ.get(_PARENT) or os.getppid())
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).prctl(_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it died before, while this process imported
            os.kill(os.getpid(), signal.SIGKILL)


def limit_process(memory: int, seconds: int) -> None:
    """Limit address space, files, processor time and core dumps, where the platform can."""
    try:
        import resource
    except ImportError:
        return  # Windows: the wall-clock limit of the parent remains
    limits = {
        "RLIMIT_AS": memory,
        "RLIMIT_FSIZE": memory,
        "RLIMIT_CPU": seconds,
        "RLIMIT_CORE": 0,
    }
    for name, value in limits.items():
        try:
            limit = getattr(resource, name)
            _, hard = resource.getrlimit(limit)
            bound = value if hard == resource.RLIM_INFINITY else min(value, hard)
            resource.setrlimit(limit, (bound, hard))
        except (AttributeError, ValueError, OSError):
            continue
