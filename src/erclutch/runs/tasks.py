"""Passes over the rows of a large log run in tasks, in their order; what they take is counted."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import process_time, thread_time
from typing import Any

from erclutch.runs.cluster import TaskPool, in_order, task_pool


@dataclass
class Tasks:
    """Runs the tasks of each pass.

    Attributes:
        pool: where; None: here, one after the other.
        show: called with the number of the pass and its tasks that are done.
        passes: begun so far.
        elsewhere: CPU time that tasks took in other processes.
        peak: most bytes of memory of such a process; None where there is none.
    """

    pool: TaskPool | None
    show: Callable[[int, int], None] = lambda passes, tasks: None
    passes: int = 0
    elsewhere: float = 0.0
    peak: int | None = None

    @property
    def here(self) -> bool:
        """Whether tasks run in this process."""
        return self.pool is None or self.pool.here

    @property
    def seconds(self) -> float:
        """CPU time so far, of this process and of the tasks in others."""
        return process_time() + self.elsewhere

    def __call__(self, of: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[Any]:
        """What a function makes of each item, in their order."""
        self.passes += 1
        counted = partial(_counted, of)
        answers = map(counted, items) if self.pool is None else in_order(self.pool, counted, items)
        for done, (value, seconds, peak) in enumerate(answers, start=1):
            if not self.here:
                self.elsewhere += seconds
                self.peak = max(self.peak or 0, peak or 0) or None
            self.show(self.passes, done)
            yield value


def _counted(of: Callable[[Any], Any], item: Any) -> tuple[Any, float, int | None]:
    began = thread_time()
    return of(item), thread_time() - began, peak_memory()


@contextmanager
def tasks_on(cluster: str | None, workers: int) -> Generator[Tasks]:
    """Tasks on so many workers; see `task_pool`."""
    if cluster in (None, "threads") and workers == 1:
        yield Tasks(None)
        return
    with task_pool(cluster, workers) as pool:
        yield Tasks(pool)


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
