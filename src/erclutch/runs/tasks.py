"""Tasks run one after another, in threads, in processes or on a Dask cluster; their results come in their order."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import process_time, thread_time
from typing import Any

from erclutch.errors import SettingError
from erclutch.fit.one_thread import one_thread


@dataclass
class Tasks:
    """Runs tasks, and counts what they take.

    Attributes:
        pool: that runs them; None: this thread.
        workers: side by side.
        apart: whether they run in other processes.
    """

    pool: Executor | None
    workers: int
    apart: bool
    elsewhere: float = 0.0
    peak: int | None = None

    @property
    def seconds(self) -> float:
        """CPU time so far, of this process and of the tasks in others."""
        return process_time() + self.elsewhere

    def __call__(self, of: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[Any]:
        """What a function makes of each item, in their order; few more than the workers wait at a time."""
        if self.pool is None:
            yield from map(of, items)
            return
        waiting: deque[Future[Any]] = deque()
        try:
            for item in items:
                waiting.append(self.pool.submit(_alone, of, item))
                if len(waiting) > 2 * self.workers:
                    yield self._result(waiting.popleft())
            while waiting:
                yield self._result(waiting.popleft())
        finally:
            for future in waiting:
                future.cancel()

    def _result(self, future: Future[Any]) -> Any:
        found, seconds, peak = future.result()
        if self.apart:
            self.elsewhere += seconds
            self.peak = max(self.peak or 0, peak or 0) or None
        return found


def _alone(of: Callable[[Any], Any], item: Any) -> tuple[Any, float, int | None]:
    began = thread_time()
    with one_thread():
        found = of(item)
    return found, thread_time() - began, peak_memory()


@contextmanager
def tasks_on(cluster: str | None, workers: int) -> Generator[Tasks]:
    """Tasks on a pool of so many workers."""
    if cluster in (None, "threads"):
        if workers == 1:
            yield Tasks(None, 1, apart=False)
            return
        pool: Executor = ThreadPoolExecutor(workers)
    elif cluster == "processes":
        import multiprocessing

        pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
    else:
        raise SettingError(f"unknown cluster {cluster!r}", remedy="Give threads or processes")
    try:
        yield Tasks(pool, workers, apart=cluster == "processes")
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def peak_memory() -> int | None:
    """The most bytes of memory that this process has had so far; None where the system does not tell.

    On Linux ``ru_maxrss`` also holds what the process that started this one had, so the kernel's own mark comes first.
    """
    try:
        marks = Path("/proc/self/status").read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        marks = []
    for mark in marks:
        if mark.startswith("VmHWM:"):
            return 1024 * int(mark.split()[1])
    try:
        import resource
    except ImportError:  # Windows
        return None
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most
