"""Tasks give the same results wherever they run; a process that dies costs its one task; what cannot be is said."""

from __future__ import annotations

import asyncio
import math
import os
import pickle
import signal
import time
from collections.abc import Coroutine
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from erclutch.errors import LogError, SettingError
from erclutch.runs import cluster
from erclutch.runs.cluster import TaskPool, WorkerLostError, finished, in_order, task_pool
from tests.support.dask_cluster import dask_cluster
from tests.support.hostile import lies, stands_still_once


def killed_once(mark: str) -> str:
    """The first process that gets this dies; the second does it."""
    try:
        Path(mark).touch(exist_ok=False)
    except FileExistsError:
        return "done"
    os.kill(os.getpid(), signal.SIGKILL)
    return "never"


def always_killed(_: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def test_threads_give_all_results_and_errors() -> None:
    with task_pool(None, 2) as pool:
        found = dict(finished(pool, math.sqrt, [4.0, -1.0, 9.0]))
        assert list(in_order(pool, abs, range(-50, 0))) == list(range(50, 0, -1))
        with pytest.raises(ValueError, match="math domain"):
            list(in_order(pool, math.sqrt, [1.0, -1.0]))
    assert (found[0], found[2]) == (2.0, 3.0)
    assert isinstance(found[1], ValueError)


def test_an_error_survives_the_way_back() -> None:
    error = pickle.loads(pickle.dumps(LogError("no rows", remedy="Log more", where="a.csv")))
    assert (type(error), str(error)) == (LogError, "a.csv: no rows. Log more.")


@pytest.mark.parametrize("cluster", ["dask", "tcp://nobody", "tcp://h:1:x", "http://h:80", ""])
def test_no_cluster(cluster: str) -> None:
    with pytest.raises(SettingError, match=r"tcp://HOST:PORT"), task_pool(cluster):
        pass


@pytest.mark.slow
def test_a_killed_process_costs_its_task_alone(tmp_path: Path) -> None:
    with task_pool("processes", 2) as pool:
        marks = [str(tmp_path / str(i)) for i in range(4)]
        assert list(in_order(pool, killed_once, marks)) == ["done"] * 4
        (found,) = finished(pool, always_killed, [0])
        assert isinstance(found[1], WorkerLostError)
        assert list(in_order(pool, math.sqrt, [4.0, 9.0])) == [2.0, 3.0]


@pytest.mark.slow
def test_two_clusters_of_one_machine_at_once_are_heard_on_the_loopback_alone() -> None:
    import psutil
    from dask import config

    with task_pool("local", 1) as one, task_pool("local", 1) as other:
        # A worker that was dead as Dask looked, 15 s after it had died before, got no successor.
        assert config.get("distributed.deploy.lost-worker-timeout") == "1 day"
        assert [list(in_order(pool, math.sqrt, [4.0, 9.0])) for pool in (one, other)] == [
            [2.0, 3.0]
        ] * 2
        here = psutil.Process()
        ears = [
            c.laddr
            for p in (here, *here.children(recursive=True))
            for c in p.net_connections("tcp")
            if not c.raddr
        ]
    assert len(ears) >= 4
    assert {ear.ip for ear in ears} == {"127.0.0.1"}
    assert 8787 not in {ear.port for ear in ears}


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_a_worker_that_stands_still_costs_a_minute_and_its_task_is_done_anew(
    workers: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """It took 606 s: Dask looks every five minutes for workers that were silent for five."""
    assert cluster._SILENCE == 60.0
    monkeypatch.setattr(cluster, "_SILENCE", 8.0)
    with task_pool("local", workers) as pool:
        began = time.monotonic()
        assert list(in_order(pool, stands_still_once, [str(tmp_path / "mark")])) == [1.0]
        assert time.monotonic() - began < 100.0
    said = capsys.readouterr().err
    assert "no sign of life from tcp://127.0.0.1:" in said
    assert "for 8 s: its task is done anew" in said


@pytest.mark.slow
def test_a_scheduler_that_stands_still_ends_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The command waited without end."""
    monkeypatch.setattr(cluster, "_SILENCE", 8.0)
    with dask_cluster(tmp_path, 1) as (address, scheduler):
        try:
            with suppress(WorkerLostError), task_pool(address) as pool:
                assert list(in_order(pool, math.sqrt, [4.0])) == [2.0]
                os.kill(scheduler, signal.SIGSTOP)
                with pytest.raises(WorkerLostError, match="went away"):
                    list(in_order(pool, math.sqrt, [4.0]))
        finally:
            os.kill(scheduler, signal.SIGCONT)


@pytest.mark.parametrize(("given", "seconds"), [("90s", 90.0), ("2 minutes", 120.0), (7, 7.0)])
def test_how_long_a_worker_may_be_silent_is_set_as_dask_has_it(
    given: object, seconds: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL", str(given))
    assert cluster._Watch(None)._silence == seconds  # pyright: ignore[reportPrivateUsage]


def test_a_silence_that_is_no_time_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL", "soon")
    with pytest.raises(SettingError, match=r"worker-ttl: 'soon' is no time\. Give a time such as"):
        cluster._Watch(None)  # pyright: ignore[reportPrivateUsage]


def test_a_worker_whose_clock_is_wrong_is_not_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    """Signs of life count by their change: the scheduler's clock may stand at any time, and jump."""
    beats, asked = iter([5.0, 1.0, 1e9, 1e9]), list[str]()

    async def identity() -> dict[str, Any]:
        return {"workers": {"tcp://far:1": {"last_seen": next(beats)}}}

    async def restart_workers(workers: list[str], **of_this: Any) -> None:
        asked.extend(workers)

    def sync(task: Any, callback_timeout: float, **of_this: Any) -> Any:
        return asyncio.run(task(**of_this))

    clock = iter([0.0, 50.0, 100.0, 170.0])
    monkeypatch.setattr(cluster, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    scheduler = SimpleNamespace(identity=identity, restart_workers=restart_workers)
    watch = cluster._Watch(SimpleNamespace(scheduler=scheduler, sync=sync))  # pyright: ignore[reportPrivateUsage]
    assert [watch.count() for _ in range(3)] == [1, 1, 1]
    assert not asked
    assert watch.count() == 0
    assert asked == ["tcp://far:1"]


def fetched(task: Coroutine[Any, Any, bytes]) -> object:
    """What `finished` gets of a task of Dask."""
    answer = Future[object]()
    asyncio.run(cluster._fetch(task, answer))  # pyright: ignore[reportPrivateUsage]
    return answer.result(0.0)


@pytest.mark.slow
def test_an_answer_of_a_worker_that_nobody_can_read_is_an_error() -> None:
    """Dask's client waited for it without end."""

    async def task() -> bytes:
        return pickle.dumps(lies(""))

    with pytest.raises(
        WorkerLostError, match=r"answer cannot be read \(ValueError\)\. Start workers with the same"
    ):
        fetched(task())


def test_a_task_that_fails_while_its_answer_is_fetched_has_an_error() -> None:
    """Its worker died between: done anew, the task failed, and Dask's executor never said so."""

    async def task() -> bytes:
        raise BrokenExecutor("all its workers died")

    with pytest.raises(BrokenExecutor, match="all its workers died"):
        fetched(task())


class Waits(Executor):
    """A cluster that never answers."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        return Future()


def test_a_cluster_whose_workers_are_all_gone_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tasks waited without end."""
    counts = iter([1, 0, 1])
    monkeypatch.setattr(cluster, "_LOOK", 0.01)
    monkeypatch.setattr(cluster, "_NO_WORKER", 0.05)
    pool = TaskPool(Waits(), 2, workers=lambda: next(counts, 0))
    with pytest.raises(
        WorkerLostError, match=r"no worker for 0 s\. Start workers, then the same command"
    ):
        list(finished(pool, math.sqrt, [4.0]))
    assert next(counts, None) is None


def test_a_part_of_dask_that_does_not_end_in_time_loses_no_work() -> None:
    """On a busy machine the command ended with a traceback after all its work."""

    def close(timeout: float) -> None:
        raise TimeoutError(f"timed out after {timeout} s.")

    cluster._close(SimpleNamespace(close=close))  # pyright: ignore[reportPrivateUsage]


@pytest.mark.slow
def test_a_signal_while_dask_starts_leaves_no_half_a_cluster(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It closed itself as Python ended, with four lines of its log for a user who had ended the command."""
    distributed: Any = pytest.importorskip("distributed")
    dask: Any = pytest.importorskip("dask")
    made: list[Any] = []
    closed: list[Any] = []

    class Cluster:
        def __init__(self, **named: Any) -> None:
            signal.raise_signal(signal.SIGTERM)
            self.folder = Path(dask.config.get("temporary-directory"))
            assert self.folder.is_dir()
            made.append(self)

        def close(self, timeout: float) -> None:
            closed.append(self)

    def end(number: int, frame: object) -> None:
        raise SystemExit(128 + number)

    monkeypatch.setattr(distributed, "LocalCluster", Cluster)
    before = signal.signal(signal.SIGTERM, end)
    try:
        with pytest.raises(SystemExit), task_pool("local", 1):
            pass
    finally:
        signal.signal(signal.SIGTERM, before)
    assert len(made) == 1
    assert closed == made
    assert not made[0].folder.exists()
