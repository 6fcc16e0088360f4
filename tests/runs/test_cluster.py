"""Tasks give the same results wherever they run; a process that dies costs its one task; what cannot be is said."""

from __future__ import annotations

import math
import os
import pickle
import signal
from pathlib import Path
from types import SimpleNamespace

import pytest

from erclutch.errors import LogError, SettingError
from erclutch.runs import cluster
from erclutch.runs.cluster import WorkerLostError, finished, in_order, task_pool
from tests.support.hostile import lies


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

    with task_pool("local", 1) as one, task_pool("local", 1) as other:
        assert [list(in_order(pool, math.sqrt, [4.0, 9.0])) for pool in (one, other)] == [[2.0, 3.0]] * 2
        here = psutil.Process()
        ears = [
            c.laddr for p in (here, *here.children(recursive=True)) for c in p.net_connections("tcp") if not c.raddr
        ]
    assert len(ears) >= 4
    assert {ear.ip for ear in ears} == {"127.0.0.1"}
    assert 8787 not in {ear.port for ear in ears}


def test_an_answer_of_a_worker_that_nobody_can_read_is_an_error() -> None:
    """Dask's client waited for it without end."""
    from concurrent.futures import Future

    packed, answer = Future[bytes](), Future[object]()
    packed.set_result(pickle.dumps(lies("")))
    cluster._unpack(packed, answer)
    with pytest.raises(WorkerLostError, match=r"answer cannot be read \(ValueError\)\. Start workers with the same"):
        answer.result(1.0)


def test_a_part_of_dask_that_does_not_end_in_time_loses_no_work() -> None:
    """On a busy machine the command ended with a traceback after all its work."""

    def close(timeout: float) -> None:
        raise TimeoutError(f"timed out after {timeout} s.")

    cluster._close(SimpleNamespace(close=close))  # pyright: ignore[reportPrivateUsage]
