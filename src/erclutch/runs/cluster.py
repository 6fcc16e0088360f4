"""Tasks run on threads here, on processes here, or on any Dask cluster; the results are the same bits.

    with task_pool("processes", workers=2) as pool:
        for index, result in finished(pool, function, tasks):
            ...

A task gets paths and ranges of rows, never arrays: what is sent stays small, and a task can be done again elsewhere.
Functions stand at the top of a module.
"""

from __future__ import annotations

import logging
import re
import signal
import sys
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sized
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
)
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from multiprocessing import resource_tracker
from queue import Empty, SimpleQueue
from typing import Any, TypeVar
from weakref import WeakSet

from erclutch.errors import ErclutchError, SettingError, printable
from erclutch.files import scratch_folder
from erclutch.files.places import unheard
from erclutch.fit.solver.one_thread import one_thread
from erclutch.runs.own_processes import OwnProcesses, one_blas_thread

T = TypeVar("T")
R = TypeVar("R")

#: Tasks that a Dask scheduler holds at a time, done or not: a few kB each in its memory, enough for 1,000 workers.
IN_FLIGHT = 2_000
_SECONDS = 10  # to reach a scheduler
#: A cluster may have no worker for so long [s]: on a busy machine the next one takes its time.
_NO_WORKER = 120.0
_LOOK = 5.0  # s without an answer after which the cluster is asked for its workers
#: A worker that sends no sign of life for so long [s] stands still, and the user's setting of Dask for it. Dask itself
#: takes five to ten minutes.
_SILENCE, _SETTING = 60.0, "distributed.scheduler.worker-ttl"


class WorkerLostError(ErclutchError):
    """A task whose workers died again and again, or a cluster that went away."""


@dataclass(frozen=True)
class TaskPool:
    """A place where tasks run.

    Attributes:
        executor: takes functions at the top of a module, and small arguments.
        places: tasks that it holds at a time.
        lost: errors that say that a worker died, not that the task failed.
        here: whether the tasks run in this process.
        workers: asks how many there are, and replaces those that stand still; None where they do not go away.
    """

    executor: Executor
    places: int
    lost: tuple[type[BaseException], ...] = (BrokenExecutor,)
    here: bool = False
    workers: Callable[[], int] | None = None


@contextmanager
def task_pool(cluster: str | None = None, workers: int = 2) -> Generator[TaskPool]:
    """A place where tasks run, with one BLAS thread for each task.

    Whatever interrupts it cancels what waits. Processes of its own end at once; threads end after the task that they
    run, and so do the workers of a cluster.

    Args:
        cluster: None or "threads"; "processes"; "local", a Dask cluster of processes on this machine; or the address
            of a Dask scheduler, such as "tcp://10.0.0.7:8786".
        workers: threads or processes; a cluster that is running has its own.

    Raises:
        SettingError: another word; Dask is not installed; no scheduler answers, it has no worker, or the versions there
            are others than here.
    """
    if workers < 1:
        raise SettingError(f"{workers} workers", remedy="Give --workers 1 or more")
    if cluster in (None, "threads"):
        with one_thread(), _ended(ThreadPoolExecutor(workers)) as executor:
            yield TaskPool(executor, 2 * workers, here=True)
    elif cluster == "processes":
        with _ended(OwnProcesses(workers)) as executor:
            yield TaskPool(executor, workers)
    elif cluster == "local" or re.fullmatch(r"(tcp|tls)://.+:\d{1,5}", cluster):
        with _dask(cluster, workers) as pool:
            yield pool
    else:
        remedy = (
            "Give threads, processes, local, or the address of a Dask scheduler: tcp://HOST:PORT"
        )
        raise SettingError(f"--cluster {cluster!r} is no cluster", remedy=remedy)


def finished(
    pool: TaskPool,
    function: Callable[[T], R],
    tasks: Iterable[T],
    *,
    retries: int = 2,
) -> Iterator[tuple[int, R | Exception]]:
    """Run a function on each task; give results as they come, each with the index of its task.

    Args:
        pool: where.
        function: stands at the top of a module.
        tasks: small arguments; only as many are taken as the pool has places.
        retries: how often a task is begun anew whose process died; a Dask scheduler counts by its own setting.

    Returns:
        What the function gave, or the error that it raised; a `WorkerLostError` for a task whose workers died.

    Raises:
        WorkerLostError: the cluster went away, or has had no worker for minutes.
    """
    turns = ((index, task, 0) for index, task in enumerate(tasks))
    running: dict[Future[R], tuple[int, T, int]] = {}
    ended: SimpleQueue[Future[R]] = SimpleQueue()

    def begin(turn: tuple[int, T, int]) -> None:
        future = pool.executor.submit(function, turn[1])
        running[future] = turn
        future.add_done_callback(ended.put)

    while True:
        for turn in islice(turns, pool.places - len(running)):
            begin(turn)
        if not running:
            return
        future = _next(ended, pool)
        index, task, lost = running.pop(future)
        if future.cancelled():
            raise _gone()
        error = future.exception()
        if isinstance(error, pool.lost):
            if lost < retries and isinstance(error, BrokenExecutor):
                begin((index, task, lost + 1))
                continue
            problem = "the process that did this died each time (killed, or out of memory)"
            error = WorkerLostError(problem, remedy="Give fewer --workers, or more memory")
        if error is not None and not isinstance(error, Exception):
            raise error
        yield index, future.result() if error is None else error


def _next(ended: SimpleQueue[Future[R]], pool: TaskPool) -> Future[R]:
    """The next task that has ended.

    Raises:
        WorkerLostError: the cluster has no worker, and gets none.
    """
    since = time.monotonic()  # when it was last seen to have one
    while True:
        with suppress(Empty):
            return ended.get(timeout=_LOOK if pool.workers else None)
        assert pool.workers is not None
        now = time.monotonic()
        since = now if pool.workers() else since
        if now - since > _NO_WORKER:
            problem = f"the cluster has had no worker for {_NO_WORKER:.0f} s"
            raise WorkerLostError(problem, remedy="Start workers, then the same command")


def _gone() -> WorkerLostError:
    return WorkerLostError(
        "the cluster went away", remedy="Start the cluster again, then the same command"
    )


def in_order(
    pool: TaskPool,
    function: Callable[[T], R],
    tasks: Iterable[T],
    *,
    retries: int = 2,
) -> Iterator[R]:
    """What a function makes of each task, in the order of the tasks; the first error is raised."""
    early: dict[int, R | Exception] = {}
    due = 0
    for index, result in finished(pool, function, tasks, retries=retries):
        early[index] = result
        while due in early:
            next_result = early.pop(due)
            if isinstance(next_result, Exception):
                raise next_result
            yield next_result
            due += 1


@contextmanager
def saying_kept(results: Sized, count: int, what: str) -> Generator[None]:
    """Where a cluster goes away, the error also says how many results there were then, and what was done with them."""
    try:
        yield
    except WorkerLostError as error:
        error.problem = f"{error.problem}; {len(results)} of {count} {what}"
        raise


@contextmanager
def _ended(executor: Any) -> Generator[Any]:
    try:
        yield executor
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
        raise
    executor.shutdown()


# --- Dask -------------------------------------------------------------------------------------------------------------


@contextmanager
def _dask(cluster: str, workers: int) -> Generator[TaskPool]:
    try:
        from dask import config
        from distributed import Client, KilledWorker, LocalCluster
        from distributed.utils import silence_logging_cmgr
    except ImportError as error:
        raise SettingError(
            "Dask is not installed", remedy='Run: pip install "erclutch[cluster]"'
        ) from error
    with silence_logging_cmgr(logging.CRITICAL), scratch_folder() as folder, ExitStack() as stack:
        place: Any = cluster
        if cluster == "local":
            # No dashboard, and nothing beyond the loopback address; a second cluster takes another port without a word.
            only_here: Any = {
                "host": "127.0.0.1",
                "dashboard_address": "127.0.0.1:0",
                "silence_logs": logging.CRITICAL,
                "scheduler_kwargs": {"dashboard": False},
            }
            stack.enter_context(config.set(temporary_directory=folder))
            # A worker that died again as Dask looked, 15 s after it had died, got no successor for good.
            stack.enter_context(config.set({"distributed.deploy.lost-worker-timeout": "1 day"}))
            with _interrupts_held(), unheard():
                place = LocalCluster(n_workers=workers, threads_per_worker=1, **only_here)
                stack.callback(_close, place)
        try:
            client: Any = Client(place, timeout=_SECONDS, set_as_default=False)
        except (OSError, ValueError, OverflowError) as error:
            problem = f"no Dask scheduler answers within {_SECONDS} s ({type(error).__name__})"
            raise SettingError(
                problem, where=cluster, remedy="Check the address, and that it runs"
            ) from error
        stack.callback(_close, client)
        _prepare(client, cluster)
        with _ended(_DaskExecutor(client)) as executor:
            yield TaskPool(
                executor, IN_FLIGHT, (BrokenExecutor, KilledWorker), workers=_Watch(client).count
            )


class _Watch:
    """The workers of a Dask cluster, and how long each has been silent.

    A worker that stands still (a stopped process, a machine that sleeps) keeps its task and its connection.
    """

    def __init__(self, client: Any) -> None:
        from dask import config as of_dask
        from dask import utils as dask_utils

        config: Any = of_dask
        utils: Any = dask_utils
        self._client = client
        self._silence = _SILENCE
        given = config.get(_SETTING, None, config=config.collect())  # what the user has set alone
        if given is not None:
            try:
                self._silence = float(utils.parse_timedelta(given))  # of "5 minutes"
            except (TypeError, ValueError, KeyError) as error:
                problem = f"{given!r} is no time"
                remedy = "Give a time such as 60s"
                raise SettingError(problem, where=_SETTING, remedy=remedy) from error
        # Worker -> its last sign of life by the scheduler's clock, and when that was new by ours.
        self._heard: dict[str, tuple[float, float]] = {}

    def count(self) -> int:
        """Workers that are alive; the others are begun anew where a nanny of Dask can, else left out.

        Raises:
            WorkerLostError: the cluster went away, or its scheduler stands still.
        """
        workers: dict[str, Any] = self._asked("identity")["workers"]
        now = time.monotonic()
        for worker, about in workers.items():
            last_seen = float(about["last_seen"])
            if self._heard.get(worker, (None, now))[0] != last_seen:
                self._heard[worker] = last_seen, now
        silent = [worker for worker in workers if now - self._heard[worker][1] > self._silence]
        if silent:
            names = printable(", ".join(silent))
            print(
                f"note: no sign of life from {names} for {self._silence:.0f} s: its task is done anew",
                file=sys.stderr,
            )
            # A worker without a nanny, or whose nanny stands still too, is struck off the scheduler's list.
            self._asked(
                "restart_workers",
                workers=silent,
                timeout=_SECONDS,
                wait_for_workers=False,
                on_error="return",
                stimulus_id=f"erclutch-silent-{now}",
            )
        return len(workers) - len(silent)

    def _asked(self, what: str, **of_this: Any) -> Any:
        """The scheduler's answer."""
        request = getattr(self._client.scheduler, what)
        try:
            return self._client.sync(request, callback_timeout=_SILENCE, **of_this)
        except (OSError, TimeoutError, RuntimeError) as error:
            raise _gone() from error


def _close(part: Any) -> None:
    """End a part of Dask; one that a busy machine does not end in time ends with this process, and its work is done."""
    with suppress(TimeoutError, OSError):
        part.close(timeout=_SECONDS)


@contextmanager
def _interrupts_held() -> Generator[None]:
    """Ctrl-C waits until the end, and never reaches processes that begin here: this process ends them, without a word.

    Threads and processes inherit which signals are held. Windows has no such thing.
    """
    if sys.platform == "win32":
        yield
        return
    resource_tracker.ensure_running()  # its start lets Ctrl-C through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _DaskExecutor(Executor):
    """Tasks of a Dask client, each with an answer whatever happens.

    Dask's own executor gives none where a worker dies after its task is done and before the result is fetched, and the
    task fails when it is done anew.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self._begun: WeakSet[Any] = WeakSet()

    def submit(
        self,
        fn: Callable[..., R],
        /,
        *args: Any,
        **kwargs: Any,
    ) -> Future[R]:
        answer: Future[R] = Future()
        try:
            task: Any = self._client.submit(_on_dask, fn, *args, **kwargs, pure=False)
            self._client.loop.add_callback(_fetch, task, answer)
        except (RuntimeError, OSError) as error:  # of a client that lost its scheduler
            raise _gone() from error
        self._begun.add(task)
        return answer

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Cancel what waits and runs where the work was interrupted; else `finished` has taken all answers."""
        if cancel_futures:
            with suppress(Exception):  # the cluster may have gone
                self._client.cancel(list(self._begun))


async def _fetch(task: Any, answer: Future[R]) -> None:
    """Hand a task's answer on once it is there, or the error that it is none; in the loop of the client."""
    try:
        packed: bytes = await task
    except CancelledError:
        answer.cancel()
        answer.set_running_or_notify_cancel()
    except BaseException as error:  # of the task, its workers, or the way here
        answer.set_exception(error)
    else:
        try:
            answer.set_result(_wire().loads(packed))
        except Exception as unreadable:  # whatever it is, it is no result
            problem = f"a worker's answer cannot be read ({type(unreadable).__name__})"
            remedy = "Start workers with the same packages as here"
            answer.set_exception(WorkerLostError(problem, remedy=remedy))


def _on_dask(function: Callable[..., object], *args: Any, **kwargs: Any) -> bytes:
    """What a function gives, as the bytes that Dask would send: where it reads them itself, a bad answer has no end."""
    one_blas_thread()
    return _wire().dumps(function(*args, **kwargs))


def _wire() -> Any:
    """What Dask makes bytes with, and reads them with."""
    from distributed.protocol import pickle

    return pickle


def _prepare(client: Any, where: str) -> None:
    """Refuse a cluster without workers, or with other versions than here: its figures might be others."""
    from erclutch.runs.written_run import versions

    try:
        client.wait_for_workers(1, timeout=_SECONDS)
        by_worker: dict[str, Any] = client.run(versions, on_error="return")
    except (OSError, TimeoutError) as error:
        raise SettingError(
            "the scheduler has no worker", where=where, remedy="Start workers first"
        ) from error
    here = versions()
    for worker, there in by_worker.items():
        if isinstance(there, Exception):
            problem = f"the worker {worker} cannot run erclutch: {there}"
            raise SettingError(
                problem, where=where, remedy="Install the same erclutch on all workers"
            )
        differing = [name for name in here if there.get(name) != here[name]]
        if differing:
            theirs = ", ".join(f"{name} {there.get(name)}" for name in differing)
            mine = ", ".join(f"{name} {here[name]}" for name in differing)
            problem = f"the worker {worker} has {theirs}; here is {mine}"
            raise SettingError(
                problem, where=where, remedy="Install the same versions on all workers"
            )
