"""Processes of this machine run tasks: each has a queue of its own, one BLAS thread, and ends with its parent."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context, parent_process
from queue import SimpleQueue
from typing import Any, TypeVar

R = TypeVar("R")


class OwnProcesses(Executor):
    """Processes of this machine, each with a queue of its own: a process that dies takes its one task with it."""

    def __init__(self, count: int) -> None:
        self._idle: SimpleQueue[ProcessPoolExecutor] = SimpleQueue()
        self._all: dict[ProcessPoolExecutor, Future[int]] = {}
        self._over = False
        for _ in range(count):
            self._idle.put(self._started())

    def _started(self) -> ProcessPoolExecutor:
        process = ProcessPoolExecutor(1, get_context("spawn"), initializer=_begin)
        self._all[process] = process.submit(os.getpid)
        return process

    def submit(
        self,
        fn: Callable[..., R],
        /,
        *args: Any,
        **kwargs: Any,
    ) -> Future[R]:
        """Give a task to an idle process, and wait until there is one."""
        process = self._idle.get()
        try:
            future = process.submit(fn, *args, **kwargs)
        except BrokenExecutor:  # it died while it was idle
            process = self._replaced(process)
            future = process.submit(fn, *args, **kwargs)

        def put_back(done: Future[R]) -> None:
            broken = not done.cancelled() and isinstance(done.exception(), BrokenExecutor)
            if not self._over:
                self._idle.put(self._replaced(process) if broken else process)

        future.add_done_callback(put_back)
        return future

    def _replaced(self, process: ProcessPoolExecutor) -> ProcessPoolExecutor:
        del self._all[process]
        return self._started()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes; at once where their tasks are cancelled."""
        self._over = True
        for process, number in list(self._all.items()):
            if cancel_futures and number.done() and number.exception() is None:
                with suppress(OSError):
                    os.kill(number.result(), signal.SIGTERM)
            process.shutdown(wait=wait, cancel_futures=cancel_futures)


def _begin() -> None:
    """In a process of our own: one BLAS thread; Ctrl-C ends it without a word; it never outlives its parent."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    parent = parent_process()
    if parent is not None:

        def end_with_parent() -> None:
            parent.join()
            os._exit(1)

        threading.Thread(target=end_with_parent, daemon=True).start()
    one_blas_thread()


def one_blas_thread() -> None:
    """Keep the BLAS of this process to one thread from now on; sums have the same bits everywhere then."""
    import scipy.linalg  # pyright: ignore[reportUnusedImport]  # noqa: F401  its BLAS must be there to be told
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)
